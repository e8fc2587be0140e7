/* What the programs of the bench share. Pins of port B, which no board of ours uses, are marks:
 * `cds55xx-sim --times FILE --stamp B` tells each step of them to the cycle. sbi and cbi use no
 * register, so the compiler does around them what it would do without; the two cycles of one are
 * taken off again, as MARK_NOTHING shows them. Arguments come from memory, or link-time
 * optimisation would build whole packets beforehand. */
#ifndef BENCH_H
#define BENCH_H

#include <avr/io.h>
#include <stdbool.h>
#include <stdint.h>

#include <cds55xx/queue.h>
#include <cds55xx/servo.h>
#include <cds55xx_avr.h>

#include "../program/say.h"

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

__attribute__((unused)) static struct cds_queue bench_queue;

/* Clock, bus and one pair of marks around nothing. */
static inline void bench_open(struct cds_bus *bus)
{
    DDRB = 0xFF;
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(bus, 0, CDS_BAUD_1M);
    mark(MARK_NOTHING);
    unmark(MARK_NOTHING);
}

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

#endif
