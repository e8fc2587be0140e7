/* SPDX-License-Identifier: MIT */
/* Reads the feedback of several servos, 8 bytes each, by group_read.h at the factory return delay.
 * Twice. Byte 0 of the EEPROM is the number of servos. */
#include <cds55xx/group_read.h>

#include "benchmark.h"

#define SERVOS_MAX 50
#define BYTES      8

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packets[2][CDS_PACKET_SIZE(2)], replies[2][BYTES];
static struct cds_request requests[2] = {CDS_REQUEST(packets[0], replies[0]),
                                         CDS_REQUEST(packets[1], replies[1])};
static struct cds_group_read group;
static struct cds_group_answer answers[SERVOS_MAX];
static uint8_t ids[SERVOS_MAX], data[SERVOS_MAX * BYTES];
static volatile uint8_t address = CDS_REG_PRESENT_POSITION, bytes = BYTES;

BENCH_NOINLINE static enum cds_result read(uint8_t servos, uint8_t from, uint8_t length)
{
    const struct cds_group_read_config config = {.bus = &bus,
                                                 .requests = requests,
                                                 .ids = ids,
                                                 .data = data,
                                                 .answers = answers,
                                                 .count = servos,
                                                 .address = from,
                                                 .length = length};
    enum cds_result result;

    mark(MARK_WHOLE);
    cds_group_read_begin(&group, &config);
    while ((result = cds_group_read_poll(&group)) == CDS_PENDING)
        cds_bus_poll(&bus);
    unmark(MARK_WHOLE);
    return result;
}

int main(void)
{
    uint8_t servos = bench_option(0), good = 0;

    for (uint8_t i = 0; i < SERVOS_MAX; i++)
        ids[i] = (uint8_t)(i + 1);
    bench_open(&bus);
    cds_bus_set_return_delay(&bus, 2);
    for (uint8_t turn = 0; turn < 2; turn++)
        if (read(servos, address, bytes) == CDS_OK)
            good++;
    say("good", good);
    say_end();
}
