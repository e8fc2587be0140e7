/* SPDX-License-Identifier: MIT */
/* Keeps the EEPROM areas of servos in a folder from run to run (--state DIR).
 *
 * Each servo has one small text file. Its name has the bus and the ID under which the servo was put
 * there. A servo without a file has factory values. A file is replaced as a whole, so a run that is
 * killed leaves the old or the new content. */
#ifndef SIM_SERVO_EEPROM_H
#define SIM_SERVO_EEPROM_H

#include <stdbool.h>
#include <stdint.h>

#include "servo/ids.h"
#include "servo/servos.h"
#include "wire/schedule.h"

/* A pattern for fnmatch() that matches the names of the files. */
#define SERVO_EEPROM_FILES "bus[0-9]-servo[0-9][0-9][0-9]*.eeprom"

struct servo_eeprom {
    const char *folder; // 0: nothing is kept, and every call does nothing
    unsigned bus;
    struct servos *servos;
    struct event save;
    uint64_t period;
    uint8_t saved[IDS_MAX][SERVO_EEPROM_SIZE];
    bool failed; // a file could not be written
};

/* Creates `folder` if needed (0: none), and saves changes four times a second from now on. Returns
 * false, with one line on stderr, if the folder cannot be created. */
bool servo_eeprom_init(struct servo_eeprom *eeprom, const char *folder, unsigned bus,
                       struct servos *servos);

/* Gives new servos the content of their files. Returns false, with one line on stderr, if a file is
 * damaged. */
bool servo_eeprom_load(struct servo_eeprom *eeprom);

/* Writes changes. After a failure, which prints one line on stderr, it does nothing. */
void servo_eeprom_save(struct servo_eeprom *eeprom);

#endif
