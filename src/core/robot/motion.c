/* SPDX-License-Identifier: MIT */
/* Timed moves; see motion.h and docs/internals/motion.md. */
#include "cds55xx/motion.h"

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "compiler.h"              // NOINLINE
#include "robot/curve_internal.h"
#include "robot/motion_internal.h"
#include "robot/rate_internal.h"
#include "servo/cycle_internal.h" // cds_cycle_has_ended_since()

#define JOINTS_PER_POLL 6
#define BEGIN_COST      5 // a joint that begins a move costs as much as 5 more joints: it divides
/* Speed of one step per period, in 1/16 register unit, is SCALE / (period in us x full speed in
 * RPM): 300 degrees are 1023 steps, and full speed is 1023 units. */
#define SCALE      ((uint32_t)800000000)
#define PERIOD_MIN 200 // us
/* Added to the speed that leads to the next goal, in 1/16384 of the mean speed: a servo lags behind
 * moving goals, and must catch up before the end. */
#define RESERVE     (CDS_CURVE_RATE_1 / 2)
#define OVERRIDE_US ((uint32_t)250000) // longest time of a change of the override

/* ---- time ---- */

/* Adds a period at `rate` to the clock. False: it is over. */
static bool advance(struct cds_motion_clock *clock, uint32_t rate)
{
    uint32_t step = clock->step, left = UINT32_MAX - clock->time;

    if (rate == CDS_MOTION_RATE_1) {
        clock->time_low = (uint16_t)(clock->time_low + clock->step_low);
        if (clock->time_low < clock->step_low)
            step++;
    } else {
        uint64_t scaled = (uint64_t)step * rate >> 16;

        step = scaled > UINT32_MAX ? UINT32_MAX : (uint32_t)scaled;
    }
    if (left < step || left - step < clock->step / 16)
        clock->time = UINT32_MAX;
    else
        clock->time += step;
    return clock->time != UINT32_MAX;
}

static uint16_t share(const struct cds_motion_clock *clock)
{
    return (uint16_t)(clock->time >> 16);
}

static uint16_t middle(uint16_t from, uint16_t to)
{
    return (uint16_t)(from + (uint16_t)(to - from) / 2);
}

/* The basis of the next goals: where the joints are at the end of the period, and their speeds in
 * its middle. A joint speeds up to the speed at the end as it would brake, the other way round. */
static void set_basis(struct cds_motion *motion)
{
    struct cds_motion_basis *basis = &motion->basis;
    uint16_t before = share(&motion->plan.time), after, half;
    uint16_t braking_before = share(&motion->plan.braking_time);

    basis->is_end = !advance(&motion->plan.time, motion->rate);
    after = share(&motion->plan.time);
    half = middle(before, after);
    basis->progress = cds_curve_progress(&motion->plan.curve, after);
    basis->is_at_rest = motion->plan.curve.kind == CDS_MOTION_BY_SERVO; // where the servo says
    if (basis->is_at_rest)
        basis->progress = UINT16_MAX;
    basis->rate = cds_curve_rate(&motion->plan.curve, half);
    basis->sent_rate = basis->rate;
    if (!basis->is_at_rest)
        basis->sent_rate = (uint16_t)(basis->rate + RESERVE);
    if (motion->plan.passes) {
        basis->passing_progress =
            (uint16_t)(CDS_MOTION_HALF - cds_curve_braking_progress((uint16_t)~after));
        basis->passing_rate = cds_curve_braking_rate((uint16_t)~half);
    }
    if (braking_before == UINT16_MAX) {
        basis->braking_rate = 0;
        return;
    }
    advance(&motion->plan.braking_time, motion->rate);
    after = share(&motion->plan.braking_time);
    basis->braking_progress = cds_curve_braking_progress(after);
    basis->braking_rate = cds_curve_braking_rate(middle(braking_before, after));
}

/* ---- a period ---- */

NOINLINE static uint32_t permitted_rate(const struct cds_motion *motion)
{
    return motion->override < motion->plan.rate_most ? motion->override : motion->plan.rate_most;
}

/* Change of the rate in a period, for a change of the override. */
NOINLINE static uint32_t override_step(const struct cds_motion *motion)
{
    return CDS_MOTION_RATE_1 * motion->config.cycle->period_us / OVERRIDE_US + 1;
}

/* The time slows down to 0, or speeds up from there, at `acceleration` at most. */
static void set_rate_step(struct cds_motion *motion, uint16_t acceleration)
{
    uint32_t change = cds_motion_speed_change(motion, acceleration);

    if (change > UINT16_MAX)
        change = UINT16_MAX;
    motion->rate_step = (change << 16) / motion->plan.peak + 1;
}

static void begin_move(struct cds_motion *motion)
{
    motion->last_basis = motion->basis;
    motion->basis.is_end = false;
    motion->plan = motion->next_plan;
    motion->rate_goal = permitted_rate(motion);
    motion->rate_step = override_step(motion); // not the step of a pause or abort before
    if (motion->is_paused) {
        motion->rate_goal = 0;
        set_rate_step(motion, motion->deceleration);
    }
    motion->carry = CDS_MOTION_CARRY_1;
    if (motion->last_basis.is_at_rest) {
        motion->rate = motion->rate_goal;
    } else if (motion->rate > motion->plan.rate_most) {
        motion->carry = (uint16_t)((motion->rate << 8) / motion->plan.rate_most << 4);
        motion->rate = motion->plan.rate_most;
    }
    motion->begun = 0;
    motion->is_ready = motion->is_ending = false;
    motion->is_under_way = true;
    motion->move_result = CDS_OK;
}

/* The motion is over; its joints stay where their last goals are. If the move was paused before its
 * first goal, the joints still have the paths of the move before. */
NOINLINE static void end(struct cds_motion *motion, enum cds_result result)
{
    if (motion->begun == 0)
        motion->basis = motion->last_basis;
    motion->basis.is_at_rest = true;
    motion->is_under_way = motion->is_ending = motion->is_paused = false;
    motion->begun = motion->count;
    motion->result = result;
}

/* A move that is checked, or waits, is not begun. */
static void drop_next(struct cds_motion *motion, enum cds_result why)
{
    if (motion->move_result == CDS_PENDING)
        motion->move_result = (uint8_t)why;
    motion->is_ready = motion->is_trial = false;
}

/* The joints come to rest on their way; the motion ends as `outcome`, and no other move begins.
 * noinline: saves 42 bytes of atmega1284p/full.elf. */
static NOINLINE void end_soon(struct cds_motion *motion, enum cds_result outcome)
{
    drop_next(motion, outcome);
    motion->rate_goal = 0;
    motion->is_ending = true;
    motion->outcome = outcome;
}

static void begin_period(struct cds_motion *motion)
{
    bool is_over = !motion->is_under_way || motion->basis.is_end;

    motion->periods = motion->config.cycle->counters.periods;
    if (motion->is_under_way && motion->basis.is_end)
        cds_motion_set_end(motion, &motion->basis);
    if (motion->is_ready && (is_over || !motion->next.waits)) {
        begin_move(motion);
    } else if (motion->basis.is_end) {
        end(motion, motion->is_ending ? (enum cds_result)motion->outcome : CDS_OK);
        return;
    }
    motion->rate = cds_rate_next(motion->rate, motion->rate_goal, motion->rate_step);
    if (motion->rate) {
        set_basis(motion);
        motion->index = 0;
    } else if (motion->is_ending) {
        end(motion, motion->outcome);
    } else {
        motion->basis.is_at_rest = true;
    }
}

void cds_motion_set_end(const struct cds_motion *motion, struct cds_motion_basis *basis)
{
    *basis = (struct cds_motion_basis){
        .passing_rate = CDS_CURVE_RATE_1, .is_end = true, .is_at_rest = !motion->plan.passes};
}

/* All goals are set: they leave with the next period. */
static void end_period(struct cds_motion *motion)
{
    cds_cycle_commit(motion->config.cycle);
    motion->periods = motion->config.cycle->counters.periods;
}

/* Joint `index` begins the move that was checked. */
static void begin_path(struct cds_motion *motion, uint8_t index)
{
    if (cds_motion_begin_path(motion, index))
        return;
    motion->joint = index;
    end_soon(motion, CDS_TIMEOUT);
}

/* Sets the goals of some joints. A joint whose goal is refused ends the motion. */
static void set_goals(struct cds_motion *motion)
{
    const struct cds_motion_joint *joint = &motion->config.joints[motion->index];
    uint8_t index = motion->index;
    int8_t left = JOINTS_PER_POLL;
    enum cds_result result;

    for (; left > 0 && index < motion->count; index++, joint++) {
        if (index == motion->begun) {
            begin_path(motion, index);
            motion->begun++;
            left = (int8_t)(left - BEGIN_COST);
        }
        if (!joint->is_moving)
            continue;
        result = cds_motion_set_goal(motion, index, joint);
        if (result == CDS_BUSY)
            break;
        if (result != CDS_OK && !motion->is_ending) {
            motion->joint = index;
            end_soon(motion, result);
        }
        left--;
    }
    motion->index = index;
    if (index == motion->count)
        end_period(motion);
}

/* ---- calls ---- */

enum cds_result cds_motion_begin(struct cds_motion *motion, const struct cds_motion_config *config)
{
    const struct cds_register_profile *profile = &cds_profile_cds55xx;
    uint16_t period_us = config->cycle->period_us;

    if (!config->cycle->bus || period_us < PERIOD_MIN)
        return CDS_BAD_ARGUMENT;
    *motion = (struct cds_motion){.config = *config,
                                  .count = config->cycle->count,
                                  .index = config->cycle->count,
                                  .begun = config->cycle->count,
                                  .cycle_begun = config->cycle->begun,
                                  .basis.is_end = true,
                                  .basis.is_at_rest = true,
                                  .override = CDS_MOTION_RATE_1};
    motion->rate_step = override_step(motion);
    for (uint8_t i = 0; i < config->cycle->count; i++) {
        uint32_t scale;

        if (config->profiles)
            profile = config->profiles[i];
        scale = SCALE / period_us * 1000 / profile->full_speed_mrpm;
        if (scale > UINT16_MAX)
            return CDS_BAD_ARGUMENT;
        config->joints[i] = (struct cds_motion_joint){.scale = (uint16_t)scale};
    }
    return CDS_OK;
}

static bool is_pose(const uint16_t *pose, uint8_t count)
{
    bool has_joint = false;

    for (; count; count--, pose++) {
        if (*pose != CDS_POSE_NONE && *pose > CDS_VALUE_MAX)
            return false;
        has_joint |= *pose != CDS_POSE_NONE;
    }
    return has_joint;
}

static bool is_time(uint32_t time_ms)
{
    return time_ms && time_ms <= CDS_MOTION_TIME_MAX_MS;
}

/* Returns which argument is out of range. */
static enum cds_motion_argument wrong_argument(const struct cds_move *move, uint8_t count)
{
    if (!is_time(move->time_ms))
        return CDS_MOTION_TIME;
    if (move->curve > CDS_MOTION_BY_SERVO)
        return CDS_MOTION_CURVE;
    if (move->curve == CDS_MOTION_TRAPEZOID && move->acceleration == 0)
        return CDS_MOTION_ACCELERATION;
    if (!is_pose(move->pose, count))
        return CDS_MOTION_POSE;
    if (move->next_pose && !is_time(move->next_ms))
        return CDS_MOTION_NEXT_TIME;
    if (move->next_pose && !is_pose(move->next_pose, count))
        return CDS_MOTION_NEXT_POSE;
    return CDS_MOTION_NO_ARGUMENT;
}

/* Stores the move, and which of its arguments is out of range. True: none. */
static bool take_move(struct cds_motion *motion, const struct cds_move *move)
{
    motion->next = *move;
    motion->wrong_argument = wrong_argument(move, motion->count);
    return motion->wrong_argument == CDS_MOTION_NO_ARGUMENT;
}

enum cds_result cds_motion_move(struct cds_motion *motion, const struct cds_move *move)
{
    if (cds_motion_is_busy(motion) || (move->waits && motion->is_ending))
        return CDS_BUSY;
    if (!take_move(motion, move))
        return CDS_BAD_ARGUMENT;
    cds_motion_begin_check(motion);
    return CDS_OK;
}

/* The moves of a sequence wait for the end of the move before: that decides how long they brake. */
enum cds_result cds_motion_try(struct cds_motion *motion, const struct cds_move *move,
                               bool is_first)
{
    if (motion->result == CDS_PENDING || cds_motion_is_busy(motion))
        return CDS_BUSY;
    if (!take_move(motion, move))
        return CDS_BAD_ARGUMENT;
    for (uint8_t i = 0; is_first && i < motion->count; i++)
        motion->config.joints[i].is_tried = false;
    motion->next.waits = true;
    motion->is_trial = true;
    cds_motion_begin_check(motion);
    return CDS_OK;
}

/* A move was checked, perhaps one that a motion under way goes over to. */
static void note_check(struct cds_motion *motion, enum cds_result result)
{
    if (motion->is_trial) {
        motion->is_trial = result == CDS_PENDING;
        motion->move_result = result;
        return;
    }
    if (result == CDS_OK) {
        motion->is_ready = true;
    } else if (result != CDS_PENDING) {
        motion->move_result = result;
        motion->is_paused &= motion->is_under_way; // a pause of a refused move is over
    }
    if (motion->is_ready)
        motion->result = CDS_PENDING;
}

/* No goal leaves any more, so the joints cannot come to rest on their way. */
static void end_without_cycle(struct cds_motion *motion)
{
    drop_next(motion, CDS_INHIBITED);
    motion->index = motion->count;
    if (motion->result == CDS_PENDING)
        end(motion, CDS_INHIBITED);
}

enum cds_result cds_motion_poll(struct cds_motion *motion)
{
    if (!motion->config.cycle)
        return CDS_OK; // it was never begun
    if (cds_cycle_has_ended_since(motion->config.cycle, motion->cycle_begun))
        end_without_cycle(motion);
    else if (motion->index < motion->count)
        set_goals(motion);
    else if (motion->is_under_way ? motion->config.cycle->counters.periods != motion->periods
                                  : motion->is_ready)
        begin_period(motion);
    else if (motion->move_result == CDS_PENDING && !motion->is_ready)
        note_check(motion, cds_motion_check(motion));
    return (enum cds_result)motion->result;
}

void cds_motion_pause(struct cds_motion *motion, uint16_t deceleration)
{
    if (motion->is_trial || (motion->move_result != CDS_PENDING && !motion->is_under_way))
        return;
    motion->is_paused = true;
    motion->deceleration = deceleration;
    if (!motion->is_under_way)
        return;
    set_rate_step(motion, deceleration);
    motion->rate_goal = 0;
}

void cds_motion_resume(struct cds_motion *motion)
{
    motion->is_paused = false;
    if (!motion->is_ending)
        motion->rate_goal = permitted_rate(motion);
}

void cds_motion_abort(struct cds_motion *motion, uint16_t deceleration)
{
    if (!motion->is_under_way) {
        if (motion->move_result == CDS_PENDING)
            motion->result = CDS_CANCELLED;
        drop_next(motion, CDS_CANCELLED);
        motion->is_paused = false;
        return;
    }
    set_rate_step(motion, deceleration);
    end_soon(motion, CDS_CANCELLED);
}

enum cds_result cds_motion_set_override(struct cds_motion *motion, uint8_t percent)
{
    if (percent < CDS_MOTION_OVERRIDE_MIN || percent > CDS_MOTION_OVERRIDE_MAX)
        return CDS_BAD_ARGUMENT;
    motion->override = CDS_MOTION_RATE_1 * percent / 100;
    if (motion->rate_goal && !motion->is_paused) {
        motion->rate_step = override_step(motion);
        cds_motion_resume(motion);
    }
    return CDS_OK;
}
