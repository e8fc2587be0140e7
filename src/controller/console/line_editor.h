/* SPDX-License-Identifier: MIT */
/* The editor of the profile `full`: the cursor moves within the line, and the latest lines can be
 * fetched back. It needs a terminal that obeys BS, CR, ESC [ n D and ESC [ K. A line wider than the
 * terminal can only be typed and deleted at its end.
 *
 *   Left, Ctrl-B   back one character        Up, Ctrl-P     the line before
 *   Right, Ctrl-F  on one character          Down, Ctrl-N   the line after
 *   Home, Ctrl-A   to the begin of the line  Tab            EDITOR_COMPLETE, with echo
 *   End, Ctrl-E    to the end of the line    Del, Ctrl-D    deletes at the cursor
 *   Backspace      deletes before the cursor Ctrl-U         deletes the line
 *   Ctrl-W         deletes the word before   Ctrl-K         deletes all from the cursor on */
#ifndef CONTROLLER_LINE_EDITOR_H
#define CONTROLLER_LINE_EDITOR_H

#include "console/editor.h"

/* Inserts a character at the cursor of a line of less than EDITOR_SIZE characters. False: a line of
 * EDITOR_SIZE - 1 characters takes one only at its end, and then it is full (EDITOR_FULL). */
bool line_editor_insert(struct editor *editor, char c);

/* Replaces the character at index `at`. */
void line_editor_replace(struct editor *editor, uint8_t at, char c);

/* The terminal shows nothing of the line: it is drawn again, behind the prompt if there is one. */
void line_editor_redraw(struct editor *editor);

#endif
