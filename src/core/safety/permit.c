/* The check of every packet before it is sent; see permit.h. Manual: 2.4; 3.1, registers 0x05, 0x06
 * to 0x09, 0x18, 0x1A to 0x21, 0x30. */
#include "safety/permit.h"

#include "cds55xx/control_table.h" // CDS_REG_RETURN_DELAY
#include "cds55xx/packet.h"        // CDS_AT_*
#include "safety/part.h"

static bool sets_delay_below(const struct cds_span *span, uint8_t shortest)
{
    const uint8_t *delay = cds_span_byte(span, CDS_REG_RETURN_DELAY);

    return delay && *delay < shortest;
}

/* A WRITE, REG WRITE or SYNC WRITE, part by part. */
static enum cds_result check_writes(const struct cds_servos *roster, const uint8_t *bytes)
{
    const uint8_t *end = bytes + CDS_AT_LENGTH + bytes[CDS_AT_LENGTH];    // the checksum
    struct cds_part part = {{bytes + CDS_AT_PARAMETERS + 2, 0, 0}, 0, 0}; // before the first block

    for (uint8_t i = 0; cds_part_of(bytes, i, &part); i++) {
        if (roster->inhibited && cds_span_may_move(&part.span))
            return CDS_INHIBITED;
        if (sets_delay_below(&part.span, roster->shortest_delay))
            return CDS_TOO_EARLY;
    }
    if (roster->inhibited && part.span.data + part.span.length != end)
        return CDS_INHIBITED; // the last block is cut, or a write has no data
    return CDS_OK;
}

enum cds_result cds_permit_check(const struct cds_servos *roster, const uint8_t *bytes)
{
    uint8_t longest = CDS_LENGTH_MIN;

    switch (bytes[CDS_AT_INSTRUCTION]) {
    case CDS_READ: longest = CDS_LENGTH_MIN + 2; // fall through
    case CDS_PING:
        return roster->inhibited && bytes[CDS_AT_LENGTH] > longest ? CDS_INHIBITED : CDS_OK;
    case CDS_WRITE:
    case CDS_REG_WRITE:
    case CDS_SYNC_WRITE:
        if (roster->inhibited || bytes[CDS_AT_PARAMETERS] <= CDS_REG_RETURN_DELAY)
            return check_writes(roster, bytes);
        return CDS_OK;
    default: return roster->inhibited ? CDS_INHIBITED : CDS_OK;
    }
}
