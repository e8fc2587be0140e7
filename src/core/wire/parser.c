/* SPDX-License-Identifier: MIT */
/* Finds and checks status packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#include <stddef.h>

#include "compiler.h" // NOINLINE

#define SUM_OF_PACKET UINT8_MAX // from the ID on, with the checksum, which is ~ of the others

/* As cds_ring_at(). The barrier lets gcc use X: two registers less to save, 8 cycles a call. */
ALWAYS_INLINE uint8_t byte_at(const struct cds_ring *ring, uint8_t position)
{
    const volatile uint8_t *place = &ring->bytes[position & (CDS_RING_SIZE - 1)];

    OPTIMIZER_BARRIER(place);
    return *place;
}

/* The candidate at the ring's tail is no packet. */
static uint8_t reject(struct cds_parser *parser, struct cds_ring *ring)
{
    cds_parser_skip_damage(parser, ring, cds_ring_after(cds_ring_begin(ring), 1));
    return CDS_PARSED_MALFORMED;
}

/* Searches for a header, an ID and a LENGTH in range. HEAD: they stand at the ring's tail. */
ALWAYS_INLINE uint8_t find_head(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t at = cds_ring_begin(ring), offset = 0, left = CDS_PARSER_SKIPPED_MAX;

    for (;;) {
        uint8_t position = cds_ring_after(at, offset), byte;

        if (position == end)
            break;
        byte = byte_at(ring, position);
        offset++;
        if (offset <= CDS_AT_ID) {
            if (byte == CDS_HEADER)
                continue;
            parser->noise_bytes++;
            at = cds_ring_after(at, offset);
            offset = 0;
        } else if (offset == CDS_AT_LENGTH) {
            parser->id = byte;
            if (byte != CDS_HEADER)
                continue;
            at = cds_ring_after(at, 1); // R27: the last two FF are the header
            offset = CDS_AT_ID;
        } else {
            parser->length = byte;
            if (byte < CDS_LENGTH_MIN || byte > parser->longest)
                return reject(parser, ring);
            parser->found = CDS_FOUND_LENGTH;
            return CDS_PARSED_HEAD;
        }
        cds_ring_release(ring, at);
        if (--left == 0) {
            parser->position = at;
            return CDS_PARSED_SOME;
        }
    }
    parser->position = end;
    return CDS_PARSED_MORE;
}

/* In two steps, so that less is left to do when ERROR has come: at 1 Mbps and 16 MHz 110 cycles
 * remain for each byte. */
uint8_t cds_parser_find(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t at, parsed, error;

    if (parser->found == CDS_FOUND_NOTHING) {
        parsed = find_head(parser, ring, end);
        if (parsed != CDS_PARSED_HEAD)
            return parsed;
    }
    at = cds_ring_after(cds_ring_begin(ring), CDS_AT_ERROR);
    parser->position = at;
    if (at == end)
        return CDS_PARSED_MORE;
    error = byte_at(ring, at);
    parser->error = error;
    parser->sum = (uint8_t)(parser->id + parser->length + error);
    parser->position = cds_ring_after(at, 1);
    parser->end = cds_ring_after(at, (uint8_t)(parser->length - 1u));
    parser->to = NULL;
    parser->found = CDS_FOUND_HEAD;
    return CDS_PARSED_HEAD;
}

uint8_t cds_parser_take_some(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t at = parser->position, last = parser->end, sum = parser->sum;

    if (at != last) {
        uint8_t *to = parser->to;

        if (cds_ring_distance(at, end) > CDS_PARSER_TAKEN_MAX)
            end = cds_ring_after(at, CDS_PARSER_TAKEN_MAX);
        do {
            uint8_t byte = byte_at(ring, at);

            sum = (uint8_t)(sum + byte);
            if (to)
                *to++ = byte;
            at = cds_ring_after(at, 1);
            if (at == end) {
                parser->position = at;
                parser->sum = sum;
                parser->to = to;
                return CDS_PARSED_SOME;
            }
        } while (at != last);
    }
    sum = (uint8_t)(sum + byte_at(ring, at));
    if (sum == SUM_OF_PACKET) {
        at = cds_ring_after(at, 1);
        parser->position = at;
        parser->found = CDS_FOUND_NOTHING;
        cds_ring_release(ring, at);
        return CDS_PARSED_PACKET;
    }
    return reject(parser, ring);
}

NOINLINE void cds_parser_skip_damage(struct cds_parser *parser, struct cds_ring *ring,
                                     uint8_t position)
{
    cds_ring_release(ring, position);
    parser->position = position;
    parser->found = CDS_FOUND_NOTHING;
    parser->is_clean = false;
}
