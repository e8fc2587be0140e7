/* SPDX-License-Identifier: MIT */
/* Poses and sequences that outlive power-off, in the EEPROM, and the joints that their positions
 * belong to. The layout: docs/internals/motion-store.md.
 *
 *     static struct motion_store_record record; // stays in place until the save has ended
 *     record = (struct motion_store_record){
 *         .kind = MOTION_STORE_POSE, .name = "stand", .length = 5, .positions = positions};
 *     result = motion_store_save(&store, &record);
 *     ...motion_store_poll(&store); // in each turn of the main loop, until it returns false
 *
 * A save never overwrites the record it replaces: when the power fails, or the save is aborted, the
 * old record stands or the new one. Reads are refused while the EEPROM is written: call them when
 * motion_store_is_saving() is false. All functions: main context. */
#ifndef CONTROLLER_MOTION_STORE_H
#define CONTROLLER_MOTION_STORE_H

#include <stdbool.h>
#include <stdint.h>

#include "avr/eeprom_driver.h" // avr_eeprom_ready()
#include "robot/settings.h"    // struct settings_store

enum {
    MOTION_STORE_NAME = 8,         // characters of a name at most
    MOTION_STORE_JOINTS = 18,      // joints at most; each pose has a position for each of them
    MOTION_STORE_STEPS = 16,       // steps of a sequence at most
    MOTION_STORE_TIME_MAX = 60000, // of a step, in 10 ms
    MOTION_STORE_DWELL_MAX = 6553, // of a step, in 10 ms
    MOTION_STORE_NONE = UINT8_MAX, // as a place: there is no such record
    MOTION_STORE_BITMAP = 12,      // bytes with a bit for each place
};

enum motion_store_kind {
    MOTION_STORE_JOINT_LIST, // one record, without a name
    MOTION_STORE_POSE,
    MOTION_STORE_SEQUENCE,
    MOTION_STORE_AUTOSTART, // one record, without a name: the sequence that plays after power-up
    MOTION_STORE_KINDS,
} __attribute__((packed));

/* A step of a sequence. */
struct motion_store_step {
    uint8_t pose;        // its number: motion_store_number()
    uint8_t curve;       // enum cds_motion_curve
    bool passes;         // without a stop at the pose
    uint16_t time_10ms;  // 1 to MOTION_STORE_TIME_MAX
    uint16_t dwell_10ms; // 0 to MOTION_STORE_DWELL_MAX
};

/* Returns the shortest time of a step that is at least `ms`: a multiple of 10 ms. */
static inline uint32_t motion_store_round_up(uint32_t ms)
{
    return (ms + 9) / 10 * 10;
}

/* What is saved or deleted. The store copies neither the record nor what the pointers point to:
 * they stay in place until the save has ended. */
struct motion_store_record {
    uint8_t kind;     // enum motion_store_kind
    const char *name; // a letter, then letters and digits. The caller refuses keywords
    uint8_t length;   // of the name, 1 to MOTION_STORE_NAME; 0 for joints and autostart
    uint8_t count;    // joints: number of IDs. Sequence: number of `steps`. Autostart: delay and
                      // AUTOSTART_LOOP (autostart.h), not 0
    uint8_t kept; // sequence: number of stored steps to keep; `steps` follow them. To append: kept
                  // = number of stored steps, count = 1
    union {       // for motion_store_save()
        const uint8_t *ids;                    // 0 to 253, each once
        const uint16_t *positions;             // MOTION_STORE_JOINTS of them: 0 to 1023, or
                                               // CDS_POSE_NONE
        const struct motion_store_step *steps; // NULL if `count` is 0
        const char *sequence; // MOTION_STORE_NAME characters: name of a sequence, zeros behind it
    };
};

/* True if a pose or a sequence may have this name of `length` characters: a letter, then letters
 * and digits, MOTION_STORE_NAME characters at most. */
bool motion_store_is_name(const char *name, uint8_t length);

/* store->result, and what motion_store_save() and motion_store_delete() return. */
enum motion_store_result {
    MOTION_STORE_IDLE,   // nothing was saved since the load, or the save was aborted
    MOTION_STORE_SAVING, // the save goes on, or has begun
    MOTION_STORE_SAVED,  // the record is stored or deleted
    MOTION_STORE_FAILED, // a byte does not keep what is written: the older record still stands. Try
                         // again: the next save takes another place
    MOTION_STORE_BUSY,   // a save is under way
    MOTION_STORE_BAD, // a name, position, ID or step is out of range, or there are too many steps
    MOTION_STORE_MISSING, // there is no whole record of this name
    MOTION_STORE_FULL,    // there is no room for one more record of the kind
    MOTION_STORE_IN_USE,  // joints: the list has another ID in the place of a joint that a pose
                          // uses, so its position would go to another servo
} __attribute__((packed));

/* The store. The program reads result, damaged and saves; the rest is internal. */
struct motion_store {
    uint8_t result;  // enum motion_store_result of the last save
    uint8_t damaged; // records that the load found damaged; they do not count as stored
    uint32_t saves;  // since the chip was new: a cell bears 100 000, and saves go round all places
    const struct settings_store *settings;    // in the same EEPROM
    const struct motion_store_record *record; // being saved
    uint16_t crc;                             // of its bytes so far
    uint16_t stale; // address of a record that a newer one replaces, or 0; the next save erases it
    uint8_t place;  // where it goes, or that is deleted
    uint8_t size;   // of the record, in bytes
    uint8_t old;    // place of the older record, or NONE
    uint8_t step;   // of the save
    uint8_t number; // byte 4 of the record
    bool is_delete : 1;                // not a save
    bool has_place : 1;                // `place` is free
    bool has_number : 1;               // no other record uses it
    bool is_written : 1;               // the byte of this step
    uint8_t last[MOTION_STORE_KINDS];  // place of the last save
    uint8_t used[MOTION_STORE_BITMAP]; // bit for each place: a record stands there
};

/* Finds the records. Once, at start-up: takes 1 ms, with a full EEPROM up to 40 ms, and waits up
 * to 8.5 ms more for a write that a reset found under way. Writes nothing. While `settings`, which
 * stays in place, are being saved no record can be read. */
void motion_store_load(struct motion_store *store, const struct settings_store *settings);

/* --- saving ----------------------------------------------------------------------------------- */

/* Begins to save `record`, in place of the record of this kind and name if there is one;
 * motion_store_poll() goes on. Takes up to 0.5 ms. Returns
 *
 *   MOTION_STORE_SAVING   it has begun; with all others nothing was changed
 *   MOTION_STORE_BUSY     motion_store_is_saving()
 *   MOTION_STORE_BAD      something in `record` is out of range
 *   MOTION_STORE_FULL     a new name, and no room
 *   MOTION_STORE_MISSING  `kept` is above the number of steps that are stored whole
 *   MOTION_STORE_IN_USE   joints: the positions of stored poses would go to other servos */
enum motion_store_result motion_store_save(struct motion_store *store,
                                           const struct motion_store_record *record);

/* Begins to delete the record of this kind and name; of `record` the other fields do not count. A
 * sequence that has a deleted pose stays as it is: its step names a number that no pose has, and no
 * new pose gets this number. MOTION_STORE_SAVING: it has begun; BUSY; MISSING. */
enum motion_store_result motion_store_delete(struct motion_store *store,
                                             const struct motion_store_record *record);

/* Goes on: writes at most one byte, none while the EEPROM is busy. Takes up to 0.2 ms. True while
 * there is more to do: up to 0.4 s for a pose, 0.9 s for a sequence of 16 steps (ATmega128). Then
 * store->result tells: MOTION_STORE_SAVED or MOTION_STORE_FAILED. */
bool motion_store_poll(struct motion_store *store);

/* Ends a save at once; result becomes MOTION_STORE_IDLE. The older record stays valid. The new
 * record is valid instead if its version byte was already being written. */
void motion_store_abort(struct motion_store *store);

/* True while no record can be read: the store or the settings are being saved, or the EEPROM writes
 * a byte of an aborted save. It is true between two bytes of a save, too, so that a command or a
 * motion is refused as a whole, and not in its midst. */
static inline bool motion_store_is_saving(const struct motion_store *store)
{
    return store->result == MOTION_STORE_SAVING || store->settings->result == SETTINGS_SAVING ||
           !avr_eeprom_ready();
}

/* --- reading ---------------------------------------------------------------------------------- */

/* Each function that reads a record checks it first, and returns as for a missing record if it is
 * damaged or motion_store_is_saving(). motion_store_find() takes up to 0.4 ms for a pose or a
 * sequence, motion_store_read_pose() 0.25 ms. A place stays valid until the next save. */

/* Returns the place of the record with this name, or MOTION_STORE_NONE. */
uint8_t motion_store_find(const struct motion_store *store, enum motion_store_kind kind,
                          const char *name, uint8_t length);

/* Returns the first place from `place` on that has a record, or MOTION_STORE_NONE. For lists: begin
 * with place 0, go on with the place behind the one returned. Reads no EEPROM, and does not check:
 * motion_store_read_name() does. */
uint8_t motion_store_next(const struct motion_store *store, enum motion_store_kind kind,
                          uint8_t place);

/* Reads the name of a record, and ends it with \0. False: no such record. */
bool motion_store_read_name(const struct motion_store *store, enum motion_store_kind kind,
                            uint8_t place, char name[MOTION_STORE_NAME + 1]);

/* Returns the number of the pose at `place`, which motion_store_find() returned: what steps name. A
 * pose keeps its number when it is replaced. Or the number of steps of a sequence. Does not check.
 */
uint8_t motion_store_number(const struct motion_store *store, enum motion_store_kind kind,
                            uint8_t place);

/* Returns the place of the pose with this number, or MOTION_STORE_NONE: it was deleted. Takes up to
 * 0.15 ms. Does not check: motion_store_read_pose() does. */
uint8_t motion_store_pose_of(const struct motion_store *store, uint8_t number);

/* Reads the positions of a pose: 0 to 1023, or CDS_POSE_NONE. False: no such record; `positions`
 * are as before. */
bool motion_store_read_pose(const struct motion_store *store, uint8_t place,
                            uint16_t positions[MOTION_STORE_JOINTS]);

/* Reads step `index` of the sequence at `place`, which motion_store_find() has checked; this
 * function checks only `index`, and takes 40 us. False: there is no such step, or
 * motion_store_is_saving(), which is not the end of the sequence: ask that first. */
bool motion_store_read_step(const struct motion_store *store, uint8_t place, uint8_t index,
                            struct motion_store_step *step);

/* Reads the IDs of the joints, in the order that positions have in poses. Returns their number; 0:
 * no joints were saved, or the record is damaged. The list may have joints that no pose uses: it is
 * saved before the pose, and a pose may be deleted. */
uint8_t motion_store_read_joints(const struct motion_store *store,
                                 uint8_t ids[MOTION_STORE_JOINTS]);

/* True if a stored pose has a position for this joint, 0 to MOTION_STORE_JOINTS - 1. Takes up to
 * 0.2 ms, if all poses lack the joint. Only if not motion_store_is_saving(). */
bool motion_store_uses_joint(const struct motion_store *store, uint8_t joint);

/* Reads the IDs of the joints that stored poses use, and returns their number. Takes up to 0.4 ms,
 * and 0.2 ms for each joint of the list that no pose uses. */
uint8_t motion_store_read_servos(const struct motion_store *store,
                                 uint8_t ids[MOTION_STORE_JOINTS]);

/* Reads the name of the sequence that plays after power-up, and ends it with \0. Returns its
 * delay and AUTOSTART_LOOP (autostart.h); 0: none plays, or the record is damaged. */
uint8_t motion_store_read_autostart(const struct motion_store *store,
                                    char name[MOTION_STORE_NAME + 1]);

/* Returns how many records of the kind the EEPROM of this chip holds. */
uint8_t motion_store_capacity(enum motion_store_kind kind);

/* Returns for how many more records of the kind there is room. */
uint8_t motion_store_room(const struct motion_store *store, enum motion_store_kind kind);

#endif
