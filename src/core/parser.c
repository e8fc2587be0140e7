/* Finding packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#include "opaque.h" // CDS_APART

#define SUM_OF_ALL                                                                                 \
    UINT8_MAX // of a packet from the ID on, with its checksum, which is ~ of the rest

static inline __attribute__((always_inline)) uint8_t peek(const struct cds_ring *ring, uint8_t at)
{
    return ring->bytes[at & (CDS_RING_SIZE - 1)];
}

CDS_APART uint8_t cds_parser_step(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t tail = ring->tail, count = (uint8_t)(end - tail), id, length;
    uint8_t parsed = CDS_PARSED_STRAY;

    if ((uint8_t)(count - 1u) >= CDS_RING_SIZE)
        return CDS_PARSED_MORE;
    if (peek(ring, tail) != CDS_HEADER)
        goto drop;
    if (count == CDS_AT_ID - 1)
        return CDS_PARSED_MORE;
    if (peek(ring, (uint8_t)(tail + 1)) != CDS_HEADER) {
        tail++;
        goto drop;
    }
    if (count == CDS_AT_ID)
        return CDS_PARSED_MORE;
    id = peek(ring, (uint8_t)(tail + CDS_AT_ID));
    parsed = CDS_PARSED_FF;
    if (id == CDS_HEADER)
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
    return CDS_PARSED_HEAD;
drop:
    ring->tail = (uint8_t)(tail + 1u);
    return parsed;
}

CDS_APART bool cds_parser_take(const struct cds_parser *parser, struct cds_ring *ring)
{
    uint8_t tail = ring->tail, at = (uint8_t)(tail + CDS_AT_ID), sum = 0;
    uint8_t end = (uint8_t)(tail + (parser->length + CDS_AT_LENGTH + 1));

    do {
        sum = (uint8_t)(sum + peek(ring, at++));
    } while (at != end);
    if (sum != SUM_OF_ALL)
        end = (uint8_t)(tail + 1u);
    ring->tail = end;
    return sum == SUM_OF_ALL;
}
