/* SPDX-License-Identifier: MIT */
/* `get` without a register, `set` of an angle limit and of the status return level, and `reset`,
 * where the flash has room. */
#include "console_rig.h"

#define LIMITS_AT_0  0, 0, 0, 0
#define UP_TO_TORQUE 0, 80, 60, 160, 255, 3, 2, 37, 4, 0, 0, 0, 0, 0 // 0x0A to 0x17

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* The next packet, which leaves by itself. */
static void assert_sends(const char *hex)
{
    port_fake_transmit(&bus.link, 0);
    assert_sent(hex);
}

/* `get` of IDs without a register: the last ID was read as a register. */
void test_get_of_ids_without_register_gives_warning(void)
{
    static const char warning[] =
        "warning: 3 was read as the address of a register, not as servo 3\r\nservo 1: ";

    for (uint8_t id = 1; id <= 3; id++)
        robot_add(&robot, id);
    robot.health_pauses = true;
    TEST_ASSERT_EQUAL_STRING(warning, reply_to("get 1 2 3"));
    assert_sends("FF FF 01 04 02 03 01 F4");
}

void test_get_of_a_list_in_one_word_gives_no_warning(void)
{
    robot_add(&robot, 3);
    robot.health_pauses = true;
    TEST_ASSERT_EQUAL_STRING("servo 1: ", reply_to("get 1,2 3"));
}

#define READ_LIMITS_TO_TORQUE "FF FF 01 04 02 06 13 DF"

void test_set_of_limit_refuses_a_turning_servo(void)
{
    static const uint8_t turns[] = {LIMITS_AT_0, UP_TO_TORQUE, 1};

    reply_to("set 1 CCW_ANGLE_LIMIT 300");
    assert_sent(READ_LIMITS_TO_TORQUE);
    answer(1, 0, turns, sizeof turns);
    TEST_ASSERT_EQUAL_STRING_LEN("error 47: servo 1: ", said, 19);
    TEST_ASSERT_NOT_EQUAL(CDS_LINK_TALKING, bus.link.state);
}

void test_set_of_limit_goes_on_if_torque_is_off(void)
{
    static const uint8_t is_off[] = {LIMITS_AT_0, UP_TO_TORQUE, 0};

    reply_to("set 1 CCW_ANGLE_LIMIT 300");
    answer(1, 0, is_off, sizeof is_off);
    assert_sends("FF FF 01 04 02 08 02 EE");
}

void test_set_of_limit_goes_on_in_position_mode(void)
{
    static const uint8_t stands[] = {0, 0, 255, 3, UP_TO_TORQUE, 1};

    reply_to("set 1 CW_ANGLE_LIMIT 10");
    answer(1, 0, stands, sizeof stands);
    assert_sends("FF FF 01 04 02 06 02 F0");
}

void test_set_of_level_is_read_back(void)
{
    reply_to("set 1 STATUS_RETURN_LEVEL 1");
    assert_sent("FF FF 01 04 03 10 01 E6");
    answer(1, 0, NULL, 0);
    assert_sends("FF FF 01 04 02 10 01 E7");
    answer(1, 0, (const uint8_t[]){1}, 1);
    TEST_ASSERT_EQUAL_STRING("written\r\nok\r\n", said);
}

void test_set_of_level_0_says_that_it_is_not_verified(void)
{
    reply_to("set 1 STATUS_RETURN_LEVEL 0");
    answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("sent, not verified: at level 0 a servo answers only PING\r\nok\r\n",
                             said);
}

void test_reset_says_what_the_servo_has_now(void)
{
    reply_to("reset 2");
    answer(2, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("factory values: ID 1, 1 Mbps\r\nok\r\n", said);
}
