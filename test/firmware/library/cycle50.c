/* SPDX-License-Identifier: MIT */
/* A cycle of 50 servos at 250 Hz: a wave of goals that changes every period, and feedback of all
 * servos. Bytes of the EEPROM: 0 and 1, seconds; 2, number of servos from ID 1 on (FF: 50); 3,
 * return delay, register 0x05 (FF: factory value). Prints a dot after each second and the results
 * at the end.
 *
 * The program calls the library when the handlers of the bus have worked, and on a tick. PB0 is
 * high while the library runs. The remaining CPU time is free for the robot. */
#include <avr/eeprom.h>
#include <cds55xx/cycle.h>
#include <cds55xx/queue.h>
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>

#include "say.h"

#define SERVOS_MAX           50
#define RETURN_DELAY_FACTORY 1
#define ERASED               0xFF

#define PERIODS_PER_S (1000000ul / CDS_CYCLE_PERIOD_US)
#define TICKS_PER_US  ((uint16_t)(F_CPU / 8000000u)) // of the clock's timer
#define TICK          (1000u * TICKS_PER_US)
#define MARK          (1 << PB0)
#define MOST          (CDS_PACKET_SIZE(CDS_FEEDBACK_SIZE) - 8) // of a reply: polls wait for the other bytes

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct cds_queue queue;
static struct cds_cycle cycle;
static uint8_t servo_count;
static uint8_t ids[SERVOS_MAX];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS_MAX)];
static struct cds_feedback feedback[SERVOS_MAX];

#ifndef SPEED
#define SPEED 0 // as fast as the servo can
#endif

#ifdef SAFE
#include "cycle50_safe.h"
#else
static void begin_servos(void)
{
    say("queue", cds_queue_attach(&queue, &bus) == CDS_OK);
}

static void begin_health(void)
{
}

static void poll_health(void)
{
}

static void say_health(void)
{
}

static uint8_t most(void)
{
    return MOST;
}
#endif

/* Calls of the library stand between mark() and unmark(); the compiler moves no code past them. */
static inline void mark(void)
{
    PORTB |= MARK;
    __asm__ volatile("" ::: "memory");
}

static inline void unmark(void)
{
    __asm__ volatile("" ::: "memory");
    PORTB &= (uint8_t)~MARK;
}

/* A period begins, or a reply is overdue, without any interrupt of the bus: then it is time for a
 * call all the same. */
static uint16_t next_tick;

/* What the handlers of the bus change: there is work when a packet has left, when most of a reply
 * has come, and then with each byte, so that at its end there is the less to do before the next
 * READ. */
static uint8_t seen_state, due; // `due`: head of the ring

static bool anything_new(void)
{
    uint8_t state = bus.link.state;

    if (bus.state == CDS_BUS_SENDING) // the deadline of the packet that has begun is not set yet
        return true;
    if (state == seen_state || state != CDS_LINK_LISTENING)
        return (int8_t)(bus.link.rx.head - due) >= 0;
    due = (uint8_t)(bus.link.rx.head + most());
    return true;
}

static void wait(void)
{
    while (!anything_new()) {
        if ((int16_t)(TCNT1 - next_tick) >= 0) {
            next_tick += TICK;
            return;
        }
    }
}

static void poll(void)
{
    if ((int8_t)(bus.link.rx.head - due) >= 0)
        due = (uint8_t)(bus.link.rx.head + 1);
    mark();
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
    poll_health();
    unmark();
    seen_state = bus.link.state; // that of a packet which has just begun, not the one before it
}

/* Sets the goals of one period. Returns true if the cycle accepted all of them. */
static bool set_goals(uint16_t period)
{
    bool taken = true;

    for (uint8_t i = 0; i < servo_count; i++) {
        uint16_t position = (4u * period + 20u * i) & 0x3FF;

        if (position & 0x200) {
            position = 0x3FF - position;
        }
        mark();
        taken &= cds_cycle_goal(&cycle, i, 256 + position, SPEED) == CDS_OK;
        unmark();
    }
    mark();
    cds_cycle_commit(&cycle);
    unmark();
    return taken;
}

static void say_counters(void)
{
    struct cds_stats count;

    cds_bus_stats(&bus, &count);
    say("sent", count.sent);
    say("ok", count.ok);
    say("timeouts", count.timeouts);
    say("corrupt", count.corrupt);
    say("malformed", count.malformed);
    say("unexpected_packets", count.unexpected_packets);
    say("framing_errors", count.framing_errors);
    say("overruns", count.overruns);
    say("ring_overflows", count.ring_overflows);
}

/* So many periods; returns how often goals were refused. */
static uint16_t run(uint32_t periods)
{
    uint32_t second = PERIODS_PER_S, set = 0, over;
    uint16_t refused = !set_goals((uint16_t)set++);

    /* Periods begin on a tick. */
    next_tick = TCNT1 - (uint16_t)(cds_port_now_us() - cycle.next_us) * TICKS_PER_US;
    while ((over = cycle.counters.periods + cycle.counters.missed) < periods) {
        poll();
        if (cycle.counters.periods == set) // what was set is on its way
            refused += !set_goals((uint16_t)set++);
        if (over == second) {
            say_text(".\n"); // the USART has room for both
            second += PERIODS_PER_S;
        }
        wait();
    }
    cds_cycle_abort(&cycle);
    while (cds_cycle_poll(&cycle) == CDS_PENDING)
        cds_bus_poll(&bus);
    return refused;
}

static void set(uint8_t address, uint8_t value)
{
    static uint8_t packet[CDS_PACKET_SIZE(3)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);

    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, address, value);
    while (cds_bus_poll(&bus)) {
    }
}

static uint8_t option(uint8_t index, uint8_t otherwise)
{
    uint8_t value = eeprom_read_byte((const uint8_t *)0 + index);

    return value == ERASED ? otherwise : value;
}

int main(void)
{
    struct cds_cycle_config config = {.bus = &bus,
                                      .ids = ids,
                                      .packets = packets,
                                      .feedback = feedback,
                                      .period_us = CDS_CYCLE_PERIOD_US};
    uint8_t delay = option(3, RETURN_DELAY_FACTORY);
    uint16_t refused;

    servo_count = config.count = option(2, SERVOS_MAX);

    for (uint8_t i = 0; i < servo_count; i++) {
        ids[i] = (uint8_t)(i + 1);
    }
    DDRB = MARK;
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, (uint16_t)(2 * delay));
    if (delay != RETURN_DELAY_FACTORY)
        set(CDS_REG_RETURN_DELAY, delay);
#ifndef SAFE // a servo with limits is prepared first
    set(CDS_REG_TORQUE_ENABLE, 1);
#endif
    begin_servos();
    say("begun", cds_cycle_begin(&cycle, &config) == CDS_OK);
    begin_health();
    refused = run(PERIODS_PER_S * eeprom_read_word((const uint16_t *)0));
    say("periods", cycle.counters.periods);
    say("missed", cycle.counters.missed);
    say("refused", refused);
    say("unsent", cycle.counters.unsent);
    say("dropped", cycle.counters.dropped);
    say("reads", cycle.counters.reads);
    say("failed", cycle.counters.failed);
    say("oldest_us", cycle.counters.oldest_us);
    say("utilisation_permille", cds_cycle_utilisation_permille(&cycle));
    say("return_delay_us", 2ul * delay);
    say_counters();
    say_health();
    say_end();
}
