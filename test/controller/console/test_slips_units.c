/* SPDX-License-Identifier: MIT */
/* Units that are nearly right: the error names the unit or the line to type. */
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

void test_long_name_of_a_unit_names_the_short_one(void)
{
    static const char *const lines[][2] = {
        {"move 1 512 steps", "error 32: servo 1: SPEED 'steps': write raw, without a space: "
                             "'move 1 512raw'\r\n"},
        {"move 1 120 Degrees", "error 32: servo 1: SPEED 'Degrees': write deg, without a "
                               "space: 'move 1 120deg'\r\n"},
        {"move 1 90.5 degrees", "error 32: servo 1: SPEED 'degrees': write deg, without a "
                                "space: 90deg\r\n"},
        {"set 1 GOAL_POSITION 9 steps", "error 31: write raw, without a space: 512raw\r\n"},
        {"pose 90 degrees",
         "error 38: 'degrees' where 'at|in' is due: write deg, without a space: 90deg\r\n"},
        {"write 1 LED 1 steps", "error 32: servo 1: VALUE... 'steps': not a number; "},
    };

    ASSERT_REPLIES(lines);
}

void test_long_unit_of_another_kind_keeps_what_was_typed(void)
{
    static const char *const lines[][2] = {
        {"move 1 90 volts", "error 32: servo 1: SPEED 'volts': write V, without a space: "
                            "6V\r\n"},
        {"move 1 90deg steps", "error 32: servo 1: SPEED 'steps': write raw, without a space: "
                               "512raw\r\n"},
        {"move 1 90 2 seconds", "error 31: write s, without a space: 2s\r\n"},
        {"move 1 90 30 degrees", "error 31: write deg, without a space: 90deg\r\n"},
        {"settings link_loss_ms 5 seconds", "error 31: write s, without a space: 2s\r\n"},
        {"play w at 50 percent", "error 31: write %, without a space: 50%\r\n"},
        {"torque 1 seconds", "error 38: servo 1: 'seconds' where 'on|off' is due: unknown word; "},
        {"move 1 degrees", "error 32: servo 1: ANGLE 'degrees': not a number; "},
    };

    ASSERT_REPLIES(lines);
}

void test_write_with_a_unit_names_set(void)
{
    static const char *const lines[][2] = {
        {"write 1 GOAL_POSITION 90deg",
         "error 32: servo 1: VALUE... '90deg': 'write' takes "
         "register values; with a unit: 'set 1 GOAL_POSITION 90deg'\r\n"},
        {"write 254 GOAL_POSITION 90deg", "error 32: VALUE... '90deg': not a number; "},
        {"write 1 LED 90deg", "error 32: servo 1: VALUE... '90deg': not a number; "},
        {"write 1 GOAL_POSITION 400deg", "error 32: servo 1: VALUE... '400deg': not a number; "},
        {"write 1 GOAL_POSITION 90.5deg", "error 32: servo 1: VALUE... '90.5deg': not a number; "},
    };

    ASSERT_REPLIES(lines);
}
