/* SPDX-License-Identifier: MIT */
/* Joints that do not follow their goals. The test sets goals and feedback. */
#include "cds55xx/follow.h"

#define JOINTS 3

#include "joints_rig.h"

#define PERIOD_US 4000

static struct cds_follow follow;
static struct cds_follow_joint joints[JOINTS];
static uint32_t now_us;

static void begin_with(const struct cds_follow_config *config)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_follow_begin(&follow, config));
}

void setUp(void)
{
    rig_begin_joints(500);
    rig_begin_cycle(PERIOD_US);
    now_us = port_fake.now_us = 67000000; // the 16-bit time of a joint overflows in the test
    for (uint8_t i = 0; i < JOINTS; i++)
        feedback[i].time_us = now_us;
    begin_with(&(struct cds_follow_config){.cycle = &cycle, .joints = joints});
}

void tearDown(void)
{
}

static void set_goal(uint8_t joint, uint16_t position)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, joint, position, 1));
    cds_cycle_commit(&cycle);
}

/* The time passes, and all joints are read and compared. */
static enum cds_result pass_us(uint32_t us)
{
    now_us += us;
    port_fake.now_us = now_us;
    for (uint8_t i = 0; i < JOINTS; i++)
        feedback[i].time_us = now_us;
    for (uint8_t i = 0; i < JOINTS; i++)
        cds_follow_poll(&follow);
    return (enum cds_result)follow.result;
}

/* 10 ms pass. */
static enum cds_result pass(void)
{
    return pass_us(10000);
}

/* Returns the time until the report in ms, or 0 if none comes within 1 s. */
static uint16_t report_ms(void)
{
    for (uint16_t ms = 10; ms <= 1000; ms = (uint16_t)(ms + 10))
        if (pass() == CDS_TIMEOUT)
            return ms;
    return 0;
}

void test_follow_joint_is_stuck_reports_it_in_time(void)
{
    set_goal(1, 500 + CDS_FOLLOW_STEPS + 1);
    TEST_ASSERT_UINT16_WITHIN(10, CDS_FOLLOW_MS + 10, report_ms());
    TEST_ASSERT_EQUAL_UINT8(1, follow.joint);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, pass()); // it stays so
    begin_with(&(struct cds_follow_config){.cycle = &cycle, .joints = joints});
    TEST_ASSERT_EQUAL(CDS_PENDING, pass());
}

void test_follow_joint_within_the_steps_reports_nothing(void)
{
    set_goal(1, 500 + CDS_FOLLOW_STEPS);
    TEST_ASSERT_EQUAL_UINT16(0, report_ms());
}

/* The time starts at each part of a unit of the 16-bit clock (1024 us). */
void test_follow_reports_after_time_ms_and_2_ms_more_at_most(void)
{
    static const uint16_t times_ms[] = {1, 2, 200, 60000};

    for (uint8_t i = 0; i < sizeof times_ms / sizeof times_ms[0]; i++) {
        for (uint8_t j = 0; j < 16; j++) {
            uint32_t time_us = 1000ul * times_ms[i];

            begin_with(&(struct cds_follow_config){
                .cycle = &cycle, .joints = joints, .time_ms = times_ms[i]});
            set_goal(1, 500 + CDS_FOLLOW_STEPS + 1);
            TEST_ASSERT_EQUAL(CDS_PENDING, pass_us(1024 + 64));
            for (uint8_t part = 0; part < 4; part++)
                TEST_ASSERT_EQUAL(CDS_PENDING, pass_us(time_us / 4 - (part == 3)));
            TEST_ASSERT_EQUAL(CDS_TIMEOUT, pass_us(2049));
        }
    }
}

void test_follow_with_own_limits_uses_them(void)
{
    struct cds_follow_config config = {
        .cycle = &cycle, .joints = joints, .steps = 10, .time_ms = 500};

    begin_with(&config);
    set_goal(2, 489);
    TEST_ASSERT_UINT16_WITHIN(10, 510, report_ms());
    TEST_ASSERT_EQUAL_UINT8(2, follow.joint);
    config.steps = 1024;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_follow_begin(&follow, &config));
    config.steps = 10;
    config.time_ms = 60001;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_follow_begin(&follow, &config));
}

void test_follow_joint_comes_nearer_reports_nothing(void)
{
    set_goal(0, 1000);
    for (uint8_t i = 0; i < 100; i++) { // 1 step in 50 ms
        if (i % 5 == 0)
            feedback[0].position++;
        TEST_ASSERT_EQUAL(CDS_PENDING, pass());
    }
}

void test_follow_joint_was_at_its_goal_starts_the_time_again(void)
{
    for (uint8_t i = 0; i < 3; i++) {
        set_goal(0, 600);
        for (uint8_t j = 0; j < 15; j++)
            TEST_ASSERT_EQUAL(CDS_PENDING, pass());
        set_goal(0, 510);
        TEST_ASSERT_EQUAL(CDS_PENDING, pass());
    }
}

void test_follow_joint_never_catches_up_reports_it(void)
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

void test_follow_goal_returns_to_stuck_joint_reports_it(void)
{
    uint16_t goal = 700;

    for (uint8_t i = 0; i < 22; i++) {
        set_goal(0, goal = (uint16_t)(goal - 5));
        pass();
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, follow.result);
}

void test_follow_polls_without_new_feedback_report_nothing(void)
{
    set_goal(0, 700);
    pass();
    for (uint16_t i = 0; i < 1000; i++)
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_follow_poll(&follow));
}

/* Its servo has no power any more. The other joints are read. */
void test_follow_joint_falls_silent_reports_it(void)
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

/* A line that was held low: the goals have gone on, and no joint could be read. */
void test_follow_counts_a_gap_as_half_of_the_time(void)
{
    set_goal(1, 900);
    port_fake.now_us += 1000ul * 2 * CDS_FOLLOW_MS - 20000;
    for (uint8_t i = 0; i < JOINTS; i++) // with the feedback from before the gap
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_follow_poll(&follow));
    now_us = port_fake.now_us;
    TEST_ASSERT_UINT16_WITHIN(15, CDS_FOLLOW_MS / 2 + 10, report_ms());
    TEST_ASSERT_EQUAL_UINT8(1, follow.joint);
}

/* A main loop so slow that each joint is read each 0.3 s. */
void test_follow_joint_that_is_read_seldom_is_reported(void)
{
    uint8_t reads = 0;

    set_goal(1, 900);
    while (pass_us(300000) == CDS_PENDING && reads < 10)
        reads++;
    TEST_ASSERT_EQUAL_UINT8(2, reads);
    TEST_ASSERT_EQUAL_UINT8(1, follow.joint);
}

/* The time of a joint restarts with its next report. */
void test_follow_skips_a_silent_joint_if_asked_to(void)
{
    begin_with(
        &(struct cds_follow_config){.cycle = &cycle, .joints = joints, .skips_silent = true});
    set_goal(1, 1000);
    TEST_ASSERT_EQUAL(CDS_PENDING, pass());
    for (uint16_t ms = 0; ms < 1000; ms = (uint16_t)(ms + 10)) {
        now_us += 10000;
        port_fake.now_us = now_us;
        feedback[0].time_us = feedback[2].time_us = now_us;
        for (uint8_t i = 0; i < JOINTS; i++)
            TEST_ASSERT_EQUAL(CDS_PENDING, cds_follow_poll(&follow));
    }
    TEST_ASSERT_UINT16_WITHIN(10, CDS_FOLLOW_MS + 10, report_ms());
    TEST_ASSERT_EQUAL_UINT8(1, follow.joint);
}

void test_follow_waits_time_ms_and_200_ms_for_a_report(void)
{
    for (uint8_t i = 0; i < 16; i++) {
        begin_with(&(struct cds_follow_config){.cycle = &cycle, .joints = joints, .time_ms = 1});
        TEST_ASSERT_EQUAL(CDS_PENDING, pass_us(1024 + 64));
        port_fake.now_us = now_us + 1000ul * (1 + CDS_FOLLOW_MS) - 1;
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_follow_poll(&follow));
        port_fake.now_us += 2049;
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_follow_poll(&follow));
    }
}

void test_follow_joint_without_feedback_or_goal_is_ignored(void)
{
    feedback[0].known = false;
    set_goal(0, 1000);
    TEST_ASSERT_EQUAL_UINT16(0, report_ms());
    feedback[0].known = true;
    cycle.is_committed = false; // as before the first goals
    TEST_ASSERT_EQUAL_UINT16(0, report_ms());
}
