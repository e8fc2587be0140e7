/* SPDX-License-Identifier: MIT */
/* Measures the submit of a READ while the ring holds 1 to 64 bytes that no servo was asked for.
 * There is a case for each kind of byte that the search treats differently, on an idle bus and
 * behind another READ. The program stores the bytes itself, as the receive handler does, while the
 * line is quiet, so that each case occurs. */
#include "benchmark.h"

#define LONGEST 56 // bytes of a reply of 50 parameters
#define ROUNDS  4

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

BENCH_REQUEST(request, 2);
BENCH_REQUEST(other, 2);
static volatile uint8_t servo = 1, address = CDS_REG_PRESENT_POSITION, length = 2;
static uint16_t ok, submits;

enum kind {
    HEADERS,    // FF FF FF ...
    NO_HEADERS, // nothing that begins a packet
    HALVES,     // FF 00 FF 00 ...: each second byte begins no packet
    PACKETS,    // good status packets of 2 parameters
    LONG,       // one good status packet of 50 parameters
    REFUTED,    // the same with a wrong checksum
    RANDOM,
    KINDS,
};

static uint8_t random_byte(void)
{
    static uint16_t state = 1;

    state = (uint16_t)(state * 25173u + 13849u);
    return (uint8_t)(state >> 8);
}

/* Returns byte `at` of a good status packet of servo 9 whose parameters are all 1. */
static uint8_t status_byte(uint8_t at, uint8_t parameters)
{
    if (at < 2)
        return 0xFF;
    if (at == 2)
        return 9;
    if (at == 3)
        return (uint8_t)(parameters + 2);
    if (at == 4)
        return 0;
    if (at < 5 + parameters)
        return 1;
    return (uint8_t) ~(9 + parameters + 2 + parameters);
}

static uint8_t byte_of(enum kind kind, uint8_t at)
{
    switch (kind) {
    case HEADERS: return 0xFF;
    case NO_HEADERS: return 0x55;
    case HALVES: return at & 1 ? 0 : 0xFF;
    case PACKETS: return status_byte(at % 8, 2);
    case LONG: return status_byte(at % LONGEST, 50);
    case REFUTED: return (uint8_t)(status_byte(at % LONGEST, 50) ^ (at % LONGEST == LONGEST - 1));
    default: return random_byte();
    }
}

BENCH_NOINLINE static void submit(struct cds_request *which, uint8_t id, uint8_t from,
                                  uint8_t count)
{
    mark(MARK_CALL);
    cds_servo_read(&bus, which, id, from, count);
    unmark(MARK_CALL);
    submits++;
}

/* Polls until the bus takes the line as quiet. */
static void settle(void)
{
    uint32_t from_us = cds_port_now_us();

    bench_wait(&bus);
    while (cds_port_now_us() - from_us < 100)
        cds_bus_poll(&bus);
}

static void count_ok(const struct cds_request *which)
{
    if (which->result == CDS_OK)
        ok++;
}

static void one_case(enum kind kind, uint8_t bytes)
{
    for (uint8_t i = 0; i < bytes; i++)
        bench_hear(&bus, byte_of(kind, i));
    submit(&request, servo, address, length);
    submit(&other, servo, address, length);
    settle();
    count_ok(&request);
    count_ok(&other);
}

int main(void)
{
    bench_open(&bus);
    cds_bus_set_return_delay(&bus, 2);
    settle();
    for (uint8_t round = 0; round < ROUNDS; round++)
        for (uint8_t kind = 0; kind < KINDS; kind++)
            for (uint8_t bytes = 1; bytes <= CDS_RING_SIZE; bytes++)
                one_case((enum kind)kind, bytes);
    say("submits", submits);
    say("ok", ok);
    say_end();
}
