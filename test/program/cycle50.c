/* The cycle with 50 servos at 250 Hz: a wave of goals, renewed every period, and all feedback. Says
 * after PERIODS periods how it went. Servos 1 to 50 at their factory return delay. */
#include <cds55xx/cycle.h>
#include <cds55xx/roster.h>
#include <cds55xx/servo.h>
#include <cds55xx_avr.h>

#include "say.h"

#define SERVOS          50
#define RETURN_DELAY_US 2

#ifndef PERIODS
#define PERIODS 1250 // 5 s
#endif

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct cds_cycle cycle;
static uint8_t ids[SERVOS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];
static struct cds_feedback feedback[SERVOS];

#ifdef ROSTER
static struct cds_roster roster;
static struct cds_roster_servo servos[SERVOS];

static void begin_roster(void)
{
    for (uint8_t i = 0; i < SERVOS; i++) {
        servos[i].id = ids[i];
    }
    say("roster", cds_roster_begin(&roster, &bus, servos, SERVOS) == CDS_OK);
    for (uint8_t i = 0; i < SERVOS; i++) {
        cds_roster_set_limits(&roster, &servos[i], 256, 767, CDS_VALUE_MAX);
    }
}
#else
static void begin_roster(void)
{
}
#endif

/* Goals of one period; true when all of them were taken. */
static bool set_goals(uint16_t period)
{
    bool taken = true;

    for (uint8_t i = 0; i < SERVOS; i++) {
        uint16_t position = (4u * period + 20u * i) & 0x3FF;

        if (position & 0x200) {
            position = 0x3FF - position;
        }
        taken &= cds_cycle_goal(&cycle, i, 256 + position, 0) == CDS_OK;
    }
    return taken && cds_cycle_commit(&cycle) == CDS_OK;
}

static void say_counters(void)
{
    struct cds_counters count;

    cds_bus_counters(&bus, &count);
    say("sent", count.sent);
    say("ok", count.ok);
    say("timeouts", count.timeouts);
    say("corrupt", count.corrupt);
    say("refuted", count.refuted);
    say("foreign", count.foreign);
    say("framing_errors", count.framing_errors);
    say("overruns", count.overruns);
    say("ring_overflows", count.ring_overflows);
}

int main(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(3)];
    static struct cds_request request = CDS_REQUEST(packet);
    uint16_t set = 0, refused = 0;
    uint32_t turns = 0;

    for (uint8_t i = 0; i < SERVOS; i++) {
        ids[i] = (uint8_t)(i + 1);
    }
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, RETURN_DELAY_US);
    begin_roster();
    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    while (cds_bus_poll(&bus)) {
    }
    say("begun", cds_cycle_begin(&cycle, &bus, ids, SERVOS, packets, feedback,
                                 CDS_CYCLE_PERIOD_US) == CDS_OK);
    refused += !set_goals(set++);
    while (cycle.counters.periods + cycle.counters.missed < PERIODS) {
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
        turns++;
        if ((uint16_t)cycle.counters.periods == set) { // what was set is on its way
            refused += !set_goals(set++);
        }
    }
    cds_cycle_stop(&cycle);
    while (cds_cycle_poll(&cycle) == CDS_PENDING) {
        cds_bus_poll(&bus);
    }
    say("periods", cycle.counters.periods);
    say("missed", cycle.counters.missed);
    say("refused", refused);
    say("unsent", cycle.counters.unsent);
    say("dropped", cycle.counters.dropped);
    say("turns", turns);
    say("reads", cycle.counters.reads);
    say("failed", cycle.counters.failed);
    say("oldest_us", cycle.counters.oldest_us);
    say("utilisation_permille", cds_cycle_utilisation_permille(&cycle));
    say("return_delay_us", RETURN_DELAY_US);
    say_counters();
    say_end();
}
