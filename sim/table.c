#include "table.h"

#define R  false
#define RW true
#define E  true
#define M  false

/* Where the manual prints two defaults the rulings R11 and R12 decide, ranges are R33's, values it
 * leaves open are R26's and R38's. The goal position follows the present one at power-up. */
// clang-format off
const struct table_row table_rows[TABLE_ROWS] = {
    {0x00,                      1, R,  E, 0,      0,      "reserved"},
    {TABLE_MODEL,               1, R,  E, 1,      0,      "model number"},
    {TABLE_FIRMWARE,            1, R,  E, 1,      0,      "firmware version"},
    {TABLE_ID,                  1, RW, E, 1,      253,    "ID"},
    {TABLE_BAUD,                1, RW, E, 1,      254,    "baud rate"},
    {TABLE_RETURN_DELAY,        1, RW, E, 0x01,   254,    "return delay"},
    {TABLE_CW_LIMIT,            2, RW, E, 0,      0x3FF,  "CW angle limit"},
    {TABLE_CCW_LIMIT,           2, RW, E, 0x3FF,  0x3FF,  "CCW angle limit"},
    {0x0A,                      1, R,  E, 0,      0,      "reserved"},
    {TABLE_HIGHEST_TEMPERATURE, 1, RW, E, 80,     255,    "highest temperature"},
    {TABLE_LOWEST_VOLTAGE,      1, RW, E, 60,     255,    "lowest voltage"},
    {TABLE_HIGHEST_VOLTAGE,     1, RW, E, 160,    255,    "highest voltage"},
    {TABLE_MAX_TORQUE,          2, RW, E, 0x3FF,  0x3FF,  "max torque"},
    {TABLE_RETURN_LEVEL,        1, RW, E, 2,      2,      "status return level"},
    {TABLE_ALARM_LED,           1, RW, E, 0x25,   0x7F,   "alarm LED"},
    {TABLE_ALARM_SHUTDOWN,      1, RW, E, 0x04,   0x7F,   "alarm shutdown"},
    {0x13,                      1, RW, E, 0,      255,    "reserved"},
    {TABLE_DOWN_CALIBRATION,    2, R,  E, 0,      0,      "down calibration"},
    {TABLE_UP_CALIBRATION,      2, R,  E, 0,      0,      "up calibration"},
    {TABLE_TORQUE_ENABLE,       1, RW, M, 0,      1,      "torque enable"},
    {TABLE_LED,                 1, RW, M, 0,      1,      "LED"},
    {TABLE_CW_MARGIN,           1, RW, M, 2,      255,    "CW compliance margin"},
    {TABLE_CCW_MARGIN,          1, RW, M, 2,      255,    "CCW compliance margin"},
    {TABLE_CW_PROPORTION,       1, RW, M, 32,     255,    "CW proportion"},
    {TABLE_CCW_PROPORTION,      1, RW, M, 32,     255,    "CCW proportion"},
    {TABLE_GOAL_POSITION,       2, RW, M, 0,      0x3FF,  "goal position"},
    {TABLE_MOVING_SPEED,        2, RW, M, 0,      0x3FF,  "moving speed"}, // 0x7FF in endless turn
    {TABLE_ACC,                 1, RW, M, 32,     255,    "Acc"},
    {TABLE_DCC,                 1, RW, M, 32,     255,    "Dcc"},
    {TABLE_PRESENT_POSITION,    2, R,  M, 0,      0,      "present position"},
    {TABLE_PRESENT_SPEED,       2, R,  M, 0,      0,      "present speed"},
    {TABLE_PRESENT_LOAD,        2, R,  M, 0,      0,      "present load"},
    {TABLE_PRESENT_VOLTAGE,     1, R,  M, 0,      0,      "present voltage"},
    {TABLE_PRESENT_TEMPERATURE, 1, R,  M, 0,      0,      "present temperature"},
    {TABLE_REGISTERED,          1, RW, M, 0,      1,      "registered instruction"},
    {0x2D,                      1, R,  M, 0,      0,      "reserved"},
    {TABLE_MOVING,              1, R,  M, 0,      0,      "moving"},
    {TABLE_LOCK,                1, RW, M, 0,      1,      "lock"},
    {TABLE_PUNCH,               2, RW, M, 0x5A,   0x3FF,  "punch"},
};
// clang-format on

uint16_t table_get(const uint8_t *registers, uint8_t address, uint8_t width)
{
    unsigned high = width == 2 ? registers[address + 1] : 0;
    return (uint16_t)(registers[address] | high << 8);
}

void table_set(uint8_t *registers, uint8_t address, uint8_t width, uint16_t value)
{
    registers[address] = (uint8_t)value;
    if (width == 2) {
        registers[address + 1] = (uint8_t)(value >> 8);
    }
}

void table_initialise(uint8_t *registers, bool eeprom)
{
    for (const struct table_row *row = table_rows; row < table_rows + TABLE_ROWS; row++) {
        if (row->eeprom == eeprom) {
            table_set(registers, row->address, row->width, row->initial);
        }
    }
}
