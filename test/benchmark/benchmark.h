/* SPDX-License-Identifier: MIT */
/* Shared by the programs of the benchmark. They mark code with pins of port B, which no board uses:
 * `cds55xx-sim --times FILE --stamp B` records each change of a pin with its cycle. sbi and cbi use
 * no register, so they do not change the code that the compiler makes around them. MARK_NOTHING
 * measures the two cycles of a mark, which are subtracted. Arguments come from memory; otherwise
 * link-time optimisation would build whole packets. */
#ifndef BENCHMARK_H
#define BENCHMARK_H

#include <avr/io.h>
#include <stdbool.h>
#include <stdint.h>

#include <cds55xx/queue.h>
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>

#include "../firmware/library/say.h"

/* Pins of the marks; scripts/measure.py uses the same numbers. */
enum {
    MARK_WHOLE = 0,   // from a call of servo.h or sync_write.h until the outcome is known
    MARK_CALL = 1,    // a call of the library that submits a request
    MARK_POLL = 2,    // a call of cds_bus_poll()
    MARK_SLOW = 3,    // any call of the library in the run with slow transactions
    MARK_BUILD = 4,   // building a packet from goals
    MARK_NOTHING = 7, // no code: the cycles of a mark itself
};

#define MARK_PORT_ "I"(_SFR_IO_ADDR(PORTB))

static inline __attribute__((always_inline)) void mark(uint8_t pin)
{
    __asm__ volatile("sbi %0, %1" ::MARK_PORT_, "I"(pin) : "memory");
}

static inline __attribute__((always_inline)) void unmark(uint8_t pin)
{
    __asm__ volatile("cbi %0, %1" ::MARK_PORT_, "I"(pin) : "memory");
}

#define BENCH_NOINLINE __attribute__((noinline, noclone))

/* ---- The only part that uses the API of the library ------------------------------------------ */

/* A request `name` and the memory for its packet and for a reply of up to `parameters` bytes (1 to
 * CDS_REPLY_MAX). */
#define BENCH_REQUEST(name, parameters)                                                            \
    static uint8_t name##_packet[CDS_PACKET_SIZE(5)], name##_reply[parameters];                    \
    static struct cds_request name = CDS_REQUEST(name##_packet, name##_reply)

/* A request `name` and the memory for a SYNC WRITE of `length` bytes to `servos` servos. */
#define BENCH_SYNC_WRITE(name, servos, length)                                                     \
    static uint8_t name##_bytes[CDS_SYNC_WRITE_SIZE(servos, length)];                              \
    static struct cds_request name = CDS_REQUEST_WITHOUT_DATA(name##_bytes)

/* Opens clock and bus, and makes one pair of marks around no code. The bus has no queue. */
static inline void bench_open_bare(struct cds_bus *bus)
{
    DDRB = 0xFF;
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(bus, 0, CDS_BAUD_1M);
    mark(MARK_NOTHING);
    unmark(MARK_NOTHING);
}

__attribute__((unused)) static struct cds_queue bench_queue;

/* Attaches a queue: requests wait behind the one in flight. */
static inline void bench_attach_queue(struct cds_bus *bus)
{
    cds_queue_attach(&bench_queue, bus);
}

static inline void bench_open(struct cds_bus *bus)
{
    bench_open_bare(bus);
    bench_attach_queue(bus);
}

/* The bus sends an idempotent request again, up to `retries` times (0 to 2). */
static inline void bench_set_retries(struct cds_bus *bus, uint8_t retries)
{
    (void)bus;
    cds_queue_set_retries(&bench_queue, retries);
}

/* Builds the READ that `request` sends when it is submitted. */
static inline void bench_build_read(struct cds_request *request, uint8_t id, uint8_t address,
                                    uint8_t length)
{
    cds_packet_read(&request->packet, id, address, length);
    request->reply_parameters = length;
}

/* True: the packet of a request survives its reply. False: the parameters of the reply overwrite
 * the packet, so it is built again before each submit. */
#define BENCH_PACKET_SURVIVES true

/* Stores `byte` as the receive handler does. Only while the line is quiet: the handler must not run
 * meanwhile. */
static inline void bench_hear(struct cds_bus *bus, uint8_t byte)
{
    cds_ring_put(&bus->link.rx, byte);
}

/* True while the last byte of a packet is not yet sent. */
static inline bool bench_is_sending(const struct cds_bus *bus)
{
    return bus->link.state != CDS_LINK_LISTENING;
}

/* True if the last byte of a packet is in the buffer of the USART, and the byte before it begins.
 */
static inline bool bench_is_draining(const struct cds_bus *bus)
{
    return bus->link.state == CDS_LINK_DRAINING;
}

/* ---- The part that does not use the API of the library --------------------------------------- */

static inline void bench_wait(struct cds_bus *bus)
{
    while (cds_bus_poll(bus)) {
    }
}

/* Returns byte `index` of the EEPROM, where measure.py writes what to measure. */
static inline uint8_t bench_option(uint8_t index)
{
    return eeprom_read_byte((const uint8_t *)0 + index);
}

/* The clock overflows every 32.768 ms. After bench_new_lap() its handler does not run until the
 * next overflow. */
static inline uint8_t bench_lap(void)
{
    return (uint8_t)(cds_port_now_us() >> 15);
}

static inline uint8_t bench_new_lap(void)
{
    uint8_t lap = bench_lap();

    while (bench_lap() == lap) {
    }
    return bench_lap();
}

/* Waits 4 cycles a turn, and one more for an odd number of turns. */
static inline void bench_idle(uint8_t turns)
{
    if (turns & 1)
        __asm__ volatile("nop");
    if (turns & 2)
        __asm__ volatile("nop\n\tnop");
    for (turns >>= 2; turns; turns--)
        __asm__ volatile("nop");
}

#endif
