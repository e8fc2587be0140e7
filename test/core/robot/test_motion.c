/* SPDX-License-Identifier: MIT */
/* Motions: bad arguments, trouble on the way, the work of a poll, and random orders. Other suites
 * test the check of a move (test_motion_plan.c), its goals (test_motion_path.c), the move after it
 * (test_motion_next.c), and pause, abort and override (test_motion_pause.c). */
#include "cds55xx/motion.h"

#include <stdlib.h> // srand()
#include <string.h>

#include "motion_rig.h"

void setUp(void)
{
    rig_begin_moves();
}

void tearDown(void)
{
    rig_check();
}

void test_period_below_200_us_is_refused(void)
{
    struct cds_motion_config config = {.cycle = &cycle, .joints = joints};

    cycle.period_us = 199;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_begin(&motion, &config));
    cycle.period_us = 200;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_begin(&motion, &config));
}

void test_servo_too_slow_for_the_numbers_of_a_motion_is_refused(void)
{
    static const struct cds_register_profile slow = {.full_speed_mrpm = 3051},
                                             enough = {.full_speed_mrpm = 3052};
    const struct cds_register_profile *profiles[JOINTS];
    struct cds_motion_config config = {.cycle = &cycle, .joints = joints, .profiles = profiles};

    for (uint8_t i = 0; i < JOINTS; i++)
        profiles[i] = &enough;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_begin(&motion, &config));
    profiles[JOINTS - 1] = &slow;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_begin(&motion, &config));
}

/* Nothing changes but the note of the move, for cds_motion_text(). */
static void check_refused(const struct cds_move *move, enum cds_result expected)
{
    struct cds_motion before;

    memcpy(&before, &motion, sizeof before);
    TEST_ASSERT_EQUAL(expected, cds_motion_move(&motion, move));
    memcpy(&before.next, &motion.next, sizeof before.next);
    before.wrong_argument = motion.wrong_argument;
    TEST_ASSERT_EQUAL_MEMORY(&before, &motion, sizeof before);
}

void test_move_with_bad_arguments_changes_no_motion(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    check_refused(&it, CDS_BAD_ARGUMENT); // no joint
    pose[0] = 1024;
    check_refused(&it, CDS_BAD_ARGUMENT);
    pose[0] = 600;
    it.time_ms = 0;
    check_refused(&it, CDS_BAD_ARGUMENT);
    it.time_ms = CDS_MOTION_TIME_MAX_MS + 1;
    check_refused(&it, CDS_BAD_ARGUMENT);
    it.time_ms = CDS_MOTION_TIME_MAX_MS;
    it.curve = CDS_MOTION_BY_SERVO + 1;
    check_refused(&it, CDS_BAD_ARGUMENT);
    it.curve = CDS_MOTION_TRAPEZOID;
    check_refused(&it, CDS_BAD_ARGUMENT);
    it.acceleration = 1;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    check_refused(&it, CDS_BUSY);
}

void test_acceleration_of_register_is_250_units_per_s(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, cds_motion_acceleration(0));
    TEST_ASSERT_EQUAL_UINT16(8000, cds_motion_acceleration(32));
    TEST_ASSERT_EQUAL_UINT16(63750, cds_motion_acceleration(255));
}

/* ---- trouble on the way ---- */

void test_motion_without_its_cycle_ends_as_inhibited(void)
{
    for (uint8_t again = 0; again < 2; again++) {
        rig_begin_cycle_and_motion(PERIOD_US);
        pose[0] = 800;
        rig_move(1000, CDS_MOTION_LINEAR);
        rig_pass_period();
        cds_cycle_abort(&cycle);
        if (again)
            rig_begin_cycle_again(PERIOD_US);
        cds_motion_poll(&motion);
        TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.result);
        TEST_ASSERT_FALSE(cds_motion_is_busy(&motion));
    }
}

/* The move is checked; before it begins, a servo is silent for 0.6 s. */
void test_joint_without_feedback_when_its_move_begins_ends_it(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    pose[0] = pose[1] = 800;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    while (!motion.is_ready)
        cds_motion_poll(&motion);
    for (uint8_t i = 0; i < JOINTS; i++)
        feedback[i].time_us = port_fake.now_us + 600000 - (i == 1 ? 600000 : 0);
    port_fake.now_us += 600000;
    for (uint8_t i = 0; i < 60; i++)
        cds_motion_poll(&motion);
    for (uint8_t i = 0; i < 70; i++) // 250 ms
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, motion.result);
    TEST_ASSERT_EQUAL_UINT8(1, motion.joint);
}

void test_joint_that_is_inhibited_on_the_way_ends_the_motion(void)
{
    pose[0] = 900;
    pose[1] = 600;
    rig_move(2000, CDS_MOTION_MINIMUM_JERK);
    for (uint8_t i = 0; i < 200; i++)
        rig_pass_period();
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STOPPED);
    for (uint8_t i = 0; i < 70 && motion.result == CDS_PENDING; i++)
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.result);
    TEST_ASSERT_EQUAL_UINT8(1, motion.joint);
    TEST_ASSERT_LESS_THAN_UINT16(800, goals[0]);
}

/* ---- work of a poll ---- */

/* A joint that begins a move divides: two of them at most in a poll, whether they are in the pose
 * of the move or brake. */
void test_polls_begin_at_most_two_joints(void)
{
    for (uint8_t i = 0; i < JOINTS; i++)
        pose[i] = 600;
    rig_move(1000, CDS_MOTION_LINEAR);
    for (uint8_t i = 0; i < 100; i++)
        rig_pass_period();
    for (uint8_t i = 1; i < JOINTS; i++)
        pose[i] = CDS_POSE_NONE;
    pose[0] = 700;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_motion_move(&motion, &(struct cds_move){.pose = pose,
                                                                  .time_ms = 1000,
                                                                  .curve = CDS_MOTION_LINEAR}));
    while (motion.move_result == CDS_PENDING) {
        uint8_t begun = motion.begun;

        if (motion.index == JOINTS && !cds_bus_is_busy(&bus) && motion.is_ready)
            rig_send_goals_and_report();
        cds_motion_poll(&motion);
        if (motion.begun > begun)
            TEST_ASSERT_LESS_OR_EQUAL_UINT8(begun + 2, motion.begun);
    }
    for (uint8_t begun = motion.begun; begun < JOINTS; begun = motion.begun) {
        cds_motion_poll(&motion);
        TEST_ASSERT_LESS_OR_EQUAL_UINT8(begun + 2, motion.begun);
    }
}

void test_polls_set_at_most_six_goals(void)
{
    uint16_t polls = 0;

    for (uint8_t i = 0; i < JOINTS; i++)
        pose[i] = 600;
    rig_move(1000, CDS_MOTION_MINIMUM_JERK);
    rig_send_goals_and_report();
    cds_motion_poll(&motion); // a new period
    for (; motion.index < JOINTS; polls++)
        cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL_UINT16((JOINTS + 5) / 6, polls);
}

/* ---- at random ---- */

static void submit_at_random(void)
{
    struct cds_move it = {.pose = pose,
                          .time_ms = 1u + random_below(3000),
                          .curve = (uint8_t)random_below(4),
                          .may_take_longer = random_below(2),
                          .waits = random_below(4) == 0,
                          .acceleration = (uint16_t)(1000u + random_below(8000))};

    if (cds_motion_is_busy(&motion))
        return;
    for (uint8_t i = 0; i < JOINTS; i++)
        pose[i] = random_below(3) ? (uint16_t)(100u + random_below(800)) : CDS_POSE_NONE;
    cds_motion_move(&motion, &it);
}

static void act_at_random(void)
{
    switch (random_below(40)) {
    case 0: cds_motion_pause(&motion, (uint16_t)(500u + random_below(8000))); break;
    case 1:
    case 2: cds_motion_resume(&motion); break;
    case 3: cds_motion_abort(&motion, (uint16_t)(500u + random_below(8000))); break;
    case 4: cds_motion_set_override(&motion, (uint8_t)(10u + random_below(191))); break;
    case 5:
    case 6: submit_at_random(); break;
    default: break;
    }
}

/* A servo goes at most 5 steps in a period. */
static void approach(uint16_t *position, uint16_t goal)
{
    int16_t way = (int16_t)(goal - *position);

    *position = (uint16_t)(*position + (uint16_t)(way > 5 ? 5 : way < -5 ? -5 : way));
}

/* Whatever the program asks for: no goal is beyond its limits or further from the last one, or from
 * the joint, than the joint can go, and no speed is 0 or above its limit. A goal by the servo is an
 * exception. */
void test_goals_stay_within_limits_at_random(void)
{
    uint16_t last[JOINTS];
    uint32_t moves = 0;

    srand(1);
    for (uint8_t i = 0; i < JOINTS; i++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[i], 90, 910, 800));
        states[i].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
        last[i] = 500;
    }
    for (uint32_t period = 0; period < 200000ul / AVR_DIVIDES_RANDOM; period++) {
        bool was_checking;

        act_at_random();
        was_checking = motion.move_result == CDS_PENDING;
        rig_pass_period();
        for (uint8_t i = 0; i < JOINTS; i++) {
            TEST_ASSERT_UINT16_WITHIN(410, 500, goals[i]);
            TEST_ASSERT_TRUE(speeds[i] > 0 && speeds[i] <= 800);
            if (motion.plan.curve.kind != CDS_MOTION_BY_SERVO) // 900 / 201.6, and rounding
                TEST_ASSERT_TRUE(distance(last[i], goals[i]) <= 6 ||
                                 distance(feedback[i].position, goals[i]) <= 12);
            last[i] = goals[i];
            approach(&feedback[i].position, goals[i]);
        }
        if (was_checking && motion.move_result == CDS_OK)
            moves++;
        TEST_ASSERT_NOT_EQUAL(CDS_INHIBITED, motion.result);
        TEST_ASSERT_NOT_EQUAL(CDS_BAD_ARGUMENT, motion.result);
        if (motion.result == CDS_LIMIT)
            TEST_FAIL_MESSAGE("a goal on the way was refused");
    }
    TEST_ASSERT_GREATER_THAN_UINT32(1000ul / AVR_DIVIDES_RANDOM, moves);
}
