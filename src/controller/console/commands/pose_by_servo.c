/* SPDX-License-Identifier: MIT */
/* "pose ... in TIME" without a cycle: each servo gets one goal, and the speed at which all arrive
 * together. */
#include "cds55xx/control_table.h" // CDS_REG_PRESENT_POSITION
#include "cds55xx/motion.h"        // CDS_POSE_NONE
#include "console/commands/shared.h"
#include "console/errors.h"
#include "console/messages.h"

/* At speed 1, 62/1023 RPM, a servo goes 31/25 steps in a second: 31/25000 in a millisecond. */
#define SPEED_BY_STEPS ((uint32_t)25000)
#define SPEED_BY_MS    ((uint32_t)31)

/* Of console->part. pose_poll() has set it to 0 or 1: positions are being read. */
#define SENDING 2

static uint8_t read_position(struct console *console)
{
    console->line.id = console->robot->group[console->index];
    return servo_read(console, CDS_REG_PRESENT_POSITION, 2);
}

static uint8_t begin(struct console *console)
{
    uint8_t error = pose_keep_goals(console);

    return error ? error : read_position(console);
}

/* Returns the speed at which a servo goes `steps` in `ms` milliseconds, rounded up. */
static uint32_t speed_for(uint16_t steps, uint32_t ms)
{
    return (SPEED_BY_STEPS * steps + SPEED_BY_MS * ms - 1) / (SPEED_BY_MS * ms);
}

/* Returns the milliseconds in which a servo goes `steps` at `speed`, rounded up: steps = speed x
 * time, so speed and time change places in the formula. */
static uint32_t ms_for(uint16_t steps, uint16_t speed)
{
    return speed_for(steps, speed);
}

/* Sets the speed of the goal of the servo that has answered. */
static uint8_t set_speed(struct console *console)
{
    struct cds_goal *goal = &console->robot->work.move.goals[console->index];
    const struct cds_servo_state *servo = console_servo(console);
    uint16_t position = 0, fastest = servo ? servo->fastest : CDS_VALUE_MAX, steps;
    uint8_t error = (uint8_t)cds_request_word(console->line.request, 0, &position);
    uint32_t speed, ms;

    if (error)
        return error;
    if (goal->position == CDS_POSE_NONE) // of a stored pose: the servo stays
        goal->position = position;
    steps = (uint16_t)(position > goal->position ? position - goal->position
                                                 : goal->position - position);
    speed = speed_for(steps, move_job(console)->ms);
    if (speed > fastest && fastest) {
        ms = ms_for(steps, fastest);
        console->printer.values[0].number = goal->id;
        console->printer.values[1].number = (uint16_t)ms;
        console->printer.values[2].number = (uint16_t)(ms >> 16);
        printer_line(&console->printer, message_too_fast);
        return ERROR_TOO_FAST;
    }
    goal->speed = speed ? (uint16_t)speed : 1; // 0 is full speed
    return 0;
}

static bool poll(struct console *console)
{
    struct robot *robot = console->robot;

    if (console->part == SENDING)
        return pose_sent_poll(console);
    if (console_waits(console))
        return true;
    if (console->error == 0)
        console->error = set_speed(console);
    if (console->error)
        return false;
    if (++console->index < robot->group_count) {
        console->error = read_position(console);
    } else {
        console->part = SENDING;
        console->index = 0;
        console->error = pose_send(console);
    }
    return console->error == 0;
}

const CDS_FLASH struct command_action pose_by_servo = {.begin = begin, .poll = poll};
