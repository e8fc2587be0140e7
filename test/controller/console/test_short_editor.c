/* SPDX-License-Identifier: MIT */
/* The editor of the profile `console`: the line being typed, and its echo. */
#include <string.h>

#include "console/short_editor.c" // the archive of the tests has the editor of the profile `full`
#include "ring_input.h"
#include "unity.h"

static struct cds_ring ring;
static struct printer printer;
static struct editor editor;
static char shown[400];
static uint16_t length;

void setUp(void)
{
    memset(&ring, 0, sizeof ring);
    memset(&editor, 0, sizeof editor);
    printer = (struct printer){.ring = &ring};
    length = 0;
    shown[0] = '\0';
}

void tearDown(void)
{
}

static void hear(void)
{
    for (; cds_ring_count(&ring); ring_drop(&ring, 1))
        shown[length++] = (char)ring_peek(&ring, 0);
    shown[length] = '\0';
}

/* Types `keys`; the event of the last one. */
static enum editor_event type(const char *keys)
{
    enum editor_event event = EDITOR_NONE;

    for (; *keys; keys++) {
        while (!editor_show(&editor, &printer))
            hear();
        event = editor_key(&editor, *keys, &printer);
        if (event == EDITOR_FULL)
            editor_take(&editor, EDITOR_SIZE / 2);
    }
    while (!editor_show(&editor, &printer))
        hear();
    hear();
    return event;
}

static void assert_line(const char *line)
{
    TEST_ASSERT_EQUAL_UINT8(strlen(line), editor.length);
    TEST_ASSERT_EQUAL_STRING_LEN(line, editor.text, strlen(line));
}

void test_prompt_is_printed_once_before_the_text(void)
{
    editor.prompt_due = true;
    TEST_ASSERT_FALSE(editor_is_shown(&editor));
    type("");
    TEST_ASSERT_EQUAL_STRING("\r> ", shown);
    TEST_ASSERT_TRUE(editor_is_shown(&editor));
    type("ping");
    TEST_ASSERT_EQUAL_STRING("\r> ping", shown);
}

void test_what_is_typed_is_echoed(void)
{
    TEST_ASSERT_EQUAL(EDITOR_NONE, type("ping 1"));
    assert_line("ping 1");
    TEST_ASSERT_EQUAL_STRING("ping 1", shown);
    TEST_ASSERT_EQUAL(EDITOR_END, type("\r"));
    TEST_ASSERT_EQUAL_STRING("ping 1\r\n", shown);
}

void test_backspace_and_delete(void)
{
    type("pong\b\x7F\bing");
    assert_line("ping");
    TEST_ASSERT_EQUAL_STRING("pong\b \b\b \b\b \bing", shown);
}

void test_backspace_on_an_empty_line_shows_nothing(void)
{
    type("\b\x7Fx\b\b\b");
    assert_line("");
    TEST_ASSERT_EQUAL_STRING("x\b \b", shown);
}

void test_without_echo_nothing_is_shown_and_the_keys_do_the_same(void)
{
    for (const char *key = "pong\b\b\bing\x15stop\b"; *key; key++) {
        editor_key(&editor, *key, NULL);
    }
    assert_line("sto");
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&ring));
}

void test_the_last_line_comes_back(void)
{
    static const char *const keys[] = {"\x10", "\x1B[A", "\x1BOA"};

    for (uint8_t i = 0; i < 3; i++) {
        setUp();
        type("ping 1\r");
        editor_end(&editor);
        length = 0;
        type(keys[i]);
        assert_line("ping 1");
        TEST_ASSERT_EQUAL_STRING("ping 1", shown);
        type("\b2"); // and is a line like any other
        assert_line("ping 2");
    }
}

void test_an_empty_line_does_not_replace_the_last_one(void)
{
    type("ping 1\r");
    editor_end(&editor);
    type("\r");
    editor_end(&editor);
    type("\x10");
    assert_line("ping 1");
}

void test_a_line_that_was_begun_is_not_replaced(void)
{
    type("ping 1\r");
    editor_end(&editor);
    type("x\x10");
    assert_line("x");
    type("\b\x10"); // its place is taken
    assert_line("");
}

void test_the_end_of_a_line_ends_an_escape_sequence(void)
{
    TEST_ASSERT_EQUAL(EDITOR_END, type("x\x1B[\r"));
    type("\x1B[");
    editor_end(&editor); // dropped, as by a packet
    type("ping 1");
    assert_line("ping 1");
}

void test_other_escape_sequences_are_ignored(void)
{
    type("a\x1B[Bb\x1B[3~c\x1B[1;5Dd\x1BOPe");
    assert_line("abcde");
    TEST_ASSERT_EQUAL_STRING("abcde", shown);
    type("\x1B"
         "f"); // and a lone ESC eats nothing
    assert_line("abcdef");
}

void test_ctrl_u_and_ctrl_c(void)
{
    TEST_ASSERT_EQUAL(EDITOR_DROP, type("ping\x15")); // for which the console prints a prompt
    assert_line("");
    TEST_ASSERT_EQUAL_STRING("ping\r\n", shown);
    TEST_ASSERT_EQUAL(EDITOR_DROP, type("pong\x03"));
    assert_line("");
}

void test_ends_of_line(void)
{
    TEST_ASSERT_EQUAL(EDITOR_END, type("a\r"));
    TEST_ASSERT_EQUAL(EDITOR_NONE, type("\n")); // of the same end
    TEST_ASSERT_EQUAL(EDITOR_END, type("\n"));
    TEST_ASSERT_EQUAL(EDITOR_END, type("\r"));
    TEST_ASSERT_EQUAL(EDITOR_END, type("\r"));
    TEST_ASSERT_EQUAL(EDITOR_END, type("\nb\n"));
}

void test_a_long_line_moves_on_and_cannot_be_fetched_back(void)
{
    for (uint8_t i = 0; i < EDITOR_SIZE - 1; i++)
        TEST_ASSERT_EQUAL(EDITOR_NONE, type("x"));
    TEST_ASSERT_EQUAL(EDITOR_FULL, type("y"));
    TEST_ASSERT_EQUAL_UINT8(EDITOR_SIZE / 2, editor.length);
    TEST_ASSERT_EQUAL_CHAR('y', editor.text[EDITOR_SIZE / 2 - 1]);
    for (uint8_t i = 0; i < 200; i++)
        type("\b");
    assert_line(""); // what has moved on stays
    TEST_ASSERT_EQUAL(EDITOR_NONE, type("\x15"));
    TEST_ASSERT_EQUAL_UINT16(EDITOR_SIZE + 3 * EDITOR_SIZE / 2, strlen(shown));
    type("z\r");
    editor_end(&editor);
    type("\x10");
    assert_line("");
}

void test_other_characters_are_shown_harmlessly(void)
{
    type("\x07\x80\xFE");
    TEST_ASSERT_EQUAL_STRING("???", shown);
    assert_line("\x07\x80\xFE");
}

void test_a_reader_that_stops_holds_up_the_echo_only(void)
{
    for (uint16_t i = 0; i < 500; i++)
        if (editor_show(&editor, &printer))
            editor_key(&editor, 'x', &printer);
    TEST_ASSERT_LESS_THAN_UINT8(CDS_RING_SIZE + 1, editor.length);
    hear();
    TEST_ASSERT_TRUE(editor_show(&editor, &printer));
    hear();
    TEST_ASSERT_EQUAL_UINT8(editor.length, strlen(shown));
}

void test_locked_text_cannot_be_taken_back(void)
{
    type("ping 1");
    editor.locked = 4;
    type("\b\b\b\b");
    assert_line("ping");
    editor_take(&editor, 4);
    assert_line("");
    type("x\b\b");
    assert_line("");
}
