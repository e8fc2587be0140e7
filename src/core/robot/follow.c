/* SPDX-License-Identifier: MIT */
/* Finds a joint that does not follow its goals; see follow.h. */
#include "cds55xx/follow.h"

#include <stdlib.h> // abs()

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "cds55xx/port.h"          // cds_port_now_us()

#define TIME_MAX_MS 60000u // the clock of a joint has 16 bits of 1024 us

/* `ms` in units of that clock, rounded up. A constant if `ms` is one. */
#define UNITS(ms) ((uint16_t)(((ms)*125ul + 127) / 128))

static uint16_t distance_of(uint16_t one, uint16_t other)
{
    return (uint16_t)abs((int16_t)(one - other));
}

/* A goal that comes back to a joint that is stuck is no progress of the joint. */
static bool has_progressed(const struct cds_follow_joint *joint, uint16_t position,
                           uint16_t distance)
{
    return distance + CDS_FOLLOW_PROGRESS_STEPS <= joint->distance &&
           distance_of(position, joint->position) >= CDS_FOLLOW_PROGRESS_STEPS;
}

/* True if the servo has not reported for too long. */
static bool is_silent(const struct cds_follow *follow, const struct cds_feedback *feedback)
{
    uint16_t age = (uint16_t)((cds_port_now_us() - feedback->time_us) >> 10);

    return age > follow->time_1024us + UNITS(CDS_FOLLOW_MS);
}

/* Adds the time since the feedback before to the time for which the joint is away, and returns
 * that. A long gap counts as about half of the permitted time: behind it the goals may be far
 * ahead. */
static uint16_t add_time(const struct cds_follow *follow, struct cds_follow_joint *joint,
                         uint16_t time)
{
    uint16_t passed = (uint16_t)(time - joint->time), most = follow->time_1024us / 2 + UNITS(3);

    joint->time = time;
    joint->away = (uint16_t)(joint->away + (passed < most ? passed : most));
    return joint->away;
}

/* False: the joint does not follow. */
static bool follows(struct cds_follow *follow, uint8_t index)
{
    struct cds_follow_joint *joint = &follow->joints[index];
    const struct cds_feedback *feedback = &follow->cycle->feedback[index];
    uint16_t goal = cds_cycle_sent_goal(follow->cycle, index), distance;
    uint16_t time = (uint16_t)(feedback->time_us >> 10);
    bool is_known = goal <= CDS_VALUE_MAX && feedback->known;
    bool is_lost = is_known && is_silent(follow, feedback);

    distance = distance_of(goal, feedback->position);
    if (!is_known || is_lost || distance <= follow->steps) {
        joint->distance = 0;
        return !is_lost || follow->skips_silent;
    }
    if (joint->distance == 0 || has_progressed(joint, feedback->position, distance)) {
        *joint = (struct cds_follow_joint){
            .distance = distance, .position = feedback->position, .time = time};
        return true;
    }
    // Both times are cut to whole units: a difference of 1 may be any time above 0.
    return add_time(follow, joint, time) <= follow->time_1024us;
}

enum cds_result cds_follow_begin(struct cds_follow *follow, const struct cds_follow_config *config)
{
    uint16_t time_ms = config->time_ms ? config->time_ms : CDS_FOLLOW_MS;

    if (!config->cycle->bus || config->steps > CDS_VALUE_MAX || time_ms > TIME_MAX_MS)
        return CDS_BAD_ARGUMENT;
    *follow = (struct cds_follow){
        .result = CDS_PENDING,
        .cycle = config->cycle,
        .joints = config->joints,
        .steps = config->steps ? config->steps : CDS_FOLLOW_STEPS,
        .time_1024us = UNITS(time_ms),
        .skips_silent = config->skips_silent,
    };
    for (uint8_t i = 0; i < config->cycle->count; i++)
        config->joints[i].distance = 0;
    return CDS_OK;
}

enum cds_result cds_follow_poll(struct cds_follow *follow)
{
    if (follow->result != CDS_PENDING)
        return (enum cds_result)follow->result;
    if (!follows(follow, follow->joint))
        follow->result = CDS_TIMEOUT;
    else if (++follow->joint >= follow->cycle->count)
        follow->joint = 0;
    return (enum cds_result)follow->result;
}
