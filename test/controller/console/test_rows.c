/* SPDX-License-Identifier: MIT */
/* Lines of a command with several rows: which row reads the line. */
#include "line_rig.h"

#define ROW(text)                                                                                  \
    {                                                                                              \
        .usage = FLASH_TEXT(text), .what = NULL, .begin = NULL, .poll = NULL                       \
    }

static const CDS_FLASH struct command rows[] = {
    ROW("pose ANGLE... [at SPEED]"), ROW("pose ANGLE... in TIME"),  ROW("pose list"),
    ROW("pose save NAME"),           ROW("pose set NAME ANGLE..."),
};

/* In another table, as the rows of another file. */
static const CDS_FLASH struct command more_rows[] = {
    ROW("pose NAME in TIME"),
    ROW("play NAME [at SHARE]"),
    ROW("play NAME times N [at SHARE]"),
    ROW("sequence show NAME"),
    ROW("sequence NAME new|add POSE TIME [dwell TIME]"),
};

static const CDS_FLASH struct command_group group = {.rows = rows, .count = 5};
static const CDS_FLASH struct command_group more = {.rows = more_rows, .count = 5};
static const CDS_FLASH struct command_group *const CDS_FLASH groups[] = {&group, &more, NULL};

const CDS_FLASH struct command_set command_set = {.groups = groups};

void setUp(void)
{
    begin_request();
}

void tearDown(void)
{
}

static void assert_read_by(const CDS_FLASH struct command *row, const char *text)
{
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(0, read_line(text), text);
    TEST_ASSERT_TRUE_MESSAGE(line.command == row, text);
}

static void assert_name(const char *name, uint8_t index)
{
    TEST_ASSERT_EQUAL_STRING(name, parse_name(&line, index));
}

void test_row_is_chosen_by_word_behind_name_of_command(void)
{
    assert_read_by(&rows[0], "pose 90");
    assert_read_by(&rows[2], "pose list");
    assert_read_by(&rows[3], "pose save stand");
    assert_name("stand", 0);
    assert_read_by(&more_rows[0], "pose stand in 2s");
    assert_name("stand", 0);
    TEST_ASSERT_EQUAL_UINT8(1, line.numbers);
}

void test_row_is_chosen_by_word_behind_list(void)
{
    assert_read_by(&rows[0], "pose 90 100 at 20rpm");
    assert_read_by(&rows[1], "pose 90 100 in 2s");
    TEST_ASSERT_EQUAL_UINT8(2, line.values);
    TEST_ASSERT_EQUAL_HEX8(307 & 0xFF, packet[0]);
    TEST_ASSERT_EQUAL_INT32(2, line.number[0].digits);
}

void test_row_is_chosen_by_word_in_bracket_of_another_row(void)
{
    assert_read_by(&more_rows[1], "play walk");
    assert_read_by(&more_rows[1], "play walk at 80%");
    assert_read_by(&more_rows[2], "play walk times 3");
    assert_read_by(&more_rows[2], "play walk times 3 at 80%");
    assert_name("walk", 0);
    TEST_ASSERT_EQUAL_UINT8(2, line.numbers);
}

void test_row_with_word_comes_before_row_with_name(void)
{
    assert_read_by(&more_rows[3], "sequence show walk");
    assert_read_by(&more_rows[4], "sequence shows add stand 1s");
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("pose save"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("pose save in 2s"));
}

void test_names_are_kept_one_behind_the_other(void)
{
    assert_read_by(&more_rows[4], "sequence walk add stand 1.2s dwell 500ms");
    TEST_ASSERT_EQUAL_UINT8(2, line.names);
    TEST_ASSERT_EQUAL_UINT8(2, line.numbers);
    assert_name("walk", 0);
    assert_name("stand", 1);
}

void test_name_stands_beside_longest_list(void)
{
    assert_read_by(&rows[4], "pose set stand 90 150raw");
    for (uint8_t i = 0; i < 48; i++)
        parse_word(&line, &(struct token){.length = 3, .text = "300"}, ' ');
    TEST_ASSERT_EQUAL_UINT8(0, parse_end(&line));
    TEST_ASSERT_EQUAL_UINT8(PARSE_LIST_MAX, line.values);
    assert_name("stand", 0);
    TEST_ASSERT_EQUAL_HEX8(150, packet[2]);
}

void test_choice_is_first_word_of_several(void)
{
    assert_read_by(&more_rows[4], "sequence walk add stand 1s dwell 2s");
    TEST_ASSERT_EQUAL_UINT8(2, line.choice);
    assert_read_by(&more_rows[4], "sequence walk new stand 1s dwell 2s");
    TEST_ASSERT_EQUAL_UINT8(1, line.choice);
}

void test_name_too_long_keeps_nine_characters(void)
{
    assert_read_by(&rows[3], "pose save abcdefgh");
    assert_name("abcdefgh", 0);
    assert_read_by(&rows[3], "pose save abcdefghijklmnopqrstuvwxyz");
    TEST_ASSERT_EQUAL_MEMORY("abcdefghi", packet + sizeof packet - PARSE_NAME_SIZE,
                             PARSE_NAME_SIZE);
    TEST_ASSERT_EQUAL_HEX8(0xEE, packet[sizeof packet - PARSE_NAME_SIZE - 1]);
}

void test_row_error_is_that_of_first_row_if_none_takes_word(void)
{
    TEST_ASSERT_EQUAL_UINT8(ERROR_NOT_A_NUMBER, read_line("pose -x in 2s"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_WORD, read_line("pose 90 by 2s"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_WORD, read_line("pose stand at 2s"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("pose list all"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("pose"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("pose stand in"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_NOT_A_NUMBER, read_line("pose stand in x"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_COMMAND, read_line("poses list"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_COMMAND, read_line("pos list"));
}
