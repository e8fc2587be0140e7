/* SPDX-License-Identifier: MIT */
/* READs of 20 bytes back to back at 2 Mbps. EEPROM: byte 0 is the number of seconds, byte 1 the
 * return delay (register 0x05). Prints the number of lost replies. */
#include "benchmark.h"

#define BAUD_2M 0
#define BYTES   20

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

BENCH_REQUEST(request, BYTES);

static void set(uint8_t address, uint8_t value)
{
    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, address, value);
    bench_wait(&bus);
}

int main(void)
{
    uint32_t until_us = 1000000 * (uint32_t)bench_option(0), reads = 0;
    struct cds_stats count;

    bench_open(&bus);
    cds_bus_set_return_delay(&bus, (uint16_t)(2 * bench_option(1)));
    set(CDS_REG_RETURN_DELAY, bench_option(1));
    set(CDS_REG_BAUD_RATE, BAUD_2M);
    cds_bus_set_baud(&bus, BAUD_2M);
    for (; cds_port_now_us() < until_us; reads++) {
        cds_servo_read(&bus, &request, 1, CDS_REG_GOAL_POSITION, BYTES);
        bench_wait(&bus);
    }
    cds_bus_stats(&bus, &count);
    say("reads", reads);
    say("timeouts", count.timeouts);
    say("corrupt", count.corrupt);
    say("overruns", count.overruns);
    say("framing_errors", count.framing_errors);
    say("ring_overflows", count.ring_overflows);
    say_end();
}
