/* Finding packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#include "opaque.h" // CDS_APART

#define SUM_OF_ALL                                                                                 \
    UINT8_MAX // of a packet from the ID on, with its checksum, which is ~ of the rest

CDS_APART enum cds_parsed cds_parser_step(struct cds_parser *parser, struct cds_ring *ring,
                                          uint8_t end)
{
    uint8_t tail = ring->tail, count = (uint8_t)(end - tail), at = tail, sum = 0, length = 0;
    uint8_t parsed = CDS_PARSED_MORE;

    if (count > CDS_RING_SIZE)
        return CDS_PARSED_MORE;
    for (uint8_t seen = 0; count; seen++, count--) {
        uint8_t byte = ring->bytes[at++ & (CDS_RING_SIZE - 1)];

        if (seen < CDS_AT_ID) {
            if (byte == CDS_HEADER)
                continue;
            tail = at; // it is none of the two, and begins none either
            parser->stray++;
            parsed = CDS_PARSED_STRAY;
            break;
        }
        sum = (uint8_t)(sum + byte);
        if (seen == CDS_AT_ID) {
            parser->id = byte;
            if (byte != CDS_HEADER)
                continue;
            tail++; // R27: still header; the last two count
            parsed = CDS_PARSED_STRAY;
            break;
        }
        if (seen == CDS_AT_LENGTH) {
            parser->length = length = byte;
            if (byte >= CDS_LENGTH_MIN && byte <= parser->longest)
                continue;
            tail++;
            parsed = CDS_PARSED_REFUTED;
            break;
        }
        if (seen == CDS_AT_ERROR) {
            parser->error = byte;
            parsed = CDS_PARSED_HEAD;
            continue;
        }
        if (seen == (uint8_t)(length + CDS_AT_LENGTH)) {
            parsed = CDS_PARSED_PACKET;
            if (sum != SUM_OF_ALL) {
                tail++;
                parsed = CDS_PARSED_REFUTED;
            }
            break;
        }
    }
    ring->tail = tail;
    return (enum cds_parsed)parsed;
}
