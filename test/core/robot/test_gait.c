/* SPDX-License-Identifier: MIT */
/* Gaits: every goal that leaves in a SYNC WRITE against the formula in real numbers. The clock
 * moves from one period to the next. */
#include "cds55xx/gait.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "real_sine.h"
#include "robot/gait_internal.h"

#include "joints_rig.h"

#define PERIOD_US 4000
#define BASE_MS   1000
#define RAMP_MS   1200
#define RAMP      (RAMP_MS / 4) // periods
#define POLLS     30            // the goals of a period, or the check of all joints
#define SWINGS    0             // a joint of one sine
#define STEADY    6             // a joint without a sine

#ifdef __AVR__
#define MANY 300
#else
#define MANY 20000
#endif

CDS_GAIT_TABLE(table) = {
    {.rest = 512, .sines = {{.amplitude = 100, .multiple = 1}}},
    {.rest = 400, .sines = {{.amplitude = 60, .multiple = 1, .wave = CDS_GAIT_LIFT, .group = 1}}},
    {.rest = 500,
     .sines = {{.amplitude = 70, .phase = CDS_GAIT_PHASE(90), .multiple = 1},
               {.amplitude = -20, .phase = CDS_GAIT_PHASE(200), .multiple = 2, .group = 2},
               {.amplitude = 11, .phase = CDS_GAIT_PHASE(359), .multiple = 4, .group = 3}}},
    {.rest = CDS_POSE_NONE},
    {.rest = 511, .sines = {{.amplitude = 137, .phase = 0x4321, .multiple = 1, .group = 3}}},
    {.rest = 1023 - 90, .sines = {{.amplitude = 90, .phase = CDS_GAIT_PHASE(180), .multiple = 1}}},
    {.rest = 300},
};

static struct cds_gait gait;
static struct cds_gait_state joints[JOINTS];
static struct cds_gait_config config;

static uint16_t last_way[JOINTS]; // steps in the last period
static uint32_t sent;             // SYNC WRITEs since the gait has begun

/* The gait in real numbers. */
static double phase, way, from[CDS_GAIT_RAMPED], to[CDS_GAIT_RAMPED], now[CDS_GAIT_RAMPED];

void setUp(void)
{
    rig_begin_joints(450);
    feedback[5].position = 900;
    rig_begin_cycle(PERIOD_US);
    memset(&gait, 0, sizeof gait);
    memset(last_way, 0, sizeof last_way);
    config = (struct cds_gait_config){.cycle = &cycle,
                                      .servos = &servos,
                                      .joints = table,
                                      .states = joints,
                                      .period_ms = BASE_MS,
                                      .ramp_ms = RAMP_MS};
    phase = way = 0;
    sent = 0;
    for (uint8_t i = 0; i < CDS_GAIT_RAMPED; i++) {
        from[i] = now[i] = 0;
        to[i] = 1;
    }
}

void tearDown(void)
{
    rig_check();
}

static void poll_often(void)
{
    for (uint8_t i = 0; i < POLLS; i++)
        cds_gait_poll(&gait);
}

/* The goals leave, and the gait sets those of the next period. */
static enum cds_result pass_period(void)
{
    rig_send_goals();
    for (uint8_t i = 0; i < JOINTS; i++)
        feedback[i].time_us = port_fake.now_us;
    sent++;
    poll_often();
    return (enum cds_result)gait.result;
}

static enum cds_result try_gait(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_gait_begin(&gait, &config));
    poll_often();
    return (enum cds_result)gait.result;
}

static void begin_gait(void)
{
    TEST_ASSERT_EQUAL(CDS_PENDING, try_gait());
    TEST_ASSERT_TRUE(gait.is_under_way);
}

/* ---- the formula ---- */

static double wave(const CDS_GAIT_FLASH struct cds_gait_sine *sine)
{
    double turn = phase * sine->multiple + sine->phase / 65536.0, height;

    height = real_sine(turn);
    if (sine->wave == CDS_GAIT_LIFT)
        height = height > 0 ? height * height : 0;
    return sine->amplitude * now[sine->group] * height;
}

static double expected_position(const CDS_GAIT_FLASH struct cds_gait_joint *joint, double start)
{
    double position = joint->rest + (start - joint->rest) * (1 - way);

    for (uint8_t i = 0; i < CDS_GAIT_SINES && joint->sines[i].amplitude; i++)
        position += wave(&joint->sines[i]);
    return position;
}

/* `is_first`: the way from where the joints were. */
static void follow_ramp(uint32_t period, bool is_first)
{
    double t = (double)period / RAMP, s = t < 1 ? t * t * (3 - 2 * t) : 1;

    phase += now[CDS_GAIT_GROUPS] * 4 / BASE_MS;
    for (uint8_t i = 0; i < CDS_GAIT_RAMPED; i++)
        now[i] = from[i] + (to[i] - from[i]) * s;
    way = is_first ? s : 1;
}

static void check_goals(uint32_t period)
{
    char text[80];

    for (uint8_t i = 0; i < JOINTS; i++) {
        double expected = expected_position(&table[i], i == 5 ? 900 : 450);

        if (i == 3 || fabs(expected - goals[i]) <= 1)
            continue;
        snprintf(text, sizeof text, "joint %u: goal %u, expected %ld, in period %lu", i, goals[i],
                 (long)expected, (unsigned long)period);
        TEST_FAIL_MESSAGE(text);
    }
}

/* Passes a ramp from the values that are now to `to`, and looks at each goal. */
static void pass_ramp(bool is_first)
{
    memcpy(from, now, sizeof from);
    for (uint32_t i = is_first ? 0 : 1; i <= RAMP; i++) {
        pass_period();
        if (i)
            follow_ramp(i, is_first);
        check_goals(i);
    }
    memcpy(from, to, sizeof from);
}

static void pass_on(uint32_t periods)
{
    for (uint32_t i = 0; i < periods; i++) {
        pass_period();
        follow_ramp(RAMP, false);
        check_goals(i);
    }
}

void test_goals_follow_the_formula_from_start_to_stop(void)
{
    begin_gait();
    pass_ramp(true);
    pass_on(MANY);
    cds_gait_stop(&gait);
    pass_on(2); // goals that were set before, and the beginning of the ramp
    for (uint8_t i = 0; i < CDS_GAIT_GROUPS; i++)
        to[i] = 0;
    pass_ramp(false);
    while (pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL(CDS_OK, gait.result);
    for (uint8_t i = 0; i < JOINTS; i++)
        TEST_ASSERT_EQUAL_UINT16(i == 3 ? 450 : table[i].rest, goals[i]);
}

void test_first_goals_are_the_last_ones_or_the_positions(void)
{
    feedback[0].position = 440; // near its goal, which stays
    feedback[1].position = 330; // turned by hand
    begin_gait();
    pass_period();
    TEST_ASSERT_EQUAL_UINT16(450, goals[0]);
    TEST_ASSERT_EQUAL_UINT16(330, goals[1]);
}

/* Goals never jump, and each has a speed that is enough for the way to it, but is never 0. */
static void pass_without_a_jump(uint32_t periods)
{
    uint16_t last[JOINTS];

    memcpy(last, goals, sizeof last);
    for (uint32_t i = 0; i < periods; i++) {
        pass_period();
        for (uint8_t j = 0; j < JOINTS; j++) {
            uint16_t steps = (uint16_t)abs((int16_t)(goals[j] - last[j]));

            TEST_ASSERT_LESS_OR_EQUAL_UINT16(5, steps);
            TEST_ASSERT_INT_WITHIN(2, last_way[j], steps);
            TEST_ASSERT_NOT_EQUAL(0, speeds[j]);
            if (j != 3) // it takes no part
                TEST_ASSERT_GREATER_OR_EQUAL_UINT16(steps ? (steps - 1) * 201 : 0, speeds[j]);
            last_way[j] = steps;
        }
        memcpy(last, goals, sizeof last);
    }
}

void test_changes_of_scale_speed_and_direction_do_not_jump(void)
{
    begin_gait();
    pass_period();
    pass_without_a_jump(RAMP + 30);
    TEST_ASSERT_EQUAL(CDS_OK, cds_gait_set_scale(&gait, 0, -100));
    pass_without_a_jump(RAMP / 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_gait_set_speed(&gait, -100)); // when the first change is over
    TEST_ASSERT_EQUAL(CDS_OK, cds_gait_set_scale(&gait, 3, 30));
    pass_without_a_jump(RAMP / 2 + 2);
    TEST_ASSERT_EQUAL_INT16(-CDS_GAIT_1, gait.now[0]);
    TEST_ASSERT_INT_WITHIN(200, CDS_GAIT_1, gait.now[CDS_GAIT_SPEED]);
    pass_without_a_jump(RAMP + 2);
    TEST_ASSERT_EQUAL_INT16(-CDS_GAIT_1, gait.now[CDS_GAIT_SPEED]);
    cds_gait_stop(&gait);
    pass_without_a_jump(RAMP + 2);
    pass_period();
    TEST_ASSERT_EQUAL(CDS_OK, gait.result);
}

void test_gait_backwards_retraces_its_goals(void)
{
    uint16_t forth[100], middle;

    begin_gait();
    for (uint32_t i = 0; i < RAMP + 10; i++)
        pass_period();
    for (uint8_t i = 0; i < 100; i++) {
        pass_period();
        forth[i] = goals[0];
    }
    gait.now[CDS_GAIT_SPEED] = gait.to[CDS_GAIT_SPEED] = -CDS_GAIT_1; // without the ramp
    cds_gait_set_speed(&gait, -100);
    pass_period(); // set before
    middle = goals[0];
    for (uint8_t i = 0; i < 100; i++) {
        pass_period();
        TEST_ASSERT_INT_WITHIN(1, forth[99 - i], goals[0]);
    }
    TEST_ASSERT_NOT_EQUAL(middle, goals[0]);
}

/* Speed x time is the way, without the reserve. */
void test_speed_leads_to_the_next_goal(void)
{
    double way_of_speeds;

    begin_gait();
    for (uint32_t i = 0; i < RAMP + 2; i++)
        pass_period();
    way_of_speeds = goals[0];
    for (uint8_t i = 0; i < 200; i++) {
        uint16_t last = goals[0];
        double steps;

        pass_period();
        steps = (speeds[0] - joints[0].reserve) / 201.6129;
        way_of_speeds += goals[0] < last || (goals[0] == last && i > 100) ? -steps : steps;
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(1023, speeds[0]);
    }
    TEST_ASSERT_INT_WITHIN(12, goals[0], (int)way_of_speeds);
}

/* ---- refused before it begins ---- */

static void assert_refused(enum cds_result result, uint8_t joint)
{
    TEST_ASSERT_EQUAL(result, try_gait());
    TEST_ASSERT_EQUAL_UINT8(joint, gait.joint);
    TEST_ASSERT_FALSE(gait.is_under_way);
}

void test_swing_beyond_a_soft_limit_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[2], 399, 601, 1023));
    begin_gait();
    cds_gait_abort(&gait, 60000);
    while (pass_period() == CDS_PENDING) {
    }
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[2], 400, 601, 1023));
    assert_refused(CDS_LIMIT, 2); // 500 - 70 - 20 - 11
    TEST_ASSERT_EQUAL_UINT32(0, gait.shortest_ms);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[2], 0, 600, 1023));
    assert_refused(CDS_LIMIT, 2);
}

void test_start_beyond_a_soft_limit_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 300, 700, 1023));
    feedback[0].position = 299;
    assert_refused(CDS_LIMIT, 0);
}

void test_period_too_short_is_refused_with_one_that_works(void)
{
    feedback[2].position = 500; // the rest position
    config.period_ms = 500;
    assert_refused(CDS_LIMIT, 2); // 70 + 2 x 20 + 4 x 11 steps, x 2 pi x 0.806 / 0.5 s: 1561 units
    TEST_ASSERT_UINT32_WITHIN(2, 500ul * 1561 / 1023, gait.shortest_ms);
    config.period_ms = (uint16_t)(gait.shortest_ms - 2);
    assert_refused(CDS_LIMIT, 2);
    config.period_ms = (uint16_t)(config.period_ms + 2);
    begin_gait();
}

void test_speed_limit_of_a_servo_is_kept(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 1023, 500));
    assert_refused(CDS_LIMIT, 0); // 100 x 2 pi x 0.806 = 507
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 1023, 600));
    begin_gait();
    for (uint32_t i = 0; i < 2 * RAMP; i++) {
        TEST_ASSERT_EQUAL(CDS_PENDING, pass_period());
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(600, speeds[0]);
    }
}

CDS_GAIT_TABLE(lifts) = {
    {.rest = 512, .sines = {{.amplitude = 300, .multiple = 1, .wave = CDS_GAIT_LIFT}}},
    {.rest = 512, .sines = {{.amplitude = 300, .multiple = 1, .group = 1}}},
    {.rest = CDS_POSE_NONE},
    {.rest = CDS_POSE_NONE},
    {.rest = CDS_POSE_NONE},
    {.rest = CDS_POSE_NONE},
    {.rest = CDS_POSE_NONE},
};

/* Passes a period. The way of joints 0 and 1 between two goals is at most that of full speed, 1023
 * units: 5.074 steps in 4 ms, and the rounding of both goals to 1/256 step. */
static void pass_within_full_speed(void)
{
    uint16_t last[] = {joints[0].position, joints[1].position};

    pass_period();
    for (uint8_t i = 0; i < 2; i++)
        TEST_ASSERT_INT_WITHIN(1299 + 2, 0, (int16_t)(joints[i].position - last[i]));
}

/* The ramp is as short as it may be, and the scale changes from 100 % to -100 % and back. */
void test_change_of_scale_keeps_full_speed(void)
{
    config.joints = lifts;
    feedback[0].position = feedback[1].position = 512;
    config.period_ms = config.ramp_ms = 1000;
    assert_refused(CDS_LIMIT, 0);
    config.period_ms = config.ramp_ms = (uint16_t)gait.shortest_ms;
    begin_gait();
    for (uint16_t i = 0; i < MANY / 10; i++) {
        int8_t percent = i % 1402 < 701 ? -100 : 100;

        if (i % 701 == 0) // another phase each time
            for (uint8_t group = 0; group < 2; group++)
                TEST_ASSERT_EQUAL(CDS_OK, cds_gait_set_scale(&gait, group, percent));
        pass_within_full_speed();
    }
}

void test_far_start_within_a_short_ramp_is_refused(void)
{
    feedback[6].position = 1023; // 723 steps within 1.2 s: 3/2 of 486 units, and no sine
    begin_gait();
    cds_gait_abort(&gait, 60000);
    while (pass_period() == CDS_PENDING) {
    }
    feedback[0].position = 0; // 512 steps beside the sine
    assert_refused(CDS_LIMIT, 0);
    TEST_ASSERT_NOT_EQUAL(0, gait.shortest_ms);
    config.ramp_ms = (uint16_t)(gait.shortest_ms * RAMP_MS / BASE_MS + 2);
    config.period_ms = (uint16_t)gait.shortest_ms;
    begin_gait();
}

/* As gait.h says: the ramp is lengthened by the same factor. */
static void check_shortest_period_works(void)
{
    uint32_t ramp_ms = config.ramp_ms, period_ms = config.period_ms;

    memset(&gait, 0, sizeof gait);
    if (try_gait() == CDS_PENDING)
        return;
    TEST_ASSERT_EQUAL(CDS_LIMIT, gait.result);
    TEST_ASSERT_NOT_EQUAL(0, gait.shortest_ms);
    ramp_ms = (ramp_ms * gait.shortest_ms + period_ms - 1) / period_ms;
    if (ramp_ms > CDS_GAIT_TIME_MAX_MS)
        return;
    config.period_ms = (uint16_t)gait.shortest_ms;
    config.ramp_ms = (uint16_t)ramp_ms;
    TEST_ASSERT_EQUAL(CDS_PENDING, try_gait());
    memset(&gait, 0, sizeof gait);
    config.period_ms = (uint16_t)(config.period_ms * 49ul / 50);
    config.ramp_ms = (uint16_t)(config.ramp_ms * 49ul / 50);
    TEST_ASSERT_EQUAL(CDS_LIMIT, try_gait());
}

void test_shortest_period_of_a_far_start_works(void)
{
    CDS_GAIT_TABLE(fast) = {
        {.rest = 700, .sines = {{.amplitude = 250, .multiple = 2}}},
        {.rest = CDS_POSE_NONE},
        {.rest = CDS_POSE_NONE},
        {.rest = CDS_POSE_NONE},
        {.rest = CDS_POSE_NONE},
        {.rest = CDS_POSE_NONE},
        {.rest = CDS_POSE_NONE},
    };

    config.joints = fast;
    for (uint16_t i = 0; i < MANY / 16; i++) {
        uint16_t speed = (uint16_t)(20 + rand() % 1004);

        feedback[0].position = (uint16_t)(rand() % 1024);
        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 1023, speed));
        config.period_ms = (uint16_t)(CDS_GAIT_TIME_MIN_MS + 10 + (uint16_t)rand() % 2000);
        config.ramp_ms = (uint16_t)(config.period_ms + (uint16_t)(rand() % 3000));
        check_shortest_period_works();
    }
}

void test_inhibited_joint_is_refused(void)
{
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STOPPED);
    assert_refused(CDS_INHIBITED, 1);
}

void test_joint_of_unknown_position_is_refused(void)
{
    feedback[4].known = false;
    assert_refused(CDS_TIMEOUT, 4);
}

void test_joint_without_feedback_for_half_a_second_is_refused(void)
{
    port_fake.now_us += 400000;
    begin_gait();
    memset(&gait, 0, sizeof gait);
    port_fake.now_us += 600000;
    assert_refused(CDS_TIMEOUT, 0);
}

void test_bad_tables_are_refused(void)
{
    CDS_GAIT_TABLE(too_far) = {{.rest = 512, .sines = {{.amplitude = -512, .multiple = 1}}}};
    CDS_GAIT_TABLE(no_multiple) = {{.rest = 512, .sines = {{.amplitude = 1}}}};
    CDS_GAIT_TABLE(high) = {{.rest = 512, .sines = {{.amplitude = 1, .multiple = 5}}}};
    CDS_GAIT_TABLE(group) = {{.rest = 512, .sines = {{.amplitude = 1, .multiple = 1, .group = 4}}}};
    CDS_GAIT_TABLE(shape) = {{.rest = 512, .sines = {{.amplitude = 1, .multiple = 1, .wave = 2}}}};
    CDS_GAIT_TABLE(rest) = {{.rest = 1024}};
    const CDS_GAIT_FLASH struct cds_gait_joint *const tables[] = {too_far, no_multiple, high,
                                                                  group,   shape,       rest};

    for (uint8_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        config.joints = tables[i];
        assert_refused(CDS_BAD_ARGUMENT, 0);
    }
}

void test_begin_refuses_times_out_of_range(void)
{
    config.period_ms = CDS_GAIT_TIME_MIN_MS - 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_gait_begin(&gait, &config));
    config.period_ms = RAMP_MS + 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_gait_begin(&gait, &config));
    config.ramp_ms = CDS_GAIT_TIME_MAX_MS + 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_gait_begin(&gait, &config));
    TEST_ASSERT_EQUAL(CDS_OK, gait.result);
}

void test_calls_refuse_values_out_of_range_and_a_second_begin(void)
{
    begin_gait();
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_gait_begin(&gait, &config));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_gait_set_scale(&gait, CDS_GAIT_GROUPS, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_gait_set_scale(&gait, 0, 101));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_gait_set_scale(&gait, 0, -101));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_gait_set_speed(&gait, 101));
}

/* ---- stop, pause, abort ---- */

void test_stop_during_the_start_ends_in_the_rest_positions(void)
{
    uint32_t periods = 0;

    begin_gait();
    for (uint32_t i = 0; i < RAMP / 2; i++)
        pass_period();
    cds_gait_stop(&gait);
    while (pass_period() == CDS_PENDING)
        periods++;
    TEST_ASSERT_UINT32_WITHIN(4, RAMP / 2 + RAMP, periods);
    for (uint8_t i = 0; i < JOINTS; i++)
        TEST_ASSERT_EQUAL_UINT16(i == 3 ? 450 : table[i].rest, goals[i]);
}

void test_stop_before_the_gait_runs_cancels_it(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_gait_begin(&gait, &config));
    cds_gait_poll(&gait);
    cds_gait_stop(&gait);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_gait_poll(&gait));
}

void test_stop_ends_though_the_program_changes_the_speed(void)
{
    uint32_t periods = 0;

    begin_gait();
    for (uint32_t i = 0; i < 2 * RAMP; i++)
        pass_period();
    cds_gait_stop(&gait);
    while (pass_period() == CDS_PENDING) {
        cds_gait_set_speed(&gait, (int8_t)(periods % 100));
        TEST_ASSERT_LESS_THAN_UINT32(2 * RAMP, ++periods);
    }
    TEST_ASSERT_EQUAL(CDS_OK, gait.result);
}

void test_gait_ends_with_its_cycle_and_does_not_resume(void)
{
    begin_gait();
    for (uint32_t i = 0; i < 2 * RAMP; i++)
        pass_period();
    cds_cycle_abort(&cycle);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_gait_poll(&gait));
    rig_begin_cycle_again(PERIOD_US);
    begin_gait();
    for (uint32_t i = 0; i < RAMP; i++)
        pass_period();
    cds_cycle_abort(&cycle);
    rig_begin_cycle_again(PERIOD_US); // the program did not poll the gait meanwhile
    TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_gait_poll(&gait));
    pass_period();
    TEST_ASSERT_EQUAL_UINT16(feedback[0].position, goals[0]); // the first goal of the new cycle
}

void test_abort_and_begin_work_after_the_cycle_has_ended(void)
{
    begin_gait();
    for (uint32_t i = 0; i < RAMP; i++)
        pass_period();
    cds_cycle_abort(&cycle);
    TEST_ASSERT_EQUAL(CDS_OK, cds_gait_begin(&gait, &config));
    cds_gait_abort(&gait, 1000);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, gait.result);
}

void test_pause_during_the_check_begins_paused(void)
{
    uint16_t first;

    TEST_ASSERT_EQUAL(CDS_OK, cds_gait_begin(&gait, &config));
    cds_gait_pause(&gait, 2000);
    for (uint8_t i = 0; i < 50; i++)
        pass_period();
    TEST_ASSERT_TRUE(gait.is_under_way);
    first = goals[0];
    for (uint8_t i = 0; i < 50; i++)
        pass_period();
    TEST_ASSERT_EQUAL_UINT16(first, goals[0]);
    cds_gait_resume(&gait);
    pass_without_a_jump(200);
    TEST_ASSERT_NOT_EQUAL(first, goals[0]);
}

/* As in the next test: the rate is 0 after 105 periods, and so it is 1 again after as many. */
void test_pause_during_the_check_keeps_its_deceleration(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_gait_begin(&gait, &config));
    cds_gait_pause(&gait, 2000);
    for (uint8_t i = 0; i < 10; i++)
        pass_period();
    cds_gait_resume(&gait);
    for (uint8_t i = 0; i < 110; i++) {
        if (i == 90)
            TEST_ASSERT_LESS_THAN_UINT16(CDS_GAIT_1, gait.rate);
        pass_period();
    }
    TEST_ASSERT_EQUAL_UINT16(CDS_GAIT_1, gait.rate);
}

/* 2000 units per second: 834 units at the most are at rest within 105 periods. */
void test_pause_stands_still_and_resume_goes_on(void)
{
    uint16_t last;

    begin_gait();
    for (uint32_t i = 0; i < 2 * RAMP; i++)
        pass_period();
    cds_gait_pause(&gait, 2000);
    for (uint8_t i = 0; i < 110; i++) {
        if (i == 90)
            TEST_ASSERT_NOT_EQUAL(0, gait.rate);
        pass_period();
    }
    TEST_ASSERT_EQUAL_UINT16(0, gait.rate);
    last = goals[0];
    pass_period();
    TEST_ASSERT_EQUAL_UINT16(last, goals[0]);
    TEST_ASSERT_EQUAL(CDS_PENDING, gait.result);
    cds_gait_resume(&gait);
    memset(last_way, 0, sizeof last_way);
    pass_without_a_jump(200);
    TEST_ASSERT_NOT_EQUAL(last, goals[0]);
    TEST_ASSERT_EQUAL_UINT16(CDS_GAIT_1, gait.rate);
}

void test_abort_stands_still_within_its_deceleration(void)
{
    uint32_t periods = 0;
    uint16_t last = 0, speed = 0;

    begin_gait();
    for (uint32_t i = 0; i < RAMP + 200; i++)
        pass_period();
    cds_gait_abort(&gait, 4000);
    while (pass_period() == CDS_PENDING) {
        uint16_t now_is = (uint16_t)(speeds[2] - joints[2].reserve);

        if (periods++ > 2 && now_is < speed)
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(16 + 12 + 8, speed - now_is); // and the sine, rounding
        speed = now_is;
        last = goals[0];
    }
    TEST_ASSERT_EQUAL(CDS_CANCELLED, gait.result);
    TEST_ASSERT_UINT32_WITHIN(4, gait.peak / 16, periods);
    TEST_ASSERT_EQUAL_UINT16(last, goals[0]);
    pass_period();
    TEST_ASSERT_EQUAL_UINT16(last, goals[0]);
}

void test_goal_that_the_permit_refuses_ends_the_gait(void)
{
    begin_gait();
    for (uint32_t i = 0; i < RAMP; i++)
        pass_period();
    cds_servos_inhibit(&servos, &states[2], CDS_INHIBIT_STOPPED);
    for (uint32_t i = 0; gait.result == CDS_PENDING; i++) {
        TEST_ASSERT_LESS_THAN_UINT32(70, i);
        pass_period();
    }
    TEST_ASSERT_EQUAL(CDS_INHIBITED, gait.result);
    TEST_ASSERT_EQUAL_UINT8(2, gait.joint);
    TEST_ASSERT_EQUAL_UINT16(CDS_CYCLE_NO_GOAL, cds_cycle_sent_goal(&cycle, 2));
    TEST_ASSERT_EQUAL_UINT16(goals[1], cds_cycle_sent_goal(&cycle, 1));
}

void test_abort_of_a_paused_gait_ends_it(void)
{
    begin_gait();
    for (uint32_t i = 0; i < RAMP; i++)
        pass_period();
    cds_gait_pause(&gait, 60000);
    for (uint8_t i = 0; i < 10; i++)
        TEST_ASSERT_EQUAL(CDS_PENDING, pass_period());
    cds_gait_abort(&gait, 60000);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, pass_period());
}

void test_stop_resumes_a_paused_gait(void)
{
    begin_gait();
    for (uint32_t i = 0; i < RAMP; i++)
        pass_period();
    cds_gait_pause(&gait, 60000);
    for (uint8_t i = 0; i < 10; i++)
        pass_period();
    cds_gait_stop(&gait);
    for (uint32_t i = 0; gait.result == CDS_PENDING; i++) {
        TEST_ASSERT_LESS_THAN_UINT32(RAMP + 10, i);
        pass_period();
    }
    TEST_ASSERT_EQUAL(CDS_OK, gait.result);
    TEST_ASSERT_EQUAL_UINT16(512, goals[0]);
}

/* ---- changes at random ---- */

static void change_at_random(void)
{
    int8_t percent = (int8_t)(rand() % 201 - 100);

    switch (rand() % 40) {
    case 0:
    case 1: cds_gait_set_scale(&gait, (uint8_t)(rand() % CDS_GAIT_GROUPS), percent); break;
    case 2: cds_gait_set_speed(&gait, percent); break;
    case 3: cds_gait_pause(&gait, (uint16_t)((uint16_t)rand() % 20000 + 1)); break;
    case 4:
    case 5: cds_gait_resume(&gait); break;
    default: break;
    }
}

static void assert_within_reach(void)
{
    for (uint8_t i = 0; i < JOINTS; i++) {
        uint16_t reach = 1; // rounding

        if (i == 3)
            continue;
        for (uint8_t j = 0; j < CDS_GAIT_SINES; j++)
            reach = (uint16_t)(reach + (uint16_t)abs(table[i].sines[j].amplitude));
        TEST_ASSERT_UINT16_WITHIN(reach, table[i].rest, goals[i]);
    }
}

void test_changes_at_random_do_not_jump_or_leave_the_reach(void)
{
    srand(18);
    begin_gait();
    for (uint32_t i = 0; i < RAMP + 1; i++)
        pass_period();
    for (uint32_t i = 0; i < MANY; i++) {
        change_at_random();
        pass_without_a_jump(1);
        assert_within_reach();
    }
    TEST_ASSERT_EQUAL(CDS_PENDING, gait.result);
    cds_gait_stop(&gait);
    for (uint32_t i = 0; gait.result == CDS_PENDING; i++) {
        TEST_ASSERT_LESS_THAN_UINT32(30000, i); // the last deceleration was perhaps 1
        pass_period();
    }
    TEST_ASSERT_EQUAL(CDS_OK, gait.result);
    for (uint8_t i = 0; i < JOINTS; i++)
        TEST_ASSERT_EQUAL_UINT16(i == 3 ? 450 : table[i].rest, goals[i]);
}
