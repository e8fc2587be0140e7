/* Finding packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#define SUM_OF_ALL                                                                                 \
    UINT8_MAX // of a packet from the ID on, with its checksum, which is ~ of the rest

void cds_parser_begin(struct cds_parser *parser, uint8_t longest)
{
    parser->longest = longest;
    parser->seen = 0;
    parser->sum = 0;
    parser->length = 0;
}

/* The first `count` bytes begin no packet. */
static void skip(struct cds_parser *parser, struct cds_ring *ring, uint8_t count)
{
    cds_ring_drop(ring, count);
    parser->seen = 0;
}

static enum cds_parsed refute(struct cds_parser *parser, struct cds_ring *ring)
{
    skip(parser, ring, 1);
    return CDS_PARSED_REFUTED;
}

enum cds_parsed cds_parser_step(struct cds_parser *parser, struct cds_ring *ring)
{
    uint8_t at = parser->seen;
    uint8_t byte = cds_ring_peek(ring, at);
    uint8_t sum = (uint8_t)(parser->sum + byte);

    parser->seen = (uint8_t)(at + 1);
    if (at >= CDS_AT_ERROR) {
        if (at == (uint8_t)(parser->length + CDS_AT_LENGTH))
            return cds_parser_ends_well(parser, byte) ? CDS_PARSED_PACKET : refute(parser, ring);
        if (at == CDS_AT_ERROR)
            parser->error = byte;
    } else if (at == CDS_AT_LENGTH) {
        if (byte < CDS_LENGTH_MIN || byte > parser->longest)
            return refute(parser, ring);
        parser->length = byte;
    } else if (at == CDS_AT_ID) {
        if (byte == CDS_HEADER) { // R27: still header; the last two of them count
            cds_ring_drop(ring, 1);
            parser->seen = CDS_AT_ID;
            return CDS_PARSED_MORE;
        }
        parser->id = byte;
    } else {
        if (byte != CDS_HEADER) { // it is none of the two, and begins none either
            skip(parser, ring, (uint8_t)(at + 1));
            parser->stray++;
        }
        sum = 0;
    }
    parser->sum = sum;
    return CDS_PARSED_MORE;
}

void cds_parser_accept(struct cds_parser *parser, struct cds_ring *ring)
{
    cds_ring_drop(ring, (uint8_t)(parser->length + CDS_AT_LENGTH + 1));
    parser->seen = 0;
}
