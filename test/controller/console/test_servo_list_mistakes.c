/* SPDX-License-Identifier: MIT */
/* Lists of servos in a line: what is refused, warnings, and what a user may have meant. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* A user who means servos 1 and 2 types `limits 1 2 10 20`. */
void test_number_with_id_of_servo_gives_warning(void)
{
    robot_add(&robot, 1);
    robot_add(&robot, 2);
    robot.health_pauses = true;
    TEST_ASSERT_EQUAL_STRING(
        "warning: 2 was read as a value, not as servo 2; a list of servos is one "
        "word: 1,2\r\nok\r\n",
        reply_to("limits 1 2 10 20"));
    reply_to("move 1 2 30");
    port_fake_transmit(&bus.link, 0);
    TEST_ASSERT_NOT_NULL(strstr(said, "warning: 2 was read as a value, not as servo 2; "));
}

void test_number_that_cannot_be_id_gives_no_warning(void)
{
    static const char *const lines[] = {"limits 1 2 10",       "limits 1 2deg 10 20",
                                        "limits 1 2 10 20rpm", "limits 1 3 10 20",
                                        "limits 1,2 2 10 20",  "limits 1 2.5 10 20"};

    robot_add(&robot, 1);
    robot_add(&robot, 2);
    robot.health_pauses = true;
    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        TEST_ASSERT_NULL_MESSAGE(strstr(reply_to(lines[i]), "warning"), lines[i]);
}

void test_list_with_wrong_words_is_refused(void)
{
    assert_error(ERROR_TWICE, "torque 1 1 on");
    assert_error(ERROR_TWICE, "torque 1-3,2 on");
    assert_error(ERROR_OUT_OF_RANGE, "torque 3-1 on");
    assert_error(ERROR_OUT_OF_RANGE, "torque 1-254 on");
    assert_error(ERROR_OUT_OF_RANGE, "torque 1 254 on");
    assert_error(ERROR_OUT_OF_RANGE, "torque 255 on");
    assert_error(ERROR_OUT_OF_RANGE, "torque -1 on");
    assert_error(ERROR_NOT_A_NUMBER, "torque 1- on");
    assert_error(ERROR_NOT_A_NUMBER, "torque 1, on");
    assert_error(ERROR_NOT_A_NUMBER, "torque ,1 on");
    assert_error(ERROR_NOT_A_NUMBER, "torque 1,all on");
    assert_error(ERROR_NOT_A_NUMBER, "torque alle on");
    assert_error(ERROR_NOT_A_NUMBER, "torque 1,2,3,4,5,6,7,8,9,10,11,12 on");
    assert_error(ERROR_TOO_MANY, "torque 1-60 on");
    assert_error(ERROR_UNKNOWN_WORD, "torque all 1 on");
    assert_error(ERROR_COUNT, "torque 1-3");
    assert_error(ERROR_COUNT, "get 1-3");
    assert_error(ERROR_COUNT, "get 1,2");
    assert_error(ERROR_COUNT, "set 1 2");
    assert_error(ERROR_COUNT, "set 1-3 LED");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

/* Several servos with one ID cannot be told apart. */
void test_id_takes_one_servo(void)
{
    static const char *const bad[] = {"id 2-3 7", "id 2,3 7", "id all 9", "id 1-1 7"};

    for (uint8_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_error(32, bad[i]);
    assert_error(31, "id 2 3 7");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
    reply_to("id 2 3");
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

void test_packet_takes_one_servo(void)
{
    assert_error(ERROR_NOT_A_NUMBER, "ping 1-3");
    assert_error(ERROR_NOT_A_NUMBER, "write all LED 1");
}

/* The refusal of the next servo in the list is in its line: the remedy of its alarm is not told. */
static void refuse(uint8_t id)
{
    command_set.unasked->remedied = 0;
    if (bus.link.state == CDS_LINK_TALKING)
        port_fake_transmit(&bus.link, 0);
    answer(id, CDS_ERROR_INSTRUCTION, NULL, 0);
    TEST_ASSERT_NOT_EQUAL_UINT16(0, command_set.unasked->remedied);
}

void test_each_refusal_in_a_list_counts_as_told(void)
{
    reply_to("torque 1 2 off");
    refuse(1);
    refuse(2);
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 2: "));
}

void test_warning_of_list_names_its_servo(void)
{
    reply_to("led 1 2 on");
    port_fake_transmit(&bus.link, 0);
    answer(1, CDS_ERROR_OVERHEATING, NULL, 0);
    port_fake_transmit(&bus.link, 0);
    answer(2, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("servo 1: ok\r\nwarning: servo 1: overheating; 'torque 1 off', unload "
                             "it; when cool, 'clear', 'release 1'\r\nservo 2: ok\r\nok\r\n",
                             said);
}

void test_refusal_in_list_names_servo_once(void)
{
    reply_to("led 1 2 on");
    port_fake_transmit(&bus.link, 0);
    answer(1, CDS_ERROR_RANGE, NULL, 0);
    port_fake_transmit(&bus.link, 0);
    answer(2, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING_LEN("servo 1: range error; ", said, 22);
}
