/* SPDX-License-Identifier: MIT */
/* Commands that are nearly right: the error names the line to type. */
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

void test_stored_name_with_a_word_names_the_line(void)
{
    static const char *const lines[][2] = {
        {"pose right at 20rpm", "error 38: 'at' where 'in' is due: try 'pose NAME in 2s'\r\n"},
        {"sequence wave loop",
         "error 38: 'loop' where 'new|add|show|set|insert|delete' is due: a sequence: 'play NAME', "
         "'play NAME times 2', 'play NAME loop'\r\n"},
        {"play wave twice",
         "error 38: 'twice' where 'at|times|loop' is due: a sequence: 'play NAME', 'play NAME "
         "times 2', 'play NAME loop'\r\n"},
        {"play wave 2", "error 38: '2' where 'at|times|loop' is due: a number of runs stands "},
    };

    ASSERT_REPLIES(lines);
}

void test_command_of_another_name_names_the_line(void)
{
    static const char *const lines[][2] = {
        {"goto 1 90", "error 30: 'goto': unknown command; try 'move 1 90deg'\r\n"},
        {"Speed 1 20", "error 30: 'Speed': unknown command; try 'move 1 90deg 30rpm'\r\n"},
        {"remove near", "error 30: 'remove': unknown command; try 'pose delete NAME', 'sequence "
                        "delete NAME'\r\n"},
        {"on", "error 30: 'on': unknown command; try 'torque 1 on'\r\n"},
        {"off", "error 30: 'off': unknown command; try 'torque 1 off', 'torque all off'\r\n"},
        {"disable 2",
         "error 30: 'disable': unknown command; try 'torque 1 off', 'torque all off'\r\n"},
        {"ls", "error 30: 'ls': unknown command; try 'servos', 'pose list'\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_word_of_another_command_names_the_line(void)
{
    static const char *const lines[][2] = {
        {"torque off", "error 32: ID|254 'off': try 'torque 1 off', 'torque all off'\r\n"},
        {"torque OFF 2", "error 32: ID|254 'OFF': try 'torque 1 off', 'torque all off'\r\n"},
        {"led off", "error 32: ID|254 'off': try 'led 1 off'\r\n"},
        {"turn 1 off", "error 32: servo 1: SPEED 'off': try 'turn 1 0', or 'torque 1 off'\r\n"},
        {"turn 1 stop", "error 32: servo 1: SPEED 'stop': try 'turn 1 0', or 'torque 1 off'\r\n"},
        {"turn 1 fast", "error 32: servo 1: SPEED 'fast': not a number; "},
        {"monitor 1 plot",
         "error 38: 'plot' where 'every|as plot' is due: try 'monitor 1 as plot'\r\n"},
        {"move 1-3 100 at 20rpm",
         "error 32: SPEED 'at': try 'move 1-3 90 30rpm'; in a time: 'help pose'\r\n"},
        {"move all 100 in 2s", "error 32: SPEED 'in': try 'move 1-3 90 30rpm'; in a time: "},
        {"settings alarm_report on",
         "error 32: VALUE 'on': write 1 (in each mode): 'settings alarm_report 1'\r\n"},
        {"settings alarm_report yes",
         "error 32: VALUE 'yes': not a number; write 1 for on, 0 for off\r\n"},
        {"settings echo off",
         "error 32: VALUE 'off': write 0 (mode program): 'settings echo 0'\r\n"},
        {"settings echo on", "error 32: VALUE 'on': not a number; write a number from 0 to 2"},
        {"settings device_id off", "error 32: VALUE 'off': write 254 (off)"},
    };

    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_many_angles_name_the_limit_of_a_line(void)
{
    char line[8 + 3 * 51] = "pose";

    for (uint8_t i = 0; i < 51; i++)
        strcat(line, " 90");
    reply_to(line);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, "too many servos or angles; at most 50 in a line"),
                                 said);
}
