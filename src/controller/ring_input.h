/* SPDX-License-Identifier: MIT */
/* Reads and drops bytes at the old end of a ring. Main context, and only the consumer of the ring.
 */
#ifndef CONTROLLER_RING_INPUT_H
#define CONTROLLER_RING_INPUT_H

#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring

/* Returns byte `index` of the ring, counted from the oldest byte: 0 to cds_ring_count() - 1. */
static inline uint8_t ring_peek(const struct cds_ring *ring, uint8_t index)
{
    return cds_ring_at(ring, cds_ring_after(cds_ring_begin(ring), index));
}

/* Drops the `count` oldest bytes, 0 to cds_ring_count(). */
static inline void ring_drop(struct cds_ring *ring, uint8_t count)
{
    cds_ring_release(ring, cds_ring_after(cds_ring_begin(ring), count));
}

#endif
