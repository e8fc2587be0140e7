/* SPDX-License-Identifier: MIT */
/* The table of commands, and lines that are read by it. */
#include "line_rig.h"

#define ROWS_MIN 60 // of all groups

void setUp(void)
{
    begin_request();
}

void tearDown(void)
{
}

/* Calls `check` with every command. */
static void each_command(void (*check)(const CDS_FLASH struct command *command))
{
    const CDS_FLASH struct command_group *const CDS_FLASH *group = command_set.groups;
    uint8_t rows = 0;

    for (; *group; group++)
        for (uint8_t i = 0; i < (*group)->count; i++, rows++)
            check(&(*group)->rows[i]);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT8(ROWS_MIN, rows);
}

static uint8_t read_example(const CDS_FLASH struct command *command)
{
    const CDS_FLASH char *example = command->example.text ? command->example.text : command->usage;
    char text[80];
    uint8_t length = 0;

    for (; example[length]; length++)
        text[length] = example[length];
    text[length] = '\0';
    return read_line(text);
}

static uint8_t length_of(const CDS_FLASH char *text)
{
    uint8_t length = 0;

    while (*text++)
        length++;
    return length;
}

static void check_row(const CDS_FLASH struct command *command)
{
    TEST_ASSERT_GREATER_THAN(2, length_of(command->usage));
    TEST_ASSERT_GREATER_THAN(3, length_of(command->what));
    TEST_ASSERT_GREATER_THAN(3, length_of(command->details.text));
    TEST_ASSERT_TRUE_MESSAGE(command->begin || command->poll, "it does nothing");
}

void test_every_row_is_whole(void)
{
    each_command(check_row);
}

/* True if the usage of `command` begins with the token. */
static bool is_named(const CDS_FLASH struct command *command, const struct token *token)
{
    const CDS_FLASH char *usage = command->usage;

    for (uint8_t i = 0; i < token->length; i++)
        if (*usage++ != token->text[i])
            return false;
    return *usage == ' ' || *usage == '\0';
}

static void check_name(const CDS_FLASH struct command *command)
{
    struct token token = {0};

    for (const CDS_FLASH char *c = command->usage; *c && *c != ' '; c++)
        token_add(&token, *c);
    TEST_ASSERT_LESS_THAN(TOKEN_MAX, token.length);
    TEST_ASSERT_TRUE(is_named(parse_command(&token), &token)); // the first of its rows
    token_add(&token, 'x');
    TEST_ASSERT_TRUE(parse_command(&token) == NULL);
    token.length = (uint8_t)(token.length - 2);
    if (token.length) // no name is the beginning of another one
        TEST_ASSERT_TRUE(parse_command(&token) == NULL);
}

void test_parse_command_each_name_finds_row(void)
{
    each_command(check_name);
}

static void check_example(const CDS_FLASH struct command *command)
{
    TEST_ASSERT_EQUAL_UINT8(0, read_example(command));
    TEST_ASSERT_TRUE(line.command == command);
}

void test_each_example_is_accepted_by_command(void)
{
    each_command(check_example);
}

static void check_many_words(const CDS_FLASH struct command *command)
{
    struct token word = {.length = 1, .text = "1"};

    read_example(command);
    for (uint8_t more = 0; more < 60; more++)
        parse_word(&line, &word, ' ');
    TEST_ASSERT_NOT_EQUAL(0, parse_end(&line));
}

void test_a_word_too_many_is_an_error_of_every_command(void)
{
    each_command(check_many_words);
}

void test_optional_words(void)
{
    TEST_ASSERT_EQUAL_UINT8(0, read_line("move 7 90.5"));
    TEST_ASSERT_EQUAL_UINT8(7, line.id);
    TEST_ASSERT_EQUAL_UINT8(1, line.numbers);
    TEST_ASSERT_EQUAL_UINT8(0, read_line("move 254 90 30rpm"));
    TEST_ASSERT_EQUAL_UINT8(2, line.numbers);
    TEST_ASSERT_EQUAL_UINT8(0, read_line("scan"));
    TEST_ASSERT_EQUAL_UINT8(0, line.choice);
    TEST_ASSERT_EQUAL_UINT8(0, read_line("scan rescue"));
    TEST_ASSERT_EQUAL_UINT8(2, line.choice);
    TEST_ASSERT_EQUAL_UINT8(0, read_line("diagnose"));
    TEST_ASSERT_EQUAL_UINT8(CDS_BROADCAST_ID, line.id);
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("scan all all"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("move 7"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("move 7 1 2 3"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_WORD, read_line("scan al"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_WORD, read_line("scan all|rescue"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_WORD, read_line("led 1 onn"));
}

void test_words_settings_and_registers_may_have_any_case(void)
{
    static const char *const lines[][2] = {{"TORQUE 1 ON", "torque 1 on"},
                                           {"Move 1 90DEG", "move 1 90deg"},
                                           {"WRITE 1 led 1", "write 1 LED 1"},
                                           {"hElP SCAN", "help scan"},
                                           {"settings LINK_Loss_ms 5", "settings link_loss_ms 5"}};

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        struct command_line small;

        TEST_ASSERT_EQUAL_UINT8_MESSAGE(0, read_line(lines[i][1]), lines[i][1]);
        small = line;
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(0, read_line(lines[i][0]), lines[i][0]);
        TEST_ASSERT_TRUE(small.command == line.command && small.choice == line.choice &&
                         small.topic == line.topic && small.setting == line.setting &&
                         small.address == line.address);
    }
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_COMMAND, read_line("TORQU\x05 1 ON"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_WORD, read_line("torque 1 OM"));
}

void test_lists_of_servos(void)
{
    TEST_ASSERT_EQUAL_UINT8(0, read_line("monitor 3 1 253 every 50ms"));
    TEST_ASSERT_EQUAL_UINT8(3, line.values);
    TEST_ASSERT_EQUAL_UINT8(253, packet[2]);
    TEST_ASSERT_EQUAL_UINT8(1, line.choice);
    TEST_ASSERT_EQUAL_UINT8(1, line.numbers);
    TEST_ASSERT_EQUAL_UINT8(0, read_line("group"));
    TEST_ASSERT_EQUAL_UINT8(0, read_line("group 1 2 action"));
    TEST_ASSERT_EQUAL_UINT8(2, line.values);
    TEST_ASSERT_EQUAL_UINT8(2, line.choice);
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("monitor"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_NOT_A_NUMBER, read_line("monitor every 50"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("monitor 1 every"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_WORD, read_line("monitor 1 every 50 60"));
    TEST_ASSERT_EQUAL_UINT8(0, read_line("monitor 1 every 50 as plot"));
    TEST_ASSERT_EQUAL_UINT8(0, read_line("monitor 1 2 as plot"));
    TEST_ASSERT_EQUAL_UINT8(0, read_line("monitor 1 2 as plot every 50ms"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("monitor 1 as"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, read_line("group 254"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_TWICE, read_line("group 1 2 1"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_TWICE, read_line("sync GOAL_POSITION 2 1:2,0 2:0,2 1:2,0"));
    TEST_ASSERT_EQUAL_UINT8(0, read_line("sync GOAL_POSITION 2 1:2,0 2:1,2"));
}

void test_lists_of_angles(void)
{
    TEST_ASSERT_EQUAL_UINT8(0, read_line("pose 90 512raw 300deg at 20rpm"));
    TEST_ASSERT_EQUAL_UINT8(3, line.values);
    TEST_ASSERT_EQUAL_HEX8(307 & 0xFF, packet[0]);
    TEST_ASSERT_EQUAL_HEX8(307 >> 8, packet[1]);
    TEST_ASSERT_EQUAL_HEX8(1023 & 0xFF, packet[4]);
    TEST_ASSERT_EQUAL_HEX8(1023 >> 8, packet[5]);
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, read_line("pose 90 1024raw"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNIT, read_line("pose 90 20rpm"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNKNOWN_WORD, read_line("pose 90 by 20rpm"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("pose 90 at"));
}

void test_list_of_angles_too_long_is_refused(void)
{
    struct token word = {.length = 1, .text = "1"};

    read_line("pose 1");
    for (uint8_t i = 0; i < 200; i++)
        parse_word(&line, &word, ' ');
    TEST_ASSERT_EQUAL_UINT8(ERROR_TOO_MANY, parse_end(&line));
    TEST_ASSERT_EQUAL_UINT8(PARSE_LIST_MAX, line.values);
}

void test_list_of_ids_too_long_is_refused(void)
{
    read_line("group 100");
    for (uint8_t id = 0; id < 60; id++) {
        struct token word = {.length = 2};

        word.text[0] = (char)('0' + id / 10);
        word.text[1] = (char)('0' + id % 10);
        parse_word(&line, &word, ' ');
    }
    TEST_ASSERT_EQUAL_UINT8(ERROR_TOO_MANY, parse_end(&line));
    TEST_ASSERT_EQUAL_UINT8(PARSE_LIST_MAX, line.values);
}
