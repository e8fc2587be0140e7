/* SPDX-License-Identifier: MIT */
/* "pose ... in TIME" by a timed move of the cycle. A cycle that this command starts ends with the
 * move. */
#include "console/commands/shared.h"
#include "console/errors.h"
#include "robot/motion_start.h"
#include "robot/moves.h"

static uint8_t begin(struct console *console)
{
    if (motion_is_paused(console->robot))
        return ERROR_PAUSED;
    return moves_is_playing(console->robot) ? (uint8_t)ERROR_MOTION : 0;
}

/* The angles of the line are the pose. They stay in its buffer until the start has ended. */
static uint8_t start(struct console *console)
{
    const void *pose = console->line.request->packet.bytes;

    return motion_start_move(console->robot,
                             &(struct cds_move){.pose = pose, .time_ms = move_job(console)->ms});
}

static bool poll(struct console *console)
{
    return motion_command_poll(console, start);
}

const CDS_FLASH struct command_action pose_moves = {.begin = begin, .poll = poll};
