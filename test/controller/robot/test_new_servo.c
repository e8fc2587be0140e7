/* SPDX-License-Identifier: MIT */
/* The search for a new servo, and which servo is set up. Faults on the way:
 * test_new_servo_faults.c. */
#include "robot/new_servo.h"

#include "new_servo_rig.h"

void setUp(void)
{
    rig_open_new_servo();
}

void tearDown(void)
{
    rig_check();
}

static void know(uint8_t id)
{
    states[0].id = 5;
    states[1].id = id;
    known.count = 2;
}

void test_servo_at_listed_rate_is_set_up(void)
{
    servo_fake_put(0, 1, 34);
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, rig_run_new_servo());
    rig_assert_set_up();
    TEST_ASSERT_EQUAL_UINT8(1, servo.found[0].id);
    TEST_ASSERT_EQUAL_UINT8(34, servo.found[0].baud_reg);
    TEST_ASSERT_FALSE(servo.searched_any);
}

void test_servo_at_unlisted_rate_is_set_up(void)
{
    servo_fake_put(0, 200, 66);
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, rig_run_new_servo());
    rig_assert_set_up();
    TEST_ASSERT_TRUE(servo.searched_any);
}

void test_servo_near_a_listed_rate_is_set_up(void)
{
    servo_fake_put(0, 1, 99);
    servos.servo[0].neighbours = 4;
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, rig_run_new_servo());
    rig_assert_set_up();
    TEST_ASSERT_TRUE(servo.searched_any);
    TEST_ASSERT_EQUAL_UINT8(99, servo.found[0].baud_reg);
}

void test_servo_in_place_is_not_changed(void)
{
    servo_fake_put(0, NEW, HOME);
    servos.servo[0].table[0x05] = 1;
    rig_begin_new_servo();
    know(NEW); // as its reply to the search does if link_loss_ms is set
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, rig_run_new_servo());
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

void test_servo_that_is_not_alone_is_not_changed(void)
{
    servo_fake_put(0, 1, HOME);
    servo_fake_put(1, 2, 34);
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_NOT_ALONE, rig_run_new_servo());
    TEST_ASSERT_EQUAL_UINT8(2, servo.count);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

void test_known_id_at_rate_of_bus_is_not_changed(void)
{
    servo_fake_put(0, 1, HOME);
    know(1);
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_KNOWN, rig_run_new_servo());
    TEST_ASSERT_EQUAL_UINT8(1, servo.id);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

void test_known_id_at_another_rate_is_set_up(void)
{
    servo_fake_put(0, 1, 34);
    know(1);
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, rig_run_new_servo());
    rig_assert_set_up();
}

void test_no_servo_is_found(void)
{
    rig_begin_new_servo();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_NONE, rig_run_new_servo());
}

void test_abort_after_the_search_does_nothing(void)
{
    servo_fake_put(0, 1, 34);
    rig_begin_new_servo();
    while (new_servo_poll(&servo) == CDS_PENDING) {
        if (servo.step > NEW_SERVO_SEARCH_THERE)
            new_servo_abort(&servo);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, rig_run_new_servo());
    rig_assert_set_up();
}
