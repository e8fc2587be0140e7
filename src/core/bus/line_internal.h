/* SPDX-License-Identifier: MIT */
/* The line between two packets, and the deadline of the one in flight; for the files of the bus and
 * cycle.c. Main context. */
#ifndef CDS_LINE_INTERNAL_H
#define CDS_LINE_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus
#include "compiler.h"    // ALWAYS_INLINE

/* Bits of bus->gate: what the bus must check before a packet leaves. GATE_PERMIT makes the bus
 * ask the permit; each other bit holds packets back. */
enum {
    GATE_SUSPECT = 1, // the line was used or low within the last two byte times
    GATE_FAULT = 2,   // the line was low when these two byte times were over
    GATE_STALE = 4,   // a stale reply may come: packets that expect a reply wait
    GATE_LOCKED = 8,  // an operation holds the bus
    GATE_PERMIT = 16, // the hooks have a permit, which must be asked
    GATE_LOW = 32,    // the line was low since these two byte times began
    GATE_LINE = GATE_SUSPECT | GATE_FAULT | GATE_LOW,
};

/* Sets the timer to the longest time `bytes` bytes and `more_us` may take after `from`. */
void cds_line_set_deadline(struct cds_bus *bus, uint16_t from, uint16_t bytes, uint16_t more_us);

/* The timer has expired. Returns 1 if this is the last expiry before the deadline; else counts it
 * and returns 0. */
uint8_t cds_line_take_expiry(struct cds_bus *bus);

/* Returns 1 if the deadline is over; counts an earlier expiry of the timer. */
ALWAYS_INLINE uint8_t cds_line_check_deadline(struct cds_bus *bus)
{
    return cds_port_timer_expired(bus->port) ? cds_line_take_expiry(bus) : 0;
}

/* Begins a rest, a pause of the bus, because the line was used or a reply failed. From now on every
 * packet waits for two byte times. A packet that expects a reply waits for `stale_us` if `stale_us`
 * is longer. A longer rest under way goes on. */
void cds_line_rest(struct cds_bus *bus, uint16_t stale_us);

/* Clears the line and stale bits of the gate whose time is over. */
void cds_line_check_rest(struct cds_bus *bus);

/* True if the receiver has stored or damaged bytes since the last search. */
ALWAYS_INLINE uint8_t cds_line_has_unread_bytes(const struct cds_bus *bus)
{
    return (uint8_t)(bus->link.broken | (bus->parser.position ^ cds_ring_end(&bus->link.rx)));
}

#endif
