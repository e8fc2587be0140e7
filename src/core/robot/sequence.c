/* SPDX-License-Identifier: MIT */
/* Sequences of poses; see sequence.h. The step under way and the next one are in two places, in
 * turn. */
#include "cds55xx/sequence.h"

enum {
    RESTING,  // until the next step may begin
    CHECKING, // the motion checks its move
    MOVING,
    QUEUED, // moving, and the move of the step behind it waits for the end
};

static uint16_t *pose_of(const struct cds_sequence *sequence, uint8_t turn)
{
    return sequence->config.poses + (turn ? sequence->config.motion->count : 0);
}

static bool read_to(struct cds_sequence *sequence, uint8_t turn, uint8_t index, uint16_t run)
{
    struct cds_sequence_place *place = &sequence->places[turn];

    place->index = index;
    place->run = run;
    return sequence->config.read(sequence->config.context, index, &place->step,
                                 pose_of(sequence, turn));
}

/* Reads the step behind the one at `turn` to the other place; behind the last one the next run
 * begins. False: there is none. */
static bool read_behind(struct cds_sequence *sequence, uint8_t turn)
{
    const struct cds_sequence_place *place = &sequence->places[turn];
    uint16_t repeats = sequence->config.repeats, run = (uint16_t)(place->run + 1);

    if (read_to(sequence, !turn, (uint8_t)(place->index + 1), place->run))
        return true;
    return (repeats == 0 || run < repeats) && read_to(sequence, !turn, 0, run);
}

/* Submits the move of the step at `turn`. A step that passes needs the one behind it. */
static enum cds_result submit(struct cds_sequence *sequence, uint8_t turn, bool waits)
{
    const struct cds_sequence_step *step = &sequence->places[turn].step;
    struct cds_move move = {.pose = pose_of(sequence, turn),
                            .time_ms = step->time_ms,
                            .curve = step->curve,
                            .may_take_longer = step->may_take_longer,
                            .waits = waits,
                            .acceleration = step->acceleration};

    if (cds_motion_is_busy(sequence->config.motion))
        return CDS_BUSY;
    sequence->passes = step->passes && read_behind(sequence, turn);
    if (sequence->passes) {
        move.next_pose = pose_of(sequence, !turn);
        move.next_ms = sequence->places[!turn].step.time_ms;
    }
    return cds_motion_move(sequence->config.motion, &move);
}

static enum cds_result end(struct cds_sequence *sequence, enum cds_result result)
{
    sequence->result = result;
    return result;
}

/* The step at `turn` is under way now. Copies what is needed of the step: its place is the next one
 * that a step is read to. */
static void note_step(struct cds_sequence *sequence, uint8_t turn)
{
    const struct cds_sequence_place *place = &sequence->places[turn];

    sequence->turn = turn;
    sequence->step = place->index;
    sequence->run = place->run;
    sequence->event = place->step.event;
    sequence->dwell_ms = place->step.dwell_ms;
}

static void tell_pose(const struct cds_sequence *sequence)
{
    if (sequence->config.on_pose)
        sequence->config.on_pose(sequence->config.context, sequence->step, sequence->event);
}

static enum cds_result poll_rest(struct cds_sequence *sequence)
{
    const struct cds_sequence_config *config = &sequence->config;
    enum cds_result result;

    if (cds_port_now_us() - sequence->rest_from_us < 1000ul * sequence->rest_ms ||
        (config->may_begin && !config->may_begin(config->context, sequence->step)))
        return CDS_PENDING;
    result = submit(sequence, sequence->turn, false);
    if (result != CDS_OK)
        return end(sequence, result);
    sequence->state = CHECKING;
    return CDS_PENDING;
}

static enum cds_result poll_check(struct cds_sequence *sequence)
{
    enum cds_result result = (enum cds_result)sequence->config.motion->move_result;

    if (result == CDS_OK)
        sequence->state = MOVING;
    else if (result != CDS_PENDING)
        return end(sequence, result);
    return CDS_PENDING;
}

/* The joints rest at the pose, then the next step begins. */
static enum cds_result arrive(struct cds_sequence *sequence)
{
    tell_pose(sequence);
    sequence->rest_ms = sequence->dwell_ms;
    if (!read_behind(sequence, sequence->turn))
        return end(sequence, CDS_OK);
    note_step(sequence, !sequence->turn);
    sequence->rest_from_us = cds_port_now_us();
    sequence->state = RESTING;
    return CDS_PENDING;
}

static enum cds_result poll_way(struct cds_sequence *sequence)
{
    struct cds_motion *motion = sequence->config.motion;
    enum cds_result result = (enum cds_result)motion->result;

    if (result == CDS_OK)
        return arrive(sequence);
    if (result != CDS_PENDING)
        return end(sequence, result);
    if (!sequence->passes)
        return CDS_PENDING;
    result = submit(sequence, !sequence->turn, true);
    if (result == CDS_OK) {
        sequence->state = QUEUED;
    } else if (result != CDS_BUSY) {
        cds_motion_abort(motion, CDS_MOTION_DECELERATION);
        return end(sequence, result);
    }
    return CDS_PENDING;
}

/* The joints pass the pose when the next move begins. If that was refused, they come to rest. */
static enum cds_result poll_queue(struct cds_sequence *sequence)
{
    struct cds_motion *motion = sequence->config.motion;
    enum cds_result result = (enum cds_result)motion->move_result;

    if (result == CDS_OK) {
        tell_pose(sequence);
        note_step(sequence, !sequence->turn);
        sequence->state = MOVING;
    } else if (result != CDS_PENDING) {
        cds_motion_abort(motion, CDS_MOTION_DECELERATION);
        return end(sequence, result);
    }
    return CDS_PENDING;
}

enum cds_result cds_sequence_begin(struct cds_sequence *sequence,
                                   const struct cds_sequence_config *config)
{
    if (config->motion->result == CDS_PENDING || cds_motion_is_busy(config->motion))
        return CDS_BUSY;
    *sequence = (struct cds_sequence){.config = *config, .state = RESTING};
    if (!read_to(sequence, 0, 0, 0))
        return CDS_BAD_ARGUMENT;
    note_step(sequence, 0);
    sequence->result = CDS_PENDING;
    return CDS_OK;
}

enum cds_result cds_sequence_poll(struct cds_sequence *sequence)
{
    cds_motion_poll(sequence->config.motion);
    if (sequence->result != CDS_PENDING)
        return (enum cds_result)sequence->result;
    switch (sequence->state) {
    case RESTING: return poll_rest(sequence);
    case CHECKING: return poll_check(sequence);
    case MOVING: return poll_way(sequence);
    default: return poll_queue(sequence);
    }
}

void cds_sequence_abort(struct cds_sequence *sequence, uint16_t deceleration)
{
    if (sequence->result != CDS_PENDING)
        return;
    cds_motion_abort(sequence->config.motion, deceleration);
    sequence->result = CDS_CANCELLED;
}
