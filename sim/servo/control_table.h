/* SPDX-License-Identifier: MIT */
/* The servo's control table (manual 3.1) as data: one row for each register. */
#ifndef SIM_CONTROL_TABLE_H
#define SIM_CONTROL_TABLE_H

#include <stdbool.h>
#include <stdint.h>

#define TABLE_REGISTERS   50 // bytes, 0x00 to 0x31
#define TABLE_EEPROM_SIZE 24 // bytes, from 0x00; all others are the RAM area
#define TABLE_ROWS        39

enum table_address {
    TABLE_MODEL = 0x01,
    TABLE_FIRMWARE = 0x02,
    TABLE_ID = 0x03,
    TABLE_BAUD = 0x04,
    TABLE_RETURN_DELAY = 0x05,
    TABLE_CW_LIMIT = 0x06,
    TABLE_CCW_LIMIT = 0x08,
    TABLE_HIGHEST_TEMPERATURE = 0x0B,
    TABLE_LOWEST_VOLTAGE = 0x0C,
    TABLE_HIGHEST_VOLTAGE = 0x0D,
    TABLE_MAX_TORQUE = 0x0E,
    TABLE_RETURN_LEVEL = 0x10,
    TABLE_ALARM_LED = 0x11,
    TABLE_ALARM_SHUTDOWN = 0x12,
    TABLE_DOWN_CALIBRATION = 0x14,
    TABLE_UP_CALIBRATION = 0x16,
    TABLE_TORQUE_ENABLE = 0x18,
    TABLE_LED = 0x19,
    TABLE_CW_MARGIN = 0x1A,
    TABLE_CCW_MARGIN = 0x1B,
    TABLE_CW_PROPORTION = 0x1C,
    TABLE_CCW_PROPORTION = 0x1D,
    TABLE_GOAL_POSITION = 0x1E,
    TABLE_MOVING_SPEED = 0x20,
    TABLE_ACC = 0x22,
    TABLE_DCC = 0x23,
    TABLE_PRESENT_POSITION = 0x24,
    TABLE_PRESENT_SPEED = 0x26,
    TABLE_PRESENT_LOAD = 0x28,
    TABLE_PRESENT_VOLTAGE = 0x2A,
    TABLE_PRESENT_TEMPERATURE = 0x2B,
    TABLE_REGISTERED = 0x2C,
    TABLE_MOVING = 0x2E,
    TABLE_LOCK = 0x2F,
    TABLE_PUNCH = 0x30,
};

struct table_row {
    uint8_t address;
    uint8_t width; // bytes; a word has its low byte first (R28)
    bool writable;
    bool eeprom;      // keeps its value without power
    uint16_t initial; // factory value; in the RAM area the value at power-up
    uint16_t highest; // highest value that may be written; the lowest is 0
    const char *name;
};

/* Sorted by address, without gaps. */
extern const struct table_row table_rows[TABLE_ROWS];

/* Returns the row with that name, or 0. */
const struct table_row *table_find(const char *name);

/* Reads and writes a register in the bytes of a control table. */
uint16_t table_get(const uint8_t *registers, uint8_t address, uint8_t width);
void table_set(uint8_t *registers, uint8_t address, uint8_t width, uint16_t value);

/* Writes the initial values of the EEPROM area or of the RAM area. */
void table_initialise(uint8_t *registers, bool eeprom);

#endif
