/* SPDX-License-Identifier: MIT */
/* `limits` without angles, and off; `factory` of a list. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_limits_without_angles_prints_the_line_that_sets_them(void)
{
    assert_reply("error 48: servo 1: ", "limits 1");
    TEST_ASSERT_EQUAL_STRING("no servo has limits\r\nok\r\n", reply_to("limits"));
    robot_add(&robot, 1);
    robot_add(&robot, 2);
    TEST_ASSERT_EQUAL_STRING("none\r\nok\r\n", reply_to("limits 1"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("limits 1 0 512raw 495raw"));
    TEST_ASSERT_EQUAL_STRING("limits 1 0deg 150.147deg 30rpm\r\nok\r\n", reply_to("limits 1"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("limits 2 0 150"));
    TEST_ASSERT_EQUAL_STRING("limits 1 0deg 150.147deg 30rpm\r\nlimits 2 0deg 150.147deg\r\nok\r\n",
                             reply_to("limits"));
    assert_reply("error 31: wrong number of arguments; usage: limits ID off", "limits 1 off 1");
    assert_reply("error 31: wrong number of arguments; usage: limits ID LOW HIGH", "limits 1 10");
    assert_reply("error 32: ID 'off': try 'limits 1 off', 'limits all off'", "limits off");
}

void test_limits_off_removes_those_of_each_servo_of_a_list(void)
{
    robot_add(&robot, 1);
    robot_add(&robot, 2);
    assert_reply("error 48: servo 9: ", "limits 9 off");
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nservo 2: ok\r\nok\r\n",
                             reply_to("limits all 60 200 30rpm"));
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nservo 2: ok\r\nok\r\n", reply_to("limits all off"));
    TEST_ASSERT_EQUAL_STRING("servo 1: none\r\nservo 2: none\r\nok\r\n", reply_to("limits 1-2"));
}

void test_factory_of_several_servos_resets_none(void)
{
    static const char *const lines[] = {"factory all", "factory 1,2", "factory 1 2 force"};

    robot_add(&robot, 1);
    robot_add(&robot, 2);
    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        assert_reply("error 53: nothing was reset; each of them would get ID 1: 'factory 1' ",
                     lines[i]);
        TEST_ASSERT_EQUAL_UINT16(0, port_fake.sent_size);
    }
}
