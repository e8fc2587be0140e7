/* SPDX-License-Identifier: MIT */
/* The AVR's EEPROM with the duration of a write. simavr's own EEPROM writes at once.
 *
 * Duration: 8.5 ms on chips without EEPM bits (data sheet of the ATmega128, "EEPROM Programming
 * Time"), else 3.4 ms, or 1.8 ms for erase only or write only (data sheet of the ATmega2560,
 * "EEPROM Mode Bits"). Meanwhile EEPE is 1, and reading, EEAR and EEPM are locked. A reset does not
 * stop a write.
 *
 * A loss of power stops a write. No data sheet says what it leaves. The model leaves, by the share
 * of the duration that was over: up to 45 % the old byte; up to 50 % its lower half erased; up to
 * 90 % an erased byte; then the new byte with its upper half unwritten. Erase only or write only:
 * the old byte. */
#ifndef SIM_EEPROM_MODEL_H
#define SIM_EEPROM_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>
#include <simavr/avr_eeprom.h>

#include "wire/schedule.h"

struct eeprom_model {
    avr_t *avr;
    avr_eeprom_t *registers; // simavr's: addresses, vector and bytes; 0: the chip has no EEPROM
    struct schedule *schedule;
    bool exact;
    struct event disarm; // clears EEMPE
    struct event done;
    uint16_t address; // of the present write
    uint8_t value;    // of the byte after the write
    uint64_t start;
    bool whole; // the write erases the old byte and writes the new byte
    void *context;
    void (*on_write)(void *context, uint64_t start, uint64_t cycles); // a write begins; may be 0
};

void eeprom_model_init(struct eeprom_model *eeprom, avr_t *avr, struct schedule *schedule,
                       bool exact);

/* Call it after simavr has reset the chip. A write continues. */
void eeprom_model_reset(struct eeprom_model *eeprom);
void eeprom_model_lose_power(struct eeprom_model *eeprom, uint64_t now);

/* Load and save all bytes. A missing file is no error. Loading checks that the file can be saved at
 * the end of the run. Saving replaces the file as a whole. Return false, with one line on stderr.
 */
bool eeprom_model_load(struct eeprom_model *eeprom, const char *path);
bool eeprom_model_save(const struct eeprom_model *eeprom, const char *path);

#endif
