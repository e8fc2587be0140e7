/* Finding packets in the bytes a receiver has put into a ring. No input or output of its own.
 * Manual: 2.3; rulings R27 (any number of 0xFF before the ID; LENGTH 2 to 254), R28.
 *
 * A packet is examined where it lies, and leaves the ring only when it is accepted or refuted. A
 * refuted one loses no more than its first byte: the search goes on right after it, so a header
 * inside a damaged packet is never lost. The search keeps nothing from step to step: it begins anew
 * at the ring's tail.
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

/* Bytes that begin no packet are taken out in one step, so many of them at the most, an FF and the
 * byte behind it counted as one. If there were any, what may be a packet is for the next step. */
#define CDS_PARSER_SKIPPED_MAX 12

/* What a step has made of the bytes at the ring's tail. From SKIPPED on, some were taken out. */
enum cds_parsed {
    CDS_PARSED_MORE,    // nothing: it depends on bytes that are not there
    CDS_PARSED_HEAD,    // a header, ID, a LENGTH that can be, and ERROR stand there
    CDS_PARSED_SKIPPED, // they begin no packet, as many as a step skips, or all before a candidate
    CDS_PARSED_REFUTED, // what looked like a packet was none: its LENGTH cannot be
};

/* A search, and the head of the candidate at the ring's tail, once it was found. */
struct cds_parser {
    uint8_t longest; // LENGTH above this is refuted at once: 2 to CDS_PARSER_LENGTH_MAX
    uint8_t id;      // 0 to CDS_BROADCAST_ID
    uint8_t length;  // LENGTH, 2 to `longest`
    uint8_t error;   // CDS_ERROR_* bits
    bool is_clean;   // nothing was refuted since the caller has set this; who drops damaged bytes
                     // clears it, too
    uint16_t stray;  // bytes that began no packet, one FF and the byte behind it as one; modulo
                     // 65536. Of use where counters are (bus.h)
};

/* Examines the bytes at the ring's tail, up to the one with index `end` (up to the ring's head),
 * which is not among them; none of them if `end` lies before. Returns enum cds_parsed. To be called
 * again after SKIPPED and REFUTED; after MORE nothing changes before more bytes have come; after
 * HEAD it is the caller's turn. Consumer's context. */
uint8_t cds_parser_step(struct cds_parser *parser, struct cds_ring *ring, uint8_t end);

/* Hook: a byte begins no packet. */
void cds_parser_note_stray_(struct cds_parser *parser);

/* Does the packet whose head stands at the tail end before the byte with index `end`? Its bytes are
 * cds_ring_peek(ring, CDS_AT_ID) and so on, its size is parser->length + 4. Consumer's context. */
static inline bool cds_parser_is_whole(const struct cds_parser *parser, const struct cds_ring *ring,
                                       uint8_t end)
{
    return (uint8_t)(end - ring->tail) > (uint8_t)(parser->length + CDS_AT_LENGTH);
}

/* Takes that packet, which is whole, out of the ring, if its checksum is right: true. Else it was
 * none, and no more than its first byte is taken out. Consumer's context. */
bool cds_parser_take(struct cds_parser *parser, struct cds_ring *ring);

/* What stands at the tail is no packet: its first byte is taken out, and nothing is clean any more.
 * Consumer's context. */
void cds_parser_refute(struct cds_parser *parser, struct cds_ring *ring);

#ifdef __cplusplus
}
#endif

#endif
