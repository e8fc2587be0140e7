/* Finding packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#include "compiler.h" // NOINLINE

#define SUM_OF_ALL                                                                                 \
    UINT8_MAX // of a packet from the ID on, with its checksum, which is ~ of the rest

ALWAYS_INLINE uint8_t peek(const struct cds_ring *ring, uint8_t at)
{
    return ring->bytes[at & (CDS_RING_SIZE - 1)];
}

/* Instead of that of account.c, where nothing is counted. */
__attribute__((weak)) void cds_parser_note_stray_(struct cds_parser *parser)
{
    (void)parser;
}

NOINLINE void cds_parser_refute(struct cds_parser *parser, struct cds_ring *ring)
{
    ring->tail++;
    parser->is_clean = false;
}

NOINLINE uint8_t cds_parser_step(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t tail = ring->tail, steps = CDS_PARSER_SKIPPED_MAX + 1, id, length;

    for (;;) {
        int8_t more = (int8_t)(end - tail - 1); // bytes, behind the first

        if (more < 0)
            return CDS_PARSED_MORE;
        if (--steps == 0)
            return CDS_PARSED_SKIPPED;
        if (peek(ring, tail) != CDS_HEADER)
            goto stray;
        if (more == 0)
            return CDS_PARSED_MORE;
        if (peek(ring, (uint8_t)(tail + 1)) != CDS_HEADER) {
            tail++;
            goto stray;
        }
        if (more == CDS_AT_ID - 1)
            return CDS_PARSED_MORE;
        id = peek(ring, (uint8_t)(tail + CDS_AT_ID));
        if (id == CDS_HEADER) // R27: still header; the last two count
            goto drop;
        if (more == CDS_AT_LENGTH - 1)
            return CDS_PARSED_MORE;
        parser->id = id;
        length = peek(ring, (uint8_t)(tail + CDS_AT_LENGTH));
        parser->length = length;
        if (length < CDS_LENGTH_MIN || length > parser->longest) {
            cds_parser_refute(parser, ring);
            return CDS_PARSED_REFUTED;
        }
        if (more == CDS_AT_ERROR - 1)
            return CDS_PARSED_MORE;
        if (steps != CDS_PARSER_SKIPPED_MAX)
            return CDS_PARSED_SKIPPED; // enough for one step
        parser->error = peek(ring, (uint8_t)(tail + CDS_AT_ERROR));
        return CDS_PARSED_HEAD;
    stray:
        cds_parser_note_stray_(parser);
    drop:
        ring->tail = ++tail;
    }
}

NOINLINE bool cds_parser_take(struct cds_parser *parser, struct cds_ring *ring)
{
    uint8_t at = (uint8_t)(ring->tail + CDS_AT_ID), sum = 0;
    uint8_t end = (uint8_t)(ring->tail + parser->length + CDS_AT_LENGTH + 1);

    do {
        sum = (uint8_t)(sum + peek(ring, at++));
    } while (at != end);
    if (sum != SUM_OF_ALL) {
        cds_parser_refute(parser, ring);
        return false;
    }
    ring->tail = end;
    return true;
}
