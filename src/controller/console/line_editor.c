/* SPDX-License-Identifier: MIT */
/* The editor of the profile `full`; see line_editor.h.
 *
 * Keys only change the text and the cursor, and note in `shown` up to where the terminal is right.
 * editor_show() then compares what the terminal has with what it should have, and sends the
 * difference, a few bytes at a time. */
#include "console/line_editor.h"

#include <string.h>

#include "compiler.h" // NOINLINE
#include "console/history.h"

#define CTRL_A    0x01
#define CTRL_B    0x02
#define CTRL_C    0x03
#define CTRL_D    0x04
#define CTRL_E    0x05
#define CTRL_F    0x06
#define BELL      0x07
#define BACKSPACE 0x08
#define TAB       0x09
#define CTRL_K    0x0B
#define CTRL_L    0x0C
#define CTRL_N    0x0E
#define CTRL_P    0x10
#define CTRL_U    0x15
#define CTRL_W    0x17
#define ESCAPE    0x1B
#define DELETE    0x7F

#define STEP_BYTES 5 // the longest step of show_step(): ESC [ 7 9 D

/* Farther to the left, ESC [ n D is shorter than n backspaces. */
#define BACKSPACES_MAX 4

static const CDS_FLASH char new_line[] = "\r\n";
static const CDS_FLASH char prompt[] = "\r> ";
static const CDS_FLASH char erase[] = "\x1B[K";

/* ---- what the terminal shows ---- */

static void show_character(struct editor *editor, struct printer *echo, char c)
{
    printer_typed_char(echo, c);
    editor->column++;
}

/* A step towards `column`: rightwards by the characters that stand there. */
static void move_to(struct editor *editor, struct printer *echo, uint8_t column)
{
    uint8_t distance = (uint8_t)(editor->column - column);

    if (editor->column < column) {
        show_character(editor, echo, editor->text[editor->column]);
    } else if (distance <= BACKSPACES_MAX) {
        printer_char(echo, '\b');
        editor->column--;
    } else {
        printer_char(echo, ESCAPE);
        printer_char(echo, '[');
        printer_decimal(echo, distance);
        printer_char(echo, 'D');
        editor->column = column;
    }
}

/* Deletes what the terminal shows behind the text; the cursor stands at the end of the text. */
static void erase_rest(struct editor *editor, struct printer *echo)
{
    if (editor->drawn - editor->length == 1)
        show_character(editor, echo, ' '); // also right on a terminal without ESC sequences
    else
        printer_flash(echo, erase);
    editor->drawn = editor->length;
}

/* Sends the next few bytes. False: the terminal is right. */
static bool show_step(struct editor *editor, struct printer *echo)
{
    bool is_short = editor->shown < editor->length;
    uint8_t due = editor->cursor;

    if (editor->prompt_due) {
        printer_flash(echo, prompt);
        editor->prompt_due = false;
        return true;
    }
    if (is_short)
        due = editor->shown;
    else if (editor->drawn > editor->length)
        due = editor->length;
    if (editor->column != due) {
        move_to(editor, echo, due);
    } else if (is_short) {
        show_character(editor, echo, editor->text[editor->shown++]);
        if (editor->drawn < editor->shown)
            editor->drawn = editor->shown;
    } else if (editor->drawn > editor->length) {
        erase_rest(editor, echo);
    } else {
        return false;
    }
    return true;
}

bool editor_show(struct editor *editor, struct printer *echo)
{
    while (cds_ring_count(echo->ring) <= CDS_RING_SIZE - STEP_BYTES)
        if (!show_step(editor, echo))
            return true;
    return false;
}

bool editor_is_shown(const struct editor *editor)
{
    return !editor->prompt_due && editor->shown == editor->length &&
           editor->drawn == editor->length && editor->column == editor->cursor;
}

void line_editor_redraw(struct editor *editor)
{
    editor->shown = editor->drawn = editor->column = 0;
}

/* ---- keys ---- */

/* The text changes from index `from` on. */
static void change(struct editor *editor, uint8_t from)
{
    if (editor->shown > from)
        editor->shown = from;
}

bool line_editor_insert(struct editor *editor, char c)
{
    uint8_t at = editor->cursor;

    if (at < editor->length && editor->length == EDITOR_SIZE - 1)
        return false;
    memmove(editor->text + at + 1, editor->text + at, (size_t)(editor->length - at));
    editor->text[at] = c;
    editor->length++;
    editor->cursor++;
    change(editor, at);
    return true;
}

void line_editor_replace(struct editor *editor, uint8_t at, char c)
{
    if (editor->text[at] == c)
        return;
    editor->text[at] = c;
    change(editor, at);
}

/* Deletes the character at the cursor. */
static void delete (struct editor *editor)
{
    uint8_t at = editor->cursor;

    if (at == editor->length)
        return;
    editor->length--;
    memmove(editor->text + at, editor->text + at + 1, (size_t)(editor->length - at));
    change(editor, at);
}

static void delete_all(struct editor *editor)
{
    editor->length = editor->cursor = editor->locked;
    change(editor, editor->locked);
}

static void delete_rest(struct editor *editor)
{
    editor->length = editor->cursor;
    change(editor, editor->cursor);
}

/* Fetches a line of the history. A line that was begun becomes the newest of them first. */
static void fetch(struct editor *editor, bool is_older)
{
    struct history *history = editor->history;
    char line[EDITOR_SIZE];
    uint8_t length, same = 0;

    if (editor->longer || editor->locked || (!is_older && history->at == history->used) ||
        (is_older && history->at == 0))
        return;
    if (history->at == history->used && editor->length) {
        history_add(history, editor->text, editor->length);
        history_older(history, line);
    }
    length = (is_older ? history_older : history_newer)(history, line);
    if (is_older && length == 0)
        return;
    while (same < length && same < editor->length && line[same] == editor->text[same])
        same++;
    memcpy(editor->text, line, length);
    editor->length = editor->cursor = length;
    change(editor, same);
}

/* The end of an escape sequence, or the digit before its ~, and the control key that means the
 * same. */
static const CDS_FLASH struct {
    char end, key;
} sequences[] = {
    {'A', CTRL_P}, {'B', CTRL_N}, {'C', CTRL_F}, {'D', CTRL_B}, {'H', CTRL_A}, {'F', CTRL_E},
    {'1', CTRL_A}, {'7', CTRL_A}, {'4', CTRL_E}, {'8', CTRL_E}, {'3', CTRL_D},
};

static char key_of(char end)
{
    for (uint8_t i = 0; i < sizeof sequences / sizeof sequences[0]; i++)
        if (sequences[i].end == end)
            return sequences[i].key;
    return '\0';
}

/* What editor->escape is: */
enum { OUTSIDE, BEGUN, WITHIN, NO_KEY }; // or the digit that stands first

/* True if the key may be more than a character. */
static bool is_special(const struct editor *editor, char key)
{
    return key < ' ' || key >= DELETE || editor->escape;
}

/* Returns the key; '\0' if it is within an escape sequence; or the control key that a sequence
 * means. */
static char decode(struct editor *editor, char key)
{
    uint8_t escape = editor->escape;

    if (key == ESCAPE) {
        editor->escape = BEGUN;
        return '\0';
    }
    if (escape == BEGUN && (key == '[' || key == 'O')) {
        editor->escape = WITHIN;
        return '\0';
    }
    if (escape <= BEGUN || key < ' ') { // the end of a line ends the sequence
        editor->escape = OUTSIDE;
        return key;
    }
    if (key >= '0' && key <= '9') {
        editor->escape = escape == WITHIN ? (uint8_t)key : NO_KEY;
        return '\0';
    }
    if (key == ';')
        return '\0';
    editor->escape = OUTSIDE;
    return key_of(key == '~' ? (char)escape : key);
}

/* A character at the end of the line. */
static enum editor_event append(struct editor *editor, char key)
{
    editor->after_cr = false;
    editor->text[editor->length++] = key;
    editor->cursor = editor->length;
    return editor->length == EDITOR_SIZE ? EDITOR_FULL : EDITOR_NONE;
}

static enum editor_event insert(struct editor *editor, char key, struct printer *echo)
{
    if (!line_editor_insert(editor, key)) {
        if (echo)
            printer_char(echo, BELL);
        return EDITOR_NONE;
    }
    return editor->length == EDITOR_SIZE ? EDITOR_FULL : EDITOR_NONE;
}

static void move_left(struct editor *editor)
{
    if (editor->cursor > editor->locked)
        editor->cursor--;
}

static enum editor_event end_of_line(struct editor *editor, struct printer *echo)
{
    (void)editor;
    if (echo)
        printer_flash(echo, new_line);
    return EDITOR_END;
}

/* Ctrl-C: a new line, unless this one is empty. */
static enum editor_event drop(struct editor *editor, struct printer *echo)
{
    if (echo && (editor->length || editor->longer))
        printer_flash(echo, new_line);
    editor->length = editor->cursor = editor->locked;
    line_editor_redraw(editor);
    return EDITOR_DROP;
}

static void take_back(struct editor *editor)
{
    if (editor->cursor > editor->locked) {
        editor->cursor--;
        delete (editor);
    }
}

/* Deletes the word before the cursor. */
static void take_word_back(struct editor *editor)
{
    bool is_in_word = false;
    char before;

    while (editor->cursor > editor->locked) {
        before = editor->text[editor->cursor - 1];
        if (before == ' ' && is_in_word)
            break;
        is_in_word |= before != ' ';
        take_back(editor);
    }
}

static enum editor_event tab(struct editor *editor, struct printer *echo)
{
    return echo ? EDITOR_COMPLETE : insert(editor, TAB, echo);
}

static enum editor_event obey(struct editor *editor, char key, struct printer *echo)
{
    switch (key) {
    case '\0':
    case CTRL_L: break;
    case '\r':
    case '\n': return end_of_line(editor, echo);
    case CTRL_C: return drop(editor, echo);
    case TAB: return tab(editor, echo);
    case CTRL_A: editor->cursor = editor->locked; break;
    case CTRL_B: move_left(editor); break;
    case CTRL_D: delete (editor); break;
    case CTRL_E: editor->cursor = editor->length; break;
    case CTRL_F:
        editor->cursor = (uint8_t)(editor->cursor + (editor->cursor < editor->length));
        break;
    case CTRL_N: fetch(editor, false); break;
    case CTRL_P: fetch(editor, true); break;
    case CTRL_K: delete_rest(editor); break;
    case CTRL_U: delete_all(editor); break;
    case CTRL_W: take_word_back(editor); break;
    case BACKSPACE:
    case DELETE: take_back(editor); break;
    default:
        // A person: a key that other editors have does nothing. A program: the line shall fail.
        return echo && key > '\0' && key < ' ' ? EDITOR_NONE : insert(editor, key, echo);
    }
    return EDITOR_NONE;
}

NOINLINE static enum editor_event take_special(struct editor *editor, char key,
                                               struct printer *echo)
{
    bool after_cr = editor->after_cr;

    editor->after_cr = key == '\r';
    if (key == '\n' && after_cr)
        return EDITOR_NONE;
    return obey(editor, decode(editor, key), echo);
}

enum editor_event editor_key(struct editor *editor, char key, struct printer *echo)
{
    if (editor->cursor == editor->length && !is_special(editor, key))
        return append(editor, key); // quickly: a program sends as fast as the link goes
    return take_special(editor, key, echo);
}

/* ---- to the parser ---- */

static uint8_t without(uint8_t index, uint8_t count)
{
    return (uint8_t)(index > count ? index - count : 0);
}

void editor_take(struct editor *editor, uint8_t count)
{
    editor->length = (uint8_t)(editor->length - count);
    memmove(editor->text, editor->text + count, editor->length);
    editor->cursor = without(editor->cursor, count);
    editor->shown = without(editor->shown, count);
    editor->drawn = without(editor->drawn, count);
    editor->column = without(editor->column, count);
    editor->longer = true;
    editor->locked = 0;
}

void editor_end(struct editor *editor)
{
    history_add(editor->history, editor->text, editor->longer ? 0 : editor->length);
    editor->length = editor->cursor = editor->locked = 0;
    editor->escape = OUTSIDE;
    editor->longer = false;
    line_editor_redraw(editor);
}
