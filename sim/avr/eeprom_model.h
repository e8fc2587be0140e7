/* The AVR's EEPROM with the time that a write takes. simavr's own writes at once.
 *
 * A write takes 8.5 ms on chips without EEPM bits (data sheet of the ATmega128, "EEPROM Programming
 * Time": 8448 cycles of 1 MHz), 3.4 ms on the others, 1.8 ms to erase only or to write only (data
 * sheet of the ATmega2560, "EEPROM Mode Bits"). Meanwhile EEPE is 1, and reading, EEAR and EEPM are
 * locked. A reset does not stop a write; loss of power does. What it leaves is our choice, by the
 * share of the time of a write that was over: up to 45 % the old byte, to 50 % with its lower half
 * erased, to 90 % an erased byte, then the new one with its upper half not yet written. Of an erase
 * only or a write only: the old byte.
 */
#ifndef SIM_EEPROM_MODEL_H
#define SIM_EEPROM_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>
#include <simavr/avr_eeprom.h>

#include "wire/schedule.h"

struct eeprom_model {
    avr_t *avr;
    avr_eeprom_t *registers; // simavr's: addresses, vector, and the bytes; 0: the chip has none
    struct schedule *schedule;
    bool exact;
    struct event disarm; // EEMPE falls
    struct event done;
    uint16_t address; // of the write in progress
    uint8_t value;    // that the byte gets
    uint64_t start;
    bool whole; // it erases the old byte and writes the new one
    void *context;
    void (*on_write)(void *context, uint64_t start, uint64_t cycles); // one begins; may be 0
};

void eeprom_model_init(struct eeprom_model *eeprom, avr_t *avr, struct schedule *schedule,
                       bool exact);

/* simavr has reset the chip: a write goes on. */
void eeprom_model_reset(struct eeprom_model *eeprom);
void eeprom_model_lose_power(struct eeprom_model *eeprom, uint64_t now);

/* All its bytes from or to a file. A missing file is not read, and that is no error. Loading also
 * checks that the file can be saved at the end of the run. Saving replaces the file as a whole.
 * False, with one line on stderr. */
bool eeprom_model_load(struct eeprom_model *eeprom, const char *path);
bool eeprom_model_save(const struct eeprom_model *eeprom, const char *path);

#endif
