/* SPDX-License-Identifier: MIT */
/* Words and spaces in place of a number: the error shows what to write. */
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

void test_word_in_place_of_a_number_is_answered_with_one(void)
{
    static const char *const lines[][2] = {
        {"move 1 x", "error 32: servo 1: ANGLE 'x': not a number; write an angle: 90, "},
        {"move 1 9 x", "error 32: servo 1: SPEED 'x': not a number; write a speed: 30, "},
        {"set 1 LOCK on", "error 32: servo 1: VALUE 'on': not a number; write a whole number: 12 "},
        {"monitor 1 every x", "error 32: MS 'x': not a number; write a time: 500ms or 1.5s\r\n"},
        {"settings link_loss_ms x", "error 32: VALUE 'x': not a number; write a time: 500ms "},
        {"bus x", "error 32: RATE 'x': not a number; write a rate: 57600 or 1Mbps\r\n"},
        {"group x", "error 32: ID... 'x': not a number; write IDs: 1, 1-3, 1,4 or all\r\n"},
        {"id x 5", "error 32: OLD 'x': not a number; write an ID: 0 to 253\r\n"},
        {"id 1 x", "error 32: servo 1: NEW 'x': not a number; write an ID: 0 to 253\r\n"},
        {"play w at x", "error 32: PERCENT 'x': not a number; write a share: 50 or 50%\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_space_before_a_unit_is_named(void)
{
    static const char *const lines[][2] = {
        {"move 1 90 deg",
         "error 32: servo 1: SPEED 'deg': no space before a unit: 90deg, 500ms\r\n"},
        {"set 1 MIN_VOLTAGE 6V 7V",
         "error 31: wrong number of arguments; usage: set ID REG VALUE\r\n"},
        {"settings link_loss_ms 500 ms", "error 31: no space before a unit: 90deg, 500ms\r\n"},
        {"pose 30 deg",
         "error 38: 'deg' where 'at|in' is due: no space before a unit: 90deg, 500ms\r\n"},
        {"move 1 90 3 4", "error 31: wrong number of arguments; usage: move ID|254 ANGLE [SPEED]"},
    };

    ASSERT_REPLIES(lines);
}
