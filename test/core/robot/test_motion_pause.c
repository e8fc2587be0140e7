/* SPDX-License-Identifier: MIT */
/* Pause, abort and override of a move: how joints slow down and speed up, and what follows. */
#include "cds55xx/motion.h"

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

/* Submits a move of joint 0 from 200 to 600, and pauses it before it is checked. */
static void pause_unchecked(const struct cds_move *move)
{
    rig_begin_motion(0);
    feedback[0].position = 200;
    pose[0] = 600;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, move));
    cds_motion_pause(&motion, 8000);
}

void test_pause_holds_a_move_that_is_checked(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    pause_unchecked(&it);
    rig_poll_motion();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    TEST_ASSERT_TRUE(motion.result == CDS_PENDING && motion.is_paused);
    cds_motion_resume(&motion);
    for (uint16_t i = 0; i < 400 && motion.result == CDS_PENDING; i++) {
        for (uint8_t poll = 0; poll < 2 * JOINTS; poll++)
            cds_motion_poll(&motion);
        rig_pass_period();
    }
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
}

/* Periods until the joints stand still, and the greatest change of speed between two of them. */
static uint16_t slow_down(int16_t *change)
{
    uint16_t periods = 0, last = speeds[0];

    *change = 0;
    for (; speeds[0] > 1 && motion.result == CDS_PENDING && periods < 1000; periods++) {
        uint16_t at = goals[0];

        rig_pass_period();
        if ((int16_t)(last - speeds[0]) > *change)
            *change = (int16_t)(last - speeds[0]);
        last = speeds[0];
        if (goals[0] == at && motion.basis.is_at_rest)
            break;
    }
    return periods;
}

static void go_half_way(void)
{
    rig_begin_motion(0);
    feedback[0].position = 200;
    pose[0] = 800;
    rig_move(1500, CDS_MOTION_LINEAR);
    for (uint16_t i = 0; i < 180; i++)
        rig_pass_period();
}

void test_pause_then_resume_reaches_the_pose(void)
{
    int16_t change;
    uint16_t at;

    go_half_way();
    cds_motion_pause(&motion, 2000);
    TEST_ASSERT_INT_WITHIN(6, 40, slow_down(&change)); // 322 units at 8 a period
    TEST_ASSERT_LESS_OR_EQUAL_INT16(13, change);       // 8, and the reserve
    at = goals[0];
    for (uint8_t i = 0; i < 50; i++)
        TEST_ASSERT_EQUAL(CDS_PENDING, rig_pass_period());
    TEST_ASSERT_EQUAL_UINT16(at, goals[0]);
    cds_motion_resume(&motion);
    for (uint8_t i = 0; i < 35; i++) {
        uint16_t last = speeds[0];

        rig_pass_period();
        TEST_ASSERT_TRUE(i == 0 || speeds[0] <= last + 13);
    }
    while (rig_pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(800, goals[0]);
}

/* A pause stops a move half way. The next move is submitted then, and the motion is resumed after
 * `polls` polls. */
static void check_resumed_at(uint8_t polls)
{
    static uint16_t back[JOINTS];
    uint16_t last;

    go_half_way();
    cds_motion_pause(&motion, 8000);
    for (uint8_t i = 0; i < 60; i++)
        rig_pass_period();
    last = feedback[0].position = goals[0];
    memcpy(back, pose, sizeof back);
    back[0] = 200;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_motion_move(&motion, &(struct cds_move){.pose = back, .time_ms = 2000}));
    for (uint8_t i = 0; i < polls; i++)
        cds_motion_poll(&motion);
    cds_motion_resume(&motion);
    for (uint16_t i = 0; i < 700 && motion.result == CDS_PENDING; i++) {
        rig_send_goals_and_report();
        for (uint8_t poll = 0; poll < 5; poll++) // the check lasts several periods
            cds_motion_poll(&motion);
        TEST_ASSERT_UINT16_WITHIN(12, last, goals[0]);
        last = goals[0];
    }
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(200, goals[0]);
}

void test_move_submitted_before_a_resume_gives_no_jump(void)
{
    for (uint8_t polls = 0; polls < 3 * JOINTS; polls++)
        check_resumed_at(polls);
}

void test_pause_ends_with_the_refusal_of_its_move(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 4};

    rig_begin_motion(0);
    pose[0] = 900;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 8000);
    rig_poll_motion();
    TEST_ASSERT_EQUAL(CDS_LIMIT, motion.move_result);
    it.time_ms = 1000;
    pose[0] = 510;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    for (uint16_t i = 0; i < 300 && rig_pass_period() == CDS_PENDING; i++) {
    }
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
}

void test_pause_during_a_trial_does_nothing(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 400};

    rig_begin_motion(0);
    pose[0] = 520;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_try(&motion, &it, true));
    cds_motion_pause(&motion, 8000);
    rig_poll_motion();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    rig_move(400, CDS_MOTION_LINEAR);
    for (uint8_t i = 0; i < 110; i++)
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(520, goals[0]);
}

/* The highest speed is 322 units; 500 units per second are 2 in a period. */
static void check_speeds_up_at_500(void)
{
    uint16_t periods = 0;

    for (uint16_t last = 0; motion.rate < 65536 && periods < 1000; periods++, last = speeds[0]) {
        rig_pass_period();
        TEST_ASSERT_TRUE(periods == 0 || speeds[0] <= last + 2 + 2); // and the reserve
    }
    TEST_ASSERT_UINT16_WITHIN(10, 161, periods); // 62 within a quarter of a second
}

void test_pause_before_the_first_goal_keeps_its_deceleration(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1500, .curve = CDS_MOTION_LINEAR};

    rig_begin_motion(0);
    feedback[0].position = 200;
    pose[0] = 800;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 500);
    for (uint8_t i = 0; i < 10; i++)
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    cds_motion_resume(&motion);
    check_speeds_up_at_500();
}

/* The rate of a slow move falls in larger steps than that of a fast move. */
void test_paused_move_after_a_slower_one_keeps_the_deceleration(void)
{
    rig_begin_motion(0);
    feedback[0].position = 200;
    pose[0] = 230;
    rig_move(1500, CDS_MOTION_LINEAR);
    for (uint8_t i = 0; i < 10; i++)
        rig_pass_period();
    cds_motion_pause(&motion, 500);
    for (uint8_t i = 0; i < 40; i++)
        rig_pass_period();
    pose[0] = 800;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_motion_move(&motion, &(struct cds_move){.pose = pose,
                                                                  .time_ms = 1500,
                                                                  .curve = CDS_MOTION_LINEAR}));
    for (uint8_t i = 0; i < 10; i++)
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    cds_motion_resume(&motion);
    check_speeds_up_at_500();
}

/* ---- abort ---- */

void test_abort_ends_at_a_standstill(void)
{
    int16_t change;
    uint16_t at;

    go_half_way();
    cds_motion_abort(&motion, 4000);
    TEST_ASSERT_INT_WITHIN(4, 20, slow_down(&change));
    TEST_ASSERT_LESS_OR_EQUAL_INT16(25, change); // 16, and the reserve
    rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    at = goals[0];
    rig_pass_period();
    TEST_ASSERT_EQUAL_UINT16(at, goals[0]);
    TEST_ASSERT_INT_WITHIN(30, 500, at);
}

void test_abort_during_check_cancels_the_move(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    pose[0] = 600;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_poll(&motion);
    cds_motion_abort(&motion, 1000);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.move_result);
    for (uint8_t i = 0; i < 10; i++)
        TEST_ASSERT_EQUAL(CDS_CANCELLED, rig_pass_period());
    TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
}

void test_move_after_an_abort_begins_at_rest(void)
{
    int16_t change;
    uint16_t at;

    go_half_way();
    cds_motion_abort(&motion, 4000);
    slow_down(&change);
    at = goals[0];
    feedback[0].position = at;
    pose[0] = 200;
    rig_move(1500, CDS_MOTION_MINIMUM_JERK);
    rig_pass_period();
    TEST_ASSERT_INT_WITHIN(2, at, goals[0]);
    while (rig_pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL_UINT16(200, goals[0]);
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
}

/* It would be checked from the end of the move that is aborted, where no joint will be. */
void test_move_that_waits_is_refused_during_an_abort(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1500, .waits = true};

    go_half_way();
    cds_motion_abort(&motion, 4000);
    rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_motion_move(&motion, &it));
    while (rig_pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
}

/* The move takes the place of an abort that slows down at 100. */
void test_move_in_place_of_an_abort_is_at_full_rate_within_250_ms(void)
{
    go_half_way();
    cds_motion_abort(&motion, 100);
    for (uint8_t i = 0; i < 100; i++)
        rig_pass_period();
    TEST_ASSERT_TRUE(motion.is_under_way && motion.rate < 60000);
    pose[0] = 200;
    rig_move(3000, CDS_MOTION_MINIMUM_JERK);
    for (uint8_t i = 0; i < 64; i++)
        rig_pass_period();
    TEST_ASSERT_EQUAL_UINT32(65536, motion.rate);
}

/* As `pause`, then `motion off`, while the next step of a sequence is checked. */
void test_move_paused_before_its_first_goal_can_be_ended(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    pause_unchecked(&it);
    for (uint8_t i = 0; i < 20; i++)
        rig_pass_period();
    cds_motion_abort(&motion, 8000);
    for (uint8_t i = 0; i < 5; i++)
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    TEST_ASSERT_FALSE(cds_motion_is_busy(&motion));
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
}

/* A joint went from 500 to 500 + `way`; the next move begins paused and is aborted. Then the joint
 * goes 50 steps further. */
static void check_move_after_an_abort_before_the_first_goal(uint16_t way, bool waits, bool resumes)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    setUp();
    pose[0] = (uint16_t)(500 + way);
    rig_move(1000, CDS_MOTION_MINIMUM_JERK);
    while (rig_pass_period() == CDS_PENDING) {
    }
    feedback[0].position = goals[0];
    pose[0] = 450;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 8000);
    for (uint8_t i = 0; i < 10; i++)
        rig_pass_period();
    if (resumes)
        cds_motion_resume(&motion);
    cds_motion_abort(&motion, 8000);
    rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    it.waits = waits;
    pose[0] = (uint16_t)(550 + way);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_check_goals_rise_to(pose[0]);
}

void test_move_after_an_abort_before_the_first_goal_does_not_jump(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        check_move_after_an_abort_before_the_first_goal(14, i & 1, i & 2);
        check_move_after_an_abort_before_the_first_goal(100, i & 1, i & 2);
    }
}

/* ---- override ---- */

static uint32_t periods_at(uint8_t percent)
{
    rig_begin_motion(0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, percent));
    feedback[0].position = 500;
    pose[0] = 520;
    sent = 0;
    rig_move(400, CDS_MOTION_MINIMUM_JERK);
    while (rig_pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL_UINT16(520, goals[0]);
    return sent;
}

void test_override_changes_the_time(void)
{
    TEST_ASSERT_UINT32_WITHIN(2, 100, periods_at(100));
    TEST_ASSERT_UINT32_WITHIN(2, 50, periods_at(200));
    TEST_ASSERT_UINT32_WITHIN(2, 200, periods_at(50));
    TEST_ASSERT_UINT32_WITHIN(5, 1000, periods_at(10));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_set_override(&motion, 9));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_set_override(&motion, 201));
}

void test_override_stays_within_the_speed_limit(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 1023, 100));
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, 200));
    pose[0] = 600;
    rig_move(2000, CDS_MOTION_MINIMUM_JERK);
    while (rig_pass_period() == CDS_PENDING)
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(100, speeds[0]);
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
    TEST_ASSERT_UINT32_WITHIN(3, 378, sent);
}

void test_override_does_not_end_a_pause(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 100};

    rig_begin_motion(0);
    pose[0] = 520;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    while (rig_pass_period() == CDS_PENDING) {
    }
    pose[0] = 510;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 8000);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, 50));
    for (uint8_t i = 0; i < 60; i++)
        rig_pass_period();
    TEST_ASSERT_TRUE(motion.is_paused && motion.result == CDS_PENDING);
    TEST_ASSERT_EQUAL_UINT16(520, goals[0]);
}

/* A pause slows down within its deceleration; the override has a time of its own. */
void test_override_after_a_pause_changes_within_250_ms(void)
{
    go_half_way();
    cds_motion_pause(&motion, 100);
    rig_pass_period();
    cds_motion_resume(&motion);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, 50));
    for (uint8_t i = 0; i < 64; i++) // 256 ms
        rig_pass_period();
    TEST_ASSERT_EQUAL_UINT32(32768, motion.rate);
}
