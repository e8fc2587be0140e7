/* SPDX-License-Identifier: MIT */
/* Mistakes in lists of IDs. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_list_in_place_of_one_servo_is_named(void)
{
    assert_reply("error 32: ID|254 '1-3': one servo here, no list; ", "ping 1-3");
    assert_reply("error 32: ID '1,2': one servo here, no list; ", "read 1,2 30 2");
    assert_reply("error 32: OLD '1-3': one servo here, no list; ", "id 1-3 5");
    assert_reply("error 32: servo 1: NEW '2-3': one servo here, no list; ", "id 1 2-3");
    assert_reply("error 32: ID|254 'all': one servo here, no list; ", "ping all");
    assert_reply(
        "error 32: ID|254 'all': this command has no 'all'; ID 254 means all servos on the "
        "bus: 'write 254'\r\n",
        "write all LED 1");
    assert_reply("error 32: ID|254 'ALL': this command has no 'all'; ", "action ALL");
    assert_reply("error 32: servo 1: NEW 'ALL': one servo here, no list; ", "id 1 ALL");
    assert_reply("error 32: ID|254 'x': not a number; ", "ping x");
    assert_reply("error 33: ID|254 -1 is out of range: 0 to 254\r\n", "torque -1 on");
}

void test_blank_behind_comma_of_list_is_named(void)
{
    assert_reply("error 32: ID|254 '1,': no space after a comma: 1,2,3; ", "move 1, 2, 3 90");
    assert_reply("error 32: ID|254 '1-2,': no space after a comma: ", "torque 1-2, 3 on");
    assert_reply("error 32: ID... '1,': no space after a comma: 1,2,3\r\n", "group 1, 2");
    assert_reply("error 32: ID|254 '1,x': not a number; ", "torque 1,x on");
    assert_reply("error 32: ID... '1': not a number; ", "group all 1");
    assert_reply("error 32: ID|254 '1,': one servo here, no list; ", "ping 1, 2");
}

void test_range_from_larger_id_on_is_named(void)
{
    assert_reply("error 33: ID|254 '3-1': the range begins with the larger ID; ", "led 3-1 on");
    assert_reply("error 33: ID... '1,9-7': the range begins with the larger ID; ", "group 1,9-7");
    assert_reply("error 33: ID|254 5-300 is out of range: 0 to 254\r\n", "led 5-300 on");
}
