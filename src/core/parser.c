/* Finding packets in a ring; see parser.h. */
#include "cds55xx/parser.h"

#include "opaque.h" // CDS_APART

#define SUM_OF_ALL                                                                                 \
    UINT8_MAX // of a packet from the ID on, with its checksum, which is ~ of the rest

void cds_parser_begin(struct cds_parser *parser, uint8_t longest)
{
    parser->longest = longest;
    parser->seen = 0;
    parser->sum = 0;
    parser->length = 0;
}

/* With what changes at every byte in registers: an AVR loads and stores nothing else meanwhile. */
CDS_APART enum cds_parsed cds_parser_scan(struct cds_parser *parser, struct cds_ring *ring,
                                          uint8_t end)
{
    uint8_t tail = ring->tail, sum = parser->sum, parsed = CDS_PARSED_MORE, stray = 0;
    uint8_t begin = (uint8_t)(tail + parser->seen), at = begin;

    if ((uint8_t)(end - begin) > parser->left)
        end = (uint8_t)(begin + parser->left);
    while (at != end) {
        uint8_t seen = (uint8_t)(at - tail);
        uint8_t byte = ring->bytes[at & (CDS_RING_SIZE - 1)];

        at++;
        if (seen < CDS_AT_ID) {
            if (byte != CDS_HEADER) { // it is none of the two, and begins none either
                tail = at;
                stray++;
            }
            continue;
        }
        if (seen == CDS_AT_ID) {
            if (byte == CDS_HEADER) // R27: still header; the last two count
                tail++;
            else
                parser->id = sum = byte;
            continue;
        }
        sum = (uint8_t)(sum + byte);
        if (seen == CDS_AT_LENGTH) {
            parser->length = byte;
            parsed = byte < CDS_LENGTH_MIN || byte > parser->longest ? CDS_PARSED_REFUTED
                                                                     : CDS_PARSED_HEAD;
            break;
        }
        if (seen == (uint8_t)(parser->length + CDS_AT_LENGTH)) {
            parsed = sum == SUM_OF_ALL ? CDS_PARSED_PACKET : CDS_PARSED_REFUTED;
            break;
        }
        if (seen == CDS_AT_ERROR)
            parser->error = byte;
    }
    parser->stray = (uint16_t)(parser->stray + stray);
    parser->left = (uint8_t)(parser->left - (uint8_t)(at - begin));
    if (parsed == CDS_PARSED_REFUTED)
        at = ++tail;
    ring->tail = tail;
    parser->seen = (uint8_t)(at - tail);
    parser->sum = sum;
    return (enum cds_parsed)parsed;
}

void cds_parser_accept(struct cds_parser *parser, struct cds_ring *ring)
{
    cds_ring_drop(ring, (uint8_t)(parser->length + CDS_AT_LENGTH + 1));
    parser->seen = 0;
}
