/* SPDX-License-Identifier: MIT */
/* Numbers and units that are nearly right: the error names the line to type. */
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

void test_steps_in_place_of_degrees_name_raw(void)
{
    static const char *const lines[][2] = {
        {"move 1 512", "error 33: servo 1: ANGLE 512: beyond 300deg; steps: 'move 1 512raw'\r\n"},
        {"move 1,2 512", "error 33: ANGLE 512: beyond 300deg; steps: 512raw\r\n"},
        {"set 1 GOAL_POSITION 512",
         "error 33: servo 1: VALUE 512: beyond 300deg; steps: 512raw\r\n"},
        {"pose 512 90", "error 33: ANGLE... '512': beyond 300deg; steps: 512raw\r\n"},
        {"limits 1 0 301", "error 33: servo 1: HIGH 301: beyond 300deg; steps: 301raw\r\n"},
        {"move 1 1024", "error 33: servo 1: ANGLE 1024 is out of range: 0 to 300deg\r\n"},
        {"move 1 90 512", "error 33: servo 1: SPEED 512 is out of range: 0 to 62rpm\r\n"},
    };

    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_long_name_of_a_unit_names_the_short_one(void)
{
    static const char *const lines[][2] = {
        {"move 1 512 steps", "error 32: servo 1: SPEED 'steps': a unit is short, without a space: "
                             "'move 1 512raw'\r\n"},
        {"move 1 120 Degrees", "error 32: servo 1: SPEED 'Degrees': a unit is short, without a "
                               "space: 'move 1 120deg'\r\n"},
        {"move 1 90.5 degrees", "error 32: servo 1: SPEED 'degrees': a unit is short, without a "
                                "space: 90deg, 512raw\r\n"},
        {"set 1 GOAL_POSITION 9 steps",
         "error 31: a unit is short, without a space: 90deg, 512raw\r\n"},
        {"write 1 LED 1 steps", "error 32: servo 1: VALUE... 'steps': not a number; "},
    };

    ASSERT_REPLIES(lines);
}

void test_move_of_two_servos_names_one_word(void)
{
    static const char two[] = "error 33: servo 1: SPEED 90: a speed is 0 to 62rpm; two servos: "
                              "'move 1,2 90'\r\n";

    assert_reply("error 33: servo 1: SPEED 90 is out of range: 0 to 62rpm\r\n", "move 1 2 90");
    robot_add(&robot, 2);
    assert_reply(two, "move 1 2 90");
}

void test_write_with_a_unit_names_set(void)
{
    static const char *const lines[][2] = {
        {"write 1 GOAL_POSITION 90deg", "error 32: servo 1: VALUE... '90deg': 'write' takes "
                                        "register values; with a unit: 'set 1 30 90deg'\r\n"},
        {"write 1 GOAL_POSITION 90.5deg", "error 32: servo 1: VALUE... '90.5deg': not a number; "},
    };

    ASSERT_REPLIES(lines);
}

void test_set_of_a_read_only_register_names_a_line(void)
{
    static const char *const lines[][2] = {
        {"set 1 PRESENT_POSITION 5",
         "error 42: servo 1: read-only, measured; 'move 1 5' moves there\r\n"},
        {"set 1 PRESENT_POSITION 512", "error 42: servo 1: read-only; 'read 1 36 2' reads it\r\n"},
        {"set 1 PRESENT_VOLTAGE 5", "error 42: servo 1: read-only; 'read 1 42 1' reads it\r\n"},
        {"set 1 ID 5", "error 42: servo 1: register cannot be set; "},
    };

    ASSERT_REPLIES(lines);
}
