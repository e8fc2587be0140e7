/* SPDX-License-Identifier: MIT */
/* Lists of servos in a line: what the parser takes, and how the command runs for each servo. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* The next packet leaves, and servo `id` acknowledges it. */
static void acknowledge(uint8_t id)
{
    if (bus.link.state == CDS_LINK_TALKING)
        port_fake_transmit(&bus.link, 0);
    TEST_ASSERT_EQUAL_UINT8(id, port_fake.sent[2]);
    answer(id, 0, NULL, 0);
}

static void answer_byte(uint8_t id, uint8_t byte)
{
    if (bus.link.state == CDS_LINK_TALKING)
        port_fake_transmit(&bus.link, 0);
    TEST_ASSERT_EQUAL_UINT8(id, port_fake.sent[2]);
    answer(id, 0, &byte, 1);
}

/* The servo that was asked last does not answer. */
static void stay_silent(void)
{
    if (bus.link.state == CDS_LINK_TALKING)
        port_fake_transmit(&bus.link, 0);
    port_fake.now_us += 1000000;
    type("");
    port_fake.now_us += CDS_STALE_REPLY_US;
    type("");
}

void test_torque_of_three_servos_has_line_for_each(void)
{
    reply_to("torque 1 2 3 off");
    acknowledge(1);
    acknowledge(2);
    acknowledge(3);
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nservo 2: ok\r\nservo 3: ok\r\nok\r\n", said);
}

/* The next packet is the READ of mode, torque and speed, and servo `id` answers it. */
static void answer_look(uint8_t id, uint16_t cw_limit, uint8_t torque)
{
    uint8_t registers[28] = {(uint8_t)cw_limit, (uint8_t)(cw_limit >> 8), [18] = torque};

    if (bus.link.state == CDS_LINK_TALKING)
        port_fake_transmit(&bus.link, 0);
    TEST_ASSERT_EQUAL_UINT8(id, port_fake.sent[2]);
    TEST_ASSERT_EQUAL_UINT8(CDS_READ, port_fake.sent[CDS_AT_INSTRUCTION]);
    answer(id, 0, registers, sizeof registers);
}

void test_torque_on_of_a_list_reads_each_servo_before(void)
{
    reply_to("torque 1-3 on");
    answer_look(1, 1, 0);
    acknowledge(1);
    answer_look(2, 0, 1); // endless turn with torque on
    acknowledge(2);
    answer_look(3, 0, 0);
    acknowledge(3); // speed 0
    acknowledge(3);
    assert_sent("FF FF 03 04 03 18 01 DC");
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nservo 2: ok\r\nservo 3: endless turn: speed set to "
                             "0\r\nok\r\n",
                             said);
}

void test_list_with_silent_servo_goes_on_and_ends_in_error(void)
{
    reply_to("led 1-3 on");
    acknowledge(1);
    stay_silent();
    acknowledge(3);
    TEST_ASSERT_NOT_NULL(strstr(said, "servo 1: ok\r\nservo 2: no reply by the deadline; "));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 3: ok\r\nerror 87: "));
}

void test_same_error_in_a_list_tells_its_remedy_once(void)
{
    reply_to("led 1-3 on");
    stay_silent();
    stay_silent();
    acknowledge(3);
    TEST_ASSERT_NOT_NULL(strstr(said, "servo 1: no reply by the deadline; "));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 2: no reply by the deadline\r\nservo 3: ok\r\n"));
}

/* `led 1-3 on`, and no servo answers; servo `id` is known to be at another rate than the bus. */
static void no_reply_with_other_rate_of(uint8_t id)
{
    begin_console();
    robot.health_pauses = true;
    for (uint8_t i = 1; i <= 3; i++)
        robot_add(&robot, i);
    robot.states[id - 1].baud_reg = 16;
    reply_to("led 1-3 on");
    for (uint8_t i = 1; i <= 3; i++)
        stay_silent();
}

void test_same_error_of_two_causes_tells_both(void)
{
    no_reply_with_other_rate_of(1);
    TEST_ASSERT_NOT_NULL(strstr(said, "servo 1: not at the rate of the bus"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 2: no reply by the deadline; check power"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 3: no reply by the deadline\r\n"));
    no_reply_with_other_rate_of(2);
    TEST_ASSERT_NOT_NULL(strstr(said, "servo 1: no reply by the deadline; check power"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 2: not at the rate of the bus"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 3: no reply by the deadline; check power"));
}

void test_limits_of_each_servo_of_a_list_are_told(void)
{
    uint8_t registers[19] = {[2] = 0xFF, [3] = 3}; // limits and torque: position mode, off

    robot.health_pauses = true;
    for (uint8_t i = 1; i <= 2; i++)
        robot_add(&robot, i);
    reply_to("limits 1,2 60 200");
    reply_to("move 1,2 250");
    answer(1, 0, registers, sizeof registers);
    if (bus.link.state == CDS_LINK_TALKING)
        port_fake_transmit(&bus.link, 0);
    answer(2, 0, registers, sizeof registers);
    TEST_ASSERT_NOT_NULL(strstr(said, "servo 1: the angle is not within its limits, "));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 2: the angle is not within its limits, "));
}

void test_address_in_decimal_follows_a_range(void)
{
    reply_to("get 1-2 25");
    answer_byte(1, 0);
    answer_byte(2, 1);
    TEST_ASSERT_EQUAL_STRING("servo 1: LED = 0\r\nservo 2: LED = 1\r\nok\r\n", said);
    reply_to("set 7,8 25 1");
    acknowledge(7);
    acknowledge(8);
    TEST_ASSERT_EQUAL_STRING("servo 7: ok\r\nservo 8: ok\r\nok\r\n", said);
    assert_error(ERROR_COUNT, "get 1-3");
    assert_error(ERROR_COUNT, "set 1-3 25");
}

void test_list_all_is_taken_in_any_case(void)
{
    assert_error(ERROR_NOT_KNOWN, "led ALL on");
}

void test_id_twice_before_a_register_is_refused(void)
{
    assert_error(ERROR_TWICE, "get 1 1 LED");
    assert_error(ERROR_TWICE, "get 1-3,2 25");
}

void test_list_of_ranges_and_commas_in_one_word(void)
{
    reply_to("led 1,7-8,3 on");
    acknowledge(1);
    acknowledge(7);
    acknowledge(8);
    acknowledge(3);
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nservo 7: ok\r\nservo 8: ok\r\nservo 3: ok\r\nok\r\n",
                             said);
}

void test_list_all_is_servos_of_robot_in_order_of_id(void)
{
    robot_add(&robot, 9);
    robot_add(&robot, 4);
    robot.health_pauses = true; // only the console sends
    reply_to("led all off");
    acknowledge(4);
    acknowledge(9);
    TEST_ASSERT_EQUAL_STRING("servo 4: ok\r\nservo 9: ok\r\nok\r\n", said);
}

void test_list_all_of_one_servo_runs_as_one_servo(void)
{
    robot_add(&robot, 9);
    robot.health_pauses = true;
    reply_to("led all off");
    acknowledge(9);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_list_all_without_known_servo_is_refused(void)
{
    assert_error(ERROR_NOT_KNOWN, "led all on");
    assert_error(ERROR_NOT_KNOWN, "monitor all");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_get_prints_value_behind_each_servo(void)
{
    reply_to("get 1 2 LED");
    answer_byte(1, 0);
    answer_byte(2, 1);
    TEST_ASSERT_EQUAL_STRING("servo 1: LED = 0\r\nservo 2: LED = 1\r\nok\r\n", said);
}

void test_get_and_set_take_address_in_decimal_as_before(void)
{
    reply_to("get 1 25");
    answer_byte(1, 1);
    TEST_ASSERT_EQUAL_STRING("LED = 1\r\nok\r\n", said);
    reply_to("set 1 25 1");
    assert_sent("FF FF 01 04 03 19 01 DD");
    answer(1, 0, NULL, 0);
    reply_to("set 1 30 512raw");
    assert_sent("FF FF 01 05 03 1E 00 02 D6");
    answer(1, 0, NULL, 0);
    reply_to("set 1 30 150");
    assert_sent("FF FF 01 05 03 1E 00 02 D6");
    answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_set_takes_list_before_decimal_address(void)
{
    reply_to("set 1 2 25 1");
    acknowledge(1);
    acknowledge(2);
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nservo 2: ok\r\nok\r\n", said);
}

void test_set_takes_hexadecimal_address_behind_list(void)
{
    reply_to("set 1 2 0x19 1");
    acknowledge(1);
    acknowledge(2);
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nservo 2: ok\r\nok\r\n", said);
}

/* `limits` sends no packet. */
void test_list_before_number_is_one_word(void)
{
    robot_add(&robot, 1);
    robot_add(&robot, 2);
    robot.health_pauses = true;
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nservo 2: ok\r\nok\r\n", reply_to("limits 1-2 0 150"));
    TEST_ASSERT_EQUAL_UINT16(512, robot.states[0].highest);
    TEST_ASSERT_EQUAL_UINT16(512, robot.states[1].highest);
}

void test_error_of_begin_is_told_behind_servo(void)
{
    robot_add(&robot, 1);
    robot.health_pauses = true;
    reply_to("limits 1,5 0 150");
    TEST_ASSERT_EQUAL_STRING_LEN("servo 1: ok\r\nservo 5: not one of the robot's servos; ", said,
                                 53);
    TEST_ASSERT_NOT_NULL(strstr(said, "error 87: "));
}

void test_monitor_and_group_take_ranges(void)
{
    TEST_ASSERT_EQUAL_STRING("group 1 2 3 7 sync\r\nok\r\n", reply_to("group 1-3 7"));
    TEST_ASSERT_EQUAL_STRING("group 1 2 3 7 action\r\nok\r\n", reply_to("group all action"));
    assert_error(ERROR_TOO_MANY, "monitor 1-9");
}

void test_id_254_is_packet_to_all_servos(void)
{
    reply_to("led 254 on");
    assert_sent("FF FF FE 04 03 19 01 E0");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_stop_ends_list(void)
{
    reply_to("led 1-3 on");
    type("\x18");
    acknowledge(1);
    TEST_ASSERT_NOT_NULL(strstr(said, "error 54: "));
    TEST_ASSERT_NULL(strstr(said, "servo 2: ok"));
}
