/* SPDX-License-Identifier: MIT */
/* Is a gait possible? See gait.h and docs/internals/motion.md. */
#include <stdlib.h> // abs()

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "robot/gait_internal.h"
#include "robot/rest_internal.h"

/* Highest speed of a sine with an amplitude of 1 step and a period of 1 ms: TURN / full_speed_mrpm
 * register units. A speed of 1 step/ms is 50000000 / full_speed_mrpm units; times 2 pi. */
#define TURN ((uint32_t)314159265)

/* What the sines of a joint may reach. */
struct reach {
    uint16_t steps; // sum of amplitudes
    uint16_t swing; // sum of amplitude x multiple: speed in 2 pi steps per base period
    uint8_t sines;
};

uint32_t cds_gait_share(uint16_t period_us, uint16_t time_ms)
{
    uint32_t whole = 1000ul * time_ms, left = period_us, share = 0;

    for (uint8_t i = 0; i < 32; i++) { // one bit of the quotient in each turn
        left <<= 1;
        share <<= 1;
        if (left >= whole) {
            left -= whole;
            share |= 1;
        }
    }
    return share;
}

/* Adds up what the sines reach. False: a sine is out of range. */
static bool measure(const CDS_GAIT_FLASH struct cds_gait_sine *sine, struct reach *reach)
{
    for (; reach->sines < CDS_GAIT_SINES && sine->amplitude; reach->sines++, sine++) {
        uint16_t amplitude = (uint16_t)abs(sine->amplitude);

        if (amplitude > CDS_VALUE_MAX / 2 || sine->multiple == 0 ||
            sine->multiple > CDS_GAIT_MULTIPLES || sine->group >= CDS_GAIT_GROUPS ||
            sine->wave > CDS_GAIT_LIFT)
            return false;
        reach->steps = (uint16_t)(reach->steps + amplitude);
        reach->swing = (uint16_t)(reach->swing + amplitude * sine->multiple);
        if (sine->wave == CDS_GAIT_LIFT) // 4.1 % faster at the end of a change from -100 to 100 %
            reach->swing = (uint16_t)(reach->swing + amplitude / 16 + 1);
    }
    return true;
}

/* Returns TURN / full speed of joint `index`. */
static uint32_t turn_of(const struct cds_gait *gait, uint8_t index)
{
    const struct cds_register_profile *profile =
        gait->config.profiles ? gait->config.profiles[index] : &cds_profile_cds55xx;

    return TURN / profile->full_speed_mrpm;
}

/* Returns `value` x period_ms / ramp_ms, rounded up. Two divisions: the product may have 37 bits.
 */
static uint32_t times_period_by_ramp(const struct cds_gait_config *config, uint32_t value)
{
    uint16_t period_ms = config->period_ms, ramp_ms = config->ramp_ms; // ramp_ms is not shorter

    return value / ramp_ms * period_ms + value % ramp_ms * period_ms / ramp_ms + 1;
}

/* Checks the speed of joint `index`. */
static void check_speed(struct cds_gait *gait, uint8_t index, const struct reach *reach)
{
    const struct cds_gait_config *config = &gait->config;
    struct cds_gait_state *state = &config->states[index];
    uint32_t turn = turn_of(gait, index), speed = reach->swing * turn, peak;
    uint16_t distance = (uint16_t)abs((int16_t)(state->start - config->joints[index].rest));

    // The highest speed of the ramp from the start is 3/2 of its mean speed. For a sine the factor
    // is 2 pi, which `turn` has: 3 / (4 pi) is about 1/4.
    if (distance)
        speed += times_period_by_ramp(config, distance * (turn / 4));
    peak = speed / config->period_ms;
    if (peak >= state->fastest) {
        speed = speed / state->fastest + 1; // the period in which it would be slow enough
        if (speed > gait->shortest_ms) {
            gait->shortest_ms = speed;
            gait->joint = index;
        }
    } else if (peak >= gait->peak) {
        gait->peak = (uint16_t)peak + 1;
    }
    state->reserve = (uint16_t)(peak / CDS_GAIT_RESERVE) + 1;
}

/* Checks the positions of joint `index` and sets what turns them into speeds. */
static enum cds_result check_positions(struct cds_gait *gait, uint8_t index,
                                       const struct reach *reach)
{
    struct cds_gait_state *state = &gait->config.states[index];
    uint16_t rest = gait->config.joints[index].rest, lowest = 0, highest = CDS_VALUE_MAX;
    struct cds_servo_state *servo = NULL;
    uint8_t id = gait->config.cycle->ids[index];

    if (!cds_rest_find(gait->config.cycle, index, cds_cycle_sent_goal(gait->config.cycle, index),
                       &state->start))
        return CDS_TIMEOUT;
    if (gait->config.servos)
        servo = cds_servos_find(gait->config.servos, id);
    if (servo) {
        if (!cds_servos_may_drive(gait->config.servos, id))
            return CDS_INHIBITED;
        lowest = servo->lowest;
        highest = servo->highest;
        state->fastest = servo->fastest;
    }
    if (rest < lowest + reach->steps || rest + reach->steps > highest || state->start < lowest ||
        state->start > highest || state->fastest == 0)
        return CDS_LIMIT;
    state->scale = // 159 = 1000 / 2 pi
        (uint16_t)(turn_of(gait, index) * 159 / gait->config.cycle->period_us + 1);
    state->position = (uint16_t)((state->start << 8) + (uint16_t)(CDS_GAIT_HALF_STEP >> 8));
    state->sines = reach->sines;
    state->takes_part = true;
    return CDS_OK;
}

enum cds_result cds_gait_check(struct cds_gait *gait, uint8_t index, bool is_second)
{
    const CDS_GAIT_FLASH struct cds_gait_joint *joint = &gait->config.joints[index];
    struct cds_gait_state *state = &gait->config.states[index];
    struct reach reach = {.sines = 0};

    if (!is_second)
        *state = (struct cds_gait_state){.fastest = CDS_VALUE_MAX};
    if (joint->rest == CDS_POSE_NONE)
        return CDS_OK;
    if (joint->rest > CDS_VALUE_MAX || !measure(joint->sines, &reach))
        return CDS_BAD_ARGUMENT;
    if (!is_second)
        return check_positions(gait, index, &reach);
    check_speed(gait, index, &reach);
    return CDS_OK;
}
