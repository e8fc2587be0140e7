/* SPDX-License-Identifier: MIT */
/* The editor of the profile `full`, on a model of a terminal: after each key the terminal shows the
 * line, and its cursor stands where the editor has its own. */
#include <stdio.h>
#include <string.h>

#include "console/history.h"
#include "console/line_editor.h"
#include "ring_input.h"
#include "unity.h"

#define LEFT  "\x1B[D"
#define RIGHT "\x1B[C"
#define UP    "\x1B[A"
#define DOWN  "\x1B[B"
#define HOME  "\x1B[H"
#define END   "\x1B[F"
#define DEL   "\x1B[3~"

#define WIDTH 255

static struct cds_ring ring;
static struct printer printer;
static struct editor editor;
static struct history history;

/* The row of the terminal that the cursor is in. */
static struct {
    char row[WIDTH + 1];
    uint8_t column;
    char number; // digits of ESC [ n D so far
    uint8_t escape;
    uint16_t bytes, bells;
} screen;

static void clear_row(void)
{
    memset(screen.row, ' ', WIDTH);
}

void setUp(void)
{
    memset(&ring, 0, sizeof ring);
    memset(&editor, 0, sizeof editor);
    memset(&history, 0, sizeof history);
    memset(&screen, 0, sizeof screen);
    clear_row();
    printer = (struct printer){.ring = &ring};
    editor.history = &history;
}

void tearDown(void)
{
}

static void obey_sequence(char c)
{
    if (screen.escape == 1) {
        TEST_ASSERT_EQUAL_CHAR('[', c);
        screen.escape = 2;
        screen.number = 0;
    } else if (c >= '0' && c <= '9') {
        screen.number = (char)(10 * screen.number + c - '0');
    } else {
        screen.escape = 0;
        if (c == 'K') {
            memset(screen.row + screen.column, ' ', (size_t)(WIDTH - screen.column));
            return;
        }
        TEST_ASSERT_EQUAL_CHAR('D', c);
        TEST_ASSERT_LESS_OR_EQUAL_INT(screen.column, screen.number);
        screen.column = (uint8_t)(screen.column - screen.number);
    }
}

static void obey(char c)
{
    screen.bytes++;
    if (screen.escape) {
        obey_sequence(c);
    } else if (c == '\x1B') {
        screen.escape = 1;
    } else if (c == '\b') {
        TEST_ASSERT_GREATER_THAN_UINT8(0, screen.column);
        screen.column--;
    } else if (c == '\r') {
        screen.column = 0;
    } else if (c == '\n') {
        clear_row();
    } else if (c == '\a') {
        screen.bells++;
    } else {
        TEST_ASSERT_TRUE(c >= ' ' && c < 0x7F);
        screen.row[screen.column++] = c;
    }
}

static void show_all(void)
{
    bool done;

    do {
        done = editor_show(&editor, &printer);
        for (; cds_ring_count(&ring); ring_drop(&ring, 1))
            obey((char)ring_peek(&ring, 0));
    } while (!done);
    TEST_ASSERT_TRUE(editor_is_shown(&editor));
}

/* The terminal shows this row up to its end, and the cursor in this column. */
static void assert_row(const char *row, uint8_t column)
{
    char expected[WIDTH + 1];

    memset(expected, ' ', sizeof expected);
    memcpy(expected, row, strlen(row));
    TEST_ASSERT_EQUAL_STRING_LEN(expected, screen.row, WIDTH);
    TEST_ASSERT_EQUAL_UINT8(column, screen.column);
}

static void assert_line(const char *line, uint8_t cursor)
{
    char text[EDITOR_SIZE + 1] = "";

    memcpy(text, editor.text, editor.length);
    TEST_ASSERT_EQUAL_STRING(line, text);
    TEST_ASSERT_EQUAL_UINT8(cursor, editor.cursor);
    assert_row(line, cursor);
}

static enum editor_event press(char key)
{
    enum editor_event event = editor_key(&editor, key, &printer);

    if (event == EDITOR_END || event == EDITOR_DROP)
        editor_end(&editor);
    show_all();
    return event;
}

/* Types `keys`; the event of the last one. */
static enum editor_event type(const char *keys)
{
    enum editor_event event = EDITOR_NONE;

    while (*keys)
        event = press(*keys++);
    return event;
}

void test_text_is_echoed_up_to_the_end_of_the_line(void)
{
    TEST_ASSERT_EQUAL(EDITOR_NONE, type("ping 1"));
    assert_line("ping 1", 6);
    TEST_ASSERT_EQUAL_UINT16(6, screen.bytes);
    TEST_ASSERT_EQUAL(EDITOR_END, type("\r"));
    assert_line("", 0);
}

void test_each_moving_key_moves_the_cursor(void)
{
    static const struct {
        const char *keys;
        uint8_t cursor;
    } cases[] = {{LEFT, 3},       {"\x02", 3},         {LEFT LEFT RIGHT, 3}, {LEFT LEFT "\x06", 3},
                 {RIGHT, 4},      {HOME, 0},           {"\x01", 0},          {HOME LEFT, 0},
                 {HOME END, 4},   {HOME "\x05", 4},    {"\x1B[1~", 0},       {"\x1B[7~", 0},
                 {"\x1BOH", 0},   {HOME "\x1B[4~", 4}, {HOME "\x1B[8~", 4},  {HOME "\x1BOF", 4},
                 {"\x1B[1;5D", 3}};

    for (uint8_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        type("ping");
        type(cases[i].keys);
        assert_line("ping", cases[i].cursor);
    }
}

void test_other_escape_sequences_are_ignored(void)
{
    type("ab\x1B[2~\x1B[15~\x1B[200~\x1B[5~\x1BOP\x1B[Z");
    assert_line("ab", 2);
    type("\x1B" // and a lone ESC eats nothing
         "f");
    assert_line("abf", 3);
    TEST_ASSERT_EQUAL(EDITOR_END, type("\x1B[\r"));
}

void test_text_is_inserted_at_the_cursor(void)
{
    type("pg" LEFT "in");
    assert_line("ping", 3);
    type(HOME "x" END "y");
    assert_line("xpingy", 6);
}

void test_delete_keys_delete_on_their_side_of_the_cursor(void)
{
    type("pong" LEFT LEFT);
    type("\b");
    assert_line("png", 1);
    type(DEL);
    assert_line("pg", 1);
    type("\x04");
    assert_line("p", 1);
    type(DEL "\x04");
    assert_line("p", 1);
    type(HOME "\b\x7F");
    assert_line("p", 0);
}

void test_backspace_at_the_end_needs_no_escape_sequence(void)
{
    type("pong");
    screen.bytes = 0;
    type("\b");
    assert_line("pon", 3);
    TEST_ASSERT_EQUAL_UINT16(3, screen.bytes);
}

void test_ctrl_u_deletes_the_line_and_ctrl_c_drops_it(void)
{
    TEST_ASSERT_EQUAL(EDITOR_NONE, type("ping" LEFT "\x15"));
    assert_line("", 0);
    TEST_ASSERT_EQUAL(EDITOR_DROP, type("pong" LEFT "\x03"));
    assert_line("", 0);
    type(UP);
    assert_line("", 0); // neither is in the history
}

void test_ctrl_k_deletes_the_rest_of_the_line(void)
{
    type("ping 13" LEFT LEFT "\x0B");
    assert_line("ping ", 5);
    type("\x0B");
    assert_line("ping ", 5);
}

void test_ctrl_w_deletes_the_word_before_the_cursor(void)
{
    type("move 1 90  \x17");
    assert_line("move 1 ", 7);
    type(LEFT LEFT "\x17");
    assert_line("1 ", 0);
    type("\x17");
    assert_line("1 ", 0);
}

void test_ends_of_line_of_every_kind(void)
{
    TEST_ASSERT_EQUAL(EDITOR_END, type("a\r"));
    TEST_ASSERT_EQUAL(EDITOR_NONE, type("\n")); // of the same end
    TEST_ASSERT_EQUAL(EDITOR_END, type("\n"));
    TEST_ASSERT_EQUAL(EDITOR_END, type("\r"));
    TEST_ASSERT_EQUAL(EDITOR_END, type("\r"));
}

void test_up_and_down_go_through_the_lines(void)
{
    type("ping 1\rping 2\r\rscan\rscan\r");
    type(UP);
    assert_line("scan", 4);
    type(UP);
    assert_line("ping 2", 6);
    type("\x10");
    assert_line("ping 1", 6);
    type(UP);
    assert_line("ping 1", 6); // the oldest one
    type(DOWN);
    assert_line("ping 2", 6);
    type("\x0E");
    assert_line("scan", 4);
    type(DOWN);
    assert_line("", 0);
    type(DOWN);
    assert_line("", 0);
}

void test_fetched_line_may_be_changed_and_entered(void)
{
    type("ping 1\rscan\r" UP UP "\b2\r" UP);
    assert_line("ping 2", 6);
    type(UP UP);
    assert_line("ping 1", 6);
}

void test_line_that_was_begun_is_fetched_back_by_down(void)
{
    type("ping 1\rmove 3 90" UP);
    assert_line("ping 1", 6);
    type(DOWN);
    assert_line("move 3 90", 9);
}

void test_history_drops_the_oldest_lines(void)
{
    char line[12];

    for (uint8_t i = 0; i < 100; i++) {
        sprintf(line, "ping %u\r", i);
        type(line);
    }
    for (uint8_t i = 99; i >= 99 - HISTORY_SIZE / 8 + 1; i--) {
        type(UP);
        sprintf(line, "ping %u", i);
        assert_line(line, (uint8_t)strlen(line));
    }
    for (uint8_t i = 0; i < 100; i++)
        type(UP);
    TEST_ASSERT_EQUAL_STRING_LEN("ping", editor.text, 4); // a whole line
}

void test_history_keeps_the_longest_line(void)
{
    char line[EDITOR_SIZE];

    memset(line, 'x', sizeof line);
    line[EDITOR_SIZE - 1] = '\0';
    type(line);
    type("\r" UP);
    assert_line(line, EDITOR_SIZE - 1);
}

void test_full_line_moves_on_and_is_not_kept(void)
{
    for (uint8_t i = 0; i < EDITOR_SIZE - 1; i++)
        TEST_ASSERT_EQUAL(EDITOR_NONE, type("x"));
    TEST_ASSERT_EQUAL(EDITOR_FULL, editor_key(&editor, 'y', &printer));
    editor_take(&editor, EDITOR_SIZE / 2);
    show_all();
    TEST_ASSERT_EQUAL_UINT8(EDITOR_SIZE / 2, editor.length);
    TEST_ASSERT_EQUAL_UINT8(EDITOR_SIZE, screen.column);
    type(HOME LEFT);
    TEST_ASSERT_EQUAL_UINT8(EDITOR_SIZE / 2, screen.column); // what has moved on stays
    type(UP END "\r" UP);
    assert_line("", 0);
}

void test_full_line_takes_no_character_in_its_middle(void)
{
    for (uint8_t i = 0; i < EDITOR_SIZE - 1; i++)
        type("x");
    TEST_ASSERT_EQUAL(EDITOR_NONE, type(LEFT "y"));
    TEST_ASSERT_EQUAL_UINT8(EDITOR_SIZE - 1, editor.length);
    TEST_ASSERT_EQUAL_UINT16(1, screen.bells);
    TEST_ASSERT_EQUAL(EDITOR_NONE, type("\b"));
    TEST_ASSERT_EQUAL_UINT8(EDITOR_SIZE - 2, editor.length);
}

void test_without_echo_keys_do_the_same_and_nothing_is_shown(void)
{
    for (const char *key = "pg" LEFT "in" DEL "\t1"; *key; key++) {
        editor_key(&editor, *key, NULL);
    }
    TEST_ASSERT_EQUAL_STRING_LEN("pin\t1", editor.text, 5);
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&ring));
}

void test_tab_with_echo_does_not_enter_the_line(void)
{
    TEST_ASSERT_EQUAL(EDITOR_COMPLETE, type("pi\t"));
    assert_line("pi", 2);
}

void test_other_characters_are_shown_as_question_marks(void)
{
    type("\x80\xFE");
    assert_row("??", 2);
}

void test_unknown_control_keys_do_nothing_with_echo(void)
{
    type("a\x0F\x12\x1A" // Ctrl-O, Ctrl-R, Ctrl-Z
         "b");
    assert_row("ab", 2);
    TEST_ASSERT_EQUAL_UINT8(2, editor.length);
}

void test_ctrl_l_is_ignored(void)
{
    type("ab\x0C"
         "c");
    assert_row("abc", 3);
}

void test_prompt_is_shown_before_the_line(void)
{
    editor.prompt_due = true;
    show_all();
    assert_row("> ", 2);
    type("ab" HOME);
    assert_row("> ab", 2);
}

void test_redraw_shows_the_line_again(void)
{
    type("ping" LEFT LEFT);
    obey('\r');
    obey('\n');
    line_editor_redraw(&editor);
    editor.prompt_due = true;
    show_all();
    assert_row("> ping", 4);
}

void test_stopped_reader_delays_the_echo_only(void)
{
    for (uint16_t i = 0; i < 500; i++)
        if (editor_show(&editor, &printer))
            editor_key(&editor, 'x', &printer);
    TEST_ASSERT_LESS_OR_EQUAL_UINT8(CDS_RING_SIZE, editor.length);
    show_all();
    TEST_ASSERT_EQUAL_UINT8(editor.length, screen.column);
}

/* ---- random keys against a reference ---- */

static uint32_t state = 1;

static uint8_t random_below(uint8_t count)
{
    state = state * 1103515245 + 12345;
    return (uint8_t)((state >> 16) % count);
}

/* The reference: the line and its cursor. */
static char reference[EDITOR_SIZE];
static uint8_t reference_cursor;

static void refer(uint8_t key, char c)
{
    uint8_t length = (uint8_t)strlen(reference), at = reference_cursor;

    switch (key) {
    case 0: reference_cursor = (uint8_t)(at ? at - 1 : 0); break;
    case 1: reference_cursor = (uint8_t)(at < length ? at + 1 : at); break;
    case 2: reference_cursor = 0; break;
    case 3: reference_cursor = length; break;
    case 4:
        if (at < length)
            memmove(reference + at, reference + at + 1, (size_t)(length - at));
        break;
    case 5:
        if (at)
            memmove(reference + at - 1, reference + at, (size_t)(length - at + 1));
        reference_cursor = (uint8_t)(at ? at - 1 : 0);
        break;
    default:
        memmove(reference + at + 1, reference + at, (size_t)(length - at + 1));
        reference[at] = c;
        reference_cursor++;
    }
}

void test_random_keys_show_what_the_reference_has(void)
{
    static const char *const keys[] = {LEFT, RIGHT, HOME, END, DEL, "\b"};

    reference[0] = '\0';
    reference_cursor = 0;
    for (uint16_t i = 0; i < 5000; i++) {
        uint8_t key = random_below(14);
        char text[2] = {(char)('a' + random_below(26)), '\0'};

        if (key >= 6 && strlen(reference) == EDITOR_SIZE - 2)
            key = 5;
        refer(key, text[0]);
        type(key < 6 ? keys[key] : text);
        assert_line(reference, reference_cursor);
    }
}
