/* Finding packets in the bytes a receiver has put into a ring. No input or output of its own.
 * Manual: 2.3; rulings R27 (any number of 0xFF before the ID; LENGTH 2 to 254), R28.
 *
 * A packet is examined where it lies, byte by byte as it arrives, and leaves the ring only when it
 * is accepted or refuted. A refuted one loses no more than its first byte: the search goes on right
 * after it, so a header inside a damaged packet is never lost.
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

/* What the bytes have made of the candidate. */
enum cds_parsed {
    CDS_PARSED_MORE,    // nothing yet: the next byte decides, or the one after
    CDS_PARSED_HEAD,    // the header, ID and a LENGTH that can be: parser->id, parser->length
    CDS_PARSED_PACKET,  // a whole packet, checksum right, stands at the ring's tail
    CDS_PARSED_REFUTED, // what looked like a packet was none (LENGTH or checksum)
};

/* How far the candidate at the ring's tail has been examined. */
struct cds_parser {
    uint8_t longest; // LENGTH above this is refuted at once
    uint8_t seen;    // bytes of the candidate at the ring's tail examined so far
    uint8_t sum;     // of its bytes from the ID on
    uint8_t length;  // its LENGTH, once seen, ...
    uint8_t id;      // its ID,
    uint8_t error;   // and its ERROR
    uint8_t left;    // bytes that may still be examined
    uint16_t stray;  // bytes, each with the FF before it, that began no packet; modulo 65536
};

/* Begins a search, with nothing seen: the caller has emptied the ring, or will. `longest`: highest
 * LENGTH that can be due, 2 to CDS_PARSER_LENGTH_MAX. `stray` goes on. Main context. */
void cds_parser_begin(struct cds_parser *parser, uint8_t longest);

/* Examines the bytes of the ring that it has not seen, up to the one with index `end` (up to the
 * ring's head), which is not among them, and no more than parser->left, which counts them off.
 * Stops at the first byte that makes something of the candidate.
 * After CDS_PARSED_PACKET the packet's bytes are cds_ring_peek(ring, CDS_AT_ID) and so on, its size
 * is parser->length + 4; the caller then calls cds_parser_accept(). Consumer's context. */
enum cds_parsed cds_parser_scan(struct cds_parser *parser, struct cds_ring *ring, uint8_t end);

/* Is `byte` (any) the checksum that ends the candidate well? Either context. */
static inline bool cds_parser_ends_well(const struct cds_parser *parser, uint8_t byte)
{
    return (uint8_t)(parser->sum + byte) == UINT8_MAX; // it is ~ of the sum of the rest
}

/* Takes the packet just found out of the ring. Consumer's context. */
void cds_parser_accept(struct cds_parser *parser, struct cds_ring *ring);

#ifdef __cplusplus
}
#endif

#endif
