/* SPDX-License-Identifier: MIT */
/* Sequences of poses; see sequence.h. The step under way and the next one are in two slots by
 * turns. */
#include "cds55xx/sequence.h"
#include "compiler.h" // NOINLINE
#include "robot/motion_internal.h"

#define RUNS_TRIED 2

enum {
    TRYING,   // the step in the slot is tried next; none has begun
    TRIED,    // until the motion has tried it
    DWELLING, // until the next step may begin
    CHECKING, // the motion checks its move
    MOVING,
    QUEUED, // moving, and the move of the step behind it waits for the end
    ENDING, // dwelling at the last pose
};

/* noinline: saves 110 bytes of atmega1284p/full.elf. */
static NOINLINE uint16_t *pose_of(const struct cds_sequence *sequence, uint8_t slot)
{
    return sequence->config.poses + (slot ? sequence->config.motion->count : 0);
}

static bool read_to(struct cds_sequence *sequence, uint8_t slot, uint8_t index, uint16_t run)
{
    struct cds_sequence_slot *to = &sequence->slots[slot];

    to->index = index;
    to->run = run;
    return sequence->config.read(sequence->config.context, index, &to->step,
                                 pose_of(sequence, slot));
}

/* Reads the step behind the step in `slot` to the other slot. Behind the last step the next run
 * begins. False: there is no step left. */
static bool read_behind(struct cds_sequence *sequence, uint8_t slot)
{
    const struct cds_sequence_slot *from = &sequence->slots[slot];
    uint16_t repeats = sequence->config.repeats, run = (uint16_t)(from->run + 1);

    if (from->index < UINT8_MAX && read_to(sequence, !slot, (uint8_t)(from->index + 1), from->run))
        return true;
    return (repeats == 0 || run < repeats) && read_to(sequence, !slot, 0, run);
}

/* Submits the move of the step in `slot`, or tries it. A step that passes needs the step behind it.
 * If that step is the one that is out of range, sequence->slot is switched to it, so that the
 * caller reports it. */
static enum cds_result submit(struct cds_sequence *sequence, uint8_t slot, bool waits)
{
    const struct cds_sequence_step *step = &sequence->slots[slot].step;
    struct cds_move move = {.pose = pose_of(sequence, slot),
                            .time_ms = step->time_ms,
                            .curve = step->curve,
                            .may_take_longer = step->may_take_longer,
                            .waits = waits,
                            .pass_rate = sequence->pass_rate,
                            .acceleration = step->acceleration};
    enum cds_result result;

    if (cds_motion_is_busy(sequence->config.motion))
        return CDS_BUSY;
    sequence->passes = step->passes && read_behind(sequence, slot);
    if (sequence->passes) {
        move.next_pose = pose_of(sequence, !slot);
        move.next_ms = sequence->slots[!slot].step.time_ms;
    }
    result = sequence->is_checking ? cds_motion_try(sequence->config.motion, &move,
                                                    sequence->step == 0 && sequence->run == 0)
                                   : cds_motion_move(sequence->config.motion, &move);
    if (result == CDS_BAD_ARGUMENT &&
        sequence->config.motion->wrong_argument >= CDS_MOTION_NEXT_TIME)
        sequence->slot = !sequence->slot;
    return result;
}

static enum cds_result end(struct cds_sequence *sequence, enum cds_result result)
{
    sequence->result = result;
    return result;
}

/* The step in the slot is under way now. Copies what is needed when its move ends: before that, the
 * step after the next one may be read to this slot. noinline: saves 130 bytes. */
static NOINLINE void note_step(struct cds_sequence *sequence)
{
    const struct cds_sequence_slot *from = &sequence->slots[sequence->slot];

    sequence->step = from->index;
    sequence->run = from->run;
    sequence->event = from->step.event;
    sequence->step_dwell_ms = from->step.dwell_ms;
}

static void report_pose(const struct cds_sequence *sequence)
{
    if (sequence->config.on_pose)
        sequence->config.on_pose(sequence->config.context, sequence->step, sequence->event);
}

static bool is_dwell_over(const struct cds_sequence *sequence)
{
    return !sequence->is_paused &&
           cds_port_now_us() - sequence->dwell_from_us >= 1000ul * sequence->dwell_ms;
}

/* The step in the other slot is under way now. */
static void note_other_step(struct cds_sequence *sequence)
{
    sequence->slot = !sequence->slot;
    note_step(sequence);
}

/* Reads the first step. False: there is none. */
static bool rewind_to_first(struct cds_sequence *sequence)
{
    if (!read_to(sequence, 0, 0, 0))
        return false;
    sequence->slot = 0;
    note_step(sequence);
    return true;
}

/* The step in the slot was tried. Tries the next one, up to the end of the second run; then the
 * sequence begins. In the first run a joint starts from where it is, in the second run from the
 * last pose that has it. Later runs equal the second one. */
static enum cds_result try_next(struct cds_sequence *sequence)
{
    if (read_behind(sequence, sequence->slot) &&
        sequence->slots[!sequence->slot].run < RUNS_TRIED) {
        note_other_step(sequence);
        sequence->state = TRYING;
        return CDS_PENDING;
    }
    sequence->is_checking = false;
    sequence->state = DWELLING;
    return rewind_to_first(sequence) ? CDS_PENDING : end(sequence, CDS_BAD_ARGUMENT);
}

/* `result`: of the check, or of a submit that was refused. Unless it is CDS_PENDING, the step in
 * the slot becomes the current step. */
static enum cds_result take_check(struct cds_sequence *sequence, enum cds_result result)
{
    if (result == CDS_PENDING)
        return result;
    note_step(sequence);
    sequence->state = MOVING;
    return result == CDS_OK ? CDS_PENDING : end(sequence, result);
}

static enum cds_result poll_trial(struct cds_sequence *sequence)
{
    enum cds_result result;

    sequence->has_passed = sequence->passes; // the step before
    result = submit(sequence, sequence->slot, false);
    if (result != CDS_OK)
        return take_check(sequence, result);
    sequence->state = TRIED;
    return CDS_PENDING;
}

static enum cds_result poll_tried(struct cds_sequence *sequence)
{
    struct cds_motion *motion = sequence->config.motion;
    enum cds_result result = (enum cds_result)motion->move_result;

    if (result == CDS_OK) {
        if (sequence->has_passed && motion->has_speeds)
            sequence->pass_rate = motion->next_plan.rate_most;
        return try_next(sequence);
    }
    return result == CDS_PENDING ? result : end(sequence, result);
}

static enum cds_result poll_check(struct cds_sequence *sequence)
{
    return take_check(sequence, (enum cds_result)sequence->config.motion->move_result);
}

static enum cds_result poll_dwell(struct cds_sequence *sequence)
{
    const struct cds_sequence_config *config = &sequence->config;
    enum cds_result result;

    if (!is_dwell_over(sequence) ||
        (config->may_begin &&
         !config->may_begin(config->context, sequence->slots[sequence->slot].index)))
        return CDS_PENDING;
    sequence->state = CHECKING;
    result = submit(sequence, sequence->slot, false);
    return result == CDS_OK ? CDS_PENDING : take_check(sequence, result);
}

/* The joints rest at the pose, then the next step begins, or the sequence ends. */
static enum cds_result arrive(struct cds_sequence *sequence)
{
    report_pose(sequence);
    sequence->dwell_ms = sequence->step_dwell_ms;
    sequence->dwell_from_us = cds_port_now_us();
    sequence->state = ENDING;
    if (read_behind(sequence, sequence->slot)) {
        sequence->slot = !sequence->slot;
        sequence->state = DWELLING;
    }
    return CDS_PENDING;
}

/* The move of the next step was refused: the joints come to rest. A move that a motion drops
 * because it ends is not refused. */
static enum cds_result end_refused(struct cds_sequence *sequence, enum cds_result result)
{
    struct cds_motion *motion = sequence->config.motion;

    if (!motion->is_ending) {
        sequence->step = sequence->slots[!sequence->slot].index;
        sequence->run = sequence->slots[!sequence->slot].run;
    }
    cds_motion_abort(motion, CDS_MOTION_DECELERATION);
    return end(sequence, result);
}

static enum cds_result poll_moving(struct cds_sequence *sequence)
{
    struct cds_motion *motion = sequence->config.motion;
    enum cds_result result = (enum cds_result)motion->result;

    if (result == CDS_OK)
        return arrive(sequence);
    if (result != CDS_PENDING)
        return end(sequence, result);
    if (!sequence->passes)
        return CDS_PENDING;
    result = submit(sequence, !sequence->slot, true);
    if (result == CDS_OK)
        sequence->state = QUEUED;
    else if (result != CDS_BUSY)
        return end_refused(sequence, result);
    return CDS_PENDING;
}

/* The joints pass the pose when the next move begins. */
static enum cds_result poll_queue(struct cds_sequence *sequence)
{
    enum cds_result result = (enum cds_result)sequence->config.motion->move_result;

    if (result == CDS_OK) {
        report_pose(sequence);
        note_other_step(sequence);
        sequence->state = MOVING;
    } else if (result != CDS_PENDING) {
        return end_refused(sequence, result);
    }
    return CDS_PENDING;
}

enum cds_result cds_sequence_begin(struct cds_sequence *sequence,
                                   const struct cds_sequence_config *config)
{
    if (config->motion->result == CDS_PENDING || cds_motion_is_busy(config->motion))
        return CDS_BUSY;
    *sequence = (struct cds_sequence){.config = *config,
                                      .state = config->checks_all ? TRYING : DWELLING,
                                      .is_checking = config->checks_all,
                                      .pass_rate = config->checks_all ? 2 * CDS_MOTION_RATE_1 : 0};
    if (!rewind_to_first(sequence))
        return CDS_BAD_ARGUMENT;
    sequence->result = CDS_PENDING;
    return CDS_OK;
}

enum cds_result cds_sequence_poll(struct cds_sequence *sequence)
{
    if (sequence->config.motion) // else it was never begun
        cds_motion_poll(sequence->config.motion);
    if (sequence->result != CDS_PENDING)
        return (enum cds_result)sequence->result;
    switch (sequence->state) {
    case TRYING: return poll_trial(sequence);
    case TRIED: return poll_tried(sequence);
    case DWELLING: return poll_dwell(sequence);
    case CHECKING: return poll_check(sequence);
    case MOVING: return poll_moving(sequence);
    case QUEUED: return poll_queue(sequence);
    default: return is_dwell_over(sequence) ? end(sequence, CDS_OK) : CDS_PENDING;
    }
}

void cds_sequence_pause(struct cds_sequence *sequence, uint16_t deceleration)
{
    if (sequence->result != CDS_PENDING)
        return;
    sequence->is_paused = true;
    cds_motion_pause(sequence->config.motion, deceleration);
}

void cds_sequence_resume(struct cds_sequence *sequence)
{
    if (sequence->result != CDS_PENDING)
        return;
    sequence->is_paused = false;
    cds_motion_resume(sequence->config.motion);
}

void cds_sequence_abort(struct cds_sequence *sequence, uint16_t deceleration)
{
    if (sequence->result != CDS_PENDING)
        return;
    cds_motion_abort(sequence->config.motion, deceleration);
    sequence->result = CDS_CANCELLED;
}
