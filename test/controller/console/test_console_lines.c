/* SPDX-License-Identifier: MIT */
/* Lines of the console: errors, line ends, warnings. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_malformed_blocks(void)
{
    static const char *const lines[] = {
        "sync 0x1E 2 1:1",       "sync 0x1E 2 1:1,2,3", "sync 0x1E 2 1,1,2", "sync 0x1E 2 1:1:2",
        "sync 0x1E 2 1:1,2 2:1", "sync 0x1E 2 1:1,2 2", "sync 0x1E 2 1:1,",  "sync 0x1E 2 1:"};

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_error(ERROR_BLOCK, lines[i]);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_unknown_commands(void)
{
    assert_error(ERROR_UNKNOWN_COMMAND, "pong 1");
    assert_error(ERROR_UNKNOWN_COMMAND, "pin 1");
    assert_error(ERROR_UNKNOWN_COMMAND, "pings 1");
    assert_error(ERROR_UNKNOWN_COMMAND, "averyveryveryverylongwordindeed");
    assert_error(ERROR_UNKNOWN_COMMAND, "\x01\x80");
}

void test_wrong_counts(void)
{
    static const char *const lines[] = {"ping",      "ping 1 2",    "read 1",       "read 1 2 3 4",
                                        "write 1",   "write 1 ID",  "regwrite 1 3", "reset",
                                        "reset 1 2", "help help 1", "version 1",    "action 1 2",
                                        "sync",      "sync 3",      "sync 3 1"};

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_error(ERROR_COUNT, lines[i]);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_numbers_out_of_range(void)
{
    static const char *const lines[] = {
        "ping 255",        "ping 65536",          "read 254 3",     "reset 254",
        "read 1 0x32",     "read 1 3 0",          "read 1 0x31 2",  "read 1 0 51",
        "write 1 3 256",   "write 1 ID 254",      "write 1 LED 2",  "write 1 GOAL_POSITION 1024",
        "sync 0x1E 0 1:1", "sync 0x30 3 1:1,2,3", "sync 3 1 254:1", "sync 3 1 1:256",
        "write 1 256 1",   "write 1 0x10000 1",   "ping -1",
    };

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_error(ERROR_OUT_OF_RANGE, lines[i]);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_write_beyond_last_register_is_wrong_count(void)
{
    assert_error(ERROR_COUNT, "write 1 PUNCH 1 2");
    assert_error(ERROR_COUNT, "write 1 0x31 1 2");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_not_a_number(void)
{
    assert_error(ERROR_NOT_A_NUMBER, "ping one");
    assert_error(ERROR_NOT_A_NUMBER, "write 1 ID 0x");
    assert_error(ERROR_NOT_A_NUMBER, "read 1 ID 1,2");
    assert_error(ERROR_NOT_A_NUMBER, "sync 3 1 1:a");
    assert_error(ERROR_NOT_A_NUMBER, "ping 1.5");
    assert_error(ERROR_NOT_A_NUMBER, "ping 1raw");
}

void test_unknown_register(void)
{
    assert_error(ERROR_UNKNOWN_REGISTER, "read 1 GOAL");
    assert_error(ERROR_UNKNOWN_REGISTER, "read 1 GOAL_POSITIONS");
    assert_error(ERROR_UNKNOWN_REGISTER, "write 1 averyveryveryverylongwordindeed 1");
}

void test_the_first_error_of_a_line_counts(void)
{
    assert_error(ERROR_NOT_A_NUMBER, "write x GOAL 99999");
}

void test_line_too_long_is_one_error_and_the_next_line_works(void)
{
    for (uint16_t i = 0; i < 7000; i++)
        type_part("abcdefghij ");
    assert_error(ERROR_LINE_TOO_LONG, "");
    for (uint16_t i = 0; i < CONSOLE_LINE_MAX; i++)
        type_part(" ");
    assert_error(ERROR_LINE_TOO_LONG, "version");
    TEST_ASSERT_EQUAL_STRING("cds55xx 0.1.0 host\r\nok\r\n", reply_to("version"));
}

void test_a_line_of_just_the_longest_length_is_carried_out(void)
{
    for (uint16_t i = 0; i < CONSOLE_LINE_MAX - 7; i++)
        type_part(" ");
    reply_to("version");
    TEST_ASSERT_EQUAL_STRING("cds55xx 0.1.0 host\r\nok\r\n", said);
}

void test_line_ends_of_every_kind_and_empty_lines(void)
{
    type("\r\n\r\n   \n\t\r");
    TEST_ASSERT_EQUAL_STRING("", said);
    type("version\r\nversion\n");
    TEST_ASSERT_EQUAL_STRING("cds55xx 0.1.0 host\r\nok\r\ncds55xx 0.1.0 host\r\nok\r\n", said);
}

void test_spaces_and_tabs_between_words(void)
{
    reply_to("  ping \t  1  ");
    assert_sent("FF FF 01 02 01 FB");
}

void test_absent_servo(void)
{
    reply_to("ping 9");
    port_fake.now_us += 1000000;
    type("");
    TEST_ASSERT_EQUAL_STRING_LEN("error 2: servo 9: no reply by the deadline; check power", said,
                                 55);
    port_fake.now_us += CDS_STALE_REPLY_US; // the bus rests
    reply_to("ping 1");
    answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_damaged_reply(void)
{
    static const uint8_t damaged[] = {0xFF, 0xFF, 1, 2, 0, 0xFD};

    reply_to("ping 1");
    port_fake_hear(&bus.link, damaged, sizeof damaged);
    port_fake.now_us += 1000000;
    type("");
    TEST_ASSERT_EQUAL_STRING_LEN("error 3: ", said, 9);
}

void test_packet_errors_of_servo_have_numbers(void)
{
    static const uint8_t errors[][2] = {{CDS_ERROR_INSTRUCTION, ERROR_SERVO_INSTRUCTION},
                                        {CDS_ERROR_RANGE, ERROR_SERVO_RANGE},
                                        {CDS_ERROR_CHECKSUM, ERROR_SERVO_CHECKSUM},
                                        {CDS_ERROR_ANGLE, ERROR_SERVO_ANGLE}};
    char start[24];

    for (uint8_t i = 0; i < 4; i++) {
        reply_to("write 1 LED 1");
        answer(1, errors[i][0], NULL, 0);
        sprintf(start, "error %u: servo 1: ", errors[i][1]);
        TEST_ASSERT_EQUAL_STRING_LEN(start, said, strlen(start));
    }
}

/* Returns what `text` has after `begin`. */
static const char *assert_begins(const char *text, const char *begin)
{
    size_t length = strlen(begin);

    TEST_ASSERT_EQUAL_STRING_LEN(begin, text, length);
    return text + length;
}

void test_conditions_are_warnings_and_ok(void)
{
    static const char load[] = "; 'torque 1 off', unload it; when cool, 'clear', 'release 1'\r\n";
    const char *next;

    reply_to("ping 1");
    answer(1, CDS_ERROR_VOLTAGE | CDS_ERROR_OVERHEATING | CDS_ERROR_OVERLOAD, NULL, 0);
    next = assert_begins(said, "warning: input voltage; compare PRESENT_VOLTAGE, MIN_VOLTAGE, "
                               "MAX_VOLTAGE; mend supply or limits, then 'clear'\r\n");
    next = assert_begins(assert_begins(next, "warning: overheating"), load);
    next = assert_begins(assert_begins(next, "warning: overload"), load);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", next);
}

/* Reads a reply with these error bits. Each of `count` lines must be said, in this order. */
static void assert_bits_are_named(uint8_t bits, const char *const *lines, uint8_t count)
{
    const char *from = said;

    reply_to("ping 1");
    answer(1, bits, NULL, 0);
    for (uint8_t i = 0; i < count; i++) {
        from = strstr(from, lines[i]);
        TEST_ASSERT_NOT_NULL_MESSAGE(from, lines[i]);
    }
}

void test_all_error_bits_are_named(void)
{
    static const char *const lines[] = {
        "warning: input voltage; ",
        "\r\nwarning: overheating; ",
        "\r\nwarning: overload; ",
        "also 20: servo: instruction error; ",
        "\r\nalso 21: servo: range error; ",
        "\r\nalso 22: servo: checksum error; ",
        "\r\nerror 23: servo 1: angle limit error; ",
    };

    assert_bits_are_named(0x25, lines, 3);
    assert_bits_are_named(0x5A, lines + 3, 4);
}

void test_several_packet_errors_end_in_one_error_line(void)
{
    reply_to("write 1 LED 1");
    answer(1, CDS_ERROR_RANGE | CDS_ERROR_ANGLE, NULL, 0);
    TEST_ASSERT_EQUAL_STRING_LEN("also 21: ", said, 9);
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nerror 23: "));
    TEST_ASSERT_NULL(strstr(said, "ok\r\n"));
}

void test_read_refused_by_the_servo_gives_no_bytes(void)
{
    reply_to("read 1 ID");
    answer(1, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL_STRING_LEN("error 21: ", said, 10);
}
