/* SPDX-License-Identifier: MIT */
/* The set-up of a new servo when packets are lost, the servo is lost or refuses, or the caller
 * aborts. */
#include "robot/new_servo.h"

#include "new_servo_rig.h"

/* The simulated AVR is slow: there the test of lost packets tries each FAULT_STEP-th packet, and
 * the test of abort one turn of the main loop of ABORT_FIRST to ABORT_LAST. */
#ifdef __AVR__
#define FAULT_STEP  7 // each of the three faults once
#define ABORT_FIRST 4 // a request is pending
#define ABORT_LAST  4
#else
#define FAULT_STEP  1
#define ABORT_FIRST 0
#define ABORT_LAST  16
#endif

void setUp(void)
{
    rig_open_new_servo();
}

void tearDown(void)
{
    rig_check();
}

void test_lost_packets_and_replies_of_set_up_are_tried_again(void)
{
    const uint16_t search = 254 * CDS_SCAN_LISTED_BAUDS;

    for (uint8_t at = 1; at <= 20; at = (uint8_t)(at + FAULT_STEP)) {
        setUp();
        servo_fake_put(0, 1, 34);
        rig_begin_new_servo();
        while (servos.packets < search) // struct servos_plan counts up to 255
            rig_turn_new_servo();
        servos.packets = 0;
        servos.plan[0] = (struct servos_plan){.at = at, .fault = (uint8_t)(LOSE_PACKET + at % 3)};
        TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, rig_run_new_servo());
        TEST_ASSERT_GREATER_OR_EQUAL_UINT16(at, servos.packets); // the fault has happened
        rig_assert_set_up();
    }
}

void test_servo_lost_after_write_of_id_ends_as_lost(void)
{
    servo_fake_put(0, 1, HOME);
    rig_begin_new_servo();
    while (servo.step != NEW_SERVO_SET_ID)
        rig_turn_new_servo();
    while (servos.servo[0].table[0x03] != NEW)
        rig_turn_new_servo();
    servos.servo[0].there = false;
    servos.packets = 0;
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_LOST, rig_run_new_servo());
    TEST_ASSERT_LESS_THAN_UINT16(50, servos.packets);
}

void test_locked_servo_ends_as_refused(void)
{
    servo_fake_put(0, 1, HOME);
    servos.servo[0].table[0x2F] = 1;
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_FAILED, rig_run_new_servo());
    TEST_ASSERT_EQUAL_UINT8(CDS_REFUSED, servo.result);
}

void test_two_servos_with_one_id_end_as_damaged(void)
{
    servo_fake_put(0, 1, HOME);
    servo_fake_put(1, 1, HOME);
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_DAMAGED, rig_run_new_servo());
    TEST_ASSERT_TRUE(servo.searched_any);
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_SEARCH_ANY, servo.step);
}

/* Aborts `turns` turns of the main loop after `step` has begun. The servo is at an unlisted rate; a
 * byte without a packet leads to NEW_SERVO_MEND_ALL. */
static void check_abort(enum new_servo_step step, uint16_t turns)
{
    uint16_t packets;

    setUp();
    servo_fake_put(0, 1, 2);
    rig_begin_new_servo();
    if (step == NEW_SERVO_MEND_ALL) {
        rig_turn_new_servo();
        port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1);
    }
    while (servo.step != step) {
        TEST_ASSERT_FALSE(servo.is_ending);
        rig_turn_new_servo();
    }
    for (uint16_t i = 0; i < turns; i++)
        rig_turn_new_servo();
    packets = servos.packets;
    new_servo_abort(&servo);
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_ENDED, rig_run_new_servo());
    TEST_ASSERT_EQUAL_UINT8(step, servo.step);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(packets + 1, servos.packets); // that was pending
}

void test_abort_ends_each_search(void)
{
    for (uint16_t turns = 0; turns < 12000; turns = (uint16_t)(turns * 2 + 1))
        check_abort(NEW_SERVO_SEARCH_LISTED, turns);
    for (uint16_t turns = ABORT_FIRST; turns <= ABORT_LAST; turns++) {
        check_abort(NEW_SERVO_MEND_ALL, turns);
        check_abort(NEW_SERVO_SEARCH_ANY, turns);
        check_abort(NEW_SERVO_SEARCH_THERE, turns);
    }
}
