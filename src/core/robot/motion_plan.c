/* SPDX-License-Identifier: MIT */
/* Is a move possible? See motion.h and docs/internals/motion.md. A distance is counted in register
 * units of speed x periods: divided by the duration it is the mean speed. */
#include <stdlib.h> // abs()

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "compiler.h"              // NOINLINE
#include "robot/curve_internal.h"
#include "robot/motion_internal.h"

#define WINDOW_US ((uint32_t)250000) // longest time of braking
#define SAMPLES   16                 // speeds that are checked in a window and in a move

/* What a poll does: it checks a joint in BRAKING, GOALS and SPEEDS, and notes one in TRIAL_END;
 * else it does a step of the plan. */
enum stage {
    BRAKING, // how long may a joint that moves brake?
    GOALS,   // within the limits? And how long does the joint take from rest?
    DURATION,
    CURVE,
    SPEEDS, // of joints that move at begin or end; if one is too fast: DURATION again
    DECISION,
    TIME,
    BRAKING_TIME,
    OVERRIDE,
    TRIAL_END, // of a trial only
    DONE,
};

/* Periods that `time_ms` lasts, rounded up: 3000000 at most, 600 s with periods of 200 us. */
NOINLINE static uint32_t periods_of(const struct cds_motion *motion, uint32_t time_ms)
{
    uint16_t period_us = motion->config.cycle->period_us;

    return (time_ms * 1000 + period_us - 1) / period_us;
}

/* The basis at which the move begins. */
static const struct cds_motion_basis *basis_before(const struct cds_motion *motion)
{
    return motion->next.waits && motion->is_under_way ? &motion->last_basis : &motion->basis;
}

void cds_motion_begin_check(struct cds_motion *motion)
{
    struct cds_motion_plan *plan = &motion->next_plan;

    plan->duration = periods_of(motion, motion->next.time_ms);
    plan->passes = motion->next.next_pose != NULL;
    plan->next_duration = plan->passes ? periods_of(motion, motion->next.next_ms) : 0;
    motion->longest_window = UINT32_MAX; // a move that waits brakes during its whole time
    if (motion->next.waits)
        cds_motion_set_end(motion, &motion->last_basis);
    else
        motion->longest_window = WINDOW_US / motion->config.cycle->period_us + 1;
    motion->shortest_periods = 1;
    motion->longest_distance = 0;
    motion->shortest_ms = 0;
    motion->has_speeds = false;
    motion->checked = 0;
    motion->follows = motion->next.waits && motion->is_under_way;
    motion->checks_from_rest = basis_before(motion)->is_at_rest;
    motion->stage = motion->checks_from_rest && !motion->is_trial ? GOALS : BRAKING;
    motion->move_result = CDS_PENDING;
}

NOINLINE uint32_t cds_motion_speed_change(const struct cds_motion *motion, uint16_t acceleration)
{
    uint32_t change = (uint32_t)acceleration * motion->config.cycle->period_us / 62500ul;

    return change ? change : 1;
}

/* Change of speed in a period, of a trapezoid: what the move asks for, or what the joints can.
 * noinline: saves 30 bytes of atmega1284p/full.elf. */
static NOINLINE uint32_t trapezoid_change(const struct cds_motion *motion)
{
    uint16_t most = motion->config.acceleration, requested = motion->next.acceleration;

    return cds_motion_speed_change(motion, most && most < requested ? most : requested);
}

NOINLINE static uint32_t root_up(uint32_t square)
{
    uint32_t root = cds_curve_root(square);

    return root * root < square ? root + 1 : root;
}

/* Periods that a trapezoid takes at least for `distance`. It reaches the speed `fastest` only if
 * the distance is long enough; else it is a triangle. */
static uint32_t shortest_trapezoid(uint32_t distance, uint16_t fastest, uint32_t change)
{
    uint32_t to_fastest = ((uint32_t)fastest * CDS_MOTION_UNIT + change - 1) / change;

    if (to_fastest * fastest <= distance)
        return (distance + fastest - 1) / fastest + to_fastest;
    return 2 * root_up(distance * CDS_MOTION_UNIT / change + 1);
}

/* Fewest periods in which minimum jerk stays within config.acceleration: its peak is 5.774 distance
 * / time^2. */
static uint32_t shortest_minimum_jerk(const struct cds_motion *motion, uint32_t distance)
{
    uint16_t most = motion->config.acceleration;

    if (most == 0)
        return 0;
    return root_up(distance * 370 / 4 / cds_motion_speed_change(motion, most) + 1);
}

/* Periods that a joint takes at least for `distance` from rest. */
static uint32_t shortest_from_rest(const struct cds_motion *motion, uint32_t distance,
                                   uint16_t fastest)
{
    uint32_t by_speed = (distance + fastest - 1) / fastest, by_acceleration = 0;

    switch (motion->next.curve) {
    case CDS_MOTION_TRAPEZOID:
        return shortest_trapezoid(distance, fastest, trapezoid_change(motion));
    case CDS_MOTION_MINIMUM_JERK: // peak: 15/8 of the mean speed
        by_speed = (distance * 15 / 8 + fastest - 1) / fastest;
        by_acceleration = shortest_minimum_jerk(motion, distance);
        break;
    default: break;
    }
    return by_speed > by_acceleration ? by_speed : by_acceleration;
}

/* Shortens the windows so that the joint brakes within its limits. Up to 1/8 step beyond is
 * permitted, since goals are clamped. Without it, rounding shortens the windows for a joint that
 * passes a pose next to its limit. */
static void narrow_window(struct cds_motion *motion, const struct cds_motion_path *path,
                          const struct cds_motion_joint *joint)
{
    int16_t speed = path->begin_speed, end = speed > 0 ? joint->highest + 1 : joint->lowest - 1;
    int32_t periods = (int32_t)(end - path->position) * joint->scale / ((int32_t)speed * 4);

    if (periods < 1)
        periods = 1;
    if ((uint32_t)periods < motion->longest_window)
        motion->longest_window = (uint32_t)periods;
}

/* Returns a distance in 1/8 step as register units of speed x periods. */
static uint32_t units_of(const struct cds_motion_joint *joint, uint16_t distance)
{
    return ((uint32_t)distance * joint->scale >> 7) + 1;
}

/* Notes how many periods joint `index` takes at least. A joint that moves at the beginning or at
 * the end is checked later, when the curve is known. */
static void note_shortest(struct cds_motion *motion, uint8_t index,
                          const struct cds_motion_path *path, uint16_t fastest)
{
    uint32_t units = units_of(&motion->config.joints[index],
                              (uint16_t)abs(path->position - path->goal)),
             periods;

    if (units > motion->longest_distance)
        motion->longest_distance = units;
    if (path->begin_speed || path->end_speed) {
        motion->has_speeds = true;
        return;
    }
    periods = shortest_from_rest(motion, units, fastest);
    if (periods > motion->shortest_periods) {
        motion->shortest_periods = periods;
        motion->joint = index;
    }
}

NOINLINE const struct cds_servo_state *cds_motion_servo(const struct cds_motion *motion,
                                                        uint8_t index)
{
    if (!motion->config.servos)
        return NULL;
    return cds_servos_find(motion->config.servos, motion->config.cycle->ids[index]);
}

/* First check of joint `index`: how long it may brake. Notes its limits. */
static enum cds_result check_braking(struct cds_motion *motion, uint8_t index)
{
    struct cds_motion_joint *joint = &motion->config.joints[index];
    const struct cds_servo_state *servo;
    struct cds_motion_path path;

    if (motion->next.pose[index] == CDS_POSE_NONE && !joint->is_moving)
        return CDS_OK;
    if (!cds_motion_find_path(motion, index, basis_before(motion), motion->next_plan.duration,
                              &path))
        return CDS_TIMEOUT;
    servo = cds_motion_servo(motion, index);
    joint->lowest = servo ? (int16_t)(servo->lowest * CDS_MOTION_STEP) : 0;
    joint->highest = (int16_t)((servo ? servo->highest : CDS_VALUE_MAX) * CDS_MOTION_STEP);
    if (path.begin_speed)
        narrow_window(motion, &path, joint);
    return CDS_OK;
}

/* True if the goals of a joint are within its limits from the first to the last one. By the servo
 * the first goal is the last one. */
static bool is_within_limits(const struct cds_motion *motion, const struct cds_motion_path *path,
                             uint16_t lowest, uint16_t highest)
{
    int16_t low = (int16_t)(lowest * CDS_MOTION_STEP), high = (int16_t)(highest * CDS_MOTION_STEP);

    if (path->goal < low || path->goal > high)
        return false;
    return motion->next.curve == CDS_MOTION_BY_SERVO ||
           (path->position >= low && path->position <= high);
}

/* Second check of joint `index`: where it begins, its goal, and the time that it takes from rest.
 */
static enum cds_result check_goal(struct cds_motion *motion, uint8_t index)
{
    uint16_t lowest = 0, highest = CDS_VALUE_MAX, fastest = CDS_VALUE_MAX;
    const struct cds_servo_state *servo;
    struct cds_motion_path path;

    if (motion->next.pose[index] == CDS_POSE_NONE)
        return CDS_OK;
    if (!cds_motion_find_path(motion, index, basis_before(motion), motion->next_plan.duration,
                              &path))
        return CDS_TIMEOUT;
    servo = cds_motion_servo(motion, index);
    if (servo) {
        if (!cds_servos_may_drive(motion->config.servos, servo->id))
            return CDS_INHIBITED;
        lowest = servo->lowest;
        highest = servo->highest;
        fastest = servo->fastest;
    }
    if (fastest == 0 || !is_within_limits(motion, &path, lowest, highest))
        return CDS_LIMIT;
    motion->config.joints[index].fastest = (uint16_t)(fastest * CDS_MOTION_QUARTERS);
    note_shortest(motion, index, &path, fastest);
    return CDS_OK;
}

/* ---- the plan, when the goals of all joints are checked ---- */

/* Chooses the duration that is tried next. */
static enum cds_result choose_duration(struct cds_motion *motion)
{
    struct cds_motion_plan *plan = &motion->next_plan;

    if (plan->duration < motion->shortest_periods)
        plan->duration = motion->shortest_periods;
    plan->window = plan->duration;
    if (plan->window > motion->longest_window)
        plan->window = motion->longest_window;
    return plan->duration <= periods_of(motion, CDS_MOTION_TIME_MAX_MS) ? CDS_OK : CDS_LIMIT;
}

static void set_curve(struct cds_motion *motion)
{
    struct cds_motion_plan *plan = &motion->next_plan;
    uint32_t mean_speed = motion->longest_distance * CDS_MOTION_UNIT / plan->duration;
    uint32_t ramp_ratio = CDS_CURVE_TRIANGLE;

    if (motion->next.curve == CDS_MOTION_TRAPEZOID) {
        if (mean_speed <= UINT16_MAX)
            ramp_ratio = (mean_speed << 16) / trapezoid_change(motion) / plan->duration;
        cds_curve_set_trapezoid(&plan->curve, ramp_ratio < CDS_CURVE_TRIANGLE ? (uint16_t)ramp_ratio
                                                                              : CDS_CURVE_TRIANGLE);
    } else {
        cds_curve_set(&plan->curve, motion->next.curve);
    }
    plan->peak = mean_speed * plan->curve.rate / CDS_CURVE_RATE_1 + 1;
}

/* ---- speeds of joints that move at the beginning or at the end ---- */

/* Raises *peak to the speed of the joint, in 1/4 unit, at the share `time` of the move and the
 * share `braking` of the window. */
static void note_speed(const struct cds_motion_plan *plan, const struct cds_motion_joint *joint,
                       uint16_t time, uint16_t braking, uint16_t *peak)
{
    struct cds_motion_basis basis = {
        .rate = cds_curve_rate(&plan->curve, time),
        .braking_rate = cds_curve_braking_rate(braking),
        .passing_rate = cds_curve_braking_rate((uint16_t)~time),
    };
    uint16_t speed = (uint16_t)abs(cds_motion_speed(joint, &basis));

    if (speed > *peak)
        *peak = speed;
}

/* Returns window / duration, in 1/65536. */
static uint32_t share_of_window(const struct cds_motion_plan *plan)
{
    uint32_t window = plan->window, duration = plan->duration;

    for (; window > UINT16_MAX; window >>= 1)
        duration >>= 1;
    return (window << 16) / duration;
}

/* Returns the highest speed of the joint, in 1/4 unit: in the window, behind the window, and where
 * the speed of a trapezoid has its corners. */
static uint16_t peak_speed(const struct cds_motion_plan *plan, const struct cds_motion_joint *joint)
{
    uint32_t window = share_of_window(plan);
    uint16_t ramp = plan->curve.ramp, braking = UINT16_MAX, peak = 0;

    for (uint8_t i = 0; i < SAMPLES; i++) {
        uint16_t share = (uint16_t)(i * (65536ul / SAMPLES));

        note_speed(plan, joint, (uint16_t)(i * window / SAMPLES), share, &peak);
        if (share >= window)
            note_speed(plan, joint, share, UINT16_MAX, &peak);
    }
    if (plan->curve.kind == CDS_MOTION_TRAPEZOID) {
        if (ramp < window)
            braking = (uint16_t)(((uint32_t)ramp << 16) / window);
        note_speed(plan, joint, ramp, braking, &peak);
        note_speed(plan, joint, (uint16_t)~ramp, UINT16_MAX, &peak);
    }
    return peak;
}

static void note_periods(struct cds_motion *motion, uint32_t periods)
{
    if (periods > motion->shortest_periods)
        motion->shortest_periods = periods;
}

/* Notes in how many periods the joint, with the highest speed `peak`, can go the same path. */
static void note_fastest_way(struct cds_motion *motion, const struct cds_motion_joint *joint,
                             uint16_t peak)
{
    uint32_t duration = motion->next_plan.duration;
    uint16_t distance;

    note_periods(motion, (duration + 3) / 4 * peak / (joint->fastest / 4) + 1);
    // braking and speeding up: 3/2 of the difference of their distances / time^2, as 1/4 of 5.774
    distance = (uint16_t)(abs(joint->distance) + abs(joint->passing - joint->braking) / 4);
    note_periods(motion, shortest_minimum_jerk(motion, units_of(joint, distance)));
}

/* Third check of joint `index`: its speed. CDS_PENDING: the joint is too fast, and a duration 1/8
 * longer is tried. A joint that rests now is checked, too: if it was moving in check_goal(), its
 * shortest time was not noted there. */
static enum cds_result check_speed(struct cds_motion *motion, uint8_t index)
{
    const struct cds_motion_plan *plan = &motion->next_plan;
    struct cds_motion_joint joint = motion->config.joints[index];
    struct cds_motion_path path;
    uint16_t peak;

    if (!motion->has_speeds || motion->next.pose[index] == CDS_POSE_NONE)
        return CDS_OK;
    if (!cds_motion_find_path(motion, index, basis_before(motion), plan->duration, &path))
        return CDS_TIMEOUT;
    cds_motion_set_path(&joint, &path, plan);
    peak = peak_speed(plan, &joint);
    // what is sent is limited to joint.fastest: a servo catches up 1/8
    if (peak > joint.fastest + joint.fastest / 8) {
        motion->shortest_periods = plan->duration + plan->duration / 8 + 1;
        motion->joint = index;
        return CDS_PENDING;
    }
    note_fastest_way(motion, &joint, peak);
    return CDS_OK;
}

/* ---- the rest of the plan ---- */

static enum cds_result decide(struct cds_motion *motion)
{
    uint32_t duration = motion->next_plan.duration;

    if (motion->shortest_periods > duration) // a joint with speeds may have 1/8 more speed
        motion->shortest_periods = duration;
    if (duration <= periods_of(motion, motion->next.time_ms))
        return CDS_OK;
    motion->shortest_ms = (duration * motion->config.cycle->period_us + 999) / 1000;
    return motion->next.may_take_longer ? CDS_OK : CDS_LIMIT;
}

/* The clock runs from 0 to 1 in `periods`, 1 or more, at 100 %. */
static void start_clock(struct cds_motion_clock *clock, uint32_t periods)
{
    uint32_t rest; // of the division, which goes on by 8 bits at a time

    *clock = (struct cds_motion_clock){.step = UINT32_MAX};
    if (periods == 1)
        return;
    clock->step = UINT32_MAX / periods;
    rest = UINT32_MAX % periods + 1;
    if (rest == periods) { // a power of two divides without a rest
        clock->step++;
        return;
    }
    rest <<= 8;
    clock->step_low = (uint16_t)(rest / periods << 8);
    clock->step_low = (uint16_t)(clock->step_low + (rest % periods << 8) / periods);
}

/* The highest rate of the time at which speed and acceleration stay within what was checked; at
 * most pass_rate beside a passed pose. */
static uint32_t highest_rate(const struct cds_motion *motion)
{
    uint32_t duration = motion->next_plan.duration, shortest = motion->shortest_periods;
    uint32_t most = 2 * CDS_MOTION_RATE_1, rate;

    if (motion->has_speeds)
        most = motion->next.pass_rate;
    if (most < CDS_MOTION_RATE_1 ||
        (motion->next.curve == CDS_MOTION_TRAPEZOID && motion->config.acceleration))
        return CDS_MOTION_RATE_1;
    if (duration / 2 >= shortest)
        return most;
    for (; duration > UINT16_MAX; duration >>= 1, shortest = (shortest >> 1) + 1) {
    }
    rate = (duration << 16) / shortest;
    return rate < most ? rate : most;
}

/* The next trial starts from where this one ends. A joint that is not in the pose rests. */
static enum cds_result note_trial_end(struct cds_motion *motion, uint8_t index)
{
    struct cds_motion_joint *joint = &motion->config.joints[index];
    struct cds_motion_path path;

    if (motion->next.pose[index] == CDS_POSE_NONE) {
        joint->trial_speed = 0;
        return CDS_OK;
    }
    if (!cds_motion_find_path(motion, index, basis_before(motion), motion->next_plan.duration,
                              &path))
        return CDS_TIMEOUT;
    joint->trial_end = path.goal;
    joint->trial_speed = path.end_speed;
    joint->is_tried = true;
    return CDS_OK;
}

static enum cds_result check_joint(struct cds_motion *motion, uint8_t index)
{
    switch (motion->stage) {
    case BRAKING: return check_braking(motion, index);
    case GOALS: return check_goal(motion, index);
    case SPEEDS: return check_speed(motion, index);
    default: return note_trial_end(motion, index);
    }
}

/* One step of the plan. Each one divides. */
static enum cds_result do_plan_step(struct cds_motion *motion)
{
    struct cds_motion_plan *plan = &motion->next_plan;

    switch (motion->stage) {
    case DURATION: return choose_duration(motion);
    case CURVE: set_curve(motion); break;
    case DECISION: return decide(motion);
    case TIME: start_clock(&plan->time, plan->duration); break;
    case BRAKING_TIME: start_clock(&plan->braking_time, plan->window); break;
    default: plan->rate_most = highest_rate(motion); break;
    }
    return CDS_OK;
}

/* Joint or stage is done. */
static void go_on(struct cds_motion *motion, bool is_of_joints)
{
    if (is_of_joints && ++motion->checked < motion->count)
        return;
    motion->checked = 0;
    motion->stage++;
    if (motion->stage == SPEEDS && !motion->has_speeds)
        motion->stage++;
    if (motion->stage == TRIAL_END && !motion->is_trial)
        motion->stage++;
}

static bool is_stage_of_joints(uint8_t stage)
{
    return stage <= GOALS || stage == SPEEDS || stage == TRIAL_END;
}

enum cds_result cds_motion_check(struct cds_motion *motion)
{
    bool is_of_joints = is_stage_of_joints(motion->stage);
    enum cds_result result;

    if (motion->checks_from_rest && !basis_before(motion)->is_at_rest) { // resumed during the check
        cds_motion_begin_check(motion);
        return CDS_PENDING;
    }
    motion->carry = CDS_MOTION_CARRY_1; // upper bound: begin_move() lowers it if the rate falls
    if (motion->rate > CDS_MOTION_RATE_1 && !motion->next.waits) // the rate is within pass_rate
        motion->carry = (uint16_t)(motion->rate >> 4);

    result = is_of_joints ? check_joint(motion, motion->checked) : do_plan_step(motion);
    if (result == CDS_PENDING) {
        motion->checked = 0;
        motion->stage = DURATION;
        return result;
    }
    if (result != CDS_OK) {
        if (is_of_joints)
            motion->joint = motion->checked;
        return result;
    }
    go_on(motion, is_of_joints);
    return motion->stage == DONE ? CDS_OK : CDS_PENDING;
}
