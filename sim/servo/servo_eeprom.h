/* The EEPROM areas of servos, kept in a folder from run to run: one small text file for each servo,
 * called after its bus and the ID it was put there with. A servo without a file is as from the
 * factory. A file is replaced as a whole, so that a run that is killed leaves the old or the new
 * one.
 */
#ifndef SIM_SERVO_EEPROM_H
#define SIM_SERVO_EEPROM_H

#include <stdbool.h>
#include <stdint.h>

#include "servo/ids.h"
#include "wire/schedule.h"
#include "servo/servos.h"

/* The names of the files in the folder, for fnmatch(). */
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

/* `folder` is made if need be; 0: none. False, with one line on stderr, when there can be none.
 * From now on what has changed is saved four times a second. */
bool servo_eeprom_init(struct servo_eeprom *eeprom, const char *folder, unsigned bus,
                       struct servos *servos);

/* The servos are others now: gives them what was kept of them. False, with one line on stderr, when
 * a file is damaged. */
bool servo_eeprom_load(struct servo_eeprom *eeprom);

/* Writes what has changed. After a failure, told once on stderr, it does nothing. */
void servo_eeprom_save(struct servo_eeprom *eeprom);

#endif
