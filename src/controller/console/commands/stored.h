/* SPDX-License-Identifier: MIT */
/* What the commands share that store, list and delete poses and sequences. */
#ifndef CONTROLLER_STORED_H
#define CONTROLLER_STORED_H

#include "console/console.h"
#include "console/errors.h" // ERROR_NO_POSE
#include "robot/motion_store.h"

/* The store of poses and sequences. */
static inline struct motion_store *console_store(void)
{
    return command_set.store->motions;
}

/* Returns 0 if the EEPROM can be read; else ERROR_SAVING. */
uint8_t stored_may_read(void);

/* The begin function of `pose list` and `sequence list`: as stored_may_read(). */
uint8_t stored_list_begin(struct console *console);

/* The begin function of `pose show` and `sequence show`: stores the place of the record of this
 * kind with name 0 of the line, if there is a name, in console->index. Returns ERROR_SAVING,
 * ERROR_NO_POSE, ERROR_NO_SEQUENCE or 0. */
uint8_t stored_show_begin(struct console *console, enum motion_store_kind kind);

/* Returns 0 if something may be stored now; else ERROR_SAVING, or ERROR_MOTION: the motion under
 * way may read the EEPROM. */
uint8_t stored_may_write(const struct console *console);

/* Returns the number of characters of name `index` of the line, up to MOTION_STORE_NAME + 1. */
uint8_t stored_length(const struct console *console, uint8_t index);

/* Returns the place of the record with name `index` of the line, or MOTION_STORE_NONE. */
uint8_t stored_find(const struct console *console, enum motion_store_kind kind, uint8_t index);

/* The name of the line of which the store has no pose (ERROR_NO_POSE) or no sequence
 * (ERROR_NO_SEQUENCE), without a zero at the end if it has PARSE_NAME_SIZE characters; NULL: the
 * error is another one. */
static inline const char *stored_unknown_name(const struct console *console)
{
    const struct command_line *line = &console->line;
    bool is_pose = console->error == ERROR_NO_POSE;

    if (line->names == 0 || !(is_pose || console->error == ERROR_NO_SEQUENCE))
        return NULL;
    return parse_name(line, is_pose && line->names > 1);
}

/* The first part of a command that stores a record with name 0 of the line. Returns true while the
 * name is compared with the words of all commands, one row in each call. When it returns false, it
 * has stored console->error: ERROR_NAME, ERROR_NAME_LONG, ERROR_KEYWORD or 0. */
bool stored_name_poll(struct console *console);

/* Begins to save `record`, which stays in place until the save has ended. Stores console->error:
 * also an error of stored_may_write(), since a packet may have started a motion after the command
 * has begun. True: begun, stored_save_poll() goes on. */
bool stored_save(struct console *console, const struct motion_store_record *record);

/* Returns the place of the sequence that plays after power-up, or MOTION_STORE_NONE. */
uint8_t stored_autostart(void);

/* Begins to delete the record of this kind with name 0 of the line. Returns an error or 0. */
uint8_t stored_delete(struct console *console, enum motion_store_kind kind);

/* Goes on with a save or delete, and returns true until it has ended. Then it has stored
 * console->error. */
bool stored_save_poll(struct console *console);

/* Polls of `pose list` and `sequence list`: prints a name in each call. Stores ERROR_SAVING in
 * console->error if a save has begun meanwhile. */
bool stored_list_poll(struct console *console, enum motion_store_kind kind);

/* For the poll of a command that prints one record, or all records of its kind: console->index is
 * the place of the present one. Returns true and the place of the first from there on in
 * console->index; false: there are no more, or console->error is ERROR_SAVING. */
bool stored_next(struct console *console, enum motion_store_kind kind);

/* In sequences.c: takes pose, time, dwell and `pass` of a step from the line. The time is number
 * `first`: 1 if the line numbers the step, else 0. Returns an error or 0. */
uint8_t sequence_take_step(struct console *console, uint8_t first, struct motion_store_step *step);

/* In sequences.c: ends a line with a step, "stand 1.2s dwell 0.5s" or "lift 0.3s pass". */
void sequence_print_way(struct printer *printer, const char *pose,
                        const struct motion_store_step *step);

/* In sequences.c: end of struct command_store. After a refused `sequence NAME new` the lines with
 * `add` behind it would go to the stored sequence of this name: they are refused until a `new` is
 * stored, or another command of the group is given. */
void sequence_end(struct console *console);

/* Print two lines of `status`: room, and wear. */
void stored_print_room(struct console *console);
void stored_print_wear(struct console *console);

#endif
