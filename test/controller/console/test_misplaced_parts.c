/* SPDX-License-Identifier: MIT */
/* Separators, registers and numbers at the wrong place: the error names the line to type. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
    robot.health_pauses = true;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_separator_in_a_word_names_spaces(void)
{
    static const char *const lines[][2] = {
        {"move 1=90",
         "error 32: ID|254 '1=90': a space between words, as in 'move 1 90deg 30rpm'\r\n"},
        {"move(1,90)", "error 30: 'move(1,90)': a space between words, as in 'move 1 90deg "},
        {"move,1,90", "error 30: 'move,1,90': a space between words, as in 'move 1 90deg 30rpm'"},
        {"status=", "error 30: 'status=': unknown command; "},
        {"walk(1)", "error 30: 'walk(1)': unknown command; "},
        {"move 1, 90", "error 32: ID|254 '1,': no space after a comma: 1,2,3; for one servo no "
                       "comma, as in 'move 1 90deg 30rpm'\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_register_or_setting_in_front_names_the_line(void)
{
    static const char *const lines[][2] = {
        {"present_load 1", "error 30: 'present_load': a register: 'get 1 40' prints it\r\n"},
        {"get position 1",
         "error 32: ID 'position': the ID comes first: 'get 1 PRESENT_VOLTAGE'\r\n"},
        {"get foo 1", "error 32: ID 'foo': not a number; write IDs: "},
        {"get id 1", "error 32: ID 'id': the ID comes first: "},
        {"set GOAL_POSITION 1 9",
         "error 32: ID 'GOAL_POSITION': the ID comes first: 'set 1 MIN_VOLTAGE 6.5V'\r\n"},
        {"set alarm_report 1", "error 32: ID 'alarm_report': a setting of the controller, "},
    };

    ASSERT_REPLIES(lines);
}

void test_period_of_monitor_without_every_names_it(void)
{
    static const char *const lines[][2] = {
        {"monitor 1 100ms", "error 32: ID... '100ms': the period stands behind 'every': 'monitor "
                            "1 every 100ms'\r\n"},
        {"monitor 1 for 5s",
         "error 38: 'for' where 'every|as plot' is due: try 'monitor 1 every 100ms', "},
        {"monitor 1 x", "error 38: 'x' where 'every|as plot' is due: unknown word; "},
    };

    ASSERT_REPLIES(lines);
}

void test_register_of_an_ax12_has_its_name_here(void)
{
    static const char *const lines[][2] = {
        {"set 1 TORQUE_LIMIT 50", "error 34: servo 1: REG 'TORQUE_LIMIT': unknown register; a "
                                  "CDS55xx has only MAX_TORQUE, which acts from the servo's next "
                                  "power-up on\r\n"},
        {"get 1 ccw-compliance-slope",
         "error 34: servo 1: REG 'ccw-compliance-slope': unknown register; a CDS55xx has "
         "CCW_PROPORTION at its address, "},
        {"get 1 goal_speed",
         "error 34: servo 1: REG 'goal_speed': unknown register; here it is MOVING_SPEED\r\n"},
        {"read 1 UP_LIMIT_VOLTAGE", "error 34: servo 1: REG 'UP_LIMIT_VOLTAGE': unknown register; "
                                    "here it is MAX_VOLTAGE\r\n"},
        {"get 1 LIMIT", "error 34: servo 1: REG 'LIMIT': unknown register; 'info ID' lists names "
                        "and addresses; did you mean "},
    };

    ASSERT_REPLIES(lines);
}

void test_register_with_an_equals_sign_needs_a_space(void)
{
    static const char *const lines[][2] = {
        {"set 1 GOAL_POSITION=300", "error 34: servo 1: REG 'GOAL_POSITION=300': a space between "
                                    "words, as in 'set 1 MIN_VOLTAGE 6.5V'\r\n"},
        {"set 1 LED= 1", "error 34: servo 1: REG 'LED=': a space between words, as in 'set "},
        {"get 1 LED,", "error 34: servo 1: REG 'LED,': unknown register; "},
    };

    ASSERT_REPLIES(lines);
}
