/* SPDX-License-Identifier: MIT */
/* Finds and checks status packets in the bytes that a receiver has put into a ring. No input or
 * output of its own. All functions: the context of the ring's consumer. Manual: 2.3; rulings R27
 * (any number of 0xFF before the ID; LENGTH 2 to 254), R28.
 *
 * A packet is examined where it lies, and leaves the ring when it is accepted or malformed. Of a
 * packet with a wrong LENGTH or checksum only the first byte goes, and the search goes on behind
 * it. Of damaged or lost bytes all up to the last one go.
 *
 *     cds_parser_find() until CDS_PARSED_HEAD, cds_parser_keep() if the packet is wanted,
 *     cds_parser_take() until CDS_PARSED_PACKET
 */
#ifndef CDS_PARSER_H
#define CDS_PARSER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_AT_*
#include "cds55xx/ring.h"   // struct cds_ring

#ifdef __cplusplus
extern "C" {
#endif

/* The highest LENGTH a parser can be told to expect: a longer packet would not fit the ring. */
#define CDS_PARSER_LENGTH_MAX (CDS_RING_SIZE - 4)

/* How many bytes that begin no packet one call takes out at most. */
#define CDS_PARSER_SKIPPED_MAX 7

/* Bytes of a packet that one call takes. */
#define CDS_PARSER_TAKEN_MAX 8

/* What a call has made of the bytes. */
enum cds_parsed {
    CDS_PARSED_MORE,      // nothing: the answer depends on bytes that have not come
    CDS_PARSED_SOME,      // some bytes were examined; call again
    CDS_PARSED_HEAD,      // a head was found: header, ID, a LENGTH in range, ERROR
    CDS_PARSED_PACKET,    // the packet is whole, its checksum is right, and it has left the ring
    CDS_PARSED_MALFORMED, // LENGTH or checksum is wrong: the first byte has left the ring
} __attribute__((packed));

/* How far a search has come. */
enum cds_found {
    CDS_FOUND_NOTHING,
    CDS_FOUND_LENGTH, // the first CDS_AT_ERROR bytes of a head stand at the ring's tail
    CDS_FOUND_HEAD,   // the packet of the head is being taken
};

/* A search, and the packet whose head was found. Zeroed, cds_parser_reset(). */
struct cds_parser {
    uint8_t position;     // bytes before this position of the ring were examined
    uint8_t end;          // position of the checksum of the packet whose head was found
    uint8_t sum;          // of its bytes from the ID on
    uint8_t longest;      // a higher LENGTH is malformed: 2 to CDS_PARSER_LENGTH_MAX
    uint8_t found;        // enum cds_found
    uint8_t id;           // of that packet: 0 to CDS_BROADCAST_ID
    uint8_t length;       // LENGTH, 2 to `longest`
    uint8_t error;        // CDS_ERROR_* bits
    uint8_t *to;          // where its next parameter goes, or NULL: nowhere
    bool is_clean;        // nothing was malformed, damaged or lost since the caller has set this
    uint16_t noise_bytes; // bytes that begin no packet, modulo 65536; an FF and the byte after it
                          // count once
};

/* Begins to search at the oldest byte of `ring`. Consumer's context, as all below. */
static inline void cds_parser_reset(struct cds_parser *parser, const struct cds_ring *ring)
{
    parser->position = cds_ring_begin(ring);
    parser->found = CDS_FOUND_NOTHING;
}

/* True if the ring has bytes that were not examined. */
static inline bool cds_parser_has_unread(const struct cds_parser *parser,
                                         const struct cds_ring *ring)
{
    return parser->position != cds_ring_end(ring);
}

/* Searches the bytes before position `end` for the head of a packet. MORE, SOME, HEAD, MALFORMED.
 */
uint8_t cds_parser_find(struct cds_parser *parser, struct cds_ring *ring, uint8_t end);

/* Stores the parameters of the packet whose head was found at `to`: parser->length - 2 bytes. */
static inline void cds_parser_keep(struct cds_parser *parser, uint8_t *to)
{
    parser->to = to;
}

/* Takes the bytes of that packet before position `end`, of which there is one at least. SOME,
 * PACKET, MALFORMED. */
uint8_t cds_parser_take_some(struct cds_parser *parser, struct cds_ring *ring, uint8_t end);

/* Takes the bytes of that packet before position `end`. MORE, SOME, PACKET, MALFORMED. */
static inline uint8_t cds_parser_take(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    if (parser->position == end)
        return CDS_PARSED_MORE;
    return cds_parser_take_some(parser, ring, end);
}

/* Gives up all bytes before `position`: damage lies there. */
void cds_parser_skip_damage(struct cds_parser *parser, struct cds_ring *ring, uint8_t position);

#ifdef __cplusplus
}
#endif

#endif
