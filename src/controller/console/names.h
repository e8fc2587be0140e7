/* SPDX-License-Identifier: MIT */
/* The names that may stand at a place of a line: commands, words of a command, registers, settings,
 * and, where the flash has room, stored poses and sequences. For completion and for hints, one name
 * a call, so that no call takes long. Main context. */
#ifndef CONTROLLER_NAMES_H
#define CONTROLLER_NAMES_H

#include <stdbool.h>
#include <stdint.h>

#include "console/parse.h" // struct command_line
#include "console/token.h" // struct token

/* A list of names. Zero it to begin. */
struct names {
    struct token name;    // after NAMES_FOUND; not longer than TOKEN_MAX
    struct token earlier; // the name before it
    uint8_t group, row;   // of command_set
    uint8_t within;       // of the row: index of its next word
    uint8_t next; // address of the next register, index of the next setting, or place in the store
};

enum names_result {
    NAMES_NONE,  // this call found no name: call again
    NAMES_FOUND, // names->name is the next name
    NAMES_END,   // there are no more names
} __attribute__((packed));

/* Looks for the next name that may stand at line->usage. line->error must be 0, or the wrong word
 * must be the word at line->usage. */
enum names_result names_next(struct names *names, const struct command_line *line);

/* True if an ID or a list of servos is due. */
bool names_id_is_due(const struct command_line *line);

/* True if the name begins with the `length` characters at `text`, in any case. */
bool names_begin_alike(const struct token *name, const char *text, uint8_t length);

#endif
