/* SPDX-License-Identifier: MIT */
/* Goals of a gait, period after period; see gait.h and docs/internals/motion.md. */
#include "cds55xx/gait.h"

#include "compiler.h" // NOINLINE
#include "robot/gait_internal.h"
#include "robot/rate_internal.h"
#include "robot/sine_internal.h"
#include "servo/cycle_internal.h" // cds_cycle_has_ended_since()

/* The work of a poll: a joint costs JOINT_COST, each of its sines 1. So a poll sets the goals of 4
 * joints without a sine, and of 2 joints with three. */
#define WORK_PER_POLL 12
#define JOINT_COST    3
#define RATE_US       ((uint32_t)250000) // after a refused goal the joints stand within this time

/* ---- one joint ---- */

/* Adds the sines of a joint to `position`, in 1/65536 step. NOINLINE: saves 20 cycles. */
static NOINLINE uint32_t add_sines(const struct cds_gait *gait,
                                   const CDS_GAIT_FLASH struct cds_gait_sine *sine, uint8_t sines,
                                   uint32_t position)
{
    for (; sines; sines--, sine++) {
        int16_t amplitude = sine->amplitude, scale = gait->now[sine->group];
        uint16_t phase = (uint16_t)(sine->phase + gait->phases[sine->multiple]);
        uint16_t height = cds_sine_height(phase);

        if (sine->wave != CDS_GAIT_SINE) {
            if (phase & CDS_SINE_HALF)
                continue;
            height = (uint16_t)((uint32_t)height * height >> 16);
        } else if (phase & CDS_SINE_HALF) {
            amplitude = (int16_t)-amplitude;
        }
        if (scale != CDS_GAIT_1) {
            if (scale < 0) {
                scale = (int16_t)-scale;
                amplitude = (int16_t)-amplitude;
            }
            if (scale != CDS_GAIT_1)
                height = (uint16_t)((uint32_t)height * (uint16_t)((uint16_t)scale * 4) >> 16);
        }
        position += (uint32_t)((int32_t)amplitude * height);
    }
    return position;
}

/* The speed that leads to a position within a period, with a reserve; so it is never 0, which would
 * be full speed. */
static uint16_t speed_to(uint16_t position, const struct cds_gait_state *state)
{
    uint16_t distance = (uint16_t)(position - state->position), speed;

    if (distance & 0x8000)
        distance = (uint16_t)-distance;
    speed = (uint16_t)((uint16_t)((uint32_t)distance * state->scale >> 8) + state->reserve);
    return speed < state->fastest ? speed : state->fastest;
}

/* Sets the next goal of a joint. */
static enum cds_result set_goal(const struct cds_gait *gait, uint8_t index,
                                const CDS_GAIT_FLASH struct cds_gait_joint *joint,
                                struct cds_gait_state *state)
{
    uint32_t goal = add_sines(gait, joint->sines, state->sines,
                              ((uint32_t)joint->rest << 16) + CDS_GAIT_HALF_STEP);
    enum cds_result result;

    if (gait->is_starting)
        goal += (uint32_t)((int32_t)(int16_t)(state->start - joint->rest) *
                           (uint16_t)~gait->ramp_progress);
    result = cds_cycle_goal(gait->config.cycle, index, (uint16_t)(goal >> 16),
                            speed_to((uint16_t)(goal >> 8), state));
    if (result != CDS_BUSY)
        state->position = (uint16_t)(goal >> 8);
    return result;
}

/* ---- time ---- */

/* A share of 1/2^32, times `factor` in 1/16384. */
static uint32_t scaled(uint32_t share, uint16_t factor)
{
    if (factor == CDS_GAIT_1)
        return share;
    return (((share >> 16) * factor) + ((share & 0xFFFF) * factor >> 16)) << 2;
}

/* Returns what a value goes to. */
static int16_t target(const struct cds_gait *gait, uint8_t value)
{
    if (!gait->is_stopping)
        return gait->set[value];
    return value == CDS_GAIT_SPEED ? gait->now[value] : 0;
}

/* Begins a ramp if a value has to change. False: none has. */
static bool begin_ramp(struct cds_gait *gait)
{
    for (uint8_t i = 0; i < CDS_GAIT_RAMPED; i++) {
        gait->from[i] = gait->now[i];
        gait->to[i] = target(gait, i);
        gait->is_ramping |= gait->to[i] != gait->from[i];
    }
    gait->ramp = 0;
    gait->ramp_progress = 0;
    return gait->is_ramping;
}

/* Moves the ramp on: its progress is 3 t^2 - 2 t^3. */
static void advance_ramp(struct cds_gait *gait)
{
    uint32_t step = scaled(gait->ramp_step, gait->rate);
    uint16_t time, square;

    gait->is_ramping = UINT32_MAX - gait->ramp > step;
    gait->ramp += step;
    time = (uint16_t)(gait->ramp >> 16);
    square = (uint16_t)((uint32_t)time * time >> 16);
    gait->ramp_progress = (uint16_t)((uint32_t)square * (uint16_t)(49151u - time / 2u) >> 14);
    for (uint8_t i = 0; i < CDS_GAIT_RAMPED; i++) {
        int32_t change = (int32_t)gait->to[i] - gait->from[i];

        gait->now[i] = gait->to[i];
        if (gait->is_ramping)
            gait->now[i] = (int16_t)(gait->from[i] + (int16_t)(change * gait->ramp_progress >> 16));
    }
    gait->is_starting &= gait->is_ramping;
}

/* A gait that stops is over when no ramp is left. */
static void advance(struct cds_gait *gait)
{
    int16_t speed = gait->now[CDS_GAIT_SPEED];
    uint16_t factor = (uint16_t)(speed < 0 ? -speed : speed);
    uint32_t step = scaled(gait->phase_step, (uint16_t)((uint32_t)factor * gait->rate >> 14));

    gait->phase += speed < 0 ? 0 - step : step;
    if (gait->is_ramping)
        advance_ramp(gait);
    if (!gait->is_ramping && !begin_ramp(gait))
        gait->is_at_rest = gait->is_stopping;
}

/* ---- a period ---- */

/* The phases of these goals. */
static void set_phases(struct cds_gait *gait)
{
    uint32_t phase = CDS_SINE_HALF; // rounds

    for (uint8_t i = 1; i <= CDS_GAIT_MULTIPLES; i++) {
        phase += gait->phase;
        gait->phases[i] = (uint16_t)(phase >> 16);
    }
    gait->index = 0;
}

static void end(struct cds_gait *gait, enum cds_result result)
{
    gait->is_under_way = false;
    gait->result = result;
}

/* The joints come to rest on their way; the gait ends as `outcome`. */
static void end_soon(struct cds_gait *gait, enum cds_result outcome)
{
    gait->rate_goal = 0;
    gait->is_ending = true;
    gait->outcome = outcome;
}

/* NOINLINE: most polls have nothing to do and save no registers. */
static NOINLINE void begin_period(struct cds_gait *gait)
{
    gait->periods = gait->config.cycle->counters.periods;
    gait->rate = (uint16_t)cds_rate_next(gait->rate, gait->rate_goal, gait->rate_step);
    if (gait->is_at_rest) {
        end(gait, gait->is_ending ? (enum cds_result)gait->outcome : CDS_OK);
    } else if (gait->rate) {
        advance(gait);
        set_phases(gait);
    } else if (gait->is_ending) {
        end(gait, (enum cds_result)gait->outcome);
    }
}

/* All goals are set: they leave with the next period. */
static void end_period(struct cds_gait *gait)
{
    cds_cycle_commit(gait->config.cycle);
    gait->periods = gait->config.cycle->counters.periods;
}

/* Sets the goals of some joints. A joint whose goal is refused ends the gait. */
static NOINLINE void set_goals(struct cds_gait *gait)
{
    uint8_t index = gait->index;
    const CDS_GAIT_FLASH struct cds_gait_joint *joint = &gait->config.joints[index];
    struct cds_gait_state *state = &gait->config.states[index];
    int8_t left = WORK_PER_POLL;
    enum cds_result result;

    for (; left > 0 && index < gait->count; index++, joint++, state++) {
        if (!state->takes_part)
            continue;
        result = set_goal(gait, index, joint, state);
        if (result == CDS_BUSY)
            break;
        if (result != CDS_OK && !gait->is_ending) {
            gait->joint = index;
            end_soon(gait, result);
        }
        left = (int8_t)(left - JOINT_COST - state->sines);
    }
    gait->index = index;
    if (index == gait->count)
        end_period(gait);
}

/* The time slows down to 0, or speeds up from there, at `acceleration` at most. */
static void set_rate_step(struct cds_gait *gait, uint16_t acceleration)
{
    uint32_t change = (uint32_t)acceleration * gait->config.cycle->period_us;
    uint32_t step = change / 62 / gait->peak; // 1000000 / 16384, rounded up

    if (step > CDS_GAIT_1)
        step = CDS_GAIT_1;
    gait->rate_step = step ? (uint16_t)step : 1;
}

/* All joints are checked. */
static void start(struct cds_gait *gait)
{
    if (gait->rate == 0) // paused during the check
        set_rate_step(gait, gait->rate_step);
    gait->is_under_way = gait->is_starting = gait->is_ramping = true;
    begin_ramp(gait);
    set_phases(gait);
}

/* Checks a joint, each one twice. The first goals are where the joints are. */
static NOINLINE void check_next(struct cds_gait *gait)
{
    uint8_t count = gait->count;
    bool is_second = gait->index >= count;
    uint8_t joint = is_second ? (uint8_t)(gait->index - count) : gait->index;
    enum cds_result result = cds_gait_check(gait, joint, is_second);

    if (result != CDS_OK) {
        gait->joint = joint;
        gait->result = result;
    } else if (++gait->index < 2 * count) {
        return;
    } else if (gait->shortest_ms) {
        gait->result = CDS_LIMIT;
    } else {
        start(gait);
    }
}

/* ---- calls ---- */

enum cds_result cds_gait_begin(struct cds_gait *gait, const struct cds_gait_config *config)
{
    uint16_t period_us = config->cycle->period_us;

    if (gait->result == CDS_PENDING &&
        !cds_cycle_has_ended_since(gait->config.cycle, gait->cycle_begun))
        return CDS_BUSY;
    if (!config->cycle->bus || config->period_ms < CDS_GAIT_TIME_MIN_MS ||
        config->ramp_ms < config->period_ms || config->ramp_ms > CDS_GAIT_TIME_MAX_MS)
        return CDS_BAD_ARGUMENT;
    *gait = (struct cds_gait){
        .peak = 1,
        .result = CDS_PENDING,
        .config = *config,
        .count = config->cycle->count,
        .cycle_begun = config->cycle->begun,
        .rate = CDS_GAIT_1,
        .rate_goal = CDS_GAIT_1,
        .rate_step = (uint16_t)((uint32_t)CDS_GAIT_1 * period_us / RATE_US + 1),
        .phase_step = cds_gait_share(period_us, config->period_ms),
        .ramp_step = cds_gait_share(period_us, config->ramp_ms),
    };
    for (uint8_t i = 0; i < CDS_GAIT_RAMPED; i++)
        gait->set[i] = CDS_GAIT_1;
    return CDS_OK;
}

enum cds_result cds_gait_poll(struct cds_gait *gait)
{
    if (gait->result != CDS_PENDING)
        return (enum cds_result)gait->result;
    if (cds_cycle_has_ended_since(gait->config.cycle, gait->cycle_begun))
        end(gait, CDS_INHIBITED);
    else if (!gait->is_under_way)
        check_next(gait);
    else if (gait->index < gait->count)
        set_goals(gait);
    else if (gait->config.cycle->counters.periods != gait->periods)
        begin_period(gait);
    return (enum cds_result)gait->result;
}

static enum cds_result set_value(struct cds_gait *gait, uint8_t value, int8_t percent)
{
    if (percent < -100 || percent > 100)
        return CDS_BAD_ARGUMENT;
    gait->set[value] = (int16_t)((int32_t)CDS_GAIT_1 * percent / 100);
    return CDS_OK;
}

enum cds_result cds_gait_set_scale(struct cds_gait *gait, uint8_t group, int8_t percent)
{
    return group < CDS_GAIT_GROUPS ? set_value(gait, group, percent) : CDS_BAD_ARGUMENT;
}

enum cds_result cds_gait_set_speed(struct cds_gait *gait, int8_t percent)
{
    return set_value(gait, CDS_GAIT_SPEED, percent);
}

void cds_gait_stop(struct cds_gait *gait)
{
    if (!gait->is_under_way)
        cds_gait_abort(gait, 1);
    gait->is_stopping = true;
    cds_gait_resume(gait);
}

void cds_gait_pause(struct cds_gait *gait, uint16_t deceleration)
{
    gait->rate_goal = 0;
    if (gait->is_under_way) {
        set_rate_step(gait, deceleration);
    } else { // start() sets the step
        gait->rate = 0;
        gait->rate_step = deceleration;
    }
}

void cds_gait_resume(struct cds_gait *gait)
{
    if (!gait->is_ending)
        gait->rate_goal = CDS_GAIT_1;
}

void cds_gait_abort(struct cds_gait *gait, uint16_t deceleration)
{
    if (gait->result != CDS_PENDING)
        return;
    if (!gait->is_under_way || cds_cycle_has_ended_since(gait->config.cycle, gait->cycle_begun)) {
        end(gait, CDS_CANCELLED);
        return;
    }
    set_rate_step(gait, deceleration);
    end_soon(gait, CDS_CANCELLED);
}
