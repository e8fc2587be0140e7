/* SPDX-License-Identifier: MIT */
/* Errors that name a number: of motions, of limits, of a list of servos. The other ones are in
 * test_explain.c, which fills the RAM of an AVR. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* The reply to `line` is this line; of a longer one, its beginning. */
static void assert_reply(const char *begin, const char *line)
{
    reply_to(line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(begin, said, strlen(begin), line);
    TEST_ASSERT_EQUAL_STRING("\r\n", said + strlen(said) - 2);
    TEST_ASSERT_EQUAL_PTR(strchr(said, '\n'), strrchr(said, '\n'));
}

void test_numbers_of_motions_out_of_range_name_their_range(void)
{
    assert_reply("error 33: N 65536 is out of range: 1 to 65535\r\n", "play w times 65536");
    assert_reply("error 33: N 0 is out of range: 1 to 65535\r\n", "play w times 0");
    assert_reply("error 82: PERCENT 9% is out of range: 10 to 200%\r\n", "play w at 9%");
    assert_reply("error 82: PERCENT 300 is out of range: 10 to 200%\r\n", "play w loop at 300");
}

void test_number_too_fine_is_named(void)
{
    assert_reply("error 32: TIME 0.5ms: finer than the command takes\r\n", "pose a in 0.5ms");
    assert_reply("error 32: PERCENT 100.5%: finer than the command takes\r\n",
                 "play w times 1 at 100.5%");
    assert_reply("error 32: N 1.5: finer than the command takes\r\n", "play w times 1.5");
}

void test_low_limit_above_high_limit_names_its_range(void)
{
    robot_add(&robot, 1);
    robot.health_pauses = true;
    assert_reply("error 33: servo 1: LOW 200 is out of range: 0 to 100deg\r\n", "limits 1 200 100");
    assert_reply("error 33: servo 1: HIGH 301 is out of range: 0 to 300deg\r\n", "limits 1 0 301");
}

void test_number_out_of_range_is_refused_for_a_list(void)
{
    assert_reply("error 33: VALUE 2 is out of range: 0 to 1\r\n", "set 1-2 TORQUE_ENABLE 2");
    assert_reply("error 33: ANGLE 400 is out of range: 0 to 300deg\r\n", "move 1,2 400");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
    reply_to("set 1-2 MOVING_SPEED 1500raw");
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}
