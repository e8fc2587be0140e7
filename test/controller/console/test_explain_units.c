/* SPDX-License-Identifier: MIT */
/* Errors that name what is right: the units that suit, the usage, the limits of a servo. Settings
 * with their units. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_setting_is_taken_and_shown_with_its_unit(void)
{
    static const char *const lines[][2] = {
        {"settings link_loss_ms 0.5s", "ok\r\n"},
        {"settings link_loss_ms", "link_loss_ms = 500 ms\r\nok\r\n"},
        {"settings cycle_us 4.5ms", "ok\r\n"},
        {"settings cycle_us", "cycle_us = 4500 us\r\nok\r\n"},
        {"settings return_delay 4us", "ok\r\n"},
        {"settings return_delay", "return_delay = 4us (2)\r\nok\r\n"},
        {"settings bus_baud", "bus_baud = 1000000bps (1)\r\nok\r\n"},
        {"settings host_baud 255",
         "the host link has this rate behind the next line: set the terminal to it; a reset "
         "without 'save' brings the old one back\r\nok\r\n"},
        {"settings host_baud", "host_baud = 255 register\r\nok\r\n"},
    };

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        TEST_ASSERT_EQUAL_STRING(lines[i][1], reply_to(lines[i][0]));
    assert_reply("error 33: VALUE 66s is out of range: 0 to 65535ms\r\n",
                 "settings link_loss_ms 66s");
    assert_reply("error 61: VALUE 1ms is out of range: 2000 to 65535us\r\n",
                 "settings cycle_us 1ms");
    assert_reply("error 33: VALUE 600us is out of range: 0 to 508us\r\n",
                 "settings return_delay 600us");
}

void test_wrong_unit_names_those_that_suit(void)
{
    assert_reply("error 39: RATE '1M': wrong unit; this takes bps, kbps or raw\r\n", "bus 1M");
    assert_reply("error 39: servo 1: ANGLE '3oo': wrong unit; this takes deg, mdeg or raw\r\n",
                 "move 1 3oo");
    assert_reply("error 39: servo 1: ANGLE 3rpm: wrong unit; this takes deg, mdeg or raw\r\n",
                 "move 1 3rpm");
    assert_reply("error 39: servo 1: VALUE 3deg: wrong unit; this takes V, mV or raw\r\n",
                 "set 1 MIN_VOLTAGE 3deg");
    assert_reply("error 39: MS 3deg: wrong unit; this takes us, ms or s\r\n",
                 "monitor 1 every 3deg");
}

void test_wrong_number_of_arguments_shows_usage(void)
{
    assert_reply("error 31: wrong number of arguments; usage: limits ID LOW HIGH [SPEED]\r\n",
                 "limits 4");
    assert_reply("error 31: wrong number of arguments; usage: move ID|254 ANGLE [SPEED]\r\n",
                 "move 1");
    assert_reply("error 31: wrong number of arguments; 'help COMMAND' shows", "pose");
}

void test_refusal_of_limits_names_them(void)
{
    robot_add(&robot, 4);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("limits 4 60 200 30rpm"));
    assert_reply("error 11: servo 4: its limits are 60.117deg to 200deg and 3",
                 "write 4 GOAL_POSITION 1000");
    TEST_ASSERT_NOT_NULL(strstr(said, "rpm; stay within them, or change them by 'limits'\r\n"));
    reply_to("servos");
    TEST_ASSERT_NOT_NULL(strstr(said, ", limits 60.117deg to 200deg and 3"));
}
