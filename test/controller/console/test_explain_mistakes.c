/* SPDX-License-Identifier: MIT */
/* Mistakes that have a text of their own, and ranges that depend on the command. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_decimal_comma_is_answered_with_a_point(void)
{
    assert_reply("error 39: servo 1: ANGLE '90,5': write a point, not a comma: 90.5\r\n",
                 "move 1 90,5");
    assert_reply("error 39: servo 1: SPEED '-5,5rpm': write a point, not a comma: "
                 "-5.5rpm\r\n",
                 "turn 1 -5,5rpm");
    reply_to("group 1 2");
    assert_reply("error 39: ANGLE... '90,120': write a point, not a comma: 90.120, or "
                 "spaces between angles\r\n",
                 "pose 90,120");
    assert_reply("error 39: servo 1: ANGLE '90,x': wrong unit; ", "move 1 90,x");
}

void test_setting_with_wrong_unit_says_so(void)
{
    assert_reply("error 39: VALUE 4ms: wrong unit; this number has no unit\r\n",
                 "settings repeats 4ms");
}

void test_rate_of_host_has_its_own_range(void)
{
    assert_reply("error 33: VALUE 2000000 is out of range: 7843 to 1000000bps\r\n",
                 "settings host_baud 2000000");
    assert_reply("error 33: VALUE 3000000 is out of range: 7843 to 1000000bps\r\n",
                 "settings host_baud 3000000");
}

void test_value_of_restore_has_range_of_register(void)
{
    assert_reply("error 33: servo 1: VALUE 300 is out of range: 0 to 25.5V\r\n",
                 "restore 1 MIN_VOLTAGE 300");
}

void test_speed_of_pose_has_its_range(void)
{
    reply_to("group 1");
    assert_reply("error 33: SPEED 63rpm is out of range: 0 to 62rpm\r\n", "pose 90 at 63rpm");
}

void test_values_behind_last_register_are_too_many(void)
{
    assert_reply("error 31: too many values: from 0x30 to 0x31, the last register, there is "
                 "room for 2\r\n",
                 "write 3 0x30 100 1 2");
    assert_reply("error 31: too many values: from 0x31 to 0x31, ", "write 3 0x31 1 1");
    assert_reply("error 31: too many values: from 0x30 to 0x31, the last register, there is "
                 "room for 1\r\n",
                 "regwrite 3 PUNCH 1 1");
    assert_reply("error 31: wrong number of arguments; usage: write ", "write 3 PUNCH");
    assert_reply("error 33: servo 3: VALUE... 300 is out of range: 0 to 255\r\n",
                 "write 3 0x31 300");
}

void test_range_of_one_value_is_printed(void)
{
    assert_reply("error 33: servo 1: LENGTH 2 is out of range: 1 to 1\r\n", "read 1 0x31 2");
}

void test_id_of_known_servo_is_named(void)
{
    robot_add(&robot, 1);
    robot_add(&robot, 12);
    reply_to("id 12 1");
    for (uint8_t i = 0; i < 20 && said_length == 0; i++) {
        if (bus.link.state == CDS_LINK_TALKING)
            port_fake_transmit(&bus.link, 0);
        if (port_fake.sent[2] == 12)
            answer(12, 0, NULL, 0);
        port_fake.now_us += 1000000;
        type("");
    }
    TEST_ASSERT_EQUAL_STRING("unchanged: ID 12 at 1000000bps\r\n"
                             "error 11: servo 12: ID 1 is in the robot's list; "
                             "choose another ID, or 'servos forget'\r\n",
                             said);
}
