/* SPDX-License-Identifier: MIT */
/* motion at PERCENT: the speed of the motion under way. Only for chips with room for it. */
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "robot/motion_start.h"
#include "robot/moves.h"

static uint8_t speed_begin(struct console *console)
{
    uint8_t percent, error = play_take_percent(console, 0, &percent);

    if (error == 0 && !motion_may_pause(console->robot))
        error = ERROR_NO_MOTION;
    if (error == 0)
        moves_set_override(console->robot, percent);
    return error;
}

static const CDS_FLASH struct command motion_speed_rows[] = {
    {
        .usage = FLASH_TEXT("motion at PERCENT"),
        .what = FLASH_TEXT("change the speed of the motion under way"),
        .details = COMMAND_DETAILS(
            "10 to 200% of the speed of its steps, as play NAME at PERCENT. Rests keep their time"),
        .example = COMMAND_DETAILS("motion at 50%"),
        .begin = speed_begin,
    },
};

const CDS_FLASH struct command_group motion_speed_commands = {
    .rows = motion_speed_rows,
    .count = sizeof motion_speed_rows / sizeof motion_speed_rows[0],
};
