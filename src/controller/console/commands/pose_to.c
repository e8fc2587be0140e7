/* SPDX-License-Identifier: MIT */
/* pose NAME in TIME: a move to a stored pose. */
#include <string.h>

#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "robot/motion_start.h" // motion_check_group()
#include "robot/stored_group.h"
#include "robot/stored_pose.h"

/* The error for an enum stored_pose_result, or 0. */
static uint8_t error_of_pose(enum stored_pose_result result)
{
    static const CDS_FLASH uint8_t errors[] = {
        [STORED_POSE_READ] = 0,
        [STORED_POSE_MISSING] = ERROR_NO_POSE,
        [STORED_POSE_ABSENT] = ERROR_ABSENT,
    };

    return errors[result];
}

/* Puts the positions of the group into the line, as its angles. */
static void take_pose(struct console *console)
{
    uint16_t pose[ROBOT_SERVOS];
    struct stored_joints joints;

    console->error = stored_may_read();
    if (console->error)
        return;
    stored_joints_find(&joints, console_store(), console->robot);
    console->error = error_of_pose(stored_pose_read(console_store(), &joints, console->part, pose));
    memcpy(console->line.request->packet.bytes, pose, sizeof pose);
}

static uint8_t in_begin(struct console *console)
{
    uint8_t error = console_move_ms(console, 0, &move_job(console)->ms);

    if (error == 0)
        error = stored_may_read();
    if (error)
        return error;
    console->part = stored_find(console, MOTION_STORE_POSE, 0);
    return console->part == MOTION_STORE_NONE
               ? (uint8_t)ERROR_NO_POSE
               : stored_group_choose(console->robot, console_store());
}

/* Finding the pose takes up to 0.4 ms, and reading it 0.65 ms: two polls, so that the cycle is not
 * late. */
static bool in_poll(struct console *console)
{
    if (console->step)
        return command_set.pose_in->poll(console);
    take_pose(console);
    console->part = 0;
    if (console->error == 0 && !command_set.moves)
        console->error = motion_check_group(console->robot); // no motion checks it
    if (console->error == 0)
        console->error = command_set.pose_in->begin(console);
    return console->error == 0;
}

static const CDS_FLASH struct command pose_to_rows[] = {
    {
        .usage = FLASH_TEXT("pose NAME in TIME"),
        .what = FLASH_TEXT("move to a stored pose; all servos arrive together"),
        .details = COMMAND_DETAILS(
            "1ms to 600s. ok: the move has begun. Without a group: all servos of the stored poses"),
        .example = COMMAND_DETAILS("pose stand in 2s"),
        .begin = in_begin,
        .poll = in_poll,
    },
};

const CDS_FLASH struct command_group pose_to_commands = {
    .rows = pose_to_rows,
    .count = sizeof pose_to_rows / sizeof pose_to_rows[0],
};
