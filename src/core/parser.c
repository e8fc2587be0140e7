/* Finding packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#include "opaque.h" // CDS_APART

#define SUM_OF_ALL                                                                                 \
    UINT8_MAX // of a packet from the ID on, with its checksum, which is ~ of the rest

static inline __attribute__((always_inline)) uint8_t peek(const struct cds_ring *ring, uint8_t at)
{
    return ring->bytes[at & (CDS_RING_SIZE - 1)];
}

/* Of the `size` bytes from byte `at` of the ring on, at least one. */
static uint8_t sum_of(const struct cds_ring *ring, uint8_t at, uint8_t size)
{
    uint8_t sum = 0;

    do {
        sum = (uint8_t)(sum + peek(ring, at++));
    } while (--size);
    return sum;
}

CDS_APART uint8_t cds_parser_step(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t tail = ring->tail, count = (uint8_t)(end - tail), id, length;
    uint8_t parsed = CDS_PARSED_STRAY;

    if ((uint8_t)(count - 1u) >= CDS_RING_SIZE)
        return CDS_PARSED_MORE;
    if (peek(ring, tail) != CDS_HEADER)
        goto stray;
    if (count == CDS_AT_ID - 1)
        return CDS_PARSED_MORE;
    if (peek(ring, (uint8_t)(tail + 1)) != CDS_HEADER) {
        tail++;
        goto stray;
    }
    if (count == CDS_AT_ID)
        return CDS_PARSED_MORE;
    id = peek(ring, (uint8_t)(tail + CDS_AT_ID));
    if (id == CDS_HEADER) // R27: still header; the last two count
        goto drop;
    if (count == CDS_AT_LENGTH)
        return CDS_PARSED_MORE;
    parser->id = id;
    length = peek(ring, (uint8_t)(tail + CDS_AT_LENGTH));
    parser->length = length;
    parsed = CDS_PARSED_REFUTED;
    if (length < CDS_LENGTH_MIN || length > parser->longest)
        goto drop;
    if (count == CDS_AT_ERROR)
        return CDS_PARSED_MORE;
    parser->error = peek(ring, (uint8_t)(tail + CDS_AT_ERROR));
    if (count <= (uint8_t)(length + CDS_AT_LENGTH))
        return CDS_PARSED_HEAD;
    if (sum_of(ring, (uint8_t)(tail + CDS_AT_ID), (uint8_t)(length + 2u)) == SUM_OF_ALL)
        return CDS_PARSED_PACKET;
    goto drop;
stray:
    parser->stray++;
drop:
    ring->tail = (uint8_t)(tail + 1u);
    return parsed;
}
