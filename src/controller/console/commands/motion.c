/* SPDX-License-Identifier: MIT */
/* What play and "pose ... in TIME" share: the start of a motion. */
#include "console/commands/shared.h"
#include "console/errors.h"
#include "console/messages.h"
#include "robot/motion_start.h"
#include "robot/moves.h"

static const CDS_FLASH char message_because[] = "because of servo %u";

enum phase {
    WAIT,  // until a cycle that is ending has ended
    START, // until the motion has begun, or was refused
    END,   // it was refused: until the cycle that was started for it has ended
} __attribute__((packed));

void motion_failed(struct console *console, uint8_t joint)
{
    const struct robot *robot = console->robot;
    const struct cds_motion *motion = &robot->moves->motion;
    union printer_value *values = console->printer.values;
    bool is_too_fast = console->error == CDS_LIMIT && motion->shortest_ms;

    if (joint == MOTION_NO_JOINT)
        return;
    values[0].number = robot->group[joint];
    if (is_too_fast) {
        values[1].number = (uint16_t)motion->shortest_ms;
        values[2].number = (uint16_t)(motion->shortest_ms >> 16);
        console->error = ERROR_TOO_FAST;
    }
    printer_line(&console->printer, is_too_fast ? message_too_fast : message_because);
}

static bool poll_start(struct console *console)
{
    const struct motion_start *start = &console->robot->moves->start;

    if (start->result == CDS_PENDING)
        return true;
    console->error = start->result;
    if (console->error == 0)
        return false;
    console->phase = END;
    motion_failed(console, start->joint);
    return true;
}

bool motion_command_poll(struct console *console, uint8_t (*start)(struct console *console))
{
    const struct robot *robot = console->robot;

    switch (console->phase) {
    case WAIT:
        if (motion_cycle_is_ending(robot))
            return true;
        console->phase = START;
        console->error = start(console);
        return console->error == 0;
    case START: return poll_start(console);
    default: return motion_cycle_is_ending(robot);
    }
}
