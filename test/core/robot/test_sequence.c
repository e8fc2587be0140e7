/* SPDX-License-Identifier: MIT */
/* Sequences of two joints. The clock moves from one period to the next. */
#include "cds55xx/sequence.h"

#include <string.h>

#define JOINTS 2

#include "motion_rig.h"
#include "robot/motion_internal.h"

#ifdef __AVR__
#define RANDOM_SEQUENCES 8
#else
#define RANDOM_SEQUENCES 240
#endif

static struct cds_sequence sequence;
static uint16_t poses[2 * JOINTS];

static struct {
    struct cds_sequence_step step;
    uint16_t pose[JOINTS];
} steps[4];
static uint8_t step_count;

static uint16_t periods; // since setUp()
static uint16_t told_at[16];
static uint8_t told[16], told_count;
static bool may;
static bool checks_all;

static bool read_step(void *context, uint8_t index, struct cds_sequence_step *step, uint16_t *pose)
{
    TEST_ASSERT_EQUAL_PTR(steps, context);
    if (index >= step_count)
        return false;
    *step = steps[index].step;
    memcpy(pose, steps[index].pose, sizeof steps[index].pose);
    return true;
}

static bool may_begin(void *context, uint8_t index)
{
    (void)context;
    return index != 1 || may;
}

static void on_pose(void *context, uint8_t index, uint8_t event)
{
    (void)context;
    (void)event;
    told_at[told_count] = periods;
    told[told_count++] = index;
}

static void add_step(uint16_t position, uint16_t time_ms, uint16_t dwell_ms, bool passes)
{
    steps[step_count].step = (struct cds_sequence_step){
        .time_ms = time_ms, .dwell_ms = dwell_ms, .passes = passes, .event = step_count};
    steps[step_count].pose[0] = position;
    steps[step_count++].pose[1] = CDS_POSE_NONE;
}

void setUp(void)
{
    rig_begin_joints(500);
    rig_begin_cycle(PERIOD_US);
    memset(&sequence, 0, sizeof sequence);
    step_count = told_count = 0;
    periods = 0;
    may = true;
    checks_all = false;
    rig_begin_motion(0);
}

void tearDown(void)
{
    rig_check();
}

static void begin(uint16_t repeats)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sequence_begin(
                                  &sequence, &(struct cds_sequence_config){.motion = &motion,
                                                                           .poses = poses,
                                                                           .context = steps,
                                                                           .read = read_step,
                                                                           .may_begin = may_begin,
                                                                           .on_pose = on_pose,
                                                                           .checks_all = checks_all,
                                                                           .repeats = repeats}));
}

static void pass_period(void)
{
    for (uint8_t i = 0; i < 20; i++)
        cds_sequence_poll(&sequence);
    rig_send_goals();
    for (uint8_t i = 0; i < JOINTS; i++) {
        feedback[i].position = goals[i];
        feedback[i].time_us = port_fake.now_us;
    }
    periods++;
}

static void run_to_end(void)
{
    while (sequence.result == CDS_PENDING) {
        TEST_ASSERT_LESS_THAN_UINT16(3000, periods);
        pass_period();
    }
}

void test_sequence_of_two_runs_reports_each_pose(void)
{
    add_step(600, 400, 200, false);
    add_step(500, 400, 0, false);
    begin(2);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(4, told_count);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((uint8_t[]){0, 1, 0, 1}), told, 4);
    TEST_ASSERT_UINT16_WITHIN(2, 100, told_at[0]);
    TEST_ASSERT_UINT16_WITHIN(4, 250, told_at[1]); // 50 of rest
    TEST_ASSERT_UINT16_WITHIN(6, 350, told_at[2]);
    TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
    TEST_ASSERT_EQUAL_UINT16(1, sequence.run);
}

void test_sequence_ends_after_the_rest_of_its_last_step(void)
{
    add_step(600, 400, 200, false);
    begin(1);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_UINT16_WITHIN(2, told_at[0] + 50, periods);
}

void test_passed_poses_are_reached_without_a_stop(void)
{
    uint16_t last = 500;

    add_step(600, 400, 0, true);
    add_step(700, 400, 0, true);
    add_step(800, 400, 0, true); // the last one does not pass
    begin(1);
    while (sequence.result == CDS_PENDING) {
        pass_period();
        TEST_ASSERT_GREATER_OR_EQUAL_UINT16(last, goals[0]);
        if (periods > 60 && periods < 240)
            TEST_ASSERT_NOT_EQUAL(last, goals[0]);
        last = goals[0];
    }
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_EQUAL_UINT16(800, goals[0]);
    TEST_ASSERT_UINT16_WITHIN(3, 301, periods);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((uint8_t[]){0, 1, 2}), told, 3);
    TEST_ASSERT_EQUAL_UINT8(3, told_count);
}

void test_endless_sequence_runs_until_it_is_aborted(void)
{
    add_step(600, 400, 0, true);
    add_step(400, 400, 0, true);
    begin(0);
    for (uint16_t i = 0; i < 1000; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_PENDING, sequence.result);
    TEST_ASSERT_UINT8_WITHIN(1, 9, told_count);
    cds_sequence_abort(&sequence, 4000);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, sequence.result);
    for (uint16_t i = 0; i < 100; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
}

void test_step_waits_until_it_may_begin(void)
{
    add_step(600, 400, 0, false);
    add_step(500, 400, 0, false);
    may = false;
    begin(1);
    for (uint16_t i = 0; i < 300; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_PENDING, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(0, sequence.step);
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
    may = true;
    run_to_end();
    TEST_ASSERT_EQUAL_UINT8(1, sequence.step);
    TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
}

void test_step_is_that_of_the_pose_where_the_joints_rest(void)
{
    add_step(600, 400, 200, false);
    add_step(500, 400, 200, false);
    begin(2);
    for (uint8_t rest = 1; rest <= 4; rest++) {
        while (told_count < rest)
            pass_period();
        for (uint8_t i = 0; i < 48; i++) {
            TEST_ASSERT_EQUAL_UINT8((rest - 1) % 2, sequence.step);
            TEST_ASSERT_EQUAL_UINT16((rest - 1) / 2, sequence.run);
            pass_period();
        }
    }
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
}

void test_pause_during_a_dwell_holds_the_next_step_back(void)
{
    add_step(600, 400, 200, false);
    add_step(500, 400, 0, false);
    begin(1);
    while (told_count == 0)
        pass_period();
    cds_sequence_pause(&sequence, 8000);
    for (uint8_t i = 0; i < 200; i++)
        pass_period();
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
    cds_sequence_resume(&sequence);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
}

void test_step_that_is_too_fast_ends_the_sequence(void)
{
    add_step(600, 400, 0, false);
    add_step(0, 40, 0, false);
    begin(1);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_LIMIT, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(1, sequence.step);
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
}

void test_too_fast_step_after_a_passed_pose_ends_sequence(void)
{
    add_step(600, 400, 0, true);
    add_step(1000, 40, 0, false);
    begin(1);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_LIMIT, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(1, sequence.step);
    for (uint8_t i = 0; i < 100; i++)
        pass_period();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, motion.result);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(600, goals[0]);
}

/* The steps are tried meanwhile; the first one does not begin before the resume. */
void test_pause_during_the_check_holds_the_first_step_back(void)
{
    checks_all = true;
    add_step(600, 400, 0, false);
    begin(1);
    cds_sequence_poll(&sequence);
    cds_sequence_pause(&sequence, 8000);
    for (uint8_t i = 0; i < 100; i++)
        pass_period();
    TEST_ASSERT_FALSE(sequence.is_checking);
    TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
    cds_sequence_resume(&sequence);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
}

void test_pause_of_a_sequence_ends_with_its_refusal(void)
{
    checks_all = true;
    add_step(0, 40, 0, false);
    begin(1);
    cds_sequence_poll(&sequence);
    cds_sequence_pause(&sequence, 8000);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_LIMIT, sequence.result);
    TEST_ASSERT_FALSE(motion.is_paused);
}

static bool read_any_step(void *context, uint8_t index, struct cds_sequence_step *step,
                          uint16_t *pose)
{
    (void)context;
    *step = (struct cds_sequence_step){.time_ms = 8};
    pose[0] = (uint16_t)(500 + index % 2);
    pose[1] = CDS_POSE_NONE;
    return true;
}

void test_sequence_ends_after_256_steps(void)
{
    TEST_ASSERT_EQUAL(
        CDS_OK, cds_sequence_begin(&sequence, &(struct cds_sequence_config){.motion = &motion,
                                                                            .poses = poses,
                                                                            .read = read_any_step,
                                                                            .repeats = 1}));
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(255, sequence.step);
}

void test_begin_without_steps_or_during_a_move_is_refused(void)
{
    struct cds_sequence_config config = {
        .motion = &motion, .poses = poses, .context = steps, .read = read_step};

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_sequence_begin(&sequence, &config));
    add_step(600, 400, 0, false);
    begin(1);
    pass_period();
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_sequence_begin(&sequence, &config));
    run_to_end();
}

/* ---- all steps are checked first ---- */

static void come_to_rest(void)
{
    for (uint8_t i = 0; i < 100; i++)
        pass_period();
}

void test_too_fast_step_is_refused_before_the_first_one_begins(void)
{
    checks_all = true;
    add_step(600, 400, 0, false);
    add_step(400, 400, 0, true);
    add_step(0, 40, 0, false);
    begin(1);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_LIMIT, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(2, sequence.step);
    TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
}

/* Runs three steps; step 1 passes its pose. `wrong` has no time. */
static void run_with_wrong_step(uint8_t wrong, bool checks)
{
    checks_all = checks;
    step_count = 0;
    add_step(520, 400, 0, false);
    add_step(540, 400, 0, true);
    add_step(560, 400, 0, false);
    steps[wrong].step.time_ms = 0;
    begin(1);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(wrong, sequence.step);
    come_to_rest();
}

void test_step_out_of_range_is_named_also_behind_a_passed_pose(void)
{
    for (uint8_t wrong = 0; wrong < 3; wrong++) {
        run_with_wrong_step(wrong, true);
        TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
    }
    for (uint8_t wrong = 0; wrong < 3; wrong++)
        run_with_wrong_step(wrong, false);
}

/* Two passed poses one after the other: the step is found out of range while the joints move. */
void test_step_out_of_range_is_named_under_way(void)
{
    add_step(520, 400, 0, true);
    add_step(540, 400, 0, true);
    add_step(560, 0, 0, false);
    begin(1);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(2, sequence.step);
    come_to_rest();
}

void test_way_back_to_the_first_step_is_checked_if_repeated(void)
{
    checks_all = true;
    add_step(500, 40, 0, false);
    add_step(1000, 1500, 0, false);
    begin(2);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_LIMIT, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(0, sequence.step);
    TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
    begin(1);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_EQUAL_UINT16(1000, goals[0]);
}

void test_checked_sequence_reports_each_pose_once(void)
{
    checks_all = true;
    add_step(600, 400, 0, true);
    add_step(700, 400, 0, false);
    begin(2);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_EQUAL_UINT8(4, told_count);
}

static uint8_t polls_of_check(bool passes)
{
    uint8_t polls = 0;

    setUp();
    checks_all = true;
    add_step(600, 400, 0, passes);
    add_step(700, 400, 0, false);
    for (begin(1); sequence.is_checking; polls++)
        cds_sequence_poll(&sequence);
    TEST_ASSERT_EQUAL(CDS_PENDING, sequence.result);
    return polls;
}

/* As sequence.h says: 7 a step, and 3 or 4 for each servo. */
void test_check_takes_up_to_4_polls_for_each_servo_and_step(void)
{
    TEST_ASSERT_EQUAL_UINT8(2 * (7 + 3 * JOINTS), polls_of_check(false));
    TEST_ASSERT_EQUAL_UINT8(2 * (7 + 4 * JOINTS), polls_of_check(true));
}

/* Result of a run of the steps. */
static enum cds_result run_all(bool checks, uint16_t repeats)
{
    rig_begin_joints(500);
    rig_begin_cycle(PERIOD_US);
    rig_begin_motion(8000);
    told_count = 0;
    periods = 0;
    checks_all = checks;
    begin(repeats);
    run_to_end();
    come_to_rest();
    return (enum cds_result)sequence.result;
}

/* What the check refuses is what the motion refuses under way, and nothing moves before. */
void test_check_agrees_with_the_motion_at_random(void)
{
    uint8_t refused = 0, played = 0;

    for (uint8_t trial = 0; trial < RANDOM_SEQUENCES; trial++) {
        uint16_t repeats = (uint16_t)(1 + random_below(2));
        enum cds_result result;
        uint32_t shortest_ms;
        uint8_t step;

        step_count = 0;
        for (uint8_t i = 0; i < 4; i++) {
            add_step(random_below(1024), (uint16_t)(300 + random_below(1100)), 0, random_below(2));
            if (random_below(2))
                steps[i].pose[1] = random_below(1024);
            steps[i].step.curve =
                (uint8_t)(random_below(4) ? CDS_MOTION_MINIMUM_JERK : random_below(4));
            steps[i].step.acceleration = 4000;
        }
        result = run_all(true, repeats);
        if (result == CDS_OK) {
            played++;
            continue;
        }
        refused++;
        TEST_ASSERT_EQUAL(CDS_LIMIT, result);
        TEST_ASSERT_EQUAL_UINT16(500, goals[0]);
        TEST_ASSERT_EQUAL_UINT16(500, goals[1]);
        shortest_ms = motion.shortest_ms;
        step = sequence.step;
        TEST_ASSERT_EQUAL(CDS_LIMIT, run_all(false, repeats));
        TEST_ASSERT_EQUAL_UINT8(step, sequence.step);
        TEST_ASSERT_EQUAL_UINT32(shortest_ms, motion.shortest_ms);
    }
    TEST_ASSERT_GREATER_THAN_UINT8(RANDOM_SEQUENCES / 8, refused);
    TEST_ASSERT_GREATER_THAN_UINT8(RANDOM_SEQUENCES / 8, played);
}

/* ---- override ---- */

/* Four steps up, one way: 100 periods at 100 %. */
static void add_steps_that_pass(void)
{
    for (uint8_t i = 1; i <= 4; i++)
        add_step((uint16_t)(500 + 25 * i), 100, 0, i < 4);
}

static uint16_t periods_of_run(bool checks, uint8_t percent)
{
    setUp();
    add_steps_that_pass();
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, percent));
    checks_all = checks;
    begin(1);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    TEST_ASSERT_EQUAL_UINT16(600, goals[0]);
    return periods;
}

void test_override_shortens_steps_that_pass_if_they_were_tried(void)
{
    uint16_t tried = periods_of_run(true, 100);

    TEST_ASSERT_UINT16_WITHIN(4, tried - 33, periods_of_run(true, 150));
    TEST_ASSERT_UINT16_WITHIN(4, tried - 50, periods_of_run(true, 200));
    TEST_ASSERT_UINT16_WITHIN(4, 100, periods_of_run(false, 200));
}

/* The way from where the joint is to the first pose needs most of the speed. */
void test_first_step_at_its_limit_does_not_slow_the_next_ones(void)
{
    uint32_t rate = 0;

    setUp();
    feedback[0].position = 420;
    rig_begin_cycle_and_motion(PERIOD_US);
    add_steps_that_pass();
    steps[0].pose[0] = 500;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, &states[0], 0, 1023, 1000));
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, 200));
    steps[0].step.time_ms = 120;
    checks_all = true;
    begin(1);
    while (told_count == 0) {
        rate = motion.rate;
        pass_period();
    }
    TEST_ASSERT_LESS_THAN_UINT32(CDS_MOTION_RATE_1 * 5 / 4, rate); // at the end of the first step
    while (told_count < 3)
        pass_period();
    TEST_ASSERT_GREATER_THAN_UINT32(CDS_MOTION_RATE_1 * 3 / 2, motion.rate);
    run_to_end();
    TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
}

void test_override_shortens_a_first_step_of_one_second(void)
{
    setUp();
    add_steps_that_pass();
    steps[0].step.time_ms = 1000;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, 200));
    checks_all = true;
    begin(1);
    while (told_count == 0)
        pass_period();
    TEST_ASSERT_UINT16_WITHIN(4, 125, periods);
    run_to_end();
}

/* Joint 0 passes a pose 1 step from its limit, with the speed of 1 step in 1.2 s. Joint 1, much
 * faster, must not brake for that. */
void test_pass_of_pose_next_to_limit_brakes_no_other_joint(void)
{
    for (uint8_t percent = 100; percent <= 200; percent = (uint8_t)(percent + 100)) {
        int16_t speed, last = 0;

        setUp();
        feedback[0].position = 980;
        add_step(1000, 2500, 0, true);
        add_step(1022, 1200, 0, true);
        add_step(1023, 1200, 0, false);
        for (uint8_t i = 0; i < 3; i++)
            steps[i].pose[1] = (uint16_t)(100 + 200 * i);
        TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, percent));
        checks_all = true;
        begin(1);
        while (sequence.result == CDS_PENDING) {
            pass_period();
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(1023, goals[0]);
            speed = (int16_t)(cds_motion_speed(&joints[1], &motion.basis) / CDS_MOTION_QUARTERS);
            TEST_ASSERT_INT_WITHIN(32, last, speed); // 8000 units/s
            last = speed;
        }
        TEST_ASSERT_EQUAL(CDS_OK, sequence.result);
    }
}

/* Anywhere, or within 3 steps of a limit. */
static uint16_t random_position(void)
{
    switch (random_below(6)) {
    case 0: return random_below(4);
    case 1: return (uint16_t)(1020 + random_below(4));
    default: return random_below(1024);
    }
}

/* Above 100 % no joint exceeds its speed, and the paths are those of 100 %: no move has to begin
 * with a lower rate than the one before has ended with. A joint brakes during the whole move. */
void test_override_keeps_speeds_and_paths_at_random(void)
{
    uint16_t faster = 0;

    for (uint8_t trial = 0; trial < RANDOM_SEQUENCES; trial++) {
        setUp();
        rig_begin_motion(random_below(2) ? 8000 : 0);
        for (uint8_t i = 0; i < 4; i++) {
            add_step(random_position(), (uint16_t)(400 + random_below(1600)), 0, i < 3);
            if (random_below(2))
                steps[i].pose[1] = random_position();
        }
        TEST_ASSERT_EQUAL(CDS_OK,
                          cds_motion_set_override(&motion, (uint8_t)(101 + random_below(100))));
        checks_all = true;
        begin(2);
        while (sequence.result == CDS_PENDING) {
            pass_period();
            if (!motion.is_under_way)
                continue;
            if (joints[0].begin_speed || joints[1].begin_speed)
                TEST_ASSERT_EQUAL_UINT32(motion.plan.duration, motion.plan.window);
            if (motion.rate <= CDS_MOTION_RATE_1)
                continue;
            faster++;
            for (uint8_t i = 0; i < JOINTS; i++) {
                uint16_t speed = (uint16_t)abs(cds_motion_speed(&joints[i], &motion.basis));

                if (joints[i].begin_speed)
                    TEST_ASSERT_LESS_OR_EQUAL_UINT16(CDS_MOTION_CARRY_1 + 16, motion.carry);
                TEST_ASSERT_LESS_OR_EQUAL_UINT32(1023ul * CDS_MOTION_QUARTERS * 102 / 100,
                                                 speed * (motion.rate >> 4) >> 12);
            }
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT16(RANDOM_SEQUENCES * 20, faster);
}

void test_sequence_that_was_never_begun_does_nothing(void)
{
    cds_sequence_pause(&sequence, 1000);
    cds_sequence_resume(&sequence);
    cds_sequence_abort(&sequence, 1000);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sequence_poll(&sequence));
}

void test_motion_that_was_never_begun_does_nothing(void)
{
    memset(&motion, 0, sizeof motion);
    cds_motion_pause(&motion, 1000);
    cds_motion_resume(&motion);
    cds_motion_abort(&motion, 1000);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_set_override(&motion, 50));
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_poll(&motion));
}
