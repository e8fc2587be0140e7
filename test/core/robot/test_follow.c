/* SPDX-License-Identifier: MIT */
/* Joints that do not follow their goals. The test sets goals and feedback. */
#include "cds55xx/follow.h"

#define JOINTS 3

#include "joints_rig.h"

#define PERIOD_US 4000

static struct cds_follow follow;
static struct cds_follow_joint joints[JOINTS];
static uint32_t now_us;

void setUp(void)
{
    rig_begin_joints(500);
    rig_begin_cycle(PERIOD_US);
    now_us = port_fake.now_us = 67000000; // the 16-bit time of a joint overflows in the test
    for (uint8_t i = 0; i < JOINTS; i++)
        feedback[i].time_us = now_us;
    TEST_ASSERT_EQUAL(CDS_OK, cds_follow_begin(&follow, &(struct cds_follow_config){
                                                            .cycle = &cycle, .joints = joints}));
}

void tearDown(void)
{
}

static void set_goal(uint8_t joint, uint16_t position)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, joint, position, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
}

/* 10 ms pass, and all joints are read and compared. */
static enum cds_result pass(void)
{
    now_us += 10000;
    port_fake.now_us = now_us;
    for (uint8_t i = 0; i < JOINTS; i++)
        feedback[i].time_us = now_us;
    for (uint8_t i = 0; i < JOINTS; i++)
        cds_follow_poll(&follow);
    return (enum cds_result)follow.result;
}

/* Returns the time until the report in ms, or 0 if none comes within 1 s. */
static uint16_t report_ms(void)
{
    for (uint16_t ms = 10; ms <= 1000; ms = (uint16_t)(ms + 10))
        if (pass() == CDS_TIMEOUT)
            return ms;
    return 0;
}

void test_joint_that_is_stuck_is_reported_in_time(void)
{
    set_goal(1, 500 + CDS_FOLLOW_STEPS + 1);
    TEST_ASSERT_UINT16_WITHIN(10, CDS_FOLLOW_MS + 10, report_ms());
    TEST_ASSERT_EQUAL_UINT8(1, follow.joint);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, pass()); // it stays so
    TEST_ASSERT_EQUAL(CDS_OK, cds_follow_begin(&follow, &(struct cds_follow_config){
                                                            .cycle = &cycle, .joints = joints}));
    TEST_ASSERT_EQUAL(CDS_PENDING, pass());
}

void test_joint_within_the_steps_is_not_reported(void)
{
    set_goal(1, 500 + CDS_FOLLOW_STEPS);
    TEST_ASSERT_EQUAL_UINT16(0, report_ms());
}

void test_values_of_the_program_count(void)
{
    struct cds_follow_config config = {
        .cycle = &cycle, .joints = joints, .steps = 10, .time_ms = 500};

    TEST_ASSERT_EQUAL(CDS_OK, cds_follow_begin(&follow, &config));
    set_goal(2, 489);
    TEST_ASSERT_UINT16_WITHIN(10, 510, report_ms());
    TEST_ASSERT_EQUAL_UINT8(2, follow.joint);
    config.steps = 1024;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_follow_begin(&follow, &config));
    config.steps = 10;
    config.time_ms = 60001;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_follow_begin(&follow, &config));
}

void test_joint_that_comes_nearer_is_not_reported(void)
{
    set_goal(0, 1000);
    for (uint8_t i = 0; i < 100; i++) { // 1 step in 50 ms
        if (i % 5 == 0)
            feedback[0].position++;
        TEST_ASSERT_EQUAL(CDS_PENDING, pass());
    }
}

void test_joint_that_was_at_its_goal_has_the_whole_time_again(void)
{
    for (uint8_t i = 0; i < 3; i++) {
        set_goal(0, 600);
        for (uint8_t j = 0; j < 15; j++)
            TEST_ASSERT_EQUAL(CDS_PENDING, pass());
        set_goal(0, 510);
        TEST_ASSERT_EQUAL(CDS_PENDING, pass());
    }
}

void test_joint_that_never_catches_up_is_reported(void)
{
    uint16_t goal = 600;

    for (uint8_t i = 0; i < 15; i++) { // both move, and the distance stays
        set_goal(0, goal = (uint16_t)(goal + 5));
        feedback[0].position = (uint16_t)(goal - 100);
        TEST_ASSERT_EQUAL(CDS_PENDING, pass());
    }
    for (uint8_t i = 0; i < 7; i++) {
        set_goal(0, goal = (uint16_t)(goal + 5));
        feedback[0].position = (uint16_t)(goal - 100);
        pass();
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, follow.result);
}

void test_goal_that_comes_back_to_a_stuck_joint_is_no_progress(void)
{
    uint16_t goal = 700;

    for (uint8_t i = 0; i < 22; i++) {
        set_goal(0, goal = (uint16_t)(goal - 5));
        pass();
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, follow.result);
}

void test_old_feedback_does_not_let_the_time_pass(void)
{
    set_goal(0, 700);
    pass();
    for (uint16_t i = 0; i < 1000; i++)
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_follow_poll(&follow));
}

/* Its servo has no power any more. The other joints are read. */
void test_joint_that_does_not_report_any_more_is_reported(void)
{
    uint16_t ms = 0;

    do {
        now_us += 10000;
        port_fake.now_us = now_us;
        feedback[0].time_us = feedback[2].time_us = now_us;
        for (uint8_t i = 0; i < JOINTS; i++)
            cds_follow_poll(&follow);
        ms = (uint16_t)(ms + 10);
    } while (follow.result == CDS_PENDING && ms < 1000);
    TEST_ASSERT_UINT16_WITHIN(20, 2 * CDS_FOLLOW_MS, ms);
    TEST_ASSERT_EQUAL_UINT8(1, follow.joint);
}

void test_joint_without_feedback_or_goal_is_not_compared(void)
{
    feedback[0].known = false;
    set_goal(0, 1000);
    TEST_ASSERT_EQUAL_UINT16(0, report_ms());
    feedback[0].known = true;
    cycle.is_committed = false; // as before the first goals
    TEST_ASSERT_EQUAL_UINT16(0, report_ms());
}
