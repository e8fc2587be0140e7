/* SPDX-License-Identifier: MIT */
/* The control table of a CDS55xx: its 50 bytes by name (manual 3.1, rulings R4 to R7, R11 to R13,
 * R26, R33, R38). The list below is the only one: enum, descriptions and names come from it.
 */
#ifndef CDS_CONTROL_TABLE_H
#define CDS_CONTROL_TABLE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define CDS_TABLE_SIZE  50    // registers 0x00 to 0x31
#define CDS_EEPROM_SIZE 0x18  // 0x00 to 0x17 outlive power-off, all others are RAM
#define CDS_VALUE_MAX   0x3FF // of every ten-bit word: 300 degrees, 62 RPM, full torque

/* X(name, address, width in bytes, access, area, initial value, lowest, highest)
 * Access: RD, RW, or NO for a byte that the manual reserves without saying RD or WR. Of
 * RESERVED_13 it says RD,WR, and no meaning: it can be written (R5). An initial
 * value is the factory's in the EEPROM area and the one at power-up in the RAM area; where the
 * servo makes it up (present values, goal), 0 stands. MOVING_SPEED reaches 0x7FF in endless turn
 * only; in position mode 0x3FF is its highest (R33). */
#define CDS_REGISTERS(X)                                                                           \
    X(RESERVED_00, 0x00, 1, NO, EEPROM, 0, 0, 255)                                                 \
    X(MODEL_NUMBER, 0x01, 1, RD, EEPROM, 1, 0, 255)                                                \
    X(FIRMWARE_VERSION, 0x02, 1, RD, EEPROM, 1, 0, 255)                                            \
    X(ID, 0x03, 1, RW, EEPROM, 1, 0, 253)                                                          \
    X(BAUD_RATE, 0x04, 1, RW, EEPROM, 1, 0, 254)                                                   \
    X(RETURN_DELAY, 0x05, 1, RW, EEPROM, 1, 0, 254)                                                \
    X(CW_ANGLE_LIMIT, 0x06, 2, RW, EEPROM, 0, 0, 0x3FF)                                            \
    X(CCW_ANGLE_LIMIT, 0x08, 2, RW, EEPROM, 0x3FF, 0, 0x3FF)                                       \
    X(RESERVED_0A, 0x0A, 1, NO, EEPROM, 0, 0, 255)                                                 \
    X(MAX_TEMPERATURE, 0x0B, 1, RW, EEPROM, 80, 0, 255)                                            \
    X(MIN_VOLTAGE, 0x0C, 1, RW, EEPROM, 60, 0, 255)                                                \
    X(MAX_VOLTAGE, 0x0D, 1, RW, EEPROM, 160, 0, 255)                                               \
    X(MAX_TORQUE, 0x0E, 2, RW, EEPROM, 0x3FF, 0, 0x3FF)                                            \
    X(STATUS_RETURN_LEVEL, 0x10, 1, RW, EEPROM, 2, 0, 2)                                           \
    X(ALARM_LED, 0x11, 1, RW, EEPROM, 0x25, 0, 0x7F)                                               \
    X(ALARM_SHUTDOWN, 0x12, 1, RW, EEPROM, 0x04, 0, 0x7F)                                          \
    X(RESERVED_13, 0x13, 1, RW, EEPROM, 0, 0, 255)                                                 \
    X(DOWN_CALIBRATION, 0x14, 2, RD, EEPROM, 0, 0, 0xFFFF)                                         \
    X(UP_CALIBRATION, 0x16, 2, RD, EEPROM, 0, 0, 0xFFFF)                                           \
    X(TORQUE_ENABLE, 0x18, 1, RW, RAM, 0, 0, 1)                                                    \
    X(LED, 0x19, 1, RW, RAM, 0, 0, 1)                                                              \
    X(CW_COMPLIANCE_MARGIN, 0x1A, 1, RW, RAM, 2, 0, 255)                                           \
    X(CCW_COMPLIANCE_MARGIN, 0x1B, 1, RW, RAM, 2, 0, 255)                                          \
    X(CW_PROPORTION, 0x1C, 1, RW, RAM, 32, 0, 255)                                                 \
    X(CCW_PROPORTION, 0x1D, 1, RW, RAM, 32, 0, 255)                                                \
    X(GOAL_POSITION, 0x1E, 2, RW, RAM, 0, 0, 0x3FF)                                                \
    X(MOVING_SPEED, 0x20, 2, RW, RAM, 0, 0, 0x7FF)                                                 \
    X(ACC, 0x22, 1, RW, RAM, 32, 0, 255)                                                           \
    X(DCC, 0x23, 1, RW, RAM, 32, 0, 255)                                                           \
    X(PRESENT_POSITION, 0x24, 2, RD, RAM, 0, 0, 0x3FF)                                             \
    X(PRESENT_SPEED, 0x26, 2, RD, RAM, 0, 0, 0x7FF)                                                \
    X(PRESENT_LOAD, 0x28, 2, RD, RAM, 0, 0, 0x7FF)                                                 \
    X(PRESENT_VOLTAGE, 0x2A, 1, RD, RAM, 0, 0, 255)                                                \
    X(PRESENT_TEMPERATURE, 0x2B, 1, RD, RAM, 0, 0, 255)                                            \
    X(REGISTERED_INSTRUCTION, 0x2C, 1, RW, RAM, 0, 0, 1)                                           \
    X(RESERVED_2D, 0x2D, 1, NO, RAM, 0, 0, 255)                                                    \
    X(MOVING, 0x2E, 1, RD, RAM, 0, 0, 1)                                                           \
    X(LOCK, 0x2F, 1, RW, RAM, 0, 0, 1)                                                             \
    X(PUNCH, 0x30, 2, RW, RAM, 0x5A, 0, 0x3FF)

/* Addresses: CDS_REG_ID, CDS_REG_GOAL_POSITION, ... */
enum cds_register_address {
#define CDS_REGISTER_ENUM_(name, address, width, access, area, initial, lowest, highest)           \
    CDS_REG_##name = address,
    CDS_REGISTERS(CDS_REGISTER_ENUM_)
#undef CDS_REGISTER_ENUM_
} __attribute__((packed));

/* What a program may do with a register; _NO: nothing; a WRITE is refused (R5). */
enum cds_access { CDS_ACCESS_NO, CDS_ACCESS_RD, CDS_ACCESS_RW } __attribute__((packed));

/* Where it lies: EEPROM outlives power-off, and wears; RAM begins again at power-up. */
enum cds_area { CDS_AREA_EEPROM, CDS_AREA_RAM } __attribute__((packed));

/* One register, as its row in the list has it. */
struct cds_register {
    uint8_t address;  // of its low byte
    uint8_t width;    // 1 or 2 bytes, low byte first (R28)
    uint8_t access;   // enum cds_access
    uint8_t area;     // enum cds_area
    uint16_t initial; // value: the factory's, or at power-up
    uint16_t lowest;  // value that a WRITE may carry
    uint16_t highest; // ... both in the register's own unit
};

/* Describes the register that holds the byte `address` (0 to 0x31; the high byte of a word belongs
 * to the word). True, and *out is filled; false above 0x31. Main context. Manual 3.1. */
bool cds_register_at(uint8_t address, struct cds_register *out);

/* Finds a register by its name, in either case, '-' as '_': "GOAL_POSITION", "goal-position".
 * `length` counts the characters of `name`. True, and *out is filled; false if there is none.
 * Main context. */
bool cds_register_named(const char *name, uint8_t length, struct cds_register *out);

/* Copies the name of the register at `address`, as NUL-terminated text, into `name`, at most `room`
 * bytes (CDS_REGISTER_NAME_SIZE is always enough). Returns its length, 0 above 0x31.
 * Main context. */
uint8_t cds_register_name(uint8_t address, char *name, uint8_t room);
#define CDS_REGISTER_NAME_SIZE 23

#ifdef __cplusplus
}
#endif

#endif
