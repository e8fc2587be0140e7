/* SPDX-License-Identifier: MIT */
/* An EEPROM for tests, in place of src/controller/avr/eeprom_driver.c. A test chooses the write
 * during which the power fails. A call that the driver does not allow in its state counts as a
 * breach. */
#ifndef EEPROM_FAKE_H
#define EEPROM_FAKE_H

#include <stdbool.h>
#include <stdint.h>

#define FAKE_EEPROM_SIZE 160 // unless the suite brings its own: an AVR has not much RAM
#define FAKE_NO_CELL     UINT16_MAX

/* What a byte is when the power goes while it is written. */
enum fake_cut { CUT_OLD, CUT_HALF_ERASED, CUT_ERASED, CUT_HALF_WRITTEN, CUT_NEW, CUTS };

struct eeprom_fake {
    uint8_t *bytes;
    uint16_t size;     // of `bytes`
    bool has_more;     // bytes behind `bytes`, which are erased and only read
    uint16_t writes;   // so far
    uint16_t cut_at;   // the write in which the power goes, from 1 on; 0: none
    uint8_t cut;       // enum fake_cut
    bool has_no_power; // nothing is written
    uint16_t dead;     // a cell that keeps 0x55, or FAKE_NO_CELL
    uint8_t slow;      // how often it is not yet ready after a write
    uint8_t busy;      // how often it is not ready from now on
    uint16_t breaches; // of the port's rules
};

extern struct eeprom_fake eeprom_fake;

/* Erased, powered, quick and without fault, with FAKE_EEPROM_SIZE bytes. */
void eeprom_fake_reset(void);

/* As eeprom_fake_reset(), with `size` bytes at `bytes`. */
void eeprom_fake_reset_to(uint8_t *bytes, uint16_t size);

/* The power is back. */
void eeprom_fake_power_up(void);

#endif
