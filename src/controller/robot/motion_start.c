/* SPDX-License-Identifier: MIT */
/* The start of a motion; see motion_start.h. */
#include "robot/motion_start.h"

#include <stddef.h>
#include <string.h>

#include "cds55xx/servo.h" // cds_servo_read()
#include "robot/angle_limits.h"
#include "robot/group_cycle.h"
#include "robot/moves.h"
#include "robot/stored_group.h"

/* Up to CHECK_SERVOS: those that read steps. */
enum phase {
    CHECK_STEPS,    // one step of the sequence in each poll
    CHECK_SERVOS,   // of one step of the sequence in each poll; comes after READ_STATES
    READ_POSITIONS, // until the positions of all servos are known
    READ_STATES,    // until mode and torque of all servos are known
    BEGIN,          // until the motion takes the move, or the sequence begins to check its steps
    CHECK_MOVES,    // until the first move has begun
} __attribute__((packed));

static struct motion_start *start_of(const struct robot *robot)
{
    return &robot->moves->start;
}

/* ---- begin ---- */

bool motion_cycle_is_ending(const struct robot *robot)
{
    return robot->cycle && robot->moves->ends_cycle && !robot_is_in_motion(robot);
}

/* Returns 0 if a motion may be started now; `replaces`: also in place of a move under way. */
static uint8_t may_start(const struct robot *robot, bool replaces)
{
    if (robot->moves == NULL)
        return MOTION_OMITTED;
    if (motion_is_paused(robot))
        return MOTION_PAUSED;
    if (motion_cycle_is_ending(robot) || motion_is_starting(robot) || moves_is_playing(robot) ||
        (robot_is_in_motion(robot) && !replaces))
        return MOTION_BUSY;
    if (robot_is_stopping(robot))
        return ROBOT_STOPPED;
    return robot_is_inhibited(robot) ? (uint8_t)CDS_INHIBITED : 0;
}

uint8_t motion_may_start_sequence(const struct robot *robot, uint8_t place)
{
    char name[MOTION_STORE_NAME + 1];
    uint8_t error = may_start(robot, false);

    if (error)
        return error;
    if (motion_store_is_saving(robot->moves->store))
        return MOTION_SAVING;
    return motion_store_read_name(robot->moves->store, MOTION_STORE_SEQUENCE, place, name)
               ? 0
               : (uint8_t)MOTION_NO_SEQUENCE;
}

static void prepare(struct robot *robot, enum phase phase)
{
    struct motion_start *start = start_of(robot);

    start->begun_us = cds_port_now_us();
    start->outcome =
        (struct motion_outcome){.result = CDS_PENDING, .id = CDS_NO_ID, .step = MOTION_NO_STEP};
    start->phase = phase;
    moves_note_outcome(robot, &start->outcome);
}

/* Starts a cycle unless one runs, and reserves the servos. The caller sets what is started. */
static uint8_t begin(struct robot *robot, enum phase phase)
{
    struct moves *moves = robot->moves;
    bool ends_cycle = robot->cycle == NULL || moves->ends_cycle;
    uint8_t error = 0;

    if (robot->group_count == 0)
        return MOTION_NO_GROUP;
    if (robot->cycle == NULL)
        error = robot_start(robot, &motion_cycle, &moves->settings->cycle_us);
    if (error)
        return error;
    prepare(robot, phase);
    moves_reserve(robot, ends_cycle);
    return 0;
}

static void set_sequence(const struct robot *robot, uint8_t place, uint16_t repeats)
{
    struct motion_start *start = start_of(robot);

    stored_joints_find(&start->joints, robot->moves->store, robot);
    start->is_sequence = true;
    start->place = place;
    start->repeats = repeats;
    start->step = 0;
}

/* The start was refused: drops the group that was chosen for it, but not the group of another
 * motion that is starting. */
static void drop_group(struct robot *robot)
{
    if (robot->moves == NULL || !motion_is_starting(robot))
        stored_group_drop(robot);
}

uint8_t motion_start_sequence(struct robot *robot, uint8_t place, uint16_t repeats)
{
    uint8_t error = motion_may_start_sequence(robot, place);

    if (error == 0)
        error = stored_group_choose(robot, robot->moves->store);
    if (error == 0)
        error = begin(robot, CHECK_STEPS);
    if (error == 0)
        set_sequence(robot, place, repeats);
    else
        drop_group(robot);
    return error;
}

uint8_t motion_start_alone(struct robot *robot, uint8_t place, uint16_t repeats)
{
    struct moves *moves = robot->moves;
    uint8_t error = (uint8_t)moves_cycle.begin(robot, &moves->settings->cycle_us);

    if (error)
        return error;
    prepare(robot, CHECK_STEPS);
    moves_reserve(robot, true);
    set_sequence(robot, place, repeats);
    moves_set_override(robot, 100);
    return 0;
}

uint8_t motion_start_move(struct robot *robot, const struct cds_move *move)
{
    struct motion_start *start = start_of(robot);
    uint8_t error = may_start(robot, true);

    if (error == 0)
        error = begin(robot, READ_POSITIONS);
    if (error) {
        drop_group(robot);
        return error;
    }
    start->is_sequence = false;
    start->move = *move;
    return 0;
}

/* ---- phases: each returns CDS_PENDING, or the result of the start ---- */

/* Why the servo cannot take a goal, or CDS_OK. */
static uint8_t reason_against(const struct cds_servo_state *servo, bool needs_torque)
{
    if (servo->inhibits || servo->presence == CDS_PRESENCE_OFFLINE)
        return CDS_INHIBITED;
    if (cds_servo_is_endless(servo))
        return MOTION_ENDLESS;
    return needs_torque && !servo->torque ? (uint8_t)MOTION_TORQUE_OFF : (uint8_t)CDS_OK;
}

/* Returns why a servo of the pose cannot take a goal, and its ID in *id; or CDS_OK. Pose NULL: all
 * servos of the group, whose torque does not matter. */
static uint8_t check_servos(const struct robot *robot, const uint16_t *pose, uint8_t *id)
{
    const struct cds_servo_state *servo = robot->servos.states;

    for (uint8_t left = robot->servos.count; left; left--, servo++) {
        uint8_t reason = reason_against(servo, pose != NULL);
        const uint8_t *joint;

        if (!reason)
            continue;
        joint = memchr(robot->group, servo->id, robot->group_count);
        if (!joint || (pose && pose[joint - robot->group] == CDS_POSE_NONE))
            continue;
        *id = servo->id;
        return reason;
    }
    return CDS_OK;
}

uint8_t motion_check_group(struct robot *robot)
{
    return check_servos(robot, NULL, &robot->servos.refused_id);
}

/* CDS_PENDING: each servo of the pose has torque, none is OFFLINE, inhibited or in endless turn,
 * and each takes its goal. After READ_STATES: the list of servos has the torque that was read, and
 * learns each later change from the packets that pass. */
static uint8_t check_pose(const struct robot *robot, const uint16_t *pose)
{
    struct motion_start *start = start_of(robot);
    uint8_t reason = check_servos(robot, pose, &start->outcome.id);

    if (reason)
        return reason;
    start->beyond = angle_limits_beyond(start->limits, pose, robot->group_count);
    if (start->beyond == ANGLE_LIMITS_NO_JOINT)
        return CDS_PENDING;
    start->beyond_goal = pose[start->beyond];
    start->outcome.id = robot->group[start->beyond];
    return CDS_LIMIT;
}

/* Checks that the store has the pose of the step, and the group has its servos. */
static uint8_t check_step(const struct robot *robot)
{
    static const CDS_FLASH uint8_t errors[] = {
        [STORED_POSE_READ] = CDS_PENDING,
        [STORED_POSE_MISSING] = MOTION_POSE_GONE,
        [STORED_POSE_ABSENT] = MOTION_ABSENT,
        [STORED_POSE_END] = CDS_PENDING,
    };
    struct motion_start *start = start_of(robot);
    uint16_t pose[ROBOT_SERVOS];
    enum stored_pose_result result =
        stored_step_pose(robot->moves->store, &start->joints, start->place, start->step++, pose);

    if (result == STORED_POSE_END)
        start->phase = READ_POSITIONS;
    return errors[result];
}

/* The ID of the first servo whose position is not known; there is one. */
static uint8_t unknown_servo(const struct robot *robot)
{
    uint8_t joint = 0;

    while (robot->work.cycle.feedback[joint].known)
        joint++;
    return robot->group[joint];
}

static uint8_t read_positions(const struct robot *robot)
{
    struct motion_start *start = start_of(robot);
    uint8_t result = (uint8_t)group_cycle_await_positions(robot, start->begun_us);

    if (result != CDS_OK) {
        if (result != CDS_PENDING)
            start->outcome.id = unknown_servo(robot);
        return result;
    }
    start->phase = READ_STATES;
    // The start of a motion under way has read the states of all servos.
    start->read_joint = moves_go_on(robot) ? robot->group_count : 0;
    start->is_reading = false;
    start->read = (struct cds_request)CDS_REQUEST(start->read_packet, start->read_reply);
    return CDS_PENDING;
}

/* Time of a READ of mode and torque at the longest return delay. */
static uint16_t read_us(const struct cds_bus *bus)
{
    return (uint16_t)((CDS_PACKET_SIZE(2) + CDS_PACKET_SIZE(MOTION_READ_SIZE)) * bus->byte_time_us +
                      CDS_RETURN_DELAY_MAX_US + CDS_REPLY_MARGIN_US);
}

/* Reads mode and torque of a servo between the goals of the cycle. If the READ never fits between
 * them, or the line was not quiet for too long, it is sent at once. Then it ends by its deadline.
 * robot->servos learns mode and torque from the packets that pass. */
static uint8_t read_state(struct robot *robot, uint8_t id)
{
    struct motion_start *start = start_of(robot);
    uint16_t us = read_us(robot->bus);
    enum cds_result result;

    if (us <= cds_cycle_spare_us(robot->cycle) &&
        cds_port_now_us() - start->begun_us < GROUP_CYCLE_KNOWN_US &&
        !cds_cycle_yields(robot->cycle, us))
        return CDS_PENDING;
    result = cds_servo_read(robot->bus, &start->read, id, CDS_REG_CW_ANGLE_LIMIT,
                            sizeof start->read_reply);
    start->is_reading = result == CDS_OK;
    return result == CDS_OK || result == CDS_BUSY ? (uint8_t)CDS_PENDING : (uint8_t)result;
}

/* Mode and torque are known: checks the servos of a move, or of a sequence step by step. */
static uint8_t end_states(const struct robot *robot)
{
    struct motion_start *start = start_of(robot);

    start->phase = start->is_sequence ? CHECK_SERVOS : BEGIN;
    start->step = 0;
    return start->is_sequence ? (uint8_t)CDS_PENDING : check_pose(robot, start->move.pose);
}

/* Checks the servos of a step. */
static uint8_t check_step_servos(const struct robot *robot)
{
    struct motion_start *start = start_of(robot);
    uint16_t pose[ROBOT_SERVOS];

    if (stored_step_pose(robot->moves->store, &start->joints, start->place, start->step++, pose) ==
        STORED_POSE_END) {
        start->phase = BEGIN;
        return CDS_PENDING;
    }
    return check_pose(robot, pose);
}

/* The READ has ended. */
static uint8_t take_state(const struct robot *robot)
{
    struct motion_start *start = start_of(robot);

    if (start->read.result == CDS_PENDING)
        return CDS_PENDING;
    start->is_reading = false;
    if (start->read.result != CDS_OK) {
        start->outcome.id = robot->group[start->read_joint];
        return start->read.result;
    }
    angle_limits_take(&start->limits[start->read_joint++], start->read_reply);
    return CDS_PENDING;
}

static uint8_t read_states(struct robot *robot)
{
    const struct motion_start *start = start_of(robot);

    if (start->is_reading)
        return take_state(robot);
    if (start->read_joint == robot->group_count)
        return end_states(robot);
    return read_state(robot, robot->group[start->read_joint]);
}

static uint8_t begin_motion(struct robot *robot)
{
    const struct moves *moves = robot->moves;
    struct motion_start *start = start_of(robot);
    enum cds_result result = start->is_sequence
                                 ? moves_play(robot, moves->store, start->place, start->repeats,
                                              moves->percent, moves->ends_cycle)
                                 : moves_begin(robot, &start->move, moves->ends_cycle);

    if (result == CDS_OK)
        start->phase = CHECK_MOVES;
    return result == CDS_OK || result == CDS_BUSY ? (uint8_t)CDS_PENDING : (uint8_t)result;
}

/* A sequence first tries all its steps, then submits the first one: until the motion is under way,
 * move_result is that of a step that was tried. */
static uint8_t check_moves(struct robot *robot)
{
    const struct moves *moves = robot->moves;
    struct motion_start *start = start_of(robot);
    uint8_t result = moves->player.sequence.result;

    if (result == CDS_PENDING && moves->motion.result != CDS_PENDING)
        return CDS_PENDING;
    if (result == CDS_OK || result == CDS_PENDING)
        result = moves->motion.move_result;
    if (result == CDS_PENDING)
        return result;
    if (result == CDS_OK) {
        stored_group_keep(robot);
        if (!start->is_sequence)
            moves_set_override(robot, 100);
        return result;
    }
    start->outcome = moves_refusal(robot, result);
    return start->outcome.result;
}

static uint8_t poll_start(struct robot *robot)
{
    const struct motion_start *start = start_of(robot);

    if (start->is_sequence && start->phase < CHECK_MOVES &&
        motion_store_is_saving(robot->moves->store))
        return MOTION_SAVING; // a step that cannot be read is not the end of the sequence
    switch (start->phase) {
    case CHECK_STEPS: return check_step(robot);
    case READ_POSITIONS: return read_positions(robot);
    case READ_STATES: return read_states(robot);
    case CHECK_SERVOS: return check_step_servos(robot);
    case BEGIN: return begin_motion(robot);
    default: return check_moves(robot);
    }
}

/* ---- end ---- */

/* The start has ended. If it was refused, a move under way goes on. */
static void end_start(struct robot *robot, uint8_t result)
{
    struct motion_start *start = start_of(robot);

    if (start->is_reading)
        cds_bus_cancel(robot->bus, &start->read);
    start->is_reading = false;
    start->outcome.result = result;
    if (start->phase <= CHECK_SERVOS) // steps are read: `step` is that behind the refused one;
                                      // 0 - 1 is MOTION_NO_STEP
        start->outcome.step = (uint8_t)(start->step - 1);
    if (result != CDS_OK && !moves_go_on(robot))
        moves_note_outcome(robot, &start->outcome);
}

static enum cds_result begin_cycle(struct robot *robot, const void *config)
{
    return moves_cycle.begin(robot, config);
}

static enum cds_result poll(struct robot *robot)
{
    enum cds_result result;

    if (motion_is_starting(robot)) {
        uint8_t error = poll_start(robot);

        if (error != CDS_PENDING)
            end_start(robot, error);
    }
    result = moves_cycle.poll(robot);
    if (result != CDS_PENDING && motion_is_starting(robot))
        end_start(robot, ROBOT_STOPPED);
    if (result != CDS_PENDING)
        stored_group_drop(robot); // of a motion that was refused
    return result;
}

/* Nothing reads the pose of a start after this: the console may use its buffer for another line. */
static void abort_cycle(struct robot *robot)
{
    if (motion_is_starting(robot))
        end_start(robot, ROBOT_STOPPED);
    moves_cycle.abort(robot);
}

const CDS_FLASH struct robot_operation motion_cycle = {
    .begin = begin_cycle, .poll = poll, .abort = abort_cycle};

void motion_end(struct robot *robot)
{
    if (motion_is_starting(robot))
        end_start(robot, MOTION_NONE);
    moves_end(robot);
}

bool motion_may_pause(const struct robot *robot)
{
    return robot_is_in_motion(robot) && !motion_is_starting(robot);
}

bool motion_is_paused(const struct robot *robot)
{
    return motion_may_pause(robot) && robot->moves->is_paused;
}

bool motion_is_starting(const struct robot *robot)
{
    return start_of(robot)->outcome.result == CDS_PENDING;
}

const struct motion_outcome *motion_outcome(const struct robot *robot)
{
    return &robot->moves->outcome;
}
