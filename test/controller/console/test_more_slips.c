/* SPDX-License-Identifier: MIT */
/* More lines that are nearly right. */
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

void test_semicolon_says_one_command_in_a_line(void)
{
    static const char *const lines[][2] = {
        {"move 1 90;move 2 90",
         "error 39: servo 1: ANGLE '90;move': one command a line, no ';'\r\n"},
        {"move 1 90; move 2 90", "error 39: servo 1: ANGLE '90;': one command a line, no ';'\r\n"},
        {"move 1 90 ; move 2 90", "error 32: servo 1: SPEED ';': one command a line, no ';'\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_words_of_other_consoles_name_a_line(void)
{
    static const char *const lines[][2] = {
        {"watch 1", "error 30: 'watch': unknown command; try 'monitor 1'\r\n"},
        {"where", "error 30: 'where': unknown command; try 'get 1 PRESENT_POSITION'"},
        {"temp 1", "error 30: 'temp': unknown command; try 'get 1 PRESENT_TEMPERATURE'\r\n"},
        {"halt", "error 30: 'halt': unknown command; try 'stop', or Ctrl-X\r\n"},
        {"move 1 to 90", "error 32: servo 1: ANGLE 'to': try 'move 1 90'\r\n"},
        {"Voltage", "error 30: 'Voltage': unknown command; try 'get 1 PRESENT_VOLTAGE'\r\n"},
        {"sequence big add far in 2s", "error 32: TIME 'in': try 'sequence NAME add POSE 2s'\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_number_behind_scan_or_servos_names_ping(void)
{
    static const char *const lines[][2] = {
        {"scan 1", "error 38: '1' where 'all|rescue' is due: one servo: 'ping 1', 'info 1'\r\n"},
        {"servos 2", "error 38: '2' where 'forget' is due: one servo: 'ping 2', 'info 2'\r\n"},
        {"scan 300", "error 38: '300' where 'all|rescue' is due: no number here, "},
    };

    ASSERT_REPLIES(lines);
}

void test_notation_of_a_number_is_named(void)
{
    static const char *const lines[][2] = {
        {"move 1 90.123456789",
         "error 33: servo 1: ANGLE '90.123456789': too many digits; at most 3 decimals\r\n"},
        {"move 1 99999999999", "error 33: servo 1: ANGLE 99999999999 is out of range: 0 to "},
        {"move 1 +10",
         "error 32: servo 1: ANGLE '+10': without '+': ANGLE is where it goes; 'get 1 "},
        {"move 1,2 +10", "error 32: ANGLE '+10': without '+'\r\n"},
        {"move 1 90 +10", "error 32: servo 1: SPEED '+10': without '+'\r\n"},
        {"turn 1 +10", "error 32: servo 1: SPEED '+10': without '+'\r\n"},
        {"limits 1 +60 90", "error 32: servo 1: LOW '+60': without '+'\r\n"},
        {"move 1 90.", "error 32: servo 1: ANGLE '90.': digits around the point: 90.0"},
        {"move 1 .5", "error 32: servo 1: ANGLE '.5': digits around the point: 90.0"},
        {"move 1 x", "error 32: servo 1: ANGLE 'x': not a number; "},
    };

    ASSERT_REPLIES(lines);
}

void test_angle_for_each_servo_names_group_and_pose(void)
{
    static const char *const lines[][2] = {
        {"move 1-3 90 120 150", "error 31: an angle for each: 'group 1-3', 'pose 90 120 150'\r\n"},
        {"move 1,2 90 120", "error 33: SPEED 120: an angle for each: 'group 1-3', "},
        {"move 1,2 30 40 50", "error 31: an angle for each: 'group 1-3', "},
        {"move 1,2 400 30", "error 33: ANGLE 400: beyond 300deg; steps: 400raw\r\n"},
        {"move 1,2 90 400", "error 33: SPEED 400 is out of range: 0 to 62rpm\r\n"},
    };

    ASSERT_REPLIES(lines);
}
