/* The line being typed: its latest characters, which may still be taken back. A longer line moves
 * on to the parser from its front, so there is no end to its length. The last line, if it was not
 * longer than this, can be fetched back until another one is begun. */
#ifndef CONTROLLER_EDITOR_H
#define CONTROLLER_EDITOR_H

#include <stdbool.h>
#include <stdint.h>

#include "console/printer.h" // struct printer

#define EDITOR_SIZE 80 // characters, even

/* What a key asks for. */
enum editor_event {
    EDITOR_NONE, // it was dealt with
    EDITOR_FULL, // no key more, until some of the text was taken by editor_take()
    EDITOR_END,  // of the line: all of it is to be taken
    EDITOR_DROP, // forget the line (Ctrl-C)
} __attribute__((packed));

/* Zeroed, it is empty. */
struct editor {
    uint8_t length; // of the text
    uint8_t shown;  // characters of the text that are echoed
    uint8_t locked; // characters on their way to the parser: they cannot be taken back
    uint8_t last;   // length of the line before, which is still there; 0: it is not
    uint8_t escape; // how much of an escape sequence has come
    bool longer;    // some of this line has gone to the parser
    bool after_cr;  // a LF now belongs to the same end of line
    char text[EDITOR_SIZE];
};

/* Echoes what has not been yet, as far as there is room; no `echo` (NULL) counts as echoed. True
 * when all is, and there is room for what the next key echoes. */
bool editor_show(struct editor *editor, struct printer *echo);

/* A key, to be given only after editor_show() was true, while length < EDITOR_SIZE. */
enum editor_event editor_key(struct editor *editor, char key, struct printer *echo);

/* Forgets the first `count` characters, 0 to length. */
void editor_take(struct editor *editor, uint8_t count);

/* The line is over, and kept to be fetched back if it was not too long. */
void editor_end(struct editor *editor);

#endif
