/* SPDX-License-Identifier: MIT */
/* Transactions of every kind with servos 1 to 3 at a return delay of 2 us, one after the other:
 * PING, a long READ, SYNC WRITE of goals, and READ of the goals. Prints the counters, and how many
 * goals were read as sent. */
#include <cds55xx/sync_write.h>
#include <cds55xx/servo.h>
#include <cds55xx/blocking.h>
#include <cds55xx/avr.h>
#include <util/delay.h>

#include "say.h"

#define ROUNDS 200

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_SYNC_WRITE_SIZE(3, 4)];
static uint8_t reply[CDS_REPLY_MAX];
static struct cds_request request = CDS_REQUEST(packet, reply);

static void sync_goals(uint16_t goal)
{
    cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t id = 1; id <= 3; id++)
        cds_sync_write_add_goal(&request, id, (uint16_t)(goal + id), 512);
    cds_blocking_sync_write(&bus, &request);
}

static bool has_goal(uint8_t id, uint16_t goal)
{
    uint16_t position = 0;

    return cds_blocking_read_word(&bus, &request, id, CDS_REG_GOAL_POSITION, &position) == CDS_OK &&
           position == goal + id;
}

static void say_counters(void)
{
    struct cds_stats counters;

    cds_bus_stats(&bus, &counters);
    say("sent", counters.sent);
    say("ok", counters.ok);
    say("timeouts", counters.timeouts);
    say("corrupt", counters.corrupt);
    say("unsent", counters.line_busy);
    say("refuted", counters.malformed);
    say("foreign", counters.unexpected_packets);
    say("framing_errors", counters.framing_errors);
    say("overruns", counters.overruns);
    say("echo_errors", counters.echo_errors);
}

int main(void)
{
    uint16_t good = 0;

    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    _delay_us(50); // what went on on the line before is not known
    cds_bus_set_return_delay(&bus, 2);
    cds_blocking_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY, 1);
    for (uint16_t round = 0; round < ROUNDS; round++) {
        uint8_t id = (uint8_t)(1 + round % 3);

        cds_blocking_ping(&bus, &request, id);
        cds_blocking_read(&bus, &request, id, 0, 49);
        sync_goals(round);
        good = (uint16_t)(good + has_goal(id, round));
    }
    say("good", good);
    say("txd_output", DDRD >> PD3 & 1);
    say_counters();
    say_end();
}
