/* What a packet writes into the registers of one servo; see written.h. */
#include <stddef.h>

#include "safety/written.h"

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/packet.h"        // CDS_AT_*

uint8_t cds_written_sets(uint8_t address, uint8_t length)
{
    uint8_t end = (uint8_t)(address + length), sets = 0; // the first register behind

    if (length == 0 || address >= CDS_TABLE_SIZE)
        return 0;
    if (end < address) // longer than any servo takes
        return UINT8_MAX;
    if (address <= CDS_REG_STATUS_RETURN_LEVEL) {
        if (address <= CDS_REG_ID && end > CDS_REG_ID)
            sets |= CDS_SETS_ID;
        if ((address <= CDS_REG_RETURN_DELAY && end > CDS_REG_BAUD_RATE) ||
            end > CDS_REG_STATUS_RETURN_LEVEL)
            sets |= CDS_SETS_REPLY;
        if (address <= CDS_REG_CCW_ANGLE_LIMIT + 1 && end > CDS_REG_CW_ANGLE_LIMIT)
            sets |= CDS_SETS_MODE;
    }
    if (address <= CDS_REG_TORQUE_ENABLE && end > CDS_REG_TORQUE_ENABLE)
        sets |= CDS_SETS_TORQUE;
    if (end > CDS_REG_CW_COMPLIANCE_MARGIN) {
        if (address <= CDS_REG_CCW_PROPORTION)
            sets |= CDS_SETS_GAIN;
        if (address <= CDS_REG_GOAL_POSITION + 1 && end > CDS_REG_GOAL_POSITION)
            sets |= CDS_SETS_GOAL;
        if (address <= CDS_REG_MOVING_SPEED + 1 && end > CDS_REG_MOVING_SPEED)
            sets |= CDS_SETS_SPEED;
        if (address <= CDS_REG_REGISTERED_INSTRUCTION && end > CDS_REG_REGISTERED_INSTRUCTION)
            sets |= CDS_SETS_REGISTERED;
        if (address <= CDS_REG_PUNCH + 1 && end > CDS_REG_PUNCH)
            sets |= CDS_SETS_GAIN;
    }
    return sets;
}

bool cds_written_by(const uint8_t *bytes, struct cds_written *written)
{
    uint8_t count = (uint8_t)(bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN);

    if (count < 2)
        return false;
    written->address = bytes[CDS_AT_PARAMETERS];
    written->id = bytes[CDS_AT_ID];
    written->data = bytes + CDS_AT_PARAMETERS + 1;
    written->length = (uint8_t)(count - 1u);
    if (bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE)
        written->length = bytes[CDS_AT_SYNC_LENGTH];
    written->sets = cds_written_sets(written->address, written->length);
    return true;
}

bool cds_written_block(const uint8_t *bytes, uint8_t index, struct cds_written *written)
{
    uint16_t end = (uint16_t)((index + 1u) * (written->length + 1u) + CDS_LENGTH_MIN + 2u);

    if (bytes[CDS_AT_INSTRUCTION] != CDS_SYNC_WRITE)
        return index == 0;
    if (end > bytes[CDS_AT_LENGTH])
        return false;
    written->data = bytes + CDS_AT_LENGTH + end - written->length;
    written->id = written->data[-1];
    return true;
}
