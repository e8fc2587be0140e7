/* SPDX-License-Identifier: MIT */
/* Errors that name a number and its range: of commands, registers, motions, limits and lists of
 * servos. A suite of its own: with test_explain.c it would not fit the RAM of an AVR. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
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
    assert_reply("error 32: TIME 0.5ms: has too many decimals\r\n", "pose a in 0.5ms");
    assert_reply("error 32: PERCENT 100.5%: has too many decimals\r\n", "play w times 1 at 100.5%");
    assert_reply("error 32: N 1.5: has too many decimals\r\n", "play w times 1.5");
}

void test_low_limit_above_high_limit_names_both(void)
{
    robot_add(&robot, 1);
    robot.health_pauses = true;
    assert_reply("error 33: servo 1: LOW 200: above HIGH, 100deg; write the smaller angle "
                 "first: limits ID LOW HIGH\r\n",
                 "limits 1 200 100");
    assert_reply("error 33: servo 1: HIGH 301deg is out of range: 0 to 300deg\r\n",
                 "limits 1 0 301deg");
}

void test_number_out_of_range_is_refused_for_a_list(void)
{
    assert_reply("error 33: VALUE 2 is out of range: 0 to 1\r\n", "set 1-2 TORQUE_ENABLE 2");
    assert_reply("error 33: ANGLE 400deg is out of range: 0 to 300deg\r\n", "move 1,2 400deg");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
    reply_to("set 1-2 MOVING_SPEED 1500raw");
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

void test_number_of_command_out_of_range_names_range(void)
{
    assert_reply("error 33: servo 1: ANGLE 400deg is out of range: 0 to 300deg\r\n",
                 "move 1 400deg");
    assert_reply("error 33: servo 1: ANGLE 1024raw is out of range: 0 to 1023raw\r\n",
                 "move 1 1024raw");
    assert_reply("error 33: servo 1: SPEED 62.5rpm is out of range: 0 to 62rpm\r\n",
                 "move 1 90 62.5rpm");
    assert_reply("error 33: servo 1: SPEED -63 is out of range: -62 to 62rpm\r\n", "turn 1 -63");
    assert_reply("error 33: RATE 3000kbps is out of range: 7843 to 2000000bps\r\n", "bus 3000kbps");
    assert_reply("error 33: MS 9ms is out of range: 10 to 60000ms\r\n", "monitor 1 every 9ms");
    assert_reply("error 33: MS 1s is out of range: 2 to 65ms\r\n", "cycle every 1s");
    assert_reply("error 33: ANGLE... 400deg is out of range: 0 to 300deg\r\n", "pose 90 400deg");
}

/* A decimal address is first read as one more ID. */
void test_address_out_of_range_behind_servos_is_named(void)
{
    assert_reply("error 33: servo 1: REG 200 is out of range: 0x00 to 0x31\r\n", "set 1 200 5");
    assert_reply("error 33: servo 1: REG 200 is out of range: 0x00 to 0x31\r\n", "set 1 200 512");
    assert_reply("error 33: servo 1: REG 200 is out of range: 0x00 to 0x31\r\n", "get 1 200");
    assert_reply("error 33: REG 60 is out of range: 0x00 to 0x31\r\n", "set 1 2 60 5");
    assert_reply("error 33: servo 1: REG 0x40 is out of range: 0x00 to 0x31\r\n", "get 1 0x40");
    assert_reply("error 33: servo 1: REG 50 is out of range: 0x00 to 0x31\r\n", "read 1 50");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_value_of_register_out_of_range_names_its_range(void)
{
    assert_reply("error 33: servo 1: VALUE 3 is out of range: 0 to 2\r\n",
                 "set 1 STATUS_RETURN_LEVEL 3");
    assert_reply("error 33: servo 1: VALUE 26V is out of range: ", "set 1 MIN_VOLTAGE 26V");
    assert_reply("error 33: servo 1: VALUE... 1024 is out of range: 0 to 1023\r\n",
                 "write 1 GOAL_POSITION 1024");
    assert_reply("error 33: servo 1: VALUE... 256 is out of range: 0 to 255\r\n", "write 1 3 256");
    assert_reply("error 33: servo 1: LENGTH 21 is out of range: 1 to 20\r\n", "read 1 30 21");
}
