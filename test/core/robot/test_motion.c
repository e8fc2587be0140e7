/* SPDX-License-Identifier: MIT */
/* Timed moves: every goal that leaves in a SYNC WRITE against the curve in real numbers. The clock
 * moves from one period to the next. */
#include "cds55xx/motion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "motion_rig.h"

#define PERIOD_US 4000
#define SIZE      (8 + 5 * JOINTS)

#ifdef __AVR__
#define FEW  300 // the simulated AVR is slower
#define SOME 8
#else
#define FEW  1
#define SOME 1
#endif

static uint16_t pose[JOINTS];

static uint32_t sent; // SYNC WRITEs

static void begin_cycle(uint16_t period_us)
{
    rig_begin_cycle(period_us);
    rig_begin_motion(0);
}

void setUp(void)
{
    rig_begin_joints(500);
    begin_cycle(PERIOD_US);
    memset(pose, 0xFF, sizeof pose); // CDS_POSE_NONE
    sent = 0;
}

void tearDown(void)
{
    rig_check();
}

/* The goals leave, and all servos report. */
static void send_goals(void)
{
    rig_send_goals();
    TEST_ASSERT_EQUAL_UINT16(SIZE, port_fake.sent_size);
    for (uint8_t i = 0; i < JOINTS; i++)
        feedback[i].time_us = port_fake.now_us;
}

/* The goals leave, and the motion sets those of the next period. Returns what its last poll has
 * returned. */
static enum cds_result pass_period(void)
{
    enum cds_result result = CDS_OK;

    send_goals();
    sent++;
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        result = cds_motion_poll(&motion);
    return result;
}

/* Returns what became of the move. If another one is under way, a period passes. */
static enum cds_result try_move(uint32_t time_ms, enum cds_motion_curve curve)
{
    struct cds_move it = {.pose = pose, .time_ms = time_ms, .curve = curve, .acceleration = 4000};

    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
    if (motion.move_result == CDS_PENDING)
        pass_period();
    return (enum cds_result)motion.move_result;
}

static void move(uint32_t time_ms, enum cds_motion_curve curve)
{
    TEST_ASSERT_EQUAL(CDS_OK, try_move(time_ms, curve));
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
    move(periods * (PERIOD_US / 1000), curve);
    for (uint32_t i = 1; i <= periods; i++) {
        enum cds_result result = pass_period();

        assert_goal(from + ((int16_t)to - (int16_t)from) * formula((double)i / (double)periods), i,
                    periods);
        TEST_ASSERT_NOT_EQUAL(0, speeds[0]);
        TEST_ASSERT_EQUAL(i < periods ? CDS_PENDING : CDS_OK, result);
    }
    TEST_ASSERT_EQUAL_UINT16(to, goals[0]);
}

void test_joint_follows_its_curve_within_a_step(void)
{
    static const uint32_t periods[] = {379, 601, 5000 / FEW + 379};

    for (uint8_t i = 0; i < sizeof periods / sizeof *periods; i++)
        for (uint16_t to = 0; to <= 1023; to = (uint16_t)(to + 93 * FEW)) {
            check_way(0, to, periods[i], CDS_MOTION_MINIMUM_JERK, minimum_jerk);
            check_way(1023, to, periods[i], CDS_MOTION_MINIMUM_JERK, minimum_jerk);
            check_way(511, to, periods[i], CDS_MOTION_LINEAR, linear);
        }
}

void test_trapezoid_keeps_its_acceleration(void)
{
    uint16_t last = 0;

    pose[0] = 900;
    move(2000, CDS_MOTION_TRAPEZOID);
    while (pass_period() == CDS_PENDING) {
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
    move(1500, CDS_MOTION_MINIMUM_JERK);
    for (uint16_t i = 1; i < 375; i++) {
        TEST_ASSERT_EQUAL(CDS_PENDING, pass_period());
        memcpy(last, goals, sizeof last);
    }
    for (uint8_t i = 0; i < JOINTS; i++)
        TEST_ASSERT_INT_WITHIN(1, pose[i], last[i]);
    TEST_ASSERT_EQUAL(CDS_OK, pass_period());
    TEST_ASSERT_EQUAL_UINT16_ARRAY(pose, goals, JOINTS);
}

/* Speed x time between two goals is their distance, within what a unit of speed is. */
void test_speed_leads_to_the_next_goal(void)
{
    double way = 0;

    pose[0] = 100;
    move(1800, CDS_MOTION_MINIMUM_JERK);
    do {
        pass_period();
        way += (speeds[0] > 90 ? speeds[0] - 90 : 0) / 201.6129;
        TEST_ASSERT_INT_WITHIN(3, 500 - goals[0], (int)way);
    } while (motion.result == CDS_PENDING);
}

void test_by_servo_sends_one_goal_and_a_speed_for_each_joint(void)
{
    pose[0] = 900;
    pose[1] = 400;
    move(1000, CDS_MOTION_BY_SERVO);
    for (uint16_t i = 1; i <= 250; i++) {
        TEST_ASSERT_EQUAL(i < 250 ? CDS_PENDING : CDS_OK, pass_period());
        TEST_ASSERT_EQUAL_UINT16(900, goals[0]);
        TEST_ASSERT_EQUAL_UINT16(400, goals[1]);
        TEST_ASSERT_EQUAL_UINT16(323, speeds[0]); // 400 steps x 201.6 / 250
        TEST_ASSERT_EQUAL_UINT16(81, speeds[1]);
    }
}

void test_move_of_one_period_sends_its_goal_once(void)
{
    pose[0] = 501;
    move(1, CDS_MOTION_LINEAR);
    TEST_ASSERT_EQUAL(CDS_OK, pass_period());
    TEST_ASSERT_EQUAL_UINT16(501, goals[0]);
    TEST_ASSERT_EQUAL_UINT32(1, sent);
}

void test_move_of_ten_minutes_takes_150000_periods(void)
{
    uint32_t periods = 600000 / 4 / FEW;

    check_way(0, 1023, periods, CDS_MOTION_MINIMUM_JERK, minimum_jerk);
}

/* Submits a move of joint 0 from 500 to 501 and checks it. */
static void plan_slowest_move(uint32_t time_ms, enum cds_motion_curve curve)
{
    struct cds_move it = {.pose = pose, .time_ms = time_ms, .curve = curve, .acceleration = 1000};

    pose[0] = 501;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
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

void test_move_with_periods_of_65_ms_arrives_in_time(void)
{
    static const uint32_t times_ms[] = {1, 65, 66, 600000 / FEW};

    for (uint8_t i = 0; i < sizeof times_ms / sizeof *times_ms; i++) {
        begin_cycle(65535);
        sent = 0;
        pose[0] = 501;
        move(times_ms[i], CDS_MOTION_MINIMUM_JERK);
        while (pass_period() == CDS_PENDING) {
        }
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
        TEST_ASSERT_EQUAL_UINT16(501, goals[0]);
        TEST_ASSERT_EQUAL_UINT32((times_ms[i] * 1000 + 65534) / 65535, sent);
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
        begin_cycle(all[i]);
        pose[0] = 900;
        move(700, CDS_MOTION_LINEAR);
        pass_period();
        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 1023, 1));
        TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
        for (uint16_t poll = 0; poll < 2000 && motion.move_result == CDS_PENDING; poll++)
            cds_motion_poll(&motion);
        TEST_ASSERT_EQUAL(CDS_LIMIT, motion.move_result);
        TEST_ASSERT_EQUAL_UINT32(0, motion.shortest_ms);
        cds_motion_abort(&motion, 60000);
        while (pass_period() == CDS_PENDING) {
        }
    }
}

/* ---- feasible or refused ---- */

static uint32_t shortest_ms(enum cds_motion_curve curve)
{
    rig_begin_motion(0);
    TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(4, curve));
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
        TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(ms - 4, (enum cds_motion_curve)curve));
        TEST_ASSERT_EQUAL(CDS_OK, try_move(ms, (enum cds_motion_curve)curve));
        while (pass_period() == CDS_PENDING)
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
    TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(ms, CDS_MOTION_MINIMUM_JERK));
    TEST_ASSERT_UINT32_WITHIN(20, 2158, motion.shortest_ms); // root of 5.774 x 403.2 / 500 s^2
}

void test_time_too_short_is_stretched_if_asked(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 4, .may_take_longer = true};

    pose[3] = 1000;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    while (pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL_UINT16(1000, goals[3]);
    TEST_ASSERT_UINT32_WITHIN(2, 739 / 4, sent);
}

void test_goal_beyond_a_limit_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[2], 200, 800, 1023));
    pose[2] = 801;
    TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(5000, CDS_MOTION_LINEAR));
    TEST_ASSERT_EQUAL_UINT8(2, motion.joint);
    TEST_ASSERT_EQUAL_UINT32(0, motion.shortest_ms);
    pose[2] = 199;
    TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(5000, CDS_MOTION_LINEAR));
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
        TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(5000, CDS_MOTION_LINEAR));
        TEST_ASSERT_EQUAL_UINT8(2, motion.joint);
        TEST_ASSERT_EQUAL_UINT32(0, motion.shortest_ms);
        TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(5000, CDS_MOTION_MINIMUM_JERK));
        TEST_ASSERT_EQUAL(CDS_OK, try_move(5000, CDS_MOTION_BY_SERVO));
        TEST_ASSERT_EQUAL(CDS_PENDING, pass_period());
        TEST_ASSERT_EQUAL_UINT16(600, goals[2]);
    }
}

/* The load turns the joint 3 steps away from its goal, which is at the limit. */
void test_joint_near_its_goal_starts_from_there_in_the_first_move(void)
{
    states[2].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[2], 200, 500, 1023));
    send_goals(); // 500
    feedback[2].position = 503;
    pose[2] = 400;
    move(400, CDS_MOTION_MINIMUM_JERK);
    while (pass_period() == CDS_PENDING)
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(500, goals[2]);
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(400, goals[2]);
}

void test_inhibited_joint_is_refused(void)
{
    pose[1] = 600;
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STOPPED);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, try_move(1000, CDS_MOTION_LINEAR));
    TEST_ASSERT_EQUAL_UINT8(1, motion.joint);
}

void test_joint_of_unknown_position_is_refused(void)
{
    pose[4] = 600;
    feedback[4].known = false;
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, try_move(1000, CDS_MOTION_LINEAR));
    TEST_ASSERT_EQUAL_UINT8(4, motion.joint);
}

void test_bad_arguments_change_nothing(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_move(&motion, &it)); // no joint
    pose[0] = 1024;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_move(&motion, &it));
    pose[0] = 600;
    it.time_ms = 0;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_move(&motion, &it));
    it.time_ms = CDS_MOTION_TIME_MAX_MS + 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_move(&motion, &it));
    it.time_ms = CDS_MOTION_TIME_MAX_MS;
    it.curve = CDS_MOTION_BY_SERVO + 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_move(&motion, &it));
    it.curve = CDS_MOTION_TRAPEZOID;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_move(&motion, &it));
    it.acceleration = 1;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_motion_move(&motion, &it));
}

/* ---- from a move to the next ---- */

void test_new_target_gives_no_jump(void)
{
    int16_t last, step, last_step = 0;

    for (uint16_t at = 1; at < 370; at = (uint16_t)(at + 37 * SOME)) {
        rig_begin_motion(0);
        feedback[0].position = 200;
        pose[0] = 800;
        move(1500, CDS_MOTION_MINIMUM_JERK);
        last = 200;
        for (uint16_t i = 0; i < 1200; i++) {
            enum cds_result result = pass_period();

            if (i == at) { // one more period passes
                last = (int16_t)goals[0];
                pose[0] = 300;
                move(1500, CDS_MOTION_MINIMUM_JERK);
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
    move(1500, CDS_MOTION_MINIMUM_JERK);
    for (uint8_t i = 0; i < 150; i++)
        pass_period();
    pose[0] = CDS_POSE_NONE;
    pose[1] = 600;
    end = goals[0];
    move(1000, CDS_MOTION_MINIMUM_JERK);
    while (pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL_UINT16(600, goals[1]);
    TEST_ASSERT_INT_WITHIN(60, end + 60, goals[0]); // half of 250 ms at 0.47 steps per ms
}

void test_limit_holds_while_a_joint_turns_back(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 200, 700, 1023));
    states[0].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
    for (uint16_t at = 5; at < 125; at = (uint16_t)(at + 10 * SOME)) {
        rig_begin_motion(0);
        feedback[0].position = 500;
        pose[0] = 700;
        move(500, CDS_MOTION_MINIMUM_JERK);
        for (uint16_t i = 0; i < at; i++)
            pass_period();
        pose[0] = 250;
        TEST_ASSERT_EQUAL(CDS_OK, try_move(3000, CDS_MOTION_MINIMUM_JERK));
        while (pass_period() == CDS_PENDING)
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(700, goals[0]);
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
        TEST_ASSERT_EQUAL_UINT16(250, goals[0]);
    }
}

static uint16_t distance(uint16_t from, uint16_t to)
{
    return to > from ? to - from : from - to;
}

/* Joint 0 goes from 100 towards 900 at `speed_ms`, and after `at` periods towards `to` instead.
 * Returns the most steps between two goals of the second move. */
static uint16_t fastest_after_new_target(uint32_t speed_ms, enum cds_motion_curve first,
                                         uint16_t at, struct cds_move *second)
{
    uint16_t last, most = 0;

    rig_begin_motion(0);
    feedback[0].position = 100;
    pose[0] = 900;
    move(speed_ms, first);
    for (uint16_t i = 0; i < at; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, second));
    do {
        last = feedback[0].position = goals[0];
        pass_period();
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

    memset(target, 0xFF, sizeof target);
    for (uint32_t ms = 4; ms < 900; ms += 4 * SOME * SOME)
        for (uint16_t at = 40; at < 160; at = (uint16_t)(at + 40 * SOME)) {
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
    for (uint16_t i = 0; i < 1000 / FEW; i++) {
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

/* The joint has 2 steps in which it may brake: the window is one period. */
void test_new_target_at_a_limit_may_take_ten_minutes(void)
{
    for (uint32_t ms = 280000; ms <= 600000; ms += 10007ul * SOME) {
        struct cds_move it = {.pose = pose, .time_ms = ms, .curve = CDS_MOTION_TRAPEZOID};

        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 900, 1023));
        states[0].held = CDS_HELD_CW_SET | CDS_HELD_CCW_SET; // position mode
        rig_begin_motion(0);
        feedback[0].position = 100;
        pose[0] = 900;
        move(640, CDS_MOTION_LINEAR);
        for (uint8_t i = 0; i < 158; i++)
            pass_period();
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
        while (pass_period() == CDS_PENDING) {
        }
    }
}

/* ---- through poses without a stop ---- */

/* Joint 0 goes by way of `via` to `end`, each within 1 s, and joint 1 by way of 600 back to 500. */
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
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
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

        TEST_ASSERT_EQUAL(i < 500 ? CDS_PENDING : CDS_OK, pass_period());
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
    for (uint16_t via = 210; via < 600; via = (uint16_t)(via + 30 * SOME)) {
        rig_begin_motion(0);
        feedback[0].position = 200;
        go_by_way_of(via, 600);
        pass_period();
        while (motion.result == CDS_PENDING) {
            uint16_t last = goals[0];

            pass_period();
            TEST_ASSERT_GREATER_OR_EQUAL_UINT16(last, goals[0]);
        }
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
        TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
    }
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

void test_motion_that_passes_ends_if_no_move_waits(void)
{
    rig_begin_motion(0);
    feedback[0].position = 200;
    go_by_way_of(400, 600);
    cds_motion_poll(&motion);
    motion.next.waits = true;
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STOPPED);
    for (uint16_t i = 0; i < 300 && motion.result == CDS_PENDING; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.move_result);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.result);
}

/* Goals go from 600 to 650, the shortest way. */
static void check_goals_rise_to(uint16_t end)
{
    uint16_t last = goals[0];

    while (motion.result == CDS_PENDING || motion.move_result == CDS_PENDING) {
        pass_period();
        TEST_ASSERT_GREATER_OR_EQUAL_UINT16(last, goals[0]);
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(end, goals[0]);
        last = goals[0];
        feedback[0].position = goals[0];
    }
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(end, goals[0]);
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
    check_goals_rise_to(600);
    for (uint8_t i = 0; i < 20; i++)
        pass_period();
    pose[0] = 650;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_motion_move(&motion, &(struct cds_move){.pose = pose, .time_ms = 2000}));
    check_goals_rise_to(650);
}

/* The servo still reports that it is at 100. */
void test_waiting_move_is_checked_from_end_of_last_move(void)
{
    static uint16_t back[JOINTS];
    struct cds_move it = {.pose = back, .time_ms = 40, .waits = true};

    rig_begin_motion(0);
    feedback[0].position = 100;
    pose[0] = 900;
    move(2000, CDS_MOTION_MINIMUM_JERK);
    memcpy(back, pose, sizeof back);
    back[0] = 100;
    for (uint8_t i = 0; i < 20; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL(CDS_LIMIT, motion.move_result);
}

/* The servo reported 560 and then nothing any more. */
void test_move_begins_at_the_last_goal_if_feedback_is_old(void)
{
    rig_begin_motion(0);
    feedback[0].position = 500;
    pose[0] = 520;
    move(200, CDS_MOTION_LINEAR);
    while (pass_period() == CDS_PENDING) {
    }
    feedback[0].position = 560;
    port_fake.now_us += 600000;
    pose[0] = 530;
    move(400, CDS_MOTION_LINEAR);
    TEST_ASSERT_UINT16_WITHIN(3, 520, (pass_period(), goals[0]));
}

/* Nothing is under way: the move does not wait. The joint was turned from 520 to 300 by hand. */
void test_waiting_move_at_rest_begins_where_the_joint_is(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 300, .waits = true};

    rig_begin_motion(0);
    feedback[0].position = 500;
    pose[0] = 520;
    move(200, CDS_MOTION_LINEAR);
    while (pass_period() == CDS_PENDING) {
    }
    feedback[0].position = 300;
    pose[0] = 320;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
    while (pass_period() == CDS_PENDING)
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
    move(400, CDS_MOTION_LINEAR);
    for (uint8_t i = 0; i < 99; i++)
        pass_period();
    feedback[0].position = 440;
    pose[0] = 510;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    send_goals();
    cds_motion_poll(&motion); // the last goals
    cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL_UINT8(JOINTS, motion.index);
    send_goals();
    cds_motion_poll(&motion);
    TEST_ASSERT_FALSE(motion.is_under_way);
    TEST_ASSERT_EQUAL(CDS_PENDING, motion.move_result);
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    while (pass_period() == CDS_PENDING)
        TEST_ASSERT_UINT16_WITHIN(5, 505, goals[0]);
    TEST_ASSERT_EQUAL_UINT16(510, goals[0]);
}

/* ---- pause, abort, override ---- */

void test_pause_holds_a_move_that_is_checked(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    rig_begin_motion(0);
    feedback[0].position = 200;
    pose[0] = 600;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 8000);
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    TEST_ASSERT_TRUE(motion.result == CDS_PENDING && motion.is_paused);
    cds_motion_resume(&motion);
    for (uint16_t i = 0; i < 400 && motion.result == CDS_PENDING; i++) {
        for (uint8_t poll = 0; poll < 2 * JOINTS; poll++)
            cds_motion_poll(&motion);
        pass_period();
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

        pass_period();
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
    move(1500, CDS_MOTION_LINEAR);
    for (uint16_t i = 0; i < 180; i++)
        pass_period();
}

/* A paused move stands at its goal when the next one is submitted, `polls` before it is resumed. */
static void check_resumed_at(uint8_t polls)
{
    static uint16_t back[JOINTS];
    uint16_t last;

    go_half_way();
    cds_motion_pause(&motion, 8000);
    for (uint8_t i = 0; i < 60; i++)
        pass_period();
    last = feedback[0].position = goals[0];
    memcpy(back, pose, sizeof back);
    back[0] = 200;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_motion_move(&motion, &(struct cds_move){.pose = back, .time_ms = 2000}));
    for (uint8_t i = 0; i < polls; i++)
        cds_motion_poll(&motion);
    cds_motion_resume(&motion);
    for (uint16_t i = 0; i < 700 && motion.result == CDS_PENDING; i++) {
        send_goals();
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
    for (uint8_t polls = 0; polls < 3 * JOINTS; polls = (uint8_t)(polls + SOME))
        check_resumed_at(polls);
}

void test_motion_without_its_cycle_ends_as_inhibited(void)
{
    for (uint8_t again = 0; again < 2; again++) {
        begin_cycle(PERIOD_US);
        pose[0] = 800;
        move(1000, CDS_MOTION_LINEAR);
        pass_period();
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
        pass_period();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, motion.result);
    TEST_ASSERT_EQUAL_UINT8(1, motion.joint);
}

/* As `pause`, then `motion off`, while the next step of a sequence is checked. */
void test_move_paused_before_its_first_goal_can_be_ended(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1000};

    rig_begin_motion(0);
    feedback[0].position = 200;
    pose[0] = 600;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 8000);
    for (uint8_t i = 0; i < 20; i++)
        pass_period();
    cds_motion_abort(&motion, 8000);
    for (uint8_t i = 0; i < 5; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    TEST_ASSERT_FALSE(cds_motion_is_busy(&motion));
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
}

/* A joint went from 500 to 500 + `way`; the next move begins paused and is aborted. Then the joint
 * goes 50 steps further. */
static void check_move_after_an_abort_before_the_first_goal(uint16_t way, bool waits, bool resumes)
{
    struct cds_move it = {.pose = pose, .time_ms = 300};

    setUp();
    pose[0] = (uint16_t)(500 + way);
    move(200, CDS_MOTION_MINIMUM_JERK);
    while (pass_period() == CDS_PENDING) {
    }
    feedback[0].position = goals[0];
    pose[0] = 450;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 8000);
    for (uint8_t i = 0; i < 10; i++)
        pass_period();
    if (resumes)
        cds_motion_resume(&motion);
    cds_motion_abort(&motion, 8000);
    pass_period();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    it.waits = waits;
    pose[0] = (uint16_t)(550 + way);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    check_goals_rise_to(pose[0]);
}

void test_move_after_an_abort_before_the_first_goal_does_not_jump(void)
{
    for (uint8_t i = 0; i < 4; i = (uint8_t)(i + SOME)) {
        check_move_after_an_abort_before_the_first_goal(14, i & 1, i & 2);
        check_move_after_an_abort_before_the_first_goal(80, i & 1, i & 2);
    }
}

void test_pause_ends_with_the_refusal_of_its_move(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 4};

    rig_begin_motion(0);
    pose[0] = 900;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 8000);
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL(CDS_LIMIT, motion.move_result);
    it.time_ms = 1000;
    pose[0] = 510;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    for (uint16_t i = 0; i < 300 && pass_period() == CDS_PENDING; i++) {
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
    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        cds_motion_poll(&motion);
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    move(400, CDS_MOTION_LINEAR);
    for (uint8_t i = 0; i < 110; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(520, goals[0]);
}

/* The highest speed is 322 units; 1000 units per second are 4 in a period. */
static void check_speeds_up_at_1000(void)
{
    uint16_t periods = 0;

    for (uint16_t last = 0; motion.rate < 65536 && periods < 1000; periods++, last = speeds[0]) {
        pass_period();
        TEST_ASSERT_TRUE(periods == 0 || speeds[0] <= last + 4 + 4); // and the reserve
    }
    TEST_ASSERT_UINT16_WITHIN(8, 81, periods); // 62 within a quarter of a second
}

void test_pause_before_the_first_goal_keeps_its_deceleration(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 1500, .curve = CDS_MOTION_LINEAR};

    rig_begin_motion(0);
    feedback[0].position = 200;
    pose[0] = 800;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 1000);
    for (uint8_t i = 0; i < 10; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    cds_motion_resume(&motion);
    check_speeds_up_at_1000();
}

/* The rate of a slow move falls in larger steps than that of a fast move. */
void test_paused_move_after_a_slower_one_keeps_the_deceleration(void)
{
    rig_begin_motion(0);
    feedback[0].position = 200;
    pose[0] = 230;
    move(1500, CDS_MOTION_LINEAR);
    for (uint8_t i = 0; i < 10; i++)
        pass_period();
    cds_motion_pause(&motion, 1000);
    for (uint8_t i = 0; i < 40; i++)
        pass_period();
    pose[0] = 800;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_motion_move(&motion, &(struct cds_move){.pose = pose,
                                                                  .time_ms = 1500,
                                                                  .curve = CDS_MOTION_LINEAR}));
    for (uint8_t i = 0; i < 10; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, motion.move_result);
    cds_motion_resume(&motion);
    check_speeds_up_at_1000();
}

void test_override_does_not_end_a_pause(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 100};

    rig_begin_motion(0);
    pose[0] = 520;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    while (pass_period() == CDS_PENDING) {
    }
    pose[0] = 510;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    cds_motion_pause(&motion, 8000);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, 50));
    for (uint8_t i = 0; i < 60; i++)
        pass_period();
    TEST_ASSERT_TRUE(motion.is_paused && motion.result == CDS_PENDING);
    TEST_ASSERT_EQUAL_UINT16(520, goals[0]);
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
        TEST_ASSERT_EQUAL(CDS_PENDING, pass_period());
    TEST_ASSERT_EQUAL_UINT16(at, goals[0]);
    cds_motion_resume(&motion);
    for (uint8_t i = 0; i < 35; i++) {
        uint16_t last = speeds[0];

        pass_period();
        TEST_ASSERT_TRUE(i == 0 || speeds[0] <= last + 13);
    }
    while (pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(800, goals[0]);
}

void test_abort_ends_at_a_standstill(void)
{
    int16_t change;
    uint16_t at;

    go_half_way();
    cds_motion_abort(&motion, 4000);
    TEST_ASSERT_INT_WITHIN(4, 20, slow_down(&change));
    TEST_ASSERT_LESS_OR_EQUAL_INT16(25, change); // 16, and the reserve
    pass_period();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    at = goals[0];
    pass_period();
    TEST_ASSERT_EQUAL_UINT16(at, goals[0]);
    TEST_ASSERT_INT_WITHIN(30, 500, at);
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
    move(1500, CDS_MOTION_MINIMUM_JERK);
    pass_period();
    TEST_ASSERT_INT_WITHIN(2, at, goals[0]);
    while (pass_period() == CDS_PENDING) {
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
    pass_period();
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_motion_move(&motion, &it));
    while (pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
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
        move(340, CDS_MOTION_LINEAR);
        for (uint16_t i = 0; i < periods; i++)
            pass_period();
        pose[0] = CDS_POSE_NONE;
        pose[1] = 505;
        TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
        while (motion.move_result == CDS_PENDING || motion.is_under_way) {
            send_goals();
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(700, goals[0]);
            for (uint8_t i = 0; i < 10; i++)
                cds_motion_poll(&motion);
        }
        feedback[0].position = goals[0];
        pose[0] = 600;
        move(2000, CDS_MOTION_MINIMUM_JERK);
        while (pass_period() == CDS_PENDING)
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(700, goals[0]);
        TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    }
}

/* A pause slows down within its deceleration; the override has a time of its own. */
void test_override_after_a_pause_changes_within_250_ms(void)
{
    go_half_way();
    cds_motion_pause(&motion, 100);
    pass_period();
    cds_motion_resume(&motion);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, 50));
    for (uint8_t i = 0; i < 64; i++) // 256 ms
        pass_period();
    TEST_ASSERT_EQUAL_UINT32(32768, motion.rate);
}

/* The move takes the place of an abort that slows down at 100. */
void test_move_in_place_of_an_abort_is_at_full_rate_within_250_ms(void)
{
    go_half_way();
    cds_motion_abort(&motion, 100);
    for (uint8_t i = 0; i < 100; i++)
        pass_period();
    TEST_ASSERT_TRUE(motion.is_under_way && motion.rate < 60000);
    pose[0] = 200;
    move(3000, CDS_MOTION_MINIMUM_JERK);
    for (uint8_t i = 0; i < 64; i++)
        pass_period();
    TEST_ASSERT_EQUAL_UINT32(65536, motion.rate);
}

void test_trapezoid_keeps_the_acceleration_of_the_joints(void)
{
    uint32_t at_4000, at_1000;

    rig_begin_motion(4000);
    pose[0] = 900;
    TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(100, CDS_MOTION_TRAPEZOID));
    at_4000 = motion.shortest_ms;
    rig_begin_motion(1000);
    TEST_ASSERT_EQUAL(CDS_LIMIT, try_move(100, CDS_MOTION_TRAPEZOID)); // it asks for 4000
    at_1000 = motion.shortest_ms;
    TEST_ASSERT_GREATER_THAN_UINT32(at_4000 * 3 / 2, at_1000);
    move(at_1000, CDS_MOTION_TRAPEZOID);
    for (uint16_t last = 0; pass_period() == CDS_PENDING; last = speeds[0])
        TEST_ASSERT_TRUE(last == 0 || distance(speeds[0], last) <= 4 + 5); // and the reserve
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
        TEST_ASSERT_EQUAL(CDS_CANCELLED, pass_period());
    TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
}

static uint32_t periods_at(uint8_t percent)
{
    rig_begin_motion(0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, percent));
    feedback[0].position = 500;
    pose[0] = 520;
    sent = 0;
    move(400, CDS_MOTION_MINIMUM_JERK);
    while (pass_period() == CDS_PENDING) {
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
    move(2000, CDS_MOTION_MINIMUM_JERK);
    while (pass_period() == CDS_PENDING)
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(100, speeds[0]);
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
    TEST_ASSERT_UINT32_WITHIN(3, 378, sent);
}

/* ---- trouble on the way ---- */

void test_joint_that_is_inhibited_on_the_way_ends_the_motion(void)
{
    pose[0] = 900;
    pose[1] = 600;
    move(2000, CDS_MOTION_MINIMUM_JERK);
    for (uint8_t i = 0; i < 200; i++)
        pass_period();
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STOPPED);
    for (uint8_t i = 0; i < 70 && motion.result == CDS_PENDING; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.result);
    TEST_ASSERT_EQUAL_UINT8(1, motion.joint);
    TEST_ASSERT_LESS_THAN_UINT16(800, goals[0]);
}

/* A joint that begins a move divides: two of them at most in a poll, whether they are in the pose
 * of the move or brake. */
void test_polls_begin_at_most_two_joints(void)
{
    for (uint8_t i = 0; i < JOINTS; i++)
        pose[i] = 600;
    move(1000, CDS_MOTION_LINEAR);
    for (uint8_t i = 0; i < 100; i++)
        pass_period();
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
            send_goals();
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
    move(1000, CDS_MOTION_MINIMUM_JERK);
    send_goals();
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
    for (uint32_t period = 0; period < 200000ul / FEW; period++) {
        bool was_checking;

        act_at_random();
        was_checking = motion.move_result == CDS_PENDING;
        pass_period();
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
    TEST_ASSERT_GREATER_THAN_UINT32(1000ul / FEW, moves);
}

void test_acceleration_of_register_is_250_units_per_s(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, cds_motion_acceleration(0));
    TEST_ASSERT_EQUAL_UINT16(8000, cds_motion_acceleration(32));
    TEST_ASSERT_EQUAL_UINT16(63750, cds_motion_acceleration(255));
}
