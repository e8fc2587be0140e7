/* SPDX-License-Identifier: MIT */
/* Marks every call of cds_bus_poll(). Cases: READs of all lengths, polled at once, or so late that
 * the whole reply has arrived or the deadline is over; a queue, whose next request begins in the
 * poll that ends a request; requests with priority; an on_end that submits again; timeouts and
 * retries. measure.py runs the program again with damaged replies, noise, and bytes FF before and
 * after replies. */
#include <cds55xx/sync_write.h>

#include "benchmark.h"

#define SERVOS  50
#define RETRIES 2
#define ABSENT  99
#define QUEUE   3
#define ROUNDS  16

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

BENCH_REQUEST(first, CDS_REPLY_MAX);
BENCH_REQUEST(second, CDS_REPLY_MAX);
BENCH_REQUEST(third, CDS_REPLY_MAX);
static struct cds_request *const requests[QUEUE] = {&first, &second, &third};
BENCH_SYNC_WRITE(goals, SERVOS, 4);
static struct cds_stats stats;
static uint32_t polls;
static uint16_t agains; // submits by on_end
static uint8_t again_left, again_length;

static bool poll(void)
{
    bool busy;

    mark(MARK_POLL);
    busy = cds_bus_poll(&bus);
    unmark(MARK_POLL);
    polls++;
    return busy;
}

/* Polls until the requests have ended, every `late_us`. */
static void run(uint16_t late_us)
{
    uint32_t from_us;

    do {
        from_us = cds_port_now_us();
        while (cds_port_now_us() - from_us < late_us) {
        }
    } while (poll());
}

/* on_end: submits the READ again, during the poll that ended it. */
static void again(struct cds_request *request)
{
    if (again_left == 0)
        return;
    again_left--;
    agains++;
    cds_servo_read(&bus, request, 1, CDS_REG_RESERVED_00, again_length);
}

/* READs of `length` bytes, then of 7 more each. `repeat`: number of READs that on_end submits. */
static void reads(uint16_t late_us, uint8_t length, uint8_t repeat)
{
    for (; length <= CDS_REPLY_MAX; length = (uint8_t)(length + 7)) {
        again_left = repeat;
        again_length = length;
        for (uint8_t i = 0; i < QUEUE; i++) {
            requests[i]->on_end = repeat ? again : NULL;
            cds_servo_read(&bus, requests[i], (uint8_t)(i + 1), CDS_REG_RESERVED_00, length);
        }
        run(late_us);
    }
}

/* One READ that on_end submits again, while no other request waits. */
static void chain(uint16_t late_us, uint8_t length)
{
    again_left = QUEUE;
    again_length = length;
    first.on_end = again;
    cds_servo_read(&bus, &first, 1, CDS_REG_RESERVED_00, length);
    run(late_us);
}

/* The queue: a READ, goals, a PING of an absent servo; then a READ with priority before both. */
static void goals_behind_a_read(uint16_t late_us)
{
    first.on_end = second.on_end = NULL;
    cds_servo_read(&bus, &first, 1, CDS_REG_PRESENT_POSITION, 8);
    cds_sync_write_begin(&goals, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t id = 1; id <= SERVOS; id++)
        cds_sync_write_add_goal(&goals, id, 512, 0);
    cds_sync_write_send(&bus, &goals);
    cds_servo_ping(&bus, &second, ABSENT);
    third.on_end = again;
    third.priority = CDS_PRIORITY_HIGH;
    again_left = 1;
    again_length = 12;
    cds_servo_read(&bus, &third, 2, CDS_REG_RESERVED_00, 12);
    run(late_us);
    third.priority = CDS_PRIORITY_NORMAL;
}

int main(void)
{
    static const uint16_t late_us[] = {0, 40, 250, 1000};

    bench_open(&bus);
    bench_set_retries(&bus, RETRIES);
    for (uint8_t i = 0; i < ROUNDS; i++) {
        cds_bus_set_return_delay(&bus, i & 1 ? 2 : CDS_RETURN_DELAY_MAX_US);
        for (uint8_t j = 0; j < sizeof(late_us) / sizeof(late_us[0]); j++) {
            reads(late_us[j], (uint8_t)(i % 7 + 1), 0);
            reads(late_us[j], (uint8_t)(i % 7 + 1), QUEUE);
            chain(late_us[j], (uint8_t)(3 * i + 2));
            goals_behind_a_read(late_us[j]);
        }
    }
    cds_bus_stats(&bus, &stats);
    say("polls", polls);
    say("agains", agains);
    say("ok", stats.ok);
    say_end();
}
