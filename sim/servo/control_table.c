/* SPDX-License-Identifier: MIT */
#include "servo/control_table.h"

#include <string.h>

#define R  false
#define RW true
#define E  true
#define M  false

/* The names are those of the firmware's console (docs/registers.md), so scenarios and console use
 * the same names. Defaults: the manual, and rulings R11 and R12 where it prints two. Ranges: R33.
 * Values that the manual leaves open: R26 and R38. At power-up the goal position is the present
 * position. */
// clang-format off
const struct table_row table_rows[TABLE_ROWS] = {
    {0x00,                      1, R,  E, 0,      0,      "RESERVED_00"},
    {TABLE_MODEL,               1, R,  E, 1,      0,      "MODEL_NUMBER"},
    {TABLE_FIRMWARE,            1, R,  E, 1,      0,      "FIRMWARE_VERSION"},
    {TABLE_ID,                  1, RW, E, 1,      253,    "ID"},
    {TABLE_BAUD,                1, RW, E, 1,      254,    "BAUD_RATE"},
    {TABLE_RETURN_DELAY,        1, RW, E, 0x01,   254,    "RETURN_DELAY"},
    {TABLE_CW_LIMIT,            2, RW, E, 0,      0x3FF,  "CW_ANGLE_LIMIT"},
    {TABLE_CCW_LIMIT,           2, RW, E, 0x3FF,  0x3FF,  "CCW_ANGLE_LIMIT"},
    {0x0A,                      1, R,  E, 0,      0,      "RESERVED_0A"},
    {TABLE_HIGHEST_TEMPERATURE, 1, RW, E, 80,     255,    "MAX_TEMPERATURE"},
    {TABLE_LOWEST_VOLTAGE,      1, RW, E, 60,     255,    "MIN_VOLTAGE"},
    {TABLE_HIGHEST_VOLTAGE,     1, RW, E, 160,    255,    "MAX_VOLTAGE"},
    {TABLE_MAX_TORQUE,          2, RW, E, 0x3FF,  0x3FF,  "MAX_TORQUE"},
    {TABLE_RETURN_LEVEL,        1, RW, E, 2,      2,      "STATUS_RETURN_LEVEL"},
    {TABLE_ALARM_LED,           1, RW, E, 0x25,   0x7F,   "ALARM_LED"},
    {TABLE_ALARM_SHUTDOWN,      1, RW, E, 0x04,   0x7F,   "ALARM_SHUTDOWN"},
    {0x13,                      1, RW, E, 0,      255,    "RESERVED_13"},
    {TABLE_DOWN_CALIBRATION,    2, R,  E, 0,      0,      "DOWN_CALIBRATION"},
    {TABLE_UP_CALIBRATION,      2, R,  E, 0,      0,      "UP_CALIBRATION"},
    {TABLE_TORQUE_ENABLE,       1, RW, M, 0,      1,      "TORQUE_ENABLE"},
    {TABLE_LED,                 1, RW, M, 0,      1,      "LED"},
    {TABLE_CW_MARGIN,           1, RW, M, 2,      255,    "CW_COMPLIANCE_MARGIN"},
    {TABLE_CCW_MARGIN,          1, RW, M, 2,      255,    "CCW_COMPLIANCE_MARGIN"},
    {TABLE_CW_PROPORTION,       1, RW, M, 32,     255,    "CW_PROPORTION"},
    {TABLE_CCW_PROPORTION,      1, RW, M, 32,     255,    "CCW_PROPORTION"},
    {TABLE_GOAL_POSITION,       2, RW, M, 0,      0x3FF,  "GOAL_POSITION"},
    {TABLE_MOVING_SPEED,        2, RW, M, 0,      0x3FF,  "MOVING_SPEED"}, // 0x7FF in endless turn
    {TABLE_ACC,                 1, RW, M, 32,     255,    "ACC"},
    {TABLE_DCC,                 1, RW, M, 32,     255,    "DCC"},
    {TABLE_PRESENT_POSITION,    2, R,  M, 0,      0,      "PRESENT_POSITION"},
    {TABLE_PRESENT_SPEED,       2, R,  M, 0,      0,      "PRESENT_SPEED"},
    {TABLE_PRESENT_LOAD,        2, R,  M, 0,      0,      "PRESENT_LOAD"},
    {TABLE_PRESENT_VOLTAGE,     1, R,  M, 0,      0,      "PRESENT_VOLTAGE"},
    {TABLE_PRESENT_TEMPERATURE, 1, R,  M, 0,      0,      "PRESENT_TEMPERATURE"},
    {TABLE_REGISTERED,          1, RW, M, 0,      1,      "REGISTERED_INSTRUCTION"},
    {0x2D,                      1, R,  M, 0,      0,      "RESERVED_2D"},
    {TABLE_MOVING,              1, R,  M, 0,      0,      "MOVING"},
    {TABLE_LOCK,                1, RW, M, 0,      1,      "LOCK"},
    {TABLE_PUNCH,               2, RW, M, 0x5A,   0x3FF,  "PUNCH"},
};
// clang-format on

const struct table_row *table_find(const char *name)
{
    for (const struct table_row *row = table_rows; row < table_rows + TABLE_ROWS; row++) {
        if (strcmp(row->name, name) == 0) {
            return row;
        }
    }
    return 0;
}

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
