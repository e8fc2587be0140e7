/* SPDX-License-Identifier: MIT */
/* Wrong units: the error names the right ones. */
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

void test_wrong_unit_names_the_units_of_the_argument(void)
{
    static const char *const lines[][2] = {
        {"move 1 90rpm", "error 39: servo 1: ANGLE 90rpm: wrong unit; units: deg, mdeg, raw\r\n"},
        {"move 1 90foo", "error 39: servo 1: ANGLE '90foo': wrong unit; units: deg, mdeg, raw\r\n"},
        {"move 1 90 3deg", "error 39: servo 1: SPEED 3deg: wrong unit; units: rpm, mrpm, raw\r\n"},
        {"set 1 MIN_VOLTAGE 6C", "error 39: servo 1: VALUE 6C: wrong unit; units: V, mV, raw\r\n"},
        {"set 1 LED 1V", "error 39: servo 1: VALUE 1V: wrong unit; this number has no unit\r\n"},
        {"set 1 MAX_TEMPERATURE 70V",
         "error 39: servo 1: VALUE 70V: wrong unit; units: C, raw\r\n"},
        {"set 1 MAX_TORQUE 70V", "error 39: servo 1: VALUE 70V: wrong unit; units: %, raw\r\n"},
        {"bus 9600deg", "error 39: RATE 9600deg: wrong unit; units: bps, kbps, Mbps, raw\r\n"},
        {"cycle every 5V", "error 39: MS 5V: wrong unit; units: s, ms, us\r\n"},
        {"monitor 1 every 100raw", "error 39: MS 100raw: wrong unit; units: s, ms, us\r\n"},
        {"play w at 50deg", "error 39: PERCENT 50deg: wrong unit; units: %\r\n"},
        {"settings link_loss_ms 5V", "error 39: VALUE 5V: wrong unit; units: s, ms, us\r\n"},
        {"settings bus_baud 5V", "error 39: VALUE 5V: wrong unit; units: bps, kbps, Mbps\r\n"},
    };

    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_unit_of_pose_is_that_behind_at_or_in(void)
{
    static const char *const lines[][2] = {
        {"pose 30rpm", "error 39: ANGLE... '30rpm': wrong unit; units: deg, mdeg, raw\r\n"},
        {"pose 30 at 5V", "error 39: SPEED 5V: wrong unit; units: rpm, mrpm, raw\r\n"},
        {"pose 30 in 5V", "error 39: TIME 5V: wrong unit; units: s, ms, us\r\n"},
    };

    reply_to("group 1");
    ASSERT_REPLIES(lines);
}
