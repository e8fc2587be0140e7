/* SPDX-License-Identifier: MIT */
/* What motion_store.c and motion_store_save.c share: the layout of a record, and access to its
 * bytes. Main context. */
#ifndef CONTROLLER_MOTION_STORE_INTERNAL_H
#define CONTROLLER_MOTION_STORE_INTERNAL_H

#include "robot/motion_store.h"

#include "flash.h" // CDS_FLASH

#define MOTION_STORE_VERSION 1
#define MOTION_STORE_ERASED  UINT8_MAX // as version: no record

/* Bytes of a record; the serial number has three, low byte first. The data begin at AT_DATA, and
 * the CRC follows them, low byte first. */
enum { AT_VERSION, AT_SERIAL, AT_NUMBER = 4, AT_NAME, AT_DATA = AT_NAME + MOTION_STORE_NAME };

enum {
    STEP_BYTES = 5,                     // of each step in the data of a sequence
    POSE_HIGH_AT = MOTION_STORE_JOINTS, // in the data of a pose: the low bytes of all positions
                                        // stand before it, the high 4 bits follow, two in a byte
};

#define POSITION_MAX 1023 // of a joint in a pose; all above is CDS_POSE_NONE

/* Bits of the last byte of a step: high bits of the dwell, curve, does the step pass? */
enum { STEP_DWELL_MASK = 0x1F, STEP_CURVE_SHIFT = 5, STEP_PASSES = 0x80 };

/* Where the records of one kind stand. There is one place more than records: a save needs one. */
struct motion_store_area {
    uint16_t address;
    uint8_t size;       // of a place, in bytes
    uint8_t places;     // how many there are
    uint8_t first_byte; // of `used`
};

/* MOTION_STORE_KINDS: only its first_byte counts. */
const CDS_FLASH struct motion_store_area *motion_store_area(uint8_t kind);

/* Address of a place. */
uint16_t motion_store_address(uint8_t kind, uint8_t place);

/* Reads `count` bytes, 1 or more. Only while the EEPROM is ready. */
void motion_store_read(uint16_t address, void *to, uint8_t count);

/* True if the place has a valid record. motion_store_set_used() notes it, in RAM only. */
bool motion_store_is_used(const struct motion_store *store, uint8_t kind, uint8_t place);
void motion_store_set_used(struct motion_store *store, uint8_t kind, uint8_t place, bool is_used);

/* Returns the first place with a record that has these bytes at `offset`, or MOTION_STORE_NONE;
 * does not check it. Takes up to 0.2 ms. */
uint8_t motion_store_search(const struct motion_store *store, uint8_t kind, uint8_t offset,
                            const uint8_t *bytes, uint8_t count);

/* Searches for a name. */
uint8_t motion_store_place_of(const struct motion_store *store, uint8_t kind, const char *name,
                              uint8_t length);

/* True if a whole record stands there. MOTION_STORE_NONE: false. Only while the EEPROM is ready. */
bool motion_store_is_whole(const struct motion_store *store, uint8_t kind, uint8_t place);

#endif
