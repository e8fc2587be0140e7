/* SPDX-License-Identifier: MIT */
/* Methods of CDS55xx.h. */
#include "CDS55xx.h"

#include "cds55xx/blocking.h" // calls that wait
#include "cds55xx/units.h"    // registers in units

#define RETRIES 2 // of PING, READ and WRITE, if no good reply has come

/* ---- the bus ---- */

extern "C" char cds55xx_serial_notice; // serial_notice.S

bool CDS55xx::begin(unsigned long baud)
{
    uint8_t baud_reg;
    int16_t permille;

    baud_ = 0;
    if (baud > INT32_MAX || cds_units_baud((int32_t)baud, &baud_reg, &permille) != CDS_OK ||
        abs(permille) > CDS_BAUD_ERROR_MAX_PERMILLE)
        return note(CDS_BAD_ARGUMENT);
    if (!request_.packet.bytes) {
        request_.packet.bytes = packet_;
        request_.packet.capacity = sizeof packet_;
        request_.reply = reply_;
        request_.reply_capacity = sizeof reply_;
        cds_avr_clock_open();
        // refers to the symbol and changes no byte
        __asm__ volatile(".reloc ., R_AVR_NONE, %0" ::"i"(&cds55xx_serial_notice));
    }
    cds_bus_open(&bus_, 0, baud_reg);
    if (!servos_.bus) {
        struct cds_servos_config config = cds_servos_config();

        config.bus = &bus_;
        config.queue = &queue_;
        config.states = states_;
        config.capacity = CDS55XX_SERVOS;
        config.grows = CDS_GROWS_ALWAYS;
        config.shortest_delay = CDS_AVR_SHORTEST_DELAY(0);
        cds_servos_begin(&servos_, &config);
        cds_queue_set_retries(&queue_, RETRIES);
    }
    baud_ = baud;
    return note(CDS_OK);
}

/* False: begin() was not called, or has failed. */
bool CDS55xx::isReady()
{
    return note(baud_ ? CDS_OK : CDS_BAD_ARGUMENT);
}

size_t CDS55xx::printLastError(Print &out) const
{
    char text[CDS_RESULT_TEXT_SIZE];

    cds_result_text(result_, text, sizeof text);
    return out.print(text);
}

/* ---- registers ---- */

bool CDS55xx::readRegisters(uint8_t id, uint8_t address, uint8_t length)
{
    return isReady() && note(cds_blocking_read(&bus_, &request_, id, address, length));
}

bool CDS55xx::readWord(uint8_t id, uint8_t address, uint16_t *value)
{
    return readRegisters(id, address, 2) && note(cds_request_word(&request_, 0, value));
}

bool CDS55xx::writeWord(uint8_t id, uint8_t address, uint16_t value)
{
    return isReady() && note(cds_blocking_write_word(&bus_, &request_, id, address, value));
}

int32_t CDS55xx::read(uint8_t id, uint16_t address, uint16_t length, uint8_t *data,
                      uint16_t capacity, uint32_t)
{
    if (address >= CDS_TABLE_SIZE || length > CDS_TABLE_SIZE || length > capacity) {
        note(CDS_BAD_ARGUMENT);
        return 0;
    }
    if (!readRegisters(id, (uint8_t)address, (uint8_t)length))
        return 0;
    memcpy(data, reply_, length);
    return length;
}

bool CDS55xx::write(uint8_t id, uint16_t address, const uint8_t *data, uint16_t length, uint32_t)
{
    if (address >= CDS_TABLE_SIZE || length > CDS_TABLE_SIZE)
        return note(CDS_BAD_ARGUMENT);
    return isReady() &&
           note(cds_blocking_write(&bus_, &request_, id, (uint8_t)address, data, (uint8_t)length));
}

bool CDS55xx::regWrite(uint8_t id, uint16_t address, const uint8_t *data, uint16_t length, uint32_t)
{
    if (address >= CDS_TABLE_SIZE || length > CDS_TABLE_SIZE)
        return note(CDS_BAD_ARGUMENT);
    return isReady() && note(cds_blocking_reg_write(&bus_, &request_, id, (uint8_t)address, data,
                                                    (uint8_t)length));
}

bool CDS55xx::action(uint8_t id, uint32_t)
{
    return isReady() && note(cds_blocking_action(&bus_, &request_, id));
}

int32_t CDS55xx::readControlTableItem(uint8_t item, uint8_t id, uint32_t)
{
    struct cds_register row;

    if (!cds_register_at(item, &row)) {
        note(CDS_BAD_ARGUMENT);
        return -1;
    }
    if (!readRegisters(id, row.address, row.width))
        return -1;
    return row.width == 1 ? reply_[0] : (int32_t)(reply_[0] | (uint16_t)reply_[1] << 8);
}

bool CDS55xx::writeControlTableItem(uint8_t item, uint8_t id, int32_t data, uint32_t)
{
    struct cds_register row;

    if (!cds_register_at(item, &row) || row.access != CDS_ACCESS_RW || data < (int32_t)row.lowest ||
        data > (int32_t)row.highest)
        return note(CDS_BAD_ARGUMENT);
    if (row.width == 2)
        return writeWord(id, row.address, (uint16_t)data);
    return isReady() &&
           note(cds_blocking_write_byte(&bus_, &request_, id, row.address, (uint8_t)data));
}

/* ---- finding and changing servos ---- */

bool CDS55xx::isThere(uint8_t id)
{
    return isReady() && note(cds_blocking_ping(&bus_, &request_, id));
}

/* What fails here shows in the calls that follow: ping() itself has succeeded. */
void CDS55xx::raiseReturnDelay(uint8_t id)
{
    uint8_t delay_reg;

    if (cds_blocking_read_byte(&bus_, &request_, id, CDS_REG_RETURN_DELAY, &delay_reg) == CDS_OK &&
        delay_reg < CDS55XX_RETURN_DELAY_US / 2)
        cds_blocking_write_byte(&bus_, &request_, id, CDS_REG_RETURN_DELAY,
                                CDS55XX_RETURN_DELAY_US / 2);
}

bool CDS55xx::ping(uint8_t id)
{
    if (id == DXL_BROADCAST_ID)
        return scan();
    if (!isThere(id))
        return false;
    raiseReturnDelay(id);
    return true;
}

uint8_t CDS55xx::scan(uint8_t *ids, uint8_t capacity)
{
    uint8_t count = 0;

    if (!isReady())
        return 0;
    for (uint8_t id = 0; id <= CDS_ID_MAX; id++) {
        // as in scan.c: a stale reply has the ID of an earlier PING, so nothing waits for it
        request_.no_retry = request_.ignores_stale = true;
        bool is_there = isThere(id);
        request_.no_retry = request_.ignores_stale = false;
        if (!is_there)
            continue;
        raiseReturnDelay(id);
        if (count < capacity)
            ids[count] = id;
        count++;
    }
    note(count ? CDS_OK : CDS_TIMEOUT);
    return count;
}

uint16_t CDS55xx::getModelNumber(uint8_t id)
{
    return (uint16_t)readControlTableItem(ControlTableItem::MODEL_NUMBER, id);
}

bool CDS55xx::changeIdentity(uint8_t change, uint8_t id, uint8_t to)
{
    struct cds_identity_config config = cds_identity_config();
    struct cds_identity identity;
    uint8_t baud_reg = bus_.baud_reg;

    if (!isReady())
        return false;
    config.bus = &bus_;
    config.request = &request_;
    config.change = change;
    config.id = id;
    config.new_id = to;
    config.new_baud_reg = to;
    note(cds_blocking_identity(&identity, &config));
    cds_bus_set_baud(&bus_, baud_reg);
    return result_ == CDS_OK;
}

bool CDS55xx::setID(uint8_t id, uint8_t new_id)
{
    return changeIdentity(CDS_IDENTITY_ID, id, new_id);
}

bool CDS55xx::setBaudrate(uint8_t id, uint32_t baudrate)
{
    uint8_t baud_reg;
    int16_t permille;

    if (baudrate > INT32_MAX || cds_units_baud((int32_t)baudrate, &baud_reg, &permille) != CDS_OK ||
        abs(permille) > CDS_BAUD_ERROR_MAX_PERMILLE || !cds_units_baud_is_kept(baud_reg))
        return note(CDS_BAD_ARGUMENT);
    return changeIdentity(CDS_IDENTITY_BAUD, id, baud_reg);
}

bool CDS55xx::factoryReset(uint8_t id, uint8_t, uint32_t)
{
    return isReady() && note(cds_blocking_reset(&bus_, &request_, id));
}

/* ---- moving ---- */

bool CDS55xx::torqueOn(uint8_t id)
{
    if (id != DXL_BROADCAST_ID) {
        if (!readRegisters(id, CDS_REG_TORQUE_ENABLE, 1)) // else a servo that was away is inhibited
            return false;
        struct cds_servo_state *servo = cds_servos_find(&servos_, id);
        if (servo)
            cds_servos_release(&servos_, servo);
    }
    return writeControlTableItem(ControlTableItem::TORQUE_ENABLE, id, 1);
}

bool CDS55xx::setOperatingMode(uint8_t id, uint8_t mode)
{
    static const uint8_t endless_turn[] = {0, 0, 0, 0};
    static const uint8_t whole_range[] = {0, 0, CDS_VALUE_MAX & 0xFF, CDS_VALUE_MAX >> 8};

    if (mode != OP_POSITION && mode != OP_VELOCITY)
        return note(CDS_BAD_ARGUMENT);
    if (!readRegisters(id, CDS_REG_CW_ANGLE_LIMIT, sizeof endless_turn))
        return false;
    if ((memcmp(reply_, endless_turn, sizeof endless_turn) == 0) == (mode == OP_VELOCITY))
        return true;
    if (mode == OP_POSITION)
        return write(id, CDS_REG_CW_ANGLE_LIMIT, whole_range, sizeof whole_range);
    // a speed of moves that is left there would be a speed of endless turn at once
    return writeWord(id, CDS_REG_MOVING_SPEED, 0) &&
           write(id, CDS_REG_CW_ANGLE_LIMIT, endless_turn, sizeof endless_turn);
}

/* Writes a goal or a speed. A servo that did not answer for a while is not driven before its
 * TORQUE_ENABLE was read: if torque is off, it has lost its power, and waits for torqueOn(). */
bool CDS55xx::drive(uint8_t id, uint8_t address, uint16_t value)
{
    if (writeWord(id, address, value) || result_ != CDS_INHIBITED || id == DXL_BROADCAST_ID)
        return result_ == CDS_OK;
    return readRegisters(id, CDS_REG_TORQUE_ENABLE, 1) && writeWord(id, address, value);
}

bool CDS55xx::setGoalPosition(uint8_t id, CDS55xxNumber value, uint8_t unit)
{
    int32_t raw = value.thousandths / 1000;
    uint16_t position = (uint16_t)raw;

    if (unit == UNIT_DEGREE) {
        if (cds_units_to_register(NULL, CDS_UNIT_MDEG, value.thousandths, &position) != CDS_OK)
            return note(CDS_BAD_ARGUMENT);
    } else if (unit != UNIT_RAW || value.thousandths < 0 || raw > CDS_VALUE_MAX) {
        return note(CDS_BAD_ARGUMENT);
    }
    return drive(id, CDS_REG_GOAL_POSITION, position);
}

#define CW_BIT 0x400 // of MOVING_SPEED: bits 0 to 9 are the magnitude

/* Converts a speed to register 0x20. */
static enum cds_result to_speed(int32_t thousandths, uint8_t unit, uint16_t *speed)
{
    int32_t raw = thousandths / 1000;
    enum cds_result result;

    if (unit == UNIT_RAW) {
        if (raw < -CDS_VALUE_MAX || raw > (CW_BIT | CDS_VALUE_MAX))
            return CDS_BAD_ARGUMENT;
        *speed = (uint16_t)(raw < 0 ? CW_BIT - raw : raw);
        return CDS_OK;
    }
    if (unit == UNIT_RPM)
        result =
            cds_units_to_register(&cds_profile_cds55xx, CDS_UNIT_SIGNED_MRPM, thousandths, speed);
    else if (unit == UNIT_PERCENT)
        result = cds_units_to_register(NULL, CDS_UNIT_SIGNED_CPCT, thousandths / 10, speed);
    else
        return CDS_BAD_ARGUMENT;
    // In position mode 0 is as fast as the servo can: only 0 becomes 0.
    if (result == CDS_OK && thousandths && !(*speed & CDS_VALUE_MAX))
        *speed = thousandths < 0 ? CW_BIT | 1 : 1;
    return result;
}

bool CDS55xx::setGoalVelocity(uint8_t id, CDS55xxNumber value, uint8_t unit)
{
    uint16_t speed;

    return note(to_speed(value.thousandths, unit, &speed)) &&
           drive(id, CDS_REG_MOVING_SPEED, speed);
}

bool CDS55xx::getPresentPosition(uint8_t id, int32_t *value, uint8_t unit)
{
    uint16_t raw;

    if (unit != UNIT_RAW && unit != UNIT_DEGREE)
        return note(CDS_BAD_ARGUMENT);
    if (!readWord(id, CDS_REG_PRESENT_POSITION, &raw))
        return false;
    if (unit == UNIT_RAW)
        *value = raw;
    else if (cds_units_from_register(NULL, CDS_UNIT_MDEG, raw, value) != CDS_OK)
        return note(CDS_CORRUPT);
    return true;
}

bool CDS55xx::getPresentVelocity(uint8_t id, int32_t *value, uint8_t unit)
{
    enum cds_unit of = unit == UNIT_RPM ? CDS_UNIT_SIGNED_MRPM : CDS_UNIT_SIGNED_CPCT;
    uint16_t raw;

    if (unit != UNIT_RAW && unit != UNIT_RPM && unit != UNIT_PERCENT)
        return note(CDS_BAD_ARGUMENT);
    if (!readWord(id, CDS_REG_PRESENT_SPEED, &raw))
        return false;
    if (unit == UNIT_RAW)
        *value = raw;
    else if (cds_units_from_register(&cds_profile_cds55xx, of, raw, value) != CDS_OK)
        return note(CDS_CORRUPT);
    else if (unit == UNIT_PERCENT)
        *value *= 10;
    return true;
}
