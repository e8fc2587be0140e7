/* SPDX-License-Identifier: MIT */
/* A ring of bytes from one producer to one consumer, of which either may be an interrupt handler.
 *
 * Positions run freely and wrap at 256: the ring is empty when head and tail are equal and full
 * when they are CDS_RING_SIZE apart. They are 8 bits wide because an AVR loads and stores only 8
 * bits at once. The compiler must not store the head before the byte that it makes readable: the
 * consumer would read the old byte. Therefore bytes and positions are volatile, and the compiler
 * keeps the order of volatile accesses.
 *
 * A position is opaque to callers: only the functions below, link.h, parser.c and the port's
 * handlers know that it is an index.
 */
#ifndef CDS_RING_H
#define CDS_RING_H

#include <stdbool.h>
#include <stdint.h>

/* Bytes: a power of two that holds the longest reply, READ of all 50 registers: 56. */
#ifndef CDS_RING_SIZE
#define CDS_RING_SIZE 64
#endif

#if CDS_RING_SIZE != 64 && CDS_RING_SIZE != 128
#error "CDS_RING_SIZE must be 64 or 128"
#endif

/* Zeroed, it is empty. */
struct cds_ring {
    volatile uint8_t head;                 // next byte to be put; written by the producer only
    volatile uint8_t tail;                 // oldest byte; written by the consumer only
    volatile uint8_t bytes[CDS_RING_SIZE]; // position & (CDS_RING_SIZE - 1) is its place
};

/* Bytes in the ring, 0 to CDS_RING_SIZE. Either side. */
static inline uint8_t cds_ring_count(const struct cds_ring *ring)
{
    return (uint8_t)(ring->head - ring->tail);
}

/* Producer: true when stored, false when the ring is full. */
static inline bool cds_ring_put(struct cds_ring *ring, uint8_t byte)
{
    uint8_t head = ring->head;

    if ((uint8_t)(head - ring->tail) == CDS_RING_SIZE)
        return false;
    ring->bytes[head & (CDS_RING_SIZE - 1)] = byte;
    ring->head = (uint8_t)(head + 1);
    return true;
}

/* Consumer: the position of the oldest byte. */
static inline uint8_t cds_ring_begin(const struct cds_ring *ring)
{
    return ring->tail;
}

/* Consumer: the position after the newest byte. Grows at any time. */
static inline uint8_t cds_ring_end(const struct cds_ring *ring)
{
    return ring->head;
}

/* The position `count` bytes after `position`. */
static inline uint8_t cds_ring_after(uint8_t position, uint8_t count)
{
    return (uint8_t)(position + count);
}

/* Returns how many bytes lie from position `from` to position `to`, which is not before it. */
static inline uint8_t cds_ring_distance(uint8_t from, uint8_t to)
{
    return (uint8_t)(to - from);
}

/* Consumer: the byte at `position`, between begin and end. */
static inline uint8_t cds_ring_at(const struct cds_ring *ring, uint8_t position)
{
    return ring->bytes[position & (CDS_RING_SIZE - 1)];
}

/* Consumer: takes out all bytes before `position`, between begin and end. */
static inline void cds_ring_release(struct cds_ring *ring, uint8_t position)
{
    ring->tail = position;
}

#endif
