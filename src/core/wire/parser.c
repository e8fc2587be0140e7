/* Finds and checks status packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#include <stddef.h>

#include "compiler.h" // NOINLINE

#define SUM_OF_PACKET UINT8_MAX // from the ID on, with the checksum, which is ~ of the rest

/* The candidate at the ring's tail is no packet. */
static enum cds_parsed reject(struct cds_parser *parser, struct cds_ring *ring)
{
    uint8_t next = cds_ring_after(cds_ring_begin(ring), 1);

    cds_ring_release(ring, next);
    parser->position = next;
    parser->is_in_packet = false;
    parser->is_clean = false;
    return CDS_PARSED_MALFORMED;
}

/* All five bytes of a head stand in the ring from position `at` on. */
static inline enum cds_parsed take_head(struct cds_parser *parser, struct cds_ring *ring,
                                        uint8_t at)
{
    uint8_t id = cds_ring_at(ring, cds_ring_after(at, CDS_AT_ID));
    uint8_t length = cds_ring_at(ring, cds_ring_after(at, CDS_AT_LENGTH));
    uint8_t error = cds_ring_at(ring, cds_ring_after(at, CDS_AT_ERROR));

    parser->id = id;
    parser->length = length;
    parser->error = error;
    parser->sum = (uint8_t)(id + length + error);
    parser->end = cds_ring_after(at, (uint8_t)(length + CDS_AT_LENGTH));
    parser->position = cds_ring_after(at, CDS_AT_PARAMETERS);
    parser->to = NULL;
    parser->is_in_packet = true;
    return CDS_PARSED_HEAD;
}

NOINLINE enum cds_parsed cds_parser_find(struct cds_parser *parser, struct cds_ring *ring,
                                         uint8_t end)
{
    uint8_t at = cds_ring_begin(ring), skipped = 0;

    for (;;) {
        uint8_t count = cds_ring_distance(at, end), length;

        parser->position = end; // unless something is found before it
        if (count == 0)
            return CDS_PARSED_MORE;
        if (cds_ring_at(ring, at) != CDS_HEADER) {
            parser->noise_bytes++;
        } else if (count == 1) {
            return CDS_PARSED_MORE;
        } else if (cds_ring_at(ring, cds_ring_after(at, 1)) != CDS_HEADER) {
            at = cds_ring_after(at, 1);
            parser->noise_bytes++;
        } else if (count == CDS_AT_ID) {
            return CDS_PARSED_MORE;
        } else if (cds_ring_at(ring, cds_ring_after(at, CDS_AT_ID)) != CDS_HEADER) {
            if (count == CDS_AT_LENGTH)
                return CDS_PARSED_MORE;
            length = cds_ring_at(ring, cds_ring_after(at, CDS_AT_LENGTH));
            if (length < CDS_LENGTH_MIN || length > parser->longest)
                return reject(parser, ring);
            return count > CDS_AT_ERROR ? take_head(parser, ring, at) : CDS_PARSED_MORE;
        } // else R27: an FF before the header
        at = cds_ring_after(at, 1);
        cds_ring_release(ring, at);
        if (++skipped == CDS_PARSER_SKIPPED_MAX) {
            parser->position = at;
            return CDS_PARSED_SOME;
        }
    }
}

NOINLINE enum cds_parsed cds_parser_take(struct cds_parser *parser, struct cds_ring *ring,
                                         uint8_t end)
{
    uint8_t at = parser->position, last = parser->end, sum = parser->sum;
    uint8_t count = cds_ring_distance(at, end);
    uint8_t *to = parser->to;

    if (count == 0)
        return CDS_PARSED_MORE;
    if (count > CDS_PARSER_TAKEN_MAX)
        count = CDS_PARSER_TAKEN_MAX;
    do {
        uint8_t byte = cds_ring_at(ring, at);

        sum = (uint8_t)(sum + byte);
        if (at == last) {
            if (sum != SUM_OF_PACKET)
                return reject(parser, ring);
            at = cds_ring_after(at, 1);
            parser->position = at;
            parser->is_in_packet = false;
            cds_ring_release(ring, at);
            return CDS_PARSED_PACKET;
        }
        at = cds_ring_after(at, 1);
        if (to)
            *to++ = byte;
    } while (--count);
    parser->sum = sum;
    parser->position = at;
    parser->to = to;
    return CDS_PARSED_SOME;
}

void cds_parser_skip_damage(struct cds_parser *parser, struct cds_ring *ring, uint8_t position)
{
    cds_ring_release(ring, position);
    parser->position = position;
    parser->is_in_packet = false;
    parser->is_clean = false;
}
