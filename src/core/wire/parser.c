/* Finds and checks status packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#include <stddef.h>

#include "compiler.h" // NOINLINE

#define SUM_OF_PACKET UINT8_MAX // from the ID on, with the checksum, which is ~ of the rest

/* The candidate at the ring's tail is no packet. */
static uint8_t reject(struct cds_parser *parser, struct cds_ring *ring)
{
    cds_parser_skip_damage(parser, ring, cds_ring_after(cds_ring_begin(ring), 1));
    return CDS_PARSED_MALFORMED;
}

NOINLINE uint8_t cds_parser_find(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t at = cds_ring_begin(ring), offset = 0, calls = CDS_PARSER_SKIPPED_MAX, byte;

    for (;;) {
        uint8_t position = cds_ring_after(at, offset);

        parser->position = position;
        if (position == end)
            return CDS_PARSED_MORE;
        byte = cds_ring_at(ring, position);
        if (offset < CDS_AT_ID) {
            offset++;
            if (byte == CDS_HEADER)
                continue;
            parser->noise_bytes++;
            at = cds_ring_after(at, offset);
            offset = 0;
        } else if (offset == CDS_AT_ID) {
            parser->id = byte;
            offset++;
            if (byte != CDS_HEADER)
                continue;
            at = cds_ring_after(at, 1); // R27: the last two FF are the header
            offset = CDS_AT_ID;
        } else if (offset == CDS_AT_LENGTH) {
            parser->length = byte;
            offset++;
            if (byte < CDS_LENGTH_MIN || byte > parser->longest)
                return reject(parser, ring);
            continue;
        } else {
            break;
        }
        cds_ring_release(ring, at);
        if (--calls == 0) {
            parser->position = at;
            return CDS_PARSED_SOME;
        }
    }
    parser->error = byte;
    parser->sum = (uint8_t)(parser->id + parser->length + byte);
    parser->position = cds_ring_after(at, CDS_AT_PARAMETERS);
    parser->end = cds_ring_after(at, (uint8_t)(parser->length + CDS_AT_LENGTH));
    parser->to = NULL;
    parser->is_in_packet = true;
    return CDS_PARSED_HEAD;
}

NOINLINE uint8_t cds_parser_take(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
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

NOINLINE void cds_parser_skip_damage(struct cds_parser *parser, struct cds_ring *ring,
                                     uint8_t position)
{
    cds_ring_release(ring, position);
    parser->position = position;
    parser->is_in_packet = false;
    parser->is_clean = false;
}
