/* SPDX-License-Identifier: MIT */
/* The editor of the profile `console`; see editor.h. */
#include "console/editor.h"

#include <string.h>

#define CTRL_C    0x03
#define BACKSPACE 0x08
#define CTRL_P    0x10
#define CTRL_U    0x15
#define ESCAPE    0x1B
#define DELETE    0x7F

#define ECHO_BYTES 4 // bytes that must be free in the printer's ring: a key's echo, at most "\b \b"

static const CDS_FLASH char take_back[] = "\b \b";
static const CDS_FLASH char new_line[] = "\r\n";
static const CDS_FLASH char short_prompt[] = "\r> ";

bool editor_show(struct editor *editor, struct printer *echo)
{
    while (cds_ring_count(echo->ring) < CDS_RING_SIZE - ECHO_BYTES) {
        if (editor->prompt_due) {
            editor->prompt_due = false;
            printer_flash(echo, short_prompt);
            continue;
        }
        if (editor->shown >= editor->length)
            return true;
        printer_typed_char(echo, editor->text[editor->shown++]);
    }
    return false;
}

bool editor_is_shown(const struct editor *editor)
{
    return !editor->prompt_due && editor->shown == editor->length;
}

static void rub_out(struct editor *editor, struct printer *echo)
{
    if (editor->length == editor->locked)
        return;
    editor->length--;
    editor->shown = editor->length;
    if (echo)
        printer_flash(echo, take_back);
}

/* Drops the line and begins a new one on the terminal. No characters are locked: the console takes
 * no key while the parser takes characters. */
static void rub_out_all(struct editor *editor, struct printer *echo)
{
    if (echo && editor->length)
        printer_flash(echo, new_line);
    editor->length = 0;
    editor->shown = 0;
}

static void fetch_back(struct editor *editor)
{
    if (editor->length == 0 && !editor->longer)
        editor->length = editor->last;
}

/* ESC [ A is arrow up; other sequences are ignored. True: the key is part of a sequence. */
static bool is_escape(struct editor *editor, char key)
{
    if (key == ESCAPE) {
        editor->escape = 1;
        return true;
    }
    if (editor->escape == 1 && (key == '[' || key == 'O')) {
        editor->escape = 2;
        return true;
    }
    if (editor->escape != 2 || key < ' ') { // the end of a line ends the sequence
        editor->escape = 0;
        return false;
    }
    if (key >= '0' && key <= ';') // a number within it
        return true;
    if (key == 'A')
        fetch_back(editor);
    editor->escape = 0;
    return true;
}

static enum editor_event put(struct editor *editor, char key)
{
    editor->text[editor->length++] = key;
    editor->last = 0; // the new line overwrites it
    return editor->length == EDITOR_SIZE ? EDITOR_FULL : EDITOR_NONE;
}

enum editor_event editor_key(struct editor *editor, char key, struct printer *echo)
{
    bool after_cr = editor->after_cr;

    editor->after_cr = key == '\r';
    if (key == '\n' && after_cr)
        return EDITOR_NONE;
    if (is_escape(editor, key))
        return EDITOR_NONE;
    switch (key) {
    case '\r':
    case '\n':
        if (echo)
            printer_flash(echo, new_line);
        return EDITOR_END;
    case CTRL_C:
    case CTRL_U:
        rub_out_all(editor, echo);
        if (key == CTRL_C || !editor->longer)
            return EDITOR_DROP; // the console prints the prompt
        return EDITOR_NONE;
    case CTRL_P: fetch_back(editor); return EDITOR_NONE;
    case BACKSPACE:
    case DELETE: rub_out(editor, echo); return EDITOR_NONE;
    default: return put(editor, key);
    }
}

void editor_take(struct editor *editor, uint8_t count)
{
    editor->length = (uint8_t)(editor->length - count);
    editor->shown = (uint8_t)(editor->shown > count ? editor->shown - count : 0);
    memmove(editor->text, editor->text + count, editor->length);
    editor->longer = true;
    editor->locked = 0;
}

void editor_end(struct editor *editor)
{
    if (editor->length || editor->longer)
        editor->last = editor->longer ? 0 : editor->length;
    editor->length = 0;
    editor->shown = 0;
    editor->locked = 0;
    editor->escape = 0;
    editor->longer = false;
}
