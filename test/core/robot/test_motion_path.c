/* SPDX-License-Identifier: MIT */
/* The path of a move: every goal that leaves in a SYNC WRITE against the curve in real numbers, and
 * poses that a joint passes without a stop. The clock moves from one period to the next. */
#include "cds55xx/motion.h"

#include <math.h>
#include <stdio.h>
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

static double minimum_jerk(double t)
{
    return t * t * t * (10 + t * (6 * t - 15));
}

static double linear(double t)
{
    return t;
}

static void assert_goal(double expected, uint32_t period, uint32_t periods)
{
    char text[80];

    if (fabs(expected - goals[0]) <= 1)
        return;
    snprintf(text, sizeof text, "goal %u, expected %ld, in period %lu of %lu", goals[0],
             (long)expected, (unsigned long)period, (unsigned long)periods);
    TEST_FAIL_MESSAGE(text);
}

/* Moves joint 0 from `from` to `to`, and looks at each goal. */
static void check_way(uint16_t from, uint16_t to, uint32_t periods, enum cds_motion_curve curve,
                      double (*formula)(double))
{
    rig_begin_motion(0);
    feedback[0].position = from;
    pose[0] = to;
    rig_move(periods * (PERIOD_US / 1000), curve);
    for (uint32_t i = 1; i <= periods; i++) {
        enum cds_result result = rig_pass_period();

        assert_goal(from + ((int16_t)to - (int16_t)from) * formula((double)i / (double)periods), i,
                    periods);
        TEST_ASSERT_NOT_EQUAL(0, speeds[0]);
        TEST_ASSERT_EQUAL(i < periods ? CDS_PENDING : CDS_OK, result);
    }
    TEST_ASSERT_EQUAL_UINT16(to, goals[0]);
}

void test_joint_follows_its_curve_within_a_step(void)
{
    static const uint32_t periods[] = {379, 601, 5000 / AVR_DIVIDES_RANDOM + 379};

    for (uint8_t i = 0; i < sizeof periods / sizeof *periods; i++)
        for (uint16_t to = 0; to <= 1023;
             to = (uint16_t)(to + (AVR_DIVIDES_LOOPS > 1 ? 341 : 93))) {
            check_way(0, to, periods[i], CDS_MOTION_MINIMUM_JERK, minimum_jerk);
            check_way(1023, to, periods[i], CDS_MOTION_MINIMUM_JERK, minimum_jerk);
            check_way(511, to, periods[i], CDS_MOTION_LINEAR, linear);
        }
}

void test_trapezoid_keeps_its_acceleration(void)
{
    uint16_t last = 0;

    pose[0] = 900;
    rig_move(2000, CDS_MOTION_TRAPEZOID);
    while (rig_pass_period() == CDS_PENDING) {
        if (last)
            TEST_ASSERT_INT_WITHIN(16 + 1, last, speeds[0]); // 4000 units per second, 4 ms
        last = speeds[0];
    }
    TEST_ASSERT_EQUAL_UINT16(900, goals[0]);
    TEST_ASSERT_EQUAL_UINT32(500, sent);
}

void test_all_joints_arrive_with_the_same_goals_packet(void)
{
    uint16_t last[JOINTS];

    for (uint8_t i = 0; i < JOINTS; i++)
        pose[i] = (uint16_t)(i * 150);
    rig_move(1500, CDS_MOTION_MINIMUM_JERK);
    for (uint16_t i = 1; i < 375; i++) {
        TEST_ASSERT_EQUAL(CDS_PENDING, rig_pass_period());
        memcpy(last, goals, sizeof last);
    }
    for (uint8_t i = 0; i < JOINTS; i++)
        TEST_ASSERT_INT_WITHIN(1, pose[i], last[i]);
    TEST_ASSERT_EQUAL(CDS_OK, rig_pass_period());
    TEST_ASSERT_EQUAL_UINT16_ARRAY(pose, goals, JOINTS);
}

/* Speed x time between two goals is their distance, within what a unit of speed is. */
void test_speed_leads_to_the_next_goal(void)
{
    double way = 0;

    pose[0] = 100;
    rig_move(1800, CDS_MOTION_MINIMUM_JERK);
    do {
        rig_pass_period();
        way += (speeds[0] > 90 ? speeds[0] - 90 : 0) / 201.6129;
        TEST_ASSERT_INT_WITHIN(3, 500 - goals[0], (int)way);
    } while (motion.result == CDS_PENDING);
}

void test_by_servo_sends_one_goal_and_a_speed_for_each_joint(void)
{
    pose[0] = 900;
    pose[1] = 400;
    rig_move(1000, CDS_MOTION_BY_SERVO);
    for (uint16_t i = 1; i <= 250; i++) {
        TEST_ASSERT_EQUAL(i < 250 ? CDS_PENDING : CDS_OK, rig_pass_period());
        TEST_ASSERT_EQUAL_UINT16(900, goals[0]);
        TEST_ASSERT_EQUAL_UINT16(400, goals[1]);
        TEST_ASSERT_EQUAL_UINT16(323, speeds[0]); // 400 steps x 201.6 / 250
        TEST_ASSERT_EQUAL_UINT16(81, speeds[1]);
    }
}

void test_move_of_one_period_sends_its_goal_once(void)
{
    pose[0] = 501;
    rig_move(1, CDS_MOTION_LINEAR);
    TEST_ASSERT_EQUAL(CDS_OK, rig_pass_period());
    TEST_ASSERT_EQUAL_UINT16(501, goals[0]);
    TEST_ASSERT_EQUAL_UINT32(1, sent);
}

/* On the host the longest move, 10 minutes; on the AVR 3 s. */
void test_long_move_takes_its_time_in_periods(void)
{
    uint32_t periods = CDS_MOTION_TIME_MAX_MS / (PERIOD_US / 1000) / AVR_DIVIDES_RANDOM;

    check_way(0, 1023, periods, CDS_MOTION_MINIMUM_JERK, minimum_jerk);
}

void test_move_with_periods_of_65_ms_arrives_in_time(void)
{
    static const uint32_t times_ms[] = {1, 65, 66, 600000 / AVR_DIVIDES_RANDOM};

    for (uint8_t i = 0; i < sizeof times_ms / sizeof *times_ms; i++) {
        rig_begin_cycle_and_motion(65535);
        sent = 0;
        pose[0] = 501;
        rig_move(times_ms[i], CDS_MOTION_MINIMUM_JERK);
        while (rig_pass_period() == CDS_PENDING) {
        }
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
        TEST_ASSERT_EQUAL_UINT16(501, goals[0]);
        TEST_ASSERT_EQUAL_UINT32((times_ms[i] * 1000 + 65534) / 65535, sent);
    }
}

/* ---- through poses without a stop ---- */

/* Joint 0 goes by way of `via` to `end`, each within 1 s, and joint 1 by way of 600 back to 500.
 * Joint 2 goes to 550 in the second move. */
static void go_by_way_of(uint16_t via, uint16_t end)
{
    static uint16_t first[JOINTS], second[JOINTS];
    struct cds_move it = {.pose = first, .time_ms = 1000, .next_pose = second, .next_ms = 1000};

    memcpy(first, pose, sizeof first);
    memcpy(second, pose, sizeof second);
    first[0] = via;
    second[0] = end;
    first[1] = 600;
    second[1] = 500;
    second[2] = 550;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_poll_motion();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    it = (struct cds_move){.pose = second, .time_ms = 1000, .waits = true};
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
}

void test_joint_passes_a_pose_without_a_stop(void)
{
    rig_begin_motion(0);
    feedback[0].position = 200;
    go_by_way_of(400, 600);
    for (uint16_t i = 1; i <= 500; i++) {
        uint16_t last = goals[0];

        TEST_ASSERT_EQUAL(i < 500 ? CDS_PENDING : CDS_OK, rig_pass_period());
        if (i > 1)
            TEST_ASSERT_GREATER_OR_EQUAL_UINT16(last, goals[0]);
        if (i == 250) {
            TEST_ASSERT_EQUAL_UINT16(400, goals[0]);
            TEST_ASSERT_EQUAL_UINT16(600, goals[1]);
        }
        if (i > 245 && i < 255) // the mean speed of both ways, 200 steps x 201.6 / 250, and 1/4
            TEST_ASSERT_UINT16_WITHIN(8, 201, speeds[0]);
    }
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
    TEST_ASSERT_EQUAL_UINT16(500, goals[1]);
}

void test_joint_that_passes_never_turns_back(void)
{
    for (uint16_t via = 210; via < 600; via = (uint16_t)(via + 30 * AVR_DIVIDES_LOOPS)) {
        rig_begin_motion(0);
        feedback[0].position = 200;
        go_by_way_of(via, 600);
        rig_pass_period();
        while (motion.result == CDS_PENDING) {
            uint16_t last = goals[0];

            rig_pass_period();
            TEST_ASSERT_GREATER_OR_EQUAL_UINT16(last, goals[0]);
        }
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
        TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
    }
}

/* Joint 2 is in the pose of the next move only. */
void test_motion_that_passes_ends_if_next_move_is_inhibited(void)
{
    rig_begin_motion(0);
    feedback[0].position = 200;
    go_by_way_of(400, 600);
    cds_servos_inhibit(&servos, &states[2], CDS_INHIBIT_STOPPED);
    for (uint16_t i = 1; i <= 250; i++)
        TEST_ASSERT_EQUAL(i < 250 ? CDS_PENDING : CDS_OK, rig_pass_period());
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.move_result);
    TEST_ASSERT_EQUAL_UINT8(2, motion.joint);
    TEST_ASSERT_EQUAL_UINT16(400, goals[0]);
    TEST_ASSERT_EQUAL_UINT16(600, goals[1]);
    rig_pass_period();
    TEST_ASSERT_EQUAL_UINT16(400, goals[0]);
}

void test_inhibited_joint_ends_motion_and_drops_next_move(void)
{
    rig_begin_motion(0);
    feedback[0].position = 200;
    go_by_way_of(400, 600);
    cds_motion_poll(&motion); // the check of the next move goes on
    TEST_ASSERT_EQUAL(CDS_PENDING, motion.move_result);
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STOPPED);
    for (uint16_t i = 0; i < 70 && motion.result == CDS_PENDING; i++) // 250 ms
        rig_pass_period();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.move_result);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.result);
    TEST_ASSERT_LESS_THAN_UINT16(400, goals[0]);
}

void test_move_after_a_pass_without_a_next_move_begins_at_rest(void)
{
    static uint16_t next[JOINTS];
    struct cds_move it = {.pose = pose, .time_ms = 1000, .next_pose = next, .next_ms = 1000};

    rig_begin_motion(8000);
    memcpy(next, pose, sizeof next);
    pose[0] = 600;
    next[0] = 700;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_check_goals_rise_to(600);
    for (uint8_t i = 0; i < 20; i++)
        rig_pass_period();
    pose[0] = 650;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_motion_move(&motion, &(struct cds_move){.pose = pose, .time_ms = 2000}));
    rig_check_goals_rise_to(650);
}
