/* SPDX-License-Identifier: MIT */
/* The line being typed: its latest characters, which may still be taken back. A longer line moves
 * on to the parser from its front, so a line may be of any length.
 *
 * A profile has one of two editors: short_editor deletes at the end of the line and fetches the
 * last line back, until another line is begun; line_editor (line_editor.h) does more. */
#ifndef CONTROLLER_EDITOR_H
#define CONTROLLER_EDITOR_H

#include <stdbool.h>
#include <stdint.h>

#include "console/printer.h" // struct printer

struct history;

#define EDITOR_SIZE 80 // characters, even

/* What a key asks for. */
enum editor_event {
    EDITOR_NONE,     // nothing to do
    EDITOR_FULL,     // give no more keys until editor_take() was called
    EDITOR_END,      // the line is complete: take all of it
    EDITOR_DROP,     // forget the line (Ctrl-C)
    EDITOR_COMPLETE, // complete the word before the cursor (Tab); only of line_editor.c
} __attribute__((packed));

/* A zeroed editor is empty. */
struct editor {
    uint8_t length;  // of the text
    uint8_t shown;   // characters of the text that are echoed
    uint8_t locked;  // characters on their way to the parser: they cannot be taken back
    uint8_t last;    // length of the last line, if the text still holds it, or 0
    uint8_t escape;  // how much of an escape sequence has come
    bool prompt_due; // the terminal does not show the prompt yet
    bool longer;     // some of this line has gone to the parser
    bool after_cr;   // a LF now belongs to the same end of line
    char text[EDITOR_SIZE];
    /* Only line_editor.c uses these: */
    uint8_t cursor; // index of the character at the cursor, 0 to length
    uint8_t drawn;  // characters of the line that the terminal shows, right or not
    uint8_t column; // where the cursor of the terminal is, from the begin of the text
    struct history *history;
};

/* Prints the prompt if it is due, and echoes more of the text, as far as there is room. True when
 * all is echoed and there is room for the echo of the next key. Not needed without echo. */
bool editor_show(struct editor *editor, struct printer *echo);

/* True if nothing is left to be echoed. */
bool editor_is_shown(const struct editor *editor);

/* Takes a key. Call it only while length < EDITOR_SIZE; with echo, after editor_show() was true.
 * Without echo, `echo` is NULL. */
enum editor_event editor_key(struct editor *editor, char key, struct printer *echo);

/* Forgets the first `count` characters, 0 to length. */
void editor_take(struct editor *editor, uint8_t count);

/* Ends the line, and keeps it to be fetched back if it is not too long. */
void editor_end(struct editor *editor);

#endif
