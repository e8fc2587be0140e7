/* SPDX-License-Identifier: MIT */
/* Finds all steps of a sequence that are too fast: `play` starts again with the steps found so far
 * made slower, until none is left, and then fails. Nothing moves meanwhile. Only for chips with
 * room for it. */
#include <stddef.h>
#include <string.h> // memset()

#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "robot/moves.h"

/* Reads the steps for the player after a start that has found one too fast: all are tried again,
 * and those that are known to be too fast may take longer, so the motion finds the next one. Steps
 * that all were tried have no pose: the sequence ends as CDS_BAD_ARGUMENT and does not begin. */
static bool read_tried_step(void *context, uint8_t index, struct cds_sequence_step *step,
                            uint16_t *pose)
{
    struct player *player = context;

    player->read = NULL; // it is for one start
    if (!player_read_step(context, index, step, pose))
        return false;
    step->may_take_longer = player->too_fast >> index & 1;
    if (!player->sequence.is_checking)
        memset(pose, UINT8_MAX, player->sequence.config.motion->count * sizeof *pose);
    return true;
}

void fast_steps_begin(struct console *console)
{
    struct player *player = &console->robot->moves->player;

    player->too_fast = ((struct play_job *)console_job(console))->too_fast;
    player->read = player->too_fast ? read_tried_step : NULL;
}

bool fast_steps_try_again(struct console *console)
{
    struct moves *moves = console->robot->moves;
    struct motion_outcome outcome = moves->start.outcome;
    struct play_job *job = console_job(console);
    uint16_t bit = (uint16_t)(1u << (outcome.step & 0x0F));

    fast_steps_end(console->robot); // the start may have ended before it read a step
    if (!moves->start.is_sequence || (job->too_fast == 0 && outcome.result != MOTION_TOO_FAST))
        return false;
    if (outcome.result == MOTION_TOO_FAST && !(job->too_fast & bit)) {
        motion_print_cause(console, &outcome);
        if (job->too_fast == 0)
            job->first = outcome;
        job->too_fast |= bit;
        return true;
    }
    if (moves->outcome.result != CDS_PENDING) // else the PC has started another motion
        moves_note_outcome(console->robot, &job->first);
    console->robot->servos.refused_id = job->first.id;
    console->error = ERROR_TOO_FAST;
    return false;
}

void fast_steps_end(struct robot *robot)
{
    robot->moves->player.read = NULL;
}
