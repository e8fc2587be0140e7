/* The parts of a packet that writes registers; see part.h. */
#include "safety/part.h"

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/packet.h"        // CDS_AT_*

bool cds_part_of(const uint8_t *bytes, uint8_t index, struct cds_part *part)
{
    const uint8_t *parameters = bytes + CDS_AT_PARAMETERS;
    uint8_t count = (uint8_t)(bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN);
    uint16_t block, end;

    if (count < 2)
        return false;
    part->span.address = parameters[0];
    part->instruction = bytes[CDS_AT_INSTRUCTION];
    if (part->instruction != CDS_SYNC_WRITE) {
        part->id = bytes[CDS_AT_ID];
        part->span.data = parameters + 1;
        part->span.length = (uint8_t)(count - 1u);
        return index == 0;
    }
    block = parameters[1] + 1u;
    end = (uint16_t)((index + 1u) * block + 2u); // fits: the part before was within the packet
    if (end > count)
        return false;
    part->span.length = parameters[1];
    part->span.data = parameters + end - parameters[1];
    part->id = part->span.data[-1];
    return true;
}

bool cds_span_drives(const struct cds_span *span)
{
    return cds_span_touches(span, CDS_REG_GOAL_POSITION, CDS_REG_MOVING_SPEED + 1) ||
           cds_span_value(span, CDS_REG_TORQUE_ENABLE, 0) ||
           cds_span_touches(span, CDS_REG_CW_ANGLE_LIMIT, CDS_REG_CCW_ANGLE_LIMIT + 1);
}

bool cds_span_may_move(const struct cds_span *span)
{
    return cds_span_drives(span) ||
           cds_span_touches(span, CDS_REG_CW_COMPLIANCE_MARGIN, CDS_REG_CCW_PROPORTION) ||
           cds_span_touches(span, CDS_REG_PUNCH, CDS_REG_PUNCH + 1);
}
