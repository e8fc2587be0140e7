/* SPDX-License-Identifier: MIT */
/* Help for people who type: a Tab completes a word, and the error of an unknown name says which
 * name is near. Both work a little in each poll. The profile `full` links them
 * (command_set.typing).
 *
 * Both keep their state in console_job(): the text that the editor holds makes packets of less than
 * 100 bytes, and the reply to a wrong line needs no packet. Main context. */
#ifndef CONTROLLER_TYPING_H
#define CONTROLLER_TYPING_H

#include <stdbool.h>
#include <stdint.h>

#include "console/token.h" // struct token
#include "flash.h"         // CDS_FLASH

struct console;

struct command_typing {
    /* Begins to complete the word before the cursor of the editor. */
    void (*begin)(struct console *console);
    /* Goes on. If one name fits, the rest of it enters the line, and a space. If several fit, what
     * they share enters the line; if there is no more of that, they are listed below the line. If
     * none fits, the terminal rings. Returns false at the end. */
    bool (*complete)(struct console *console);
    /* After an unknown name, token is the word: looks for the nearest name. Returns false at the
     * end. */
    bool (*search)(struct console *console);
    /* True if search() has found a near name, and it is not printed yet. */
    bool (*has_hint)(struct console *console);
    /* Prints it, and the end of the line. */
    void (*print_hint)(struct console *console);
};

extern const CDS_FLASH struct command_typing typing;

/* console->phase while the error of a line waits for search(). hint_parts.c has phases of its own
 * behind TYPING_ENDED. */
enum typing_phase {
    TYPING_BEGINS, // a command begins in this phase
    TYPING_SEARCHES,
    TYPING_ENDED,
    TYPING_NO_SEARCH = UINT8_MAX, // the text of the error names what to type: search no near name
};

/* Begin and complete of `typing`. */
void typing_begin(struct console *console);
bool typing_complete(struct console *console);

/* The begin of a hint. */
extern const CDS_FLASH char typing_did_you_mean[];

/* True if the error is about a name that is not known, so that search() may find a near one. */
bool typing_has_unknown_name(const struct console *console);

/* Counts the characters of `word` that are too many, missing, wrong, or swapped with the next one;
 * stops behind 2. An end that is missing counts as one, behind 3 characters: "mon" has one error of
 * "monitor". */
uint8_t typing_errors(const struct token *word, const struct token *name);

#endif
