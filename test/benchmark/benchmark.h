/* What the programs of the bench share. Pins of port B, which no board of ours uses, are marks:
 * `cds55xx-sim --times FILE --stamp B` tells each step of them to the cycle. sbi and cbi use no
 * register, so the compiler does around them what it would do without; the two cycles of one are
 * taken off again, as MARK_NOTHING shows them. Arguments come from memory, or link-time
 * optimisation would build whole packets beforehand. */
#ifndef BENCHMARK_H
#define BENCHMARK_H

#include <avr/io.h>
#include <stdbool.h>
#include <stdint.h>

#include <cds55xx/queue.h>
#include <cds55xx/servo.h>
#include <cds55xx_avr.h>

#include "../firmware/library/say.h"

/* Pin of a mark: scripts/bench.py knows them by these numbers. */
enum {
    MARK_WHOLE = 0,   // from the typed call until the outcome is known
    MARK_CALL = 1,    // a typed call
    MARK_POLL = 2,    // a call of cds_bus_poll()
    MARK_SLOW = 3,    // any call of the library while all takes longer
    MARK_BUILD = 4,   // goals into a packet
    MARK_NOTHING = 7, // nothing
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

/* ---- What knows the library's API: a change of the API is a change of this part -------------- */

/* A request `name` and the memory for its packet and for a reply of up to `parameters` bytes (1 to
 * CDS_REPLY_MAX). */
#define BENCH_REQUEST(name, parameters)                                                            \
    static uint8_t name##_packet[CDS_PACKET_SIZE(5)], name##_reply[parameters];                    \
    static struct cds_request name = CDS_REQUEST(name##_packet, name##_reply)

/* A request `name` and the memory for a SYNC WRITE of `length` bytes to `servos` servos. */
#define BENCH_SYNC_WRITE(name, servos, length)                                                     \
    static uint8_t name##_bytes[CDS_SYNC_WRITE_SIZE(servos, length)];                              \
    static struct cds_request name = CDS_REQUEST_WITHOUT_DATA(name##_bytes)

/* Clock, bus and one pair of marks around nothing. The bus has no queue. */
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

/* From now on requests wait behind the one in flight. */
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

/* The packet of a request survives its reply. False: the reply's parameters take the packet's
 * place, and the packet is built again before each submit. */
#define BENCH_PACKET_SURVIVES true

/* The receive handler stores `byte`: only while the line is quiet, as the handler may not run
 * meanwhile. */
static inline void bench_hear(struct cds_bus *bus, uint8_t byte)
{
    cds_ring_put(&bus->link.rx, byte);
}

/* The last byte of a packet is not yet out. */
static inline bool bench_is_sending(const struct cds_bus *bus)
{
    return bus->link.state != CDS_LINK_LISTENING;
}

/* The last byte of a packet is with the USART, the byte before it begins. */
static inline bool bench_is_draining(const struct cds_bus *bus)
{
    return bus->link.state == CDS_LINK_DRAINING;
}

/* ---- The same for any API ----------------------------------------------------------------------
 */

static inline void bench_wait(struct cds_bus *bus)
{
    while (cds_bus_poll(bus)) {
    }
}

/* Byte `index` of the EEPROM, where the bench says what to measure. */
static inline uint8_t bench_option(uint8_t index)
{
    return eeprom_read_byte((const uint8_t *)0 + index);
}

/* Laps of the clock (32.768 ms each). In a new lap no handler of the clock runs for the whole of
 * it. */
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
