/* SPDX-License-Identifier: MIT */
/* READ from an absent servo: the time until the outcome is known, and the longest call of the
 * library meanwhile. The second run has a rate and a return delay that make the transaction fifteen
 * times as long. A call that waits would take longer in that run. */
#include "benchmark.h"

#define ABSENT     99
#define SLOW_BAUD  34 // 57 143 bit/s
#define SETTLED_US 2000

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

BENCH_REQUEST(request, 2);
static volatile uint8_t servo = ABSENT, address = CDS_REG_PRESENT_POSITION, length = 2;
static uint8_t timeouts;

/* Polls until no stale reply can come any more; the next READ would wait for it. */
static void settle(void)
{
    uint32_t from_us = cds_port_now_us();

    while (cds_port_now_us() - from_us < SETTLED_US)
        cds_bus_poll(&bus);
}

BENCH_NOINLINE static void whole(uint8_t id, uint8_t from, uint8_t count)
{
    mark(MARK_WHOLE);
    cds_servo_read(&bus, &request, id, from, count);
    while (cds_bus_poll(&bus)) {
    }
    unmark(MARK_WHOLE);
    if (request.result == CDS_TIMEOUT)
        timeouts++;
}

/* Marks each call by itself. Inlined, so that `pin` is a constant for sbi and cbi. */
static inline __attribute__((always_inline)) void calls(uint8_t pin, uint8_t id, uint8_t from,
                                                        uint8_t count)
{
    bool busy;

    mark(pin);
    cds_servo_read(&bus, &request, id, from, count);
    unmark(pin);
    do {
        mark(pin);
        busy = cds_bus_poll(&bus);
        unmark(pin);
    } while (busy);
    if (request.result == CDS_TIMEOUT)
        timeouts++;
}

BENCH_NOINLINE static void quick(uint8_t id, uint8_t from, uint8_t count)
{
    calls(MARK_CALL, id, from, count);
}

BENCH_NOINLINE static void slow(uint8_t id, uint8_t from, uint8_t count)
{
    calls(MARK_SLOW, id, from, count);
}

int main(void)
{
    bench_open_bare(&bus);
    cds_bus_set_return_delay(&bus, 2);
    whole(servo, address, length);
    settle();
    quick(servo, address, length);
    cds_bus_set_return_delay(&bus, CDS_RETURN_DELAY_MAX_US);
    cds_bus_set_baud(&bus, SLOW_BAUD);
    settle();
    slow(servo, address, length);
    say("timeouts", timeouts);
    say_end();
}
