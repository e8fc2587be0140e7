/* SPDX-License-Identifier: MIT */
/* Words at the wrong place: the error names the line to type. */
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

void test_command_behind_a_command_is_named(void)
{
    static const char *const lines[][2] = {
        {"motion pause",
         "error 38: 'pause' where 'wait|off|at' is due: a command of its own: 'pause'\r\n"},
        {"motion stop",
         "error 38: 'stop' where 'wait|off|at' is due: 'motion off' ends a motion; 'stop' "
         "switches torque off, too\r\n"},
        {"play walk stop",
         "error 38: 'stop' where 'at|times|loop' is due: 'motion off' ends a motion; "},
        {"set id 1 3", "error 32: ID 'id': a command of its own: 'id 1 5'\r\n"},
        {"set Baud 1 9600", "error 32: ID 'Baud': a command of its own: 'baud 1 57600bps'\r\n"},
        {"cycle stop", "error 38: 'stop' where 'every|off' is due: try 'cycle off'\r\n"},
        {"settings autostart play x", "error 32: DELAY 'x': not a number; write whole seconds"},
    };

    ASSERT_REPLIES(lines);
}

void test_word_in_the_place_of_a_name_is_named(void)
{
    static const char *const lines[][2] = {
        {"sequence new walk",
         "error 38: 'walk' where 'new|add|show|set|insert|delete' is due: the name comes "
         "first: 'sequence walk new stand 1.2s dwell 0.5s'\r\n"},
        {"sequence insert", "error 31: the name comes first: 'sequence walk insert 2 lift "},
        {"sequence play wave",
         "error 38: 'wave' where 'new|add|show|set|insert|delete' is due: a command of its "
         "own: 'play walk at 80%'\r\n"},
        {"play loop", "error 75: 'loop': the name comes first: 'play walk loop'\r\n"},
        {"play nothere", "error 75: 'nothere': unknown sequence; "},
    };

    ASSERT_REPLIES(lines);
}

void test_word_of_another_form_names_its_usage(void)
{
    static const char *const lines[][2] = {
        {"play walk at 80% loop", "error 31: usage: play NAME loop [at PERCENT]\r\n"},
        {"settings autostart walk 5s loop",
         "error 31: usage: settings autostart NAME loop [DELAY]\r\n"},
        {"settings autostart walk once", "error 32: DELAY 'once': try 'settings autostart NAME'"},
        {"save up", "error 31: 'save' alone keeps the settings; for a pose 'pose save NAME'\r\n"},
        {"status up", "error 31: wrong number of arguments; usage: status\r\n"},
    };

    ASSERT_REPLIES(lines);
}
