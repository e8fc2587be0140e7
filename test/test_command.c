/* The table of commands, and lines that are read by it. */
#include <string.h>

#include "console/commands.h"
#include "console/errors.h"
#include "console/input.h"
#include "texts.h"
#include "console/printer.h"
#include "unity.h"

static uint8_t packet[258];
static struct cds_request request;
static struct command_line line;

void setUp(void)
{
    request = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(packet);
    line.request = &request;
    command_begin(&line);
}

void tearDown(void)
{
}

/* Reads a line: its error, or 0. */
static uint8_t read_line(const char *text)
{
    struct token token = {0};

    command_begin(&line);
    for (;; text++) {
        bool block = command_in_block(&line) && (*text == ':' || *text == ',');

        if (*text != '\0' && *text != ' ' && !block) {
            lexer_add(&token, *text);
            continue;
        }
        if (token.length || block)
            command_word(&line, &token, block ? *text : ' ');
        token.length = 0;
        if (*text == '\0')
            return command_end(&line);
    }
}

/* The example of a row. */
static uint8_t read_example(uint8_t row)
{
    static struct cds_ring ring;
    struct printer printer = {.ring = &ring};
    char text[80];
    uint8_t length = 0;

    printer_line(&printer, printer_text_at(TEXT_EXAMPLE, row));
    while (printer.text || cds_ring_count(&ring)) {
        printer_ready(&printer);
        for (; cds_ring_count(&ring) && length < sizeof text; input_drop(&ring, 1))
            text[length++] = (char)input_peek(&ring, 0);
    }
    text[length - 2] = '\0'; // without the end of the line
    return read_line(text);
}

static uint8_t length_of(const CDS_FLASH char *text)
{
    uint8_t length = 0;

    while (*text++)
        length++;
    return length;
}

static uint16_t packed_length(uint16_t text, uint8_t index)
{
    text = printer_text_at(text, index);
    return (uint16_t)(printer_text_at(text, 1) - text - 1);
}

void test_every_row_is_whole(void)
{
    for (uint8_t i = 0; i < COMMAND_COUNT; i++) {
        const CDS_FLASH struct command *command = &commands[i];

        TEST_ASSERT_LESS_THAN(TOKEN_MAX, length_of(command->words));
        TEST_ASSERT_GREATER_THAN(3, packed_length(TEXT_USAGE, i));
        TEST_ASSERT_GREATER_THAN(3, packed_length(TEXT_DETAILS, i));
        TEST_ASSERT_TRUE_MESSAGE(command->begin || command->poll, "it does nothing");
    }
}

void test_every_name_finds_its_row(void)
{
    for (uint8_t i = 0; i < COMMAND_COUNT; i++) {
        struct token token = {0};

        for (const CDS_FLASH char *c = commands[i].words; *c; c++)
            lexer_add(&token, *c);
        TEST_ASSERT_EQUAL_UINT8(i, command_named(&token));
        lexer_add(&token, 'x');
        TEST_ASSERT_EQUAL_UINT8(COMMAND_COUNT, command_named(&token));
        token.length = (uint8_t)(token.length - 2);
        if (token.length) // no name is the beginning of another one
            TEST_ASSERT_EQUAL_UINT8(COMMAND_COUNT, command_named(&token));
    }
}

void test_every_example_is_a_line_of_its_command(void)
{
    for (uint8_t i = 0; i < COMMAND_COUNT; i++) {
        TEST_ASSERT_EQUAL_UINT8(0, read_example(i));
        TEST_ASSERT_EQUAL_UINT8(i, line.kind);
    }
}

void test_a_word_too_many_is_an_error_of_every_command(void)
{
    struct token word = {.length = 1, .text = "1"};

    for (uint8_t i = 0; i < COMMAND_COUNT; i++) {
        read_example(i);
        for (uint8_t more = 0; more < 60; more++)
            command_word(&line, &word, ' ');
        TEST_ASSERT_NOT_EQUAL(0, command_end(&line));
    }
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
    TEST_ASSERT_EQUAL_UINT8(ERROR_COUNT, read_line("monitor 1 every 50 60"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, read_line("group 254"));
    TEST_ASSERT_EQUAL_UINT8(ERROR_TWICE, read_line("group 1 2 1"));
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

void test_a_list_is_never_longer_than_its_room(void)
{
    struct token word = {.length = 1, .text = "1"};

    read_line("pose 1");
    for (uint8_t i = 0; i < 200; i++)
        command_word(&line, &word, ' ');
    TEST_ASSERT_EQUAL_UINT8(ERROR_TOO_MANY, command_end(&line));
    TEST_ASSERT_EQUAL_UINT8(COMMAND_LIST_MAX, line.values);
}

void test_a_list_of_ids_neither(void)
{
    read_line("group 100");
    for (uint8_t id = 0; id < 60; id++) {
        struct token word = {.length = 2};

        word.text[0] = (char)('0' + id / 10);
        word.text[1] = (char)('0' + id % 10);
        command_word(&line, &word, ' ');
    }
    TEST_ASSERT_EQUAL_UINT8(ERROR_TOO_MANY, command_end(&line));
    TEST_ASSERT_EQUAL_UINT8(COMMAND_LIST_MAX, line.values);
}
