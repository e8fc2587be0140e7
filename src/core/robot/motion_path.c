/* SPDX-License-Identifier: MIT */
/* The path of one joint in a move: where it begins, with which speeds, and its goals; see
 * docs/internals/motion.md. */
#include "compiler.h" // NOINLINE
#include "robot/motion_internal.h"
#include "robot/rest_internal.h"

#define CARRY_QUARTER (CDS_MOTION_CARRY_1 / CDS_MOTION_QUARTERS)

/* What braking from begin_speed and speeding up to end_speed add to the offset from the start, in
 * 1/65536 of the unit of positions. */
static int32_t transition_offset(const struct cds_motion_joint *joint,
                                 const struct cds_motion_basis *basis)
{
    return (int32_t)joint->braking * basis->braking_progress +
           (int32_t)joint->passing * basis->passing_progress;
}

/* What braking from begin_speed and speeding up to end_speed add to the speed, in 1/16384 of the
 * unit of speeds. */
static int32_t transition_speed(const struct cds_motion_joint *joint,
                                const struct cds_motion_basis *basis)
{
    return (int32_t)joint->begin_speed * basis->braking_rate +
           (int32_t)joint->end_speed * basis->passing_rate;
}

/* Returns `offset`, in 1/65536 of the unit of positions, or where the limit of the joint is if
 * `offset` leads a joint that brakes beyond it. */
static NOINLINE int32_t offset_within_limits(const struct cds_motion_joint *joint, int32_t offset)
{
    int16_t start = (int16_t)joint->start;
    int32_t lowest = (int32_t)(joint->lowest - start) * 65536;
    int32_t highest = (int32_t)(joint->highest - start) * 65536;

    if (joint->begin_speed == 0)
        return offset;
    return offset < lowest ? lowest : offset > highest ? highest : offset;
}

static int16_t position_of(const struct cds_motion_joint *joint,
                           const struct cds_motion_basis *basis)
{
    int32_t offset = (int32_t)joint->distance * basis->progress;

    if (basis->is_end)
        offset = ((int32_t)joint->distance + joint->braking / 2 + joint->passing / 2) * 65536;
    else if (joint->has_speeds)
        offset += transition_offset(joint, basis);
    offset = offset_within_limits(joint, offset);
    return (int16_t)(joint->start + (uint16_t)((uint32_t)(offset + CDS_MOTION_HALF) >> 16));
}

/* The result is in 1/4 unit: a shift by 16 bits drops two bytes, no instruction. */
int16_t cds_motion_speed(const struct cds_motion_joint *joint, const struct cds_motion_basis *basis)
{
    int32_t speed = (int32_t)joint->mean_speed * basis->rate;

    if (joint->has_speeds)
        speed += transition_speed(joint, basis);
    return (int16_t)(speed >> 16);
}

/* Finds where the joint is, and its speed. A joint that moves is at the goal of `basis`. So is a
 * joint at the end of a move that the next one follows: its feedback lags behind. False: not known.
 */
static bool locate(const struct cds_motion *motion, uint8_t index,
                   const struct cds_motion_basis *basis, struct cds_motion_path *path)
{
    const struct cds_motion_joint *joint = &motion->config.joints[index];
    uint16_t goal, rest;

    if (motion->is_trial && joint->is_tried) {
        path->position = joint->trial_end;
        path->begin_speed = joint->trial_speed;
        return true;
    }
    path->position = position_of(joint, basis);
    path->begin_speed = 0;
    if (joint->is_moving && !basis->is_at_rest) {
        path->begin_speed =
            (int16_t)((int32_t)cds_motion_speed(joint, basis) * motion->carry / CARRY_QUARTER);
        return true;
    }
    if (joint->is_moving && motion->follows)
        return true;
    goal = joint->is_known ? (uint16_t)path->position / CDS_MOTION_STEP
                           : cds_cycle_sent_goal(motion->config.cycle, index);
    if (!cds_rest_find(motion->config.cycle, index, goal, &rest))
        return joint->is_known;
    if (!joint->is_known || rest != goal)
        path->position = (int16_t)(rest * CDS_MOTION_STEP);
    return true;
}

/* Mean speed over `distance`, in 1/16 unit; INT16_MAX, or minus that, if it is beyond any speed. */
NOINLINE static int16_t mean_speed(const struct cds_motion_joint *joint, int16_t distance,
                                   uint32_t duration)
{
    int32_t speed = ((int32_t)distance * (int32_t)joint->scale >> 3) / (int32_t)duration;

    if (speed > INT16_MAX)
        return INT16_MAX;
    return speed < -INT16_MAX ? -INT16_MAX : (int16_t)speed;
}

/* The speed with which the joint passes the pose: between its mean speeds before and after it, and
 * less than twice the lower one, so that it turns back neither before nor after. 0 if it turns
 * there. */
static int16_t passing_speed(const struct cds_motion *motion, uint8_t index,
                             const struct cds_motion_path *path, uint32_t duration)
{
    const struct cds_motion_joint *joint = &motion->config.joints[index];
    int16_t next = (int16_t)(motion->next.next_pose[index] * CDS_MOTION_STEP);
    int32_t speed_before, speed_after;

    if (motion->next.next_pose[index] == CDS_POSE_NONE)
        return 0;
    speed_before = mean_speed(joint, (int16_t)(path->goal - path->position), duration);
    speed_after = mean_speed(joint, (int16_t)(next - path->goal), motion->next_plan.next_duration);
    if ((speed_before < 0) != (speed_after < 0) || speed_before == 0 || speed_after == 0)
        return 0;
    return (int16_t)(2 * speed_before * speed_after / (speed_before + speed_after));
}

bool cds_motion_find_path(const struct cds_motion *motion, uint8_t index,
                          const struct cds_motion_basis *basis, uint32_t duration,
                          struct cds_motion_path *path)
{
    uint8_t curve = motion->next.curve;

    if (!locate(motion, index, basis, path))
        return false;
    path->goal = (int16_t)(motion->next.pose[index] * CDS_MOTION_STEP);
    path->end_speed = 0;
    if (curve != CDS_MOTION_MINIMUM_JERK && curve != CDS_MOTION_TRAPEZOID)
        path->begin_speed = 0;
    else if (motion->next.next_pose && motion->next.pose[index] != CDS_POSE_NONE)
        path->end_speed = passing_speed(motion, index, path, duration);
    return true;
}

/* Twice the distance in which a joint brakes from `speed` within `window` periods. */
static int16_t twice_distance(const struct cds_motion_joint *joint, int16_t speed, uint32_t window)
{
    if (speed == 0)
        return 0; // without the division
    return (int16_t)((int32_t)speed * (int32_t)(window * CDS_MOTION_STEP) / (int32_t)joint->scale);
}

void cds_motion_set_path(struct cds_motion_joint *joint, const struct cds_motion_path *path,
                         const struct cds_motion_plan *plan)
{
    joint->start = (uint16_t)path->position;
    joint->begin_speed = path->begin_speed;
    joint->end_speed = path->end_speed;
    joint->has_speeds = path->begin_speed || path->end_speed;
    joint->braking = twice_distance(joint, path->begin_speed, plan->window);
    joint->passing = twice_distance(joint, path->end_speed, plan->duration);
    joint->distance =
        (int16_t)(path->goal - path->position - joint->braking / 2 - joint->passing / 2);
    joint->mean_speed = mean_speed(joint, joint->distance, plan->duration);
}

bool cds_motion_begin_path(struct cds_motion *motion, uint8_t index)
{
    struct cds_motion_joint *joint = &motion->config.joints[index];
    bool is_in_pose = motion->next.pose[index] != CDS_POSE_NONE;
    struct cds_motion_path path;

    if (!is_in_pose && !joint->is_moving)
        return true;
    if (!cds_motion_find_path(motion, index, &motion->last_basis, motion->plan.duration, &path)) {
        joint->is_moving = false;
        return false;
    }
    if (!is_in_pose) // it stays at its last goal, not where its servo reports it
        path.goal = path.position = position_of(joint, &motion->last_basis);
    cds_motion_set_path(joint, &path, &motion->plan);
    if (!is_in_pose) {
        joint->distance = 0;
        joint->mean_speed = 0;
    }
    joint->is_moving = is_in_pose || path.begin_speed;
    if (joint->is_moving)
        joint->is_known = true;
    return true;
}

/* Repeats position_of() and cds_motion_speed(): saves 108 cycles a joint. */
enum cds_result cds_motion_set_goal(struct cds_motion *motion, uint8_t index,
                                    const struct cds_motion_joint *joint)
{
    const struct cds_motion_basis *basis = &motion->basis;
    int32_t offset = (int32_t)joint->distance * basis->progress;
    int32_t speed = (int32_t)joint->mean_speed * basis->sent_rate;
    uint16_t position, quarters;

    if (joint->has_speeds) {
        offset = offset_within_limits(joint, offset + transition_offset(joint, basis));
        speed += transition_speed(joint, basis);
    }
    position = (uint16_t)(joint->start + (uint16_t)((uint32_t)(offset + CDS_MOTION_HALF) >> 16));
    quarters = (uint16_t)((uint32_t)(speed < 0 ? -speed : speed) >> 16);
    if (motion->rate != CDS_MOTION_RATE_1)
        quarters = (uint16_t)((uint32_t)quarters * (uint16_t)(motion->rate >> 4) >> 12);
    if (quarters > joint->fastest) // with the reserve
        quarters = joint->fastest;
    if (quarters == 0)
        quarters = 1;
    quarters = (uint16_t)(quarters + CDS_MOTION_QUARTERS - 1);
    return cds_cycle_goal(motion->config.cycle, index,
                          (uint16_t)(position + CDS_MOTION_STEP / 2) / CDS_MOTION_STEP,
                          quarters / CDS_MOTION_QUARTERS);
}
