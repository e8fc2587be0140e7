/* Bytes of an input ring that wait for their turn. Main context, the ring's consumer. */
#ifndef CONTROLLER_INPUT_H
#define CONTROLLER_INPUT_H

#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring

/* The byte `index` places behind the oldest one; index: 0 to cds_ring_count() - 1. */
static inline uint8_t input_peek(const struct cds_ring *ring, uint8_t index)
{
    return cds_ring_at(ring, cds_ring_after(cds_ring_begin(ring), index));
}

/* Takes the `count` oldest bytes out, 0 to cds_ring_count(). */
static inline void input_drop(struct cds_ring *ring, uint8_t count)
{
    cds_ring_release(ring, cds_ring_after(cds_ring_begin(ring), count));
}

#endif
