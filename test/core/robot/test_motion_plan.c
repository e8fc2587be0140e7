/* SPDX-License-Identifier: MIT */
/* The check of a move: its duration, what is refused, and the limits of the joints. */
#include "cds55xx/motion.h"

#include <math.h>
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

/* Submits a move of joint 0 from 500 to 501 and checks it. */
static void plan_slowest_move(uint32_t time_ms, enum cds_motion_curve curve)
{
    struct cds_move it = {.pose = pose, .time_ms = time_ms, .curve = curve, .acceleration = 1000};

    pose[0] = 501;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_poll_motion();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
}

/* The bus needs longer periods for 7 joints than the shortest one: the cycle is not polled. */
void test_times_of_all_periods_are_exact_in_the_plan(void)
{
    static const uint16_t all[] = {200, 201, 1000, 4000, 10007, 65535};
    static const uint32_t times_ms[] = {66, 1000, 65536, 131072, 262144, 524288, 600000};

    for (uint8_t i = 0; i < sizeof all / sizeof *all; i++)
        for (uint8_t j = 0; j < sizeof times_ms / sizeof *times_ms; j++) {
            uint32_t time_ms = times_ms[j];
            uint32_t periods = (time_ms * 1000 + all[i] - 1) / all[i];
            uint64_t end; // of the clock: 2^48

            cycle.period_us = all[i];
            rig_begin_motion(0);
            plan_slowest_move(time_ms, (enum cds_motion_curve)(i % 4));
            TEST_ASSERT_EQUAL_UINT32(periods, motion.plan.duration);
            end = ((uint64_t)motion.plan.time.step << 16 | motion.plan.time.step_low) * periods;
            if (periods > 1)
                TEST_ASSERT_TRUE(end <= 1ull << 48 && (1ull << 48) - end <= periods);
        }
}

/* ---- time too short ---- */

static uint32_t shortest_ms(enum cds_motion_curve curve)
{
    rig_begin_motion(0);
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(4, curve));
    TEST_ASSERT_NOT_EQUAL(0, motion.shortest_ms);
    return motion.shortest_ms;
}

void test_time_too_short_is_refused_with_the_shortest_that_works(void)
{
    pose[2] = 510;
    pose[3] = 1000;
    for (uint8_t curve = 0; curve <= CDS_MOTION_BY_SERVO; curve++) {
        uint32_t ms = shortest_ms((enum cds_motion_curve)curve);

        TEST_ASSERT_EQUAL_UINT8(3, motion.joint);
        TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(ms - 4, (enum cds_motion_curve)curve));
        TEST_ASSERT_EQUAL(CDS_OK, rig_try_move(ms, (enum cds_motion_curve)curve));
        while (rig_pass_period() == CDS_PENDING)
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(1023, speeds[3]);
    }
}

void test_shortest_time_follows_speed_limit_and_acceleration(void)
{
    uint32_t ms;

    pose[3] = 1000;
    TEST_ASSERT_UINT32_WITHIN(8, 739,
                              shortest_ms(CDS_MOTION_MINIMUM_JERK)); // 15/8 x 500 / 1268.6 per s
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[3], 0, 1023, 512));
    ms = shortest_ms(CDS_MOTION_MINIMUM_JERK);
    TEST_ASSERT_UINT32_WITHIN(8, 1477, ms);
    rig_begin_motion(500);
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(ms, CDS_MOTION_MINIMUM_JERK));
    TEST_ASSERT_UINT32_WITHIN(20, 2158, motion.shortest_ms); // root of 5.774 x 403.2 / 500 s^2
}

void test_time_too_short_is_stretched_if_asked(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 4, .may_take_longer = true};

    pose[3] = 1000;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_poll_motion();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    while (rig_pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL_UINT16(1000, goals[3]);
    TEST_ASSERT_UINT32_WITHIN(2, 739 / 4, sent);
}

void test_trapezoid_keeps_the_acceleration_of_the_joints(void)
{
    uint32_t at_4000, at_1000;

    rig_begin_motion(4000);
    pose[0] = 900;
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(100, CDS_MOTION_TRAPEZOID));
    at_4000 = motion.shortest_ms;
    rig_begin_motion(1000);
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(100, CDS_MOTION_TRAPEZOID)); // it asks for 4000
    at_1000 = motion.shortest_ms;
    TEST_ASSERT_GREATER_THAN_UINT32(at_4000 * 3 / 2, at_1000);
    rig_move(at_1000, CDS_MOTION_TRAPEZOID);
    for (uint16_t last = 0; rig_pass_period() == CDS_PENDING; last = speeds[0])
        TEST_ASSERT_TRUE(last == 0 || distance(speeds[0], last) <= 4 + 5); // and the reserve
}

void test_time_too_short_to_pass_is_refused(void)
{
    for (uint32_t ms = 4; ms < 700; ms = ms * 3 / 2) {
        struct cds_move it = {.pose = pose, .time_ms = ms, .next_ms = ms};
        static uint16_t second[JOINTS];

        rig_begin_motion(0);
        feedback[0].position = 0;
        memcpy(second, pose, sizeof second);
        pose[0] = 511;
        second[0] = 1023;
        it.next_pose = second;
        TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
        for (uint16_t i = 0; i < 3 * JOINTS + 400; i++)
            cds_motion_poll(&motion);
        TEST_ASSERT_EQUAL(CDS_LIMIT, motion.move_result);
        TEST_ASSERT_GREATER_THAN_UINT32(ms, motion.shortest_ms);
    }
}

/* ---- rate of a move that begins or ends in motion ---- */

/* A move of one joint as real numbers: steps and periods. */
struct real_move {
    double distance, periods, begin_speed, end_speed;
};

static double greater(double a, double b)
{
    return a > b ? a : b;
}

/* The highest rate within `fastest` steps a period and `most` steps a period^2, 0: any. */
static double slow_rate(const struct real_move *move, double fastest, double most)
{
    double mean = move->distance / move->periods - (move->begin_speed + move->end_speed) / 2;
    double peak = 0, change = 0, rate = 2;

    for (uint16_t i = 0; i <= 200; i++) {
        double x = i / 200.0, y = 1 - x;
        double speed = mean * 30 * x * x * y * y +
                       move->begin_speed * (1 - 3 * x * x + 2 * x * x * x) +
                       move->end_speed * (1 - 3 * y * y + 2 * y * y * y);
        double acceleration =
            (mean * 60 * x * y * (y - x) + (move->end_speed - move->begin_speed) * 6 * x * y) /
            move->periods;

        peak = greater(peak, fabs(speed));
        change = greater(change, fabs(acceleration));
    }
    if (peak * rate > fastest)
        rate = fastest / peak;
    while (most > 0 && change * rate * rate > most)
        rate *= 0.999;
    return greater(rate, 1);
}

static double passing_speed_of(double before, double after)
{
    return before * after > 0 ? 2 * before * after / (before + after) : 0;
}

void test_rate_of_moves_that_pass_is_that_of_real_numbers(void)
{
    uint16_t places[4], tried = 0, faster = 0;
    static uint16_t next_pose[JOINTS];

    memset(next_pose, 0xFF, sizeof next_pose);
    for (uint16_t trial = 0; trial < 2000 / AVR_DIVIDES_RANDOM; trial++) {
        uint16_t acceleration = random_below(2) ? 8000 : 0;
        uint16_t times_ms[3];
        double speed = 0, step_speed;

        rig_begin_motion(acceleration);
        step_speed = 1023 * 16.0 / joints[0].scale; // steps a period
        feedback[0].position = places[0] = 500;
        for (uint8_t i = 0; i < 3; i++) {
            places[i + 1] = random_below(1024);
            times_ms[i] = (uint16_t)(4 * (50 + random_below(500)));
        }
        for (uint8_t i = 0; i < 2; i++) {
            struct cds_move it = {.pose = pose,
                                  .time_ms = times_ms[i],
                                  .next_pose = next_pose,
                                  .next_ms = times_ms[i + 1],
                                  .pass_rate = 2 * 65536};
            double to = (double)places[i + 1] - places[i];
            double behind = (double)places[i + 2] - places[i + 1];
            struct real_move move = {to, times_ms[i] / 4, speed, 0};
            double rate, most = acceleration * 16.0 * 0.004 / joints[0].scale;

            speed = move.end_speed =
                passing_speed_of(to / move.periods, behind / (times_ms[i + 1] / 4));
            pose[0] = places[i + 1];
            next_pose[0] = places[i + 2];
            TEST_ASSERT_EQUAL(CDS_OK, cds_motion_try(&motion, &it, i == 0));
            for (uint16_t polls = 0; polls < 8 * JOINTS && motion.is_trial; polls++)
                cds_motion_poll(&motion);
            if (motion.move_result != CDS_OK)
                break;
            rate = slow_rate(&move, step_speed, most);
            tried++;
            if (rate > 1.05)
                faster++;
            TEST_ASSERT_TRUE(motion.next_plan.rate_most < 65536 * rate * 1.02);
            TEST_ASSERT_TRUE(motion.next_plan.rate_most > 65536 * greater(rate * 0.9, 0.999));
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT16(600 / AVR_DIVIDES_RANDOM, tried);
    TEST_ASSERT_GREATER_THAN_UINT16(300 / AVR_DIVIDES_RANDOM, faster);
}

/* ---- joints and their limits ---- */

void test_goal_beyond_a_limit_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[2], 200, 800, 1023));
    pose[2] = 801;
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(5000, CDS_MOTION_LINEAR));
    TEST_ASSERT_EQUAL_UINT8(2, motion.joint);
    TEST_ASSERT_EQUAL_UINT32(0, motion.shortest_ms);
    pose[2] = 199;
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(5000, CDS_MOTION_LINEAR));
}

/* The joint was turned by hand. By the servo, its first goal is the goal of the move. */
void test_joint_that_rests_beyond_a_limit_is_refused(void)
{
    states[2].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[2], 200, 800, 1023));
    pose[2] = 600;
    for (uint8_t i = 0; i < 2; i++) {
        rig_begin_motion(0);
        feedback[2].position = i ? 199 - 40 : 801 + 40;
        TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(5000, CDS_MOTION_LINEAR));
        TEST_ASSERT_EQUAL_UINT8(2, motion.joint);
        TEST_ASSERT_EQUAL_UINT32(0, motion.shortest_ms);
        TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(5000, CDS_MOTION_MINIMUM_JERK));
        TEST_ASSERT_EQUAL(CDS_OK, rig_try_move(5000, CDS_MOTION_BY_SERVO));
        TEST_ASSERT_EQUAL(CDS_PENDING, rig_pass_period());
        TEST_ASSERT_EQUAL_UINT16(600, goals[2]);
    }
}

/* The load turns the joint 3 steps away from its goal, which is at the limit. */
void test_joint_near_its_goal_starts_from_there_in_the_first_move(void)
{
    states[2].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[2], 200, 500, 1023));
    rig_send_goals_and_report(); // 500
    feedback[2].position = 503;
    pose[2] = 400;
    rig_move(400, CDS_MOTION_MINIMUM_JERK);
    while (rig_pass_period() == CDS_PENDING)
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(500, goals[2]);
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(400, goals[2]);
}

void test_inhibited_joint_is_refused(void)
{
    pose[1] = 600;
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STOPPED);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, rig_try_move(1000, CDS_MOTION_LINEAR));
    TEST_ASSERT_EQUAL_UINT8(1, motion.joint);
}

void test_joint_of_unknown_position_is_refused(void)
{
    pose[4] = 600;
    feedback[4].known = false;
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, rig_try_move(1000, CDS_MOTION_LINEAR));
    TEST_ASSERT_EQUAL_UINT8(4, motion.joint);
}

void test_limit_holds_while_a_joint_turns_back(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 200, 700, 1023));
    states[0].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
    for (uint16_t at = 5; at < 125; at = (uint16_t)(at + 10 * AVR_DIVIDES_LOOPS)) {
        rig_begin_motion(0);
        feedback[0].position = 500;
        pose[0] = 700;
        rig_move(500, CDS_MOTION_MINIMUM_JERK);
        for (uint16_t i = 0; i < at; i++)
            rig_pass_period();
        pose[0] = 250;
        TEST_ASSERT_EQUAL(CDS_OK, rig_try_move(3000, CDS_MOTION_MINIMUM_JERK));
        while (rig_pass_period() == CDS_PENDING)
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(700, goals[0]);
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
        TEST_ASSERT_EQUAL_UINT16(250, goals[0]);
    }
}

/* The check of a move takes several periods, and joint 0 comes nearer to its limit meanwhile. Where
 * it stands after braking is within the limit, so that the next move is permitted. */
void test_joint_that_brakes_at_its_limit_stands_within_it(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000, .curve = CDS_MOTION_MINIMUM_JERK};

    for (uint16_t periods = 60; periods < 84; periods++) {
        setUp();
        states[0].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 300, 700, 1023));
        feedback[0].position = 300;
        pose[0] = 700;
        rig_move(340, CDS_MOTION_LINEAR);
        for (uint16_t i = 0; i < periods; i++)
            rig_pass_period();
        pose[0] = CDS_POSE_NONE;
        pose[1] = 505;
        TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
        while (motion.move_result == CDS_PENDING || motion.is_under_way) {
            rig_send_goals_and_report();
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(700, goals[0]);
            for (uint8_t i = 0; i < 10; i++)
                cds_motion_poll(&motion);
        }
        feedback[0].position = goals[0];
        pose[0] = 600;
        rig_move(2000, CDS_MOTION_MINIMUM_JERK);
        while (rig_pass_period() == CDS_PENDING)
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(700, goals[0]);
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    }
}
