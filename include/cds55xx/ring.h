/* A ring of bytes from one producer to one consumer, of which either may be an interrupt handler.
 *
 * Indices run freely and wrap at 256: the ring is empty when they are equal and full when they are
 * CDS_RING_SIZE apart. They are 8 bits wide because an AVR loads and stores only that much at once.
 * The feared reordering is the compiler's: the index must not be stored before the byte it vouches
 * for. Therefore bytes and indices are all volatile, and volatile accesses keep their order.
 *
 * Manual: nothing.
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
    volatile uint8_t bytes[CDS_RING_SIZE]; // index & (CDS_RING_SIZE - 1) is its place
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

/* Consumer: the byte `offset` after the oldest. Only for offset < cds_ring_count(). */
static inline uint8_t cds_ring_peek(const struct cds_ring *ring, uint8_t offset)
{
    return ring->bytes[(uint8_t)(ring->tail + offset) & (CDS_RING_SIZE - 1)];
}

/* Consumer: takes the `count` oldest bytes out. Only for count <= cds_ring_count(). */
static inline void cds_ring_drop(struct cds_ring *ring, uint8_t count)
{
    ring->tail = (uint8_t)(ring->tail + count);
}

#endif
