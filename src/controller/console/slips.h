/* SPDX-License-Identifier: MIT */
/* Slips of a line: words in another order, a comma, a wrong kind of name, a command of another
 * name, a number without its unit, a long unit, a move that is too fast as its time is in ms, a
 * read-only register, `limits` without angles. The text of the error names the line to type:
 *
 *     error 32: ID|254 'on': the ID comes first: 'torque 1 on'
 *
 * advice() returns these texts. */
#ifndef CONTROLLER_SLIPS_H
#define CONTROLLER_SLIPS_H

#include <stdint.h>

#include "console/parse.h" // struct command_line
#include "flash.h"         // CDS_FLASH

struct console;

/* Words that people try behind `command`, and the lines to type instead. */
struct slip_word {
    const CDS_FLASH char *command; // NULL: the word is the first one of the line, and unknown
    const CDS_FLASH char *words;   // "goto|go"
    const CDS_FLASH char *lines;   // "'move 1 90deg'"
};

/* A slip that causes `error`; `text` returns its message, or NULL: the line does not have it. */
struct slip {
    uint8_t error;
    const CDS_FLASH char *(*text)(struct console *console);
};

extern const CDS_FLASH char message_try[];      // "unknown command; try %s"
extern const CDS_FLASH char message_id_first[]; // "the ID comes first: '%s'"
extern const CDS_FLASH char message_is_pose[];

/* A line to type for the command: its example, or its usage. */
static inline const CDS_FLASH char *slip_line_to_type(const CDS_FLASH struct command *row)
{
    const CDS_FLASH char *example = COMMAND_DETAILS_TEXT(row->example);

    return example ? example : row->usage;
}

/* True if the line names one servo, or ID 254: its ID is line->id. */
static inline bool slip_has_one_servo(const struct command_line *line)
{
    return !line->takes_all && !(line->is_repeated && line->values > 1);
}

/* Returns the message that names the lines of the first row that has console->token; NULL: no row
 * has it. */
const CDS_FLASH char *slip_word_text(const CDS_FLASH struct slip_word *rows, uint8_t count,
                                     struct console *console);

/* Returns the text of the first row of console->error that has one; NULL: none has. */
const CDS_FLASH char *slip_first_text(const CDS_FLASH struct slip *rows, uint8_t count,
                                      struct console *console);

/* Returns the message for console->error, with its values in the printer; NULL: the line has none
 * of these slips. The printer must be ready. */
const CDS_FLASH char *slip_text(struct console *console);

#endif
