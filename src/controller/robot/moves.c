/* SPDX-License-Identifier: MIT */
/* Timed moves of the group; see moves.h. */
#include "robot/moves.h"

#include <stddef.h>
#include <string.h>

#include "compiler.h" // NOINLINE
#include "robot/group_cycle.h"
#include "robot/motion_store.h" // motion_store_round_up()

static enum cds_result begin_cycle(struct robot *robot, const void *config)
{
    struct moves *moves = robot->moves;
    enum cds_result result = group_cycle_begin(robot, config);

    moves->ends_cycle = false;
    moves->player.sequence.result = CDS_OK;
    return result != CDS_OK
               ? result
               : cds_motion_begin(
                     &moves->motion,
                     &(struct cds_motion_config){.cycle = robot->cycle,
                                                 .servos = &robot->servos,
                                                 .joints = moves->joints,
                                                 .acceleration = CDS_MOTION_FACTORY_ACCELERATION});
}

void moves_open(struct robot *robot, const struct motion_store *store,
                const struct settings *settings)
{
    robot->moves->store = store;
    robot->moves->settings = settings;
    robot->moves->percent = 100;
}

bool moves_go_on(const struct robot *robot)
{
    const struct moves *moves = robot->moves;

    return moves->player.sequence.result == CDS_PENDING || moves->motion.result == CDS_PENDING ||
           cds_motion_is_busy(&moves->motion);
}

bool moves_is_playing(const struct robot *robot)
{
    const struct moves *moves = robot->moves;

    return moves && robot->cycle && moves->player.sequence.result == CDS_PENDING;
}

void moves_reserve(struct robot *robot, bool ends_cycle)
{
    if (!moves_go_on(robot))
        robot->moves->follow.result = CDS_OK; // of the motion before
    robot->moves->ends_cycle = ends_cycle;
    cds_servos_reserve(&robot->servos, &robot->cycle->goals, robot->group, robot->group_count);
}

/* The motion is checked: its servos are reserved, and compared with their goals. */
static void take_servos(struct robot *robot, bool ends_cycle)
{
    struct moves *moves = robot->moves;

    moves_reserve(robot, ends_cycle);
    cds_follow_begin(&moves->follow, &(struct cds_follow_config){.cycle = robot->cycle,
                                                                 .joints = moves->follow_joints});
}

static void release_servos(struct robot *robot)
{
    cds_servos_reserve(&robot->servos, NULL, NULL, 0);
}

/* Periods without a packet on the line, after which the line counts as low or never quiet. With
 * noise some packets leave. */
#define UNSENT_PERIODS 3

static void count_unsent_periods(struct moves *moves, uint8_t sent)
{
    if (moves->sent != sent)
        moves->unsent_periods = 0;
    else if (moves->unsent_periods < UNSENT_PERIODS)
        moves->unsent_periods++;
    moves->sent = sent;
}

/* True if the torque of a joint that takes part in the move was switched off since its start. */
static bool is_limp(struct robot *robot, uint8_t joint)
{
    const struct cds_servo_state *servo = cds_servos_find(&robot->servos, robot->group[joint]);

    return robot->moves->joints[joint].is_moving && servo && !servo->torque;
}

/* In each period counts whether a packet has left, and looks at one joint: the poll, which comes
 * several times in a turn, stays short. */
static void watch_period(struct robot *robot)
{
    struct moves *moves = robot->moves;
    uint8_t period = (uint8_t)robot->work.cycle.cycle.counters.periods;

    if (moves->watched == period)
        return;
    moves->watched = period;
    count_unsent_periods(moves, (uint8_t)robot->bus->stats.sent);
    if (moves->follow.result != CDS_PENDING)
        return;
    if (is_limp(robot, moves->follow.joint))
        moves->follow.result = CDS_TIMEOUT; // however near to its goal
    if (cds_follow_poll(&moves->follow) == CDS_TIMEOUT)
        moves_end(robot);
}

void moves_note_outcome(struct robot *robot, const struct motion_outcome *outcome)
{
    struct moves *moves = robot->moves;

    moves->outcome = *outcome;
    moves->noted_saves = (uint8_t)moves->store->saves;
    moves->end_is_unreported = false;
}

bool moves_take_end(struct robot *robot)
{
    bool is_unreported = robot->moves->end_is_unreported;

    robot->moves->end_is_unreported = false;
    return is_unreported;
}

/* The step that is checked or under way; MOTION_NO_STEP: no sequence plays. */
static uint8_t step_of(const struct moves *moves)
{
    return moves->player.sequence.result == CDS_OK ? MOTION_NO_STEP : moves->player.sequence.step;
}

struct motion_outcome moves_refusal(const struct robot *robot, uint8_t result)
{
    const struct moves *moves = robot->moves;
    const struct cds_motion *motion = &moves->motion;
    struct motion_outcome outcome = {
        .result = result,
        .id = motion->joint < robot->group_count ? robot->group[motion->joint] : CDS_NO_ID,
        .step = step_of(moves)};

    if (result == CDS_LIMIT && motion->shortest_ms) {
        outcome.result = MOTION_TOO_FAST;
        outcome.shortest_ms = motion->shortest_ms;
        if (outcome.step != MOTION_NO_STEP)
            outcome.shortest_ms = motion_store_round_up(outcome.shortest_ms);
    }
    return outcome;
}

/* A servo did not follow its goals, or take one. In place of this symptom stores the first cause
 * that holds: inhibited, OFFLINE, line low or never quiet, torque off. No ID: all servos are
 * concerned. noinline: saves 12 bytes of atmega1284p/full.elf. */
static NOINLINE void find_cause(struct robot *robot, struct motion_outcome *outcome)
{
    const struct cds_servo_state *servo = cds_servos_find(&robot->servos, outcome->id);
    uint8_t result = CDS_TIMEOUT; // the servo is OFFLINE, or was until now

    if (!servo || robot_is_inhibited(robot)) {
        outcome->id = CDS_NO_ID;
        return;
    }
    if (servo->inhibits) {
        result = CDS_INHIBITED;
    } else if (servo->presence < CDS_PRESENCE_OFFLINE) {
        if (robot->moves->unsent_periods >= UNSENT_PERIODS) {
            result = CDS_LINE_BUSY;
            outcome->id = CDS_NO_ID;
        } else if (outcome->result != CDS_INHIBITED) {
            if (servo->torque)
                return;
            result = MOTION_TORQUE_OFF;
        }
    }
    outcome->result = result;
}

/* How the motion under way has ended. */
static struct motion_outcome ended(struct robot *robot)
{
    const struct moves *moves = robot->moves;
    struct motion_outcome outcome = {.id = CDS_NO_ID, .step = MOTION_NO_STEP};
    uint8_t result = moves->player.sequence.result;

    if (moves->follow.result == CDS_TIMEOUT) {
        outcome.result = MOTION_STUCK;
        outcome.id = robot->group[moves->follow.joint];
        outcome.step = step_of(moves);
    } else if (robot->work.cycle.cycle.is_aborted) {
        outcome.result = robot_is_inhibited(robot) ? (uint8_t)ROBOT_STOPPED : (uint8_t)MOTION_NONE;
    } else {
        if (result == CDS_OK || (result == CDS_CANCELLED && moves->motion.result != CDS_OK))
            result = moves->motion.result;
        outcome.result = result;
        if (result == CDS_CANCELLED)
            outcome.result = MOTION_NONE;
        else if (result != CDS_OK)
            outcome = moves_refusal(robot, result);
    }
    if (outcome.result == MOTION_STUCK || outcome.result == CDS_INHIBITED)
        find_cause(robot, &outcome);
    return outcome;
}

/* The motion has ended, or the cycle has. The start of a motion notes its own outcome. */
static void end_motion(struct robot *robot)
{
    if (robot->moves->outcome.result == CDS_PENDING &&
        robot->moves->start.outcome.result != CDS_PENDING) {
        const struct motion_outcome outcome = ended(robot);

        moves_note_outcome(robot, &outcome);
        robot->moves->end_is_unreported = true;
    }
    release_servos(robot);
    if (robot->moves->ends_cycle)
        group_cycle_abort(robot);
}

static enum cds_result poll_cycle(struct robot *robot)
{
    struct moves *moves = robot->moves;
    enum cds_result result = group_cycle_poll(robot);

    if (moves->player.sequence.result == CDS_PENDING)
        cds_sequence_poll(&moves->player.sequence);
    else
        cds_motion_poll(&moves->motion);
    if (robot->servos.reserved_count || moves->ends_cycle) {
        watch_period(robot);
        if (result != CDS_PENDING || !(moves_go_on(robot) || motion_is_starting(robot)))
            end_motion(robot);
    }
    return result;
}

const CDS_FLASH struct robot_operation moves_cycle = {
    .begin = begin_cycle, .poll = poll_cycle, .abort = group_cycle_abort};

enum cds_result moves_begin(struct robot *robot, const struct cds_move *move, bool ends_cycle)
{
    struct moves *moves = robot->moves;
    struct cds_move copy = *move;
    enum cds_result result;

    if (moves_is_playing(robot) || cds_motion_is_busy(&moves->motion))
        return CDS_BUSY;
    if (!moves_go_on(robot))
        moves_set_override(robot, 100); // else when this move begins in place of the other one
    memcpy(moves->player.poses, move->pose, robot->group_count * sizeof *move->pose);
    copy.pose = moves->player.poses;
    result = cds_motion_move(&moves->motion, &copy);
    moves->is_paused = moves->motion.is_paused;
    moves->player.sequence.result = CDS_OK; // of a sequence that played before
    if (result == CDS_OK)
        take_servos(robot, ends_cycle);
    return result;
}

enum cds_result moves_play(struct robot *robot, const struct motion_store *store, uint8_t place,
                           uint16_t repeats, uint8_t percent, bool ends_cycle)
{
    struct moves *moves = robot->moves;
    enum cds_result result =
        player_begin(&moves->player, &moves->motion, store, robot, place, repeats);

    if (result != CDS_OK)
        return result;
    moves->is_paused = false;
    take_servos(robot, ends_cycle);
    moves_set_override(robot, percent);
    return CDS_OK;
}

void moves_set_override(struct robot *robot, uint8_t percent)
{
    robot->moves->percent = percent;
    cds_motion_set_override(&robot->moves->motion, percent);
}

void moves_pause(struct robot *robot)
{
    robot->moves->is_paused = true;
    if (moves_is_playing(robot))
        cds_sequence_pause(&robot->moves->player.sequence, CDS_MOTION_DECELERATION);
    else
        cds_motion_pause(&robot->moves->motion, CDS_MOTION_DECELERATION);
}

void moves_resume(struct robot *robot)
{
    robot->moves->is_paused = false;
    if (moves_is_playing(robot))
        cds_sequence_resume(&robot->moves->player.sequence);
    else
        cds_motion_resume(&robot->moves->motion);
}

void moves_end(struct robot *robot)
{
    robot->moves->is_paused = false;
    player_abort(&robot->moves->player);
    cds_motion_abort(&robot->moves->motion, CDS_MOTION_DECELERATION);
}
