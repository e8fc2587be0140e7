/* SPDX-License-Identifier: MIT */
/* READs of 1, 2, 8 and 50 bytes from servo 1, each at the return delays 2, 4, ... 32 us, on a bus
 * without a queue. Then the submit of a READ, on an idle bus and behind another READ. Then PINGs
 * whose last stop bits end at different phases of the main loop. Each part runs between two
 * overflows of the clock, so that no other handler runs. */
#include "benchmark.h"

#define DELAYS 16
#define PINGS  64

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

BENCH_REQUEST(request, CDS_REPLY_MAX);
BENCH_REQUEST(other, 2);
static volatile uint8_t servo = 1, address = CDS_REG_PRESENT_POSITION, length = 2;
static volatile uint8_t sizes[] = {1, 2, 8, CDS_REPLY_MAX};
static uint8_t good, torn;

static void set_return_delay(uint8_t n)
{
    cds_servo_write_byte(&bus, &request, servo, CDS_REG_RETURN_DELAY, n);
    bench_wait(&bus);
    cds_bus_set_return_delay(&bus, (uint16_t)(2 * n));
}

BENCH_NOINLINE static void read(uint8_t id, uint8_t from, uint8_t count)
{
    mark(MARK_WHOLE);
    cds_servo_read(&bus, &request, id, from, count);
    while (cds_bus_poll(&bus)) {
    }
    unmark(MARK_WHOLE);
}

BENCH_NOINLINE static void submit(struct cds_request *which, uint8_t id, uint8_t from,
                                  uint8_t count)
{
    mark(MARK_CALL);
    cds_servo_read(&bus, which, id, from, count);
    unmark(MARK_CALL);
}

static void count_good(const struct cds_request *which)
{
    uint16_t position;

    if (cds_request_word(which, 0, &position) == CDS_OK && position == 512)
        good++;
}

/* Reads `count` bytes at all return delays. */
static void reads(uint8_t count)
{
    uint8_t lap = bench_new_lap();

    for (uint8_t n = 1; n <= DELAYS; n++) {
        set_return_delay(n);
        read(servo, count == CDS_REPLY_MAX ? CDS_REG_RESERVED_00 : address, count);
        if (request.result == CDS_OK && request.length == count)
            good++;
    }
    if (bench_lap() != lap)
        torn++;
}

static void submits(void)
{
    uint8_t lap;

    set_return_delay(1);
    bench_attach_queue(&bus);
    lap = bench_new_lap();
    for (uint8_t i = 0; i < 4; i++) {
        submit(&request, servo, address, length);
        bench_idle(i);
        submit(&other, servo, address, length);
        bench_wait(&bus);
        count_good(&request);
        count_good(&other);
    }
    if (bench_lap() != lap)
        torn++;
}

static void pings(void)
{
    uint8_t lap = bench_new_lap();

    for (uint8_t i = 0; i < PINGS; i++) {
        cds_servo_ping(&bus, &request, servo);
        bench_idle(i);
        bench_wait(&bus);
        if (request.result == CDS_OK)
            good++;
    }
    if (bench_lap() != lap)
        torn++;
}

int main(void)
{
    bench_open_bare(&bus);
    for (uint8_t i = 0; i < sizeof(sizes); i++)
        reads(sizes[i]);
    submits();
    pings();
    say("good", good);
    say("torn", torn);
    say_end();
}
