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
        {"pose right at 20rpm", "error 38: in 'at': a stored pose takes a time: 'pose NAME in "
                                "2s'\r\n"},
        {"sequence wave loop",
         "error 38: new|add|show|set|insert|delete 'loop': a sequence: 'play NAME' plays it, "
         "'play NAME loop' repeats it\r\n"},
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
        {"ls", "error 30: 'ls': unknown command; try 'servos', 'pose list'\r\n"},
    };

    ASSERT_REPLIES(lines);
}
