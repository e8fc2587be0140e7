/* SPDX-License-Identifier: MIT */
/* A READ of 2 bytes whose packet is built once and submitted again and again, at the return delays
 * 2, 4, ... 32 us: the fastest way to read a servo. It runs between two overflows of the clock, so
 * that no other handler runs. */
#include "benchmark.h"

#define DELAYS 16

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

BENCH_REQUEST(request, 2);
BENCH_REQUEST(write, 2);
static volatile uint8_t servo = 1, address = CDS_REG_PRESENT_POSITION, length = 2;
static uint8_t good;

static void set_return_delay(uint8_t n)
{
    cds_servo_write_byte(&bus, &write, servo, CDS_REG_RETURN_DELAY, n);
    bench_wait(&bus);
    cds_bus_set_return_delay(&bus, (uint16_t)(2 * n));
}

BENCH_NOINLINE static void read_again(void)
{
    mark(MARK_WHOLE);
    cds_bus_submit(&bus, &request);
    while (cds_bus_poll(&bus)) {
    }
    unmark(MARK_WHOLE);
}

int main(void)
{
    uint8_t lap;

    bench_open_bare(&bus);
    bench_build_read(&request, servo, address, length);
    lap = bench_new_lap();
    for (uint8_t n = 1; n <= DELAYS; n++) {
        uint16_t position = 0;

        set_return_delay(n);
        read_again();
        if (cds_request_word(&request, 0, &position) == CDS_OK && position == 512)
            good++;
        if (!BENCH_PACKET_SURVIVES)
            bench_build_read(&request, servo, address, length);
    }
    say("good", good);
    say("torn", bench_lap() != lap);
    say_end();
}
