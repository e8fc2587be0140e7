/* SPDX-License-Identifier: MIT */
/* A sequence after power-up; see autostart.h. */
#include "robot/autostart.h"

#include <stddef.h>
#include <string.h>

#include "cds55xx/servo.h" // cds_servo_write_byte()
#include "robot/angle_limits.h"
#include "robot/moves.h"

#define S_US ((uint32_t)1000000)

_Static_assert(ROBOT_SERVOS >= MOTION_STORE_JOINTS, "the group has room for all joints");

static struct autostart *autostart_of(struct robot *robot)
{
    return &robot->moves->autostart;
}

/* It does not play. */
static enum cds_result give_up(struct autostart *autostart, uint8_t state)
{
    autostart->state = state;
    return CDS_CANCELLED;
}

/* True for power-on, also with a brown-out flag: a supply that rises slowly sets both. */
static bool was_power_on(uint8_t reset_cause)
{
    return (reset_cause & FAILSAFE_RESET_POWER) &&
           !(reset_cause & ~(FAILSAFE_RESET_POWER | FAILSAFE_RESET_BROWN_OUT));
}

static bool is_alarmed(const struct robot *robot)
{
    return robot_is_inhibited(robot) || robot->servos.alarms ||
           !cds_servos_may_drive((struct cds_servos *)&robot->servos, CDS_BROADCAST_ID);
}

/* The servos of the stored poses become the group. */
static bool choose_group(struct robot *robot, const struct motion_store *store)
{
    robot->group_count = motion_store_read_servos(store, robot->group);
    for (uint8_t i = 0; i < robot->group_count; i++)
        if (!robot_add(robot, robot->group[i]))
            robot->group_count = 0;
    robot->group_acts = false;
    return robot->group_count;
}

/* ---- the servos ---- */

/* Begins with servo `index` of the group. `last`: enum cds_torque_on_part. */
static void begin_servo(struct robot *robot, uint8_t index, uint8_t last)
{
    struct autostart_servos *servos = &robot->work.autostart;

    servos->index = index;
    cds_torque_on_begin(&servos->torque_on,
                        &(struct cds_torque_on_config){.bus = robot->bus,
                                                       .request = &servos->request,
                                                       .id = robot->group[index],
                                                       .last = last,
                                                       .checks_condition = true});
}

static enum cds_result next_servo(struct robot *robot, uint8_t index, uint8_t last)
{
    if (index == robot->group_count)
        return CDS_OK;
    robot->work.autostart.tries = 0;
    begin_servo(robot, index, last);
    return CDS_PENDING;
}

/* Notes a servo without torque: torque that it gets is switched off again if nothing plays. */
static void note_torque(struct autostart *autostart, const struct autostart_servos *servos)
{
    if (servos->reply[CDS_REG_TORQUE_ENABLE - CDS_TORQUE_ON_READ_FROM] == 0)
        autostart->without_torque |= (uint32_t)1 << servos->index;
}

/* Goes through the servos of the group, each up to the part `last`. CDS_PENDING; CDS_OK: behind the
 * last servo, the limits of all are known; CDS_CANCELLED: a servo is not well. */
static enum cds_result poll_servos(struct robot *robot, struct autostart *autostart, uint8_t last)
{
    struct autostart_servos *servos = &robot->work.autostart;
    enum cds_result result = cds_torque_on_poll(&servos->torque_on);
    uint8_t index = servos->index;

    if (result == CDS_PENDING)
        return result;
    if (result == CDS_OK) {
        angle_limits_take(&servos->limits[index],
                          servos->reply + (CDS_REG_CW_ANGLE_LIMIT - CDS_TORQUE_ON_READ_FROM));
        if (last == CDS_TORQUE_ON_CHECK)
            note_torque(autostart, servos);
        return next_servo(robot, (uint8_t)(index + 1), last);
    }
    autostart->outcome.result = servos->torque_on.reason;
    if (autostart->outcome.result != CDS_REASON_NO_REPLY || ++servos->tries == AUTOSTART_TRIES) {
        autostart->outcome.id = robot->group[index];
        return give_up(autostart, AUTOSTART_NOT_WELL);
    }
    begin_servo(robot, index, last);
    return CDS_PENDING;
}

/* ---- the states ---- */

static enum cds_result wait(struct robot *robot, struct autostart *autostart)
{
    struct autostart_servos *servos = &robot->work.autostart;

    if (cds_port_now_us() - autostart->begun_us < (autostart->delay & AUTOSTART_DELAY_MAX) * S_US)
        return CDS_PENDING;
    if (is_alarmed(robot))
        return give_up(autostart, AUTOSTART_ALARM);
    if (!choose_group(robot, autostart->store))
        return give_up(autostart, AUTOSTART_MISSING);
    servos->request = (struct cds_request)CDS_REQUEST(servos->packet, servos->reply);
    next_servo(robot, 0, CDS_TORQUE_ON_CHECK);
    autostart->state = AUTOSTART_CHECKING_SERVOS;
    return CDS_PENDING;
}

static enum cds_result check_servos(struct robot *robot, struct autostart *autostart)
{
    enum cds_result result = poll_servos(robot, autostart, CDS_TORQUE_ON_CHECK);

    if (result != CDS_OK)
        return result;
    autostart->state = AUTOSTART_CHECKING_POSES;
    return CDS_PENDING;
}

/* Checks the pose of one step: the servos have told their limits. CDS_OK behind the last step. */
static enum cds_result check_step(struct robot *robot, struct autostart *autostart)
{
    const struct angle_limits *limits = robot->work.autostart.limits;
    uint16_t pose[ROBOT_SERVOS];
    struct stored_joints joints;
    enum stored_pose_result result;
    uint8_t joint;

    if (motion_store_is_saving(autostart->store))
        return CDS_PENDING;
    stored_joints_find(&joints, autostart->store, robot);
    result = stored_step_pose(autostart->store, &joints, autostart->place, autostart->outcome.step,
                              pose);
    if (result == STORED_POSE_END)
        return CDS_OK;
    if (result != STORED_POSE_READ)
        return give_up(autostart, AUTOSTART_POSE_GONE);
    joint = angle_limits_beyond(limits, pose, robot->group_count);
    if (joint != ANGLE_LIMITS_NO_JOINT) {
        autostart->outcome.id = robot->group[joint];
        autostart->lowest = limits[joint].lowest;
        autostart->highest = limits[joint].highest;
        return give_up(autostart, AUTOSTART_LIMITS);
    }
    autostart->outcome.step++;
    return CDS_PENDING;
}

static enum cds_result check_poses(struct robot *robot, struct autostart *autostart)
{
    enum cds_result result = check_step(robot, autostart);

    if (result != CDS_OK)
        return result;
    if (is_alarmed(robot))
        return give_up(autostart, AUTOSTART_ALARM);
    next_servo(robot, 0, CDS_TORQUE_ON_SWITCH);
    autostart->has_switched_on = true;
    autostart->state = AUTOSTART_SWITCHING_ON;
    return CDS_PENDING;
}

/* The motion has not begun, or has failed before its first goal. */
static void refuse(struct autostart *autostart, const struct motion_outcome *outcome)
{
    autostart->state = AUTOSTART_REFUSED;
    autostart->outcome = *outcome;
}

static enum cds_result switch_on(struct robot *robot, struct autostart *autostart)
{
    enum cds_result result = poll_servos(robot, autostart, CDS_TORQUE_ON_SWITCH);
    struct motion_outcome outcome = {.id = CDS_NO_ID, .step = MOTION_NO_STEP};

    if (result != CDS_OK)
        return result;
    outcome.result =
        motion_start_alone(robot, autostart->place, autostart->delay & AUTOSTART_LOOP ? 0 : 1);
    autostart->state = AUTOSTART_STARTING_MOTION;
    if (outcome.result == CDS_OK)
        return CDS_PENDING;
    moves_note_outcome(robot, &outcome);
    refuse(autostart, &outcome);
    return CDS_CANCELLED;
}

/* The cycle runs, and the operation is that of the motion. */
static enum cds_result poll_cycle(struct robot *robot, struct autostart *autostart)
{
    enum cds_result result;

    if (autostart->state == AUTOSTART_STARTING_MOTION && autostart->failsafe->watching) {
        autostart->state = AUTOSTART_HOST;
        motion_end(robot);
    }
    result = motion_cycle.poll(robot);
    if (autostart->state == AUTOSTART_STARTING_MOTION && !motion_is_starting(robot)) {
        autostart->state = AUTOSTART_BEGUN;
        if (robot->moves->start.outcome.result != CDS_OK)
            refuse(autostart, &robot->moves->start.outcome);
    }
    return result;
}

/* ---- torque off again ---- */

static void begin_switching_off(struct robot *robot, struct autostart *autostart)
{
    struct autostart_servos *servos = &robot->work.autostart; // of the cycle until now

    robot_share_bus(robot, NULL);
    servos->request = (struct cds_request)CDS_REQUEST(servos->packet, servos->reply);
    servos->index = 0;
    servos->tries = 0;
    autostart->is_switching_off = true;
}

/* Switches torque off for servo `index`, if it had none before, then goes on to the next one. */
static enum cds_result switch_off(struct robot *robot, const struct autostart *autostart)
{
    struct autostart_servos *servos = &robot->work.autostart;
    enum cds_result result = servos->request.result;
    bool is_done = servos->tries && (result == CDS_OK || servos->tries == AUTOSTART_TRIES);

    if (result == CDS_PENDING)
        return result;
    if (autostart->is_aborted || servos->index == robot->group_count)
        return CDS_CANCELLED;
    if (is_done || !(autostart->without_torque >> servos->index & 1)) {
        servos->index++;
        servos->tries = 0;
        return CDS_PENDING;
    }
    if (cds_servo_write_byte(robot->bus, &servos->request, robot->group[servos->index],
                             CDS_REG_TORQUE_ENABLE, 0) != CDS_BUSY)
        servos->tries++;
    return CDS_PENDING;
}

/* ---- the operation ---- */

static enum cds_result go_on(struct robot *robot, struct autostart *autostart)
{
    if (robot->cycle)
        return poll_cycle(robot, autostart);
    if (robot->work.autostart.request.result == CDS_PENDING)
        return CDS_PENDING; // also if it was aborted
    if (autostart->is_aborted) {
        autostart->outcome.id = CDS_NO_ID;
        autostart->outcome.step = MOTION_NO_STEP;
        autostart->outcome.result = ROBOT_STOPPED;
        return give_up(autostart, AUTOSTART_REFUSED);
    }
    if (autostart->failsafe->watching)
        return give_up(autostart, AUTOSTART_HOST);
    switch (autostart->state) {
    case AUTOSTART_WAITING: return wait(robot, autostart);
    case AUTOSTART_CHECKING_SERVOS: return check_servos(robot, autostart);
    case AUTOSTART_CHECKING_POSES: return check_poses(robot, autostart);
    default: return switch_on(robot, autostart);
    }
}

/* A stop switches torque off for all servos by itself. */
static enum cds_result poll(struct robot *robot)
{
    struct autostart *autostart = autostart_of(robot);
    enum cds_result result;

    if (autostart->is_switching_off)
        return switch_off(robot, autostart);
    result = go_on(robot, autostart);
    if (result == CDS_PENDING || autostart->state == AUTOSTART_BEGUN || autostart->is_aborted ||
        !autostart->has_switched_on)
        return result;
    begin_switching_off(robot, autostart);
    return CDS_PENDING;
}

static void abort_operation(struct robot *robot)
{
    autostart_of(robot)->is_aborted = true;
    if (robot->cycle)
        motion_cycle.abort(robot);
}

static enum cds_result begin(struct robot *robot, const void *config)
{
    (void)config;
    autostart_of(robot)->begun_us = cds_port_now_us();
    return CDS_OK;
}

static const CDS_FLASH struct robot_operation operation = {
    .begin = begin, .poll = poll, .abort = abort_operation};

void autostart_begin(const struct failsafe *failsafe, struct motion_store *store)
{
    struct robot *robot = failsafe->robot;
    struct autostart *autostart = autostart_of(robot);
    char name[MOTION_STORE_NAME + 1];

    autostart->failsafe = failsafe;
    autostart->store = store;
    autostart->outcome.id = CDS_NO_ID;
    autostart->saves = (uint8_t)store->saves;
    autostart->delay = motion_store_read_autostart(store, name);
    if (autostart->delay == 0)
        return;
    autostart->place = motion_store_find(store, MOTION_STORE_SEQUENCE, name, (uint8_t)strlen(name));
    if (!was_power_on(failsafe->reset_cause))
        autostart->state = AUTOSTART_RESET;
    else if (autostart->place == MOTION_STORE_NONE)
        autostart->state = AUTOSTART_MISSING;
    else if (robot_start(robot, &operation, NULL) == 0)
        autostart->state = AUTOSTART_WAITING;
}
