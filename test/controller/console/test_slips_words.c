/* SPDX-License-Identifier: MIT */
/* Words that are nearly right: the error or `help` names the line to type. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
    robot.health_pauses = true;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_range_with_spaces_names_one_word(void)
{
    static const char *const lines[][2] = {
        {"torque 1 - 3 on", "error 38: servo 1: '-' where 'on|off' is due: no space in a range of "
                            "IDs, as in 'torque 1-3 on'\r\n"},
        {"torque 1 -3 on", "error 38: servo 1: '-3' where 'on|off' is due: no space in a range of "
                           "IDs, as in 'torque 1-3 on'\r\n"},
        {"group 1 - 3", "error 32: ID... '-': no space in a range of IDs, "},
        {"id 1 - 3", "error 32: servo 1: NEW '-': not a number; write an ID: 0 to 253\r\n"},
        {"turn 1 -20.1234rpm", "error 32: servo 1: SPEED -20.1234rpm: has too many decimals"},
        {"move 1 - 3 90",
         "error 32: servo 1: ANGLE '-': no space in a range of IDs, as in 'torque 1-3 on'\r\n"},
    };

    ASSERT_REPLIES(lines);
    reply_to("turn 1,2 -20.1234rpm");
    TEST_ASSERT_NULL_MESSAGE(strstr(said, "range of IDs"), said);
}

void test_number_for_a_switch_names_on_or_off(void)
{
    static const char *const lines[][2] = {
        {"led 1 1", "error 41: ID '1': an ID is given twice; if 1 means on: 'led 1 on'\r\n"},
        {"led 1 0", "error 31: on|off is missing; if 0 means off: 'led 1 off'\r\n"},
        {"torque 2 1", "error 31: on|off is missing; if 1 means on: 'torque 2 on'\r\n"},
        {"torque 0 0",
         "error 41: ID '0': an ID is given twice; if 0 means off: 'torque 0 off'\r\n"},
        {"led 5,1 1", "error 41: ID '1': an ID is given twice; usage: led "},
        {"led 0-1 1", "error 41: ID '1': an ID is given twice; usage: led "},
        {"led 5-6 1", "error 31: wrong number of arguments; usage: led "},
        {"led 1 2", "error 31: wrong number of arguments; usage: led ID|254 on|off\r\n"},
        {"led all 1", "error 38: '1' where 'on|off' is due: no number here, as in 'led 1 on'\r\n"},
    };

    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_move_with_a_word_names_the_line(void)
{
    static const char *const lines[][2] = {
        {"move 1 90 in 2s", "error 32: servo 1: SPEED 'in': 'move' takes no time; 'group 1', then "
                            "'pose 90 in 2s'\r\n"},
        {"move 1 90deg at 30rpm", "error 32: servo 1: SPEED 'at': the speed stands behind the "
                                  "angle: 'move 1 90deg 30rpm'\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_help_of_units_lists_them(void)
{
    static const char *const words[] = {"units", "UNIT", "degrees", "steps", "rpm"};

    for (uint8_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        char line[16];

        sprintf(line, "help %s", words[i]);
        reply_to(line);
        TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE("Angle: deg, mdeg, or raw: ", said, 26, line);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, "495raw\r\nok\r\n"), said);
    }
}

void test_help_of_motion_lists_command_and_heading(void)
{
    reply_to("help motion");
    TEST_ASSERT_NOT_NULL(strstr(said, "  motion at PERCENT: "));
    reply_to("help motion");
    TEST_ASSERT_NULL(strstr(said, "Safety:"));
    reply_to("help stop");
    TEST_ASSERT_NULL(strstr(said, "Safety:"));
}

void test_help_of_keys_lists_them(void)
{
    reply_to("help keys");
    TEST_ASSERT_EQUAL_STRING_LEN("Ctrl-X: stop, ", said, 14);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, "Ctrl-W a word\r\nok\r\n"), said);
}
