/* SPDX-License-Identifier: MIT */
/* From a move to the next: new targets of joints that move, and moves that wait. */
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

void test_new_target_gives_no_jump(void)
{
    int16_t last, step, last_step = 0;

    for (uint16_t at = 1; at < 370; at = (uint16_t)(at + 37 * AVR_DIVIDES_LOOPS)) {
        rig_begin_motion(0);
        feedback[0].position = 200;
        pose[0] = 800;
        rig_move(1500, CDS_MOTION_MINIMUM_JERK);
        last = 200;
        for (uint16_t i = 0; i < 1200; i++) {
            enum cds_result result = rig_pass_period();

            if (i == at) { // one more period passes
                last = (int16_t)goals[0];
                pose[0] = 300;
                rig_move(1500, CDS_MOTION_MINIMUM_JERK);
            }
            step = (int16_t)((int16_t)goals[0] - last);
            TEST_ASSERT_INT_WITHIN(2, last_step, step);
            last = (int16_t)goals[0];
            last_step = step;
            if (result == CDS_OK)
                break;
        }
        TEST_ASSERT_EQUAL_UINT16(300, goals[0]);
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    }
}

void test_joint_that_is_not_in_the_next_pose_brakes(void)
{
    uint16_t end;

    pose[0] = 900;
    rig_move(1500, CDS_MOTION_MINIMUM_JERK);
    for (uint8_t i = 0; i < 150; i++)
        rig_pass_period();
    pose[0] = CDS_POSE_NONE;
    pose[1] = 600;
    end = goals[0];
    rig_move(1000, CDS_MOTION_MINIMUM_JERK);
    while (rig_pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL_UINT16(600, goals[1]);
    TEST_ASSERT_INT_WITHIN(60, end + 60, goals[0]); // half of 250 ms at 0.47 steps per ms
}

/* Joint 0 goes from 100 towards 900 in `time_ms`; after `at` periods `second` replaces that
 * move. Returns the most steps between two goals of the second move. */
static uint16_t fastest_after_new_target(uint32_t time_ms, enum cds_motion_curve first, uint16_t at,
                                         struct cds_move *second)
{
    uint16_t last, most = 0;

    rig_begin_motion(0);
    feedback[0].position = 100;
    pose[0] = 900;
    rig_move(time_ms, first);
    for (uint16_t i = 0; i < at; i++)
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, second));
    do {
        last = feedback[0].position = goals[0];
        rig_pass_period();
        if (distance(last, goals[0]) > most)
            most = distance(last, goals[0]);
    } while (motion.result == CDS_PENDING || motion.move_result == CDS_PENDING);
    return most;
}

/* Full speed is 5.1 steps in a period. A joint that moves may be 1/8 too fast, and goals are
 * rounded. */
void test_new_target_with_a_short_ramp_keeps_full_speed(void)
{
    static uint16_t target[JOINTS];
    struct cds_move it = {.pose = target,
                          .may_take_longer = true,
                          .curve = CDS_MOTION_TRAPEZOID,
                          .acceleration = 60000};

    srand(1);
    memset(target, 0xFF, sizeof target);
    for (uint32_t ms = 4; ms < 900; ms += 4 * AVR_DIVIDES_LOOPS * AVR_DIVIDES_LOOPS)
        for (uint16_t at = 40; at < 160; at = (uint16_t)(at + 40 * AVR_DIVIDES_LOOPS)) {
            target[0] = (uint16_t)(random_below(1024));
            it.time_ms = ms;
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(
                6, fastest_after_new_target(700, CDS_MOTION_LINEAR, at, &it));
            TEST_ASSERT_EQUAL_UINT16(target[0], goals[0]);
        }
}

void test_new_target_after_a_linear_move_keeps_the_limits(void)
{
    static uint16_t target[JOINTS];
    struct cds_move it = {.pose = target, .may_take_longer = true};

    srand(2);
    memset(target, 0xFF, sizeof target);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 100, 900, 1023));
    states[0].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
    for (uint16_t i = 0; i < 1000 / AVR_DIVIDES_RANDOM; i++) {
        uint32_t ms = 640u + random_below(200);
        uint16_t at = (uint16_t)(ms / 4 - 1u - random_below(10));

        target[0] = (uint16_t)(100 + random_below(801));
        it.time_ms = 1u + random_below(3000);
        it.curve = random_below(2) ? CDS_MOTION_TRAPEZOID : CDS_MOTION_MINIMUM_JERK;
        it.acceleration = (uint16_t)(1000u + random_below(60000));
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(6,
                                         fastest_after_new_target(ms, CDS_MOTION_LINEAR, at, &it));
        TEST_ASSERT_EQUAL(CDS_OK, motion.result); // the permit refuses goals beyond 900
    }
}

/* The joint is at its limit: the window is one period. */
void test_new_target_at_a_limit_may_take_ten_minutes(void)
{
    for (uint32_t ms = 280000; ms <= 600000; ms += 10007ul * AVR_DIVIDES_LOOPS) {
        struct cds_move it = {.pose = pose, .time_ms = ms, .curve = CDS_MOTION_TRAPEZOID};

        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 900, 1023));
        states[0].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
        rig_begin_motion(0);
        feedback[0].position = 100;
        pose[0] = 900;
        rig_move(640, CDS_MOTION_LINEAR);
        for (uint8_t i = 0; i < 159; i++)
            rig_pass_period();
        TEST_ASSERT_TRUE(motion.is_under_way);
        pose[0] = 400;
        it.acceleration = 1000;
        TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
        for (uint16_t poll = 0; poll < 200 && motion.move_result == CDS_PENDING && !motion.is_ready;
             poll++)
            cds_motion_poll(&motion);
        TEST_ASSERT_EQUAL_UINT32(0, motion.shortest_ms);
        TEST_ASSERT_EQUAL(CDS_PENDING, motion.move_result);
        TEST_ASSERT_EQUAL_UINT32(1, motion.next_plan.window);
        cds_motion_abort(&motion, 60000);
        while (rig_pass_period() == CDS_PENDING) {
        }
    }
}

/* A joint at full speed gets a limit of 1 unit: no time is long enough. */
void test_new_target_beyond_ten_minutes_is_refused(void)
{
    static const uint16_t all[] = {1000, 4000, 65535};

    for (uint8_t i = 0; i < sizeof all / sizeof *all; i++) {
        struct cds_move it = {.pose = pose, .time_ms = 600000, .may_take_longer = true};

        feedback[0].position = 100;
        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 1023, 1023));
        rig_begin_cycle_and_motion(all[i]);
        pose[0] = 900;
        rig_move(700, CDS_MOTION_LINEAR);
        rig_pass_period();
        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 1023, 1));
        TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
        for (uint16_t poll = 0; poll < 2000 && motion.move_result == CDS_PENDING; poll++)
            cds_motion_poll(&motion);
        TEST_ASSERT_EQUAL(CDS_LIMIT, motion.move_result);
        TEST_ASSERT_EQUAL_UINT32(0, motion.shortest_ms);
        cds_motion_abort(&motion, 60000);
        while (rig_pass_period() == CDS_PENDING) {
        }
    }
}

/* ---- where the next move begins ---- */

/* The servo still reports that it is at 100. */
void test_waiting_move_is_checked_from_end_of_last_move(void)
{
    static uint16_t back[JOINTS];
    struct cds_move it = {.pose = back, .time_ms = 40, .waits = true};

    rig_begin_motion(0);
    feedback[0].position = 100;
    pose[0] = 900;
    rig_move(2000, CDS_MOTION_MINIMUM_JERK);
    memcpy(back, pose, sizeof back);
    back[0] = 100;
    for (uint8_t i = 0; i < 20; i++)
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_poll_motion();
    TEST_ASSERT_EQUAL(CDS_LIMIT, motion.move_result);
}

/* The servo reported 560 and then nothing any more. */
void test_move_begins_at_the_last_goal_if_feedback_is_old(void)
{
    rig_begin_motion(0);
    feedback[0].position = 500;
    pose[0] = 520;
    rig_move(200, CDS_MOTION_LINEAR);
    while (rig_pass_period() == CDS_PENDING) {
    }
    feedback[0].position = 560;
    port_fake.now_us += 600000;
    pose[0] = 530;
    rig_move(400, CDS_MOTION_LINEAR);
    TEST_ASSERT_UINT16_WITHIN(3, 520, (rig_pass_period(), goals[0]));
}

/* Nothing is under way: the move does not wait. The joint was turned from 520 to 300 by hand. */
void test_waiting_move_at_rest_begins_where_the_joint_is(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 300, .waits = true};

    rig_begin_motion(0);
    feedback[0].position = 500;
    pose[0] = 520;
    rig_move(200, CDS_MOTION_LINEAR);
    while (rig_pass_period() == CDS_PENDING) {
    }
    feedback[0].position = 300;
    pose[0] = 320;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_poll_motion();
    while (rig_pass_period() == CDS_PENDING)
        TEST_ASSERT_UINT16_WITHIN(10, 310, goals[0]);
    TEST_ASSERT_EQUAL_UINT16(320, goals[0]);
}

/* The move under way ends meanwhile. The servo lags behind: it still reports 440. */
void test_move_that_waits_begins_at_the_goal_it_was_checked_from(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 300, .waits = true};

    rig_begin_motion(0);
    feedback[0].position = 400;
    pose[0] = 500;
    rig_move(400, CDS_MOTION_LINEAR);
    for (uint8_t i = 0; i < 99; i++)
        rig_pass_period();
    feedback[0].position = 440;
    pose[0] = 510;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_send_goals_and_report();
    cds_motion_poll(&motion); // the last goals
    cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL_UINT8(JOINTS, motion.index);
    rig_send_goals_and_report();
    cds_motion_poll(&motion);
    TEST_ASSERT_FALSE(motion.is_under_way);
    TEST_ASSERT_EQUAL(CDS_PENDING, motion.move_result);
    rig_poll_motion();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    while (rig_pass_period() == CDS_PENDING)
        TEST_ASSERT_UINT16_WITHIN(5, 505, goals[0]);
    TEST_ASSERT_EQUAL_UINT16(510, goals[0]);
}
