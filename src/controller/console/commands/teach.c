/* SPDX-License-Identifier: MIT */
/* teach: switches torque off so that a person can turn the servos, and on again where they are. */
#include <string.h>

#include "cds55xx/servo.h"     // cds_servo_write_byte()
#include "cds55xx/torque_on.h" // cds_torque_on_poll()
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

enum choice { HAND_MOVES = 1, SERVO_HOLDS } __attribute__((packed)); // teach on, teach off

struct teach_job {
    struct cds_torque_on torque_on; // of servo line.id
};

_Static_assert(sizeof(struct teach_job) <= CONSOLE_JOB_SIZE, "the job must fit");

uint8_t torque_on_error(uint8_t reason)
{
    static const CDS_FLASH uint8_t errors[] = {
        [CDS_REASON_NONE] = 0,
        [CDS_REASON_NO_REPLY] = CDS_TIMEOUT,
        [CDS_REASON_ALARM] = ERROR_ALARM,
        [CDS_REASON_MODE] = ERROR_ENDLESS,
        [CDS_REASON_VOLTAGE] = ERROR_VOLTAGE,
        [CDS_REASON_POSITION] = CDS_LIMIT,
        [CDS_REASON_REFUSED] = ERROR_GOAL,
        [CDS_REASON_INHIBITED] = CDS_INHIBITED,
    };

    return errors[reason];
}

uint8_t teach_choose(struct console *console)
{
    struct command_line *line = &console->line;
    const struct robot *robot = console->robot;
    uint8_t error = robot_busy(robot); // the next goals would move a servo that gets torque

    if (error)
        return error;
    if (line->choice == SERVO_HOLDS && robot_is_inhibited(robot))
        return CDS_INHIBITED; // no servo may have torque
    if (line->values == 0) {
        if (command_set.motion_words)
            error = command_set.motion_words->choose(console);
        if (error)
            return error;
        line->values = robot->group_count;
        memcpy(line->request->packet.bytes, robot->group, robot->group_count);
    }
    line->is_repeated = true;
    line->id = line->request->packet.bytes[0];
    return line->values ? 0 : ERROR_NO_GROUP;
}

/* The speed that goes with the goal; 0: the servo keeps its own. A servo whose speed is limited
 * gets the limit, unless its own speed is known to be within. */
static uint16_t speed_of_goal(const struct cds_servo_state *servo)
{
    const uint8_t speeds = CDS_HELD_SPEED | CDS_HELD_SPEED_0;
    bool is_limited = servo && servo->has_limits && servo->fastest < CDS_VALUE_MAX;

    return is_limited && (servo->held & speeds) != CDS_HELD_SPEED ? servo->fastest : 0;
}

uint8_t teach_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    struct teach_job *job = console_job(console);
    uint16_t speed = command_set.has_room ? speed_of_goal(console_servo(console)) : 0;

    if (line->choice == HAND_MOVES)
        return cds_servo_write_byte(console->bus, line->request, line->id, CDS_REG_TORQUE_ENABLE,
                                    0);
    return cds_torque_on_begin(&job->torque_on,
                               &(struct cds_torque_on_config){.bus = console->bus,
                                                              .request = line->request,
                                                              .id = line->id,
                                                              .last = CDS_TORQUE_ON_SWITCH,
                                                              .checks_condition = true,
                                                              .speed = speed});
}

/* Returns CDS_PENDING while torque of servo line.id is switched on; else an error or 0. */
static uint8_t switch_on(struct console *console)
{
    struct teach_job *job = console_job(console);
    uint8_t bits = console->line.request->error, result = cds_torque_on_poll(&job->torque_on);

    if (result != CDS_REFUSED)
        return result;
    result = error_of_servo(&bits);
    return result ? result : torque_on_error(job->torque_on.reason);
}

/* A servo that fails is left as it is. */
static bool teach_poll(struct console *console)
{
    uint8_t result;

    if (console->line.choice == HAND_MOVES)
        return console_waits(console);
    result = switch_on(console);
    if (result == CDS_PENDING)
        return true;
    console->error = result;
    return false;
}

static const CDS_FLASH struct command teach_rows[] = {
    {
        .usage = FLASH_TEXT("teach on|off [ID...]"),
        .what = FLASH_TEXT("torque off to turn servos by hand, on again where they are"),
        .details = COMMAND_DETAILS("Without IDs: the group. on: torque off. off: torque on, each "
                                   "servo holds its present position"),
        .example = COMMAND_DETAILS("teach on 1 2 3"),
        .begin = teach_begin,
        .poll = teach_poll,
    },
};

const CDS_FLASH struct command_group teach_commands = {
    .heading = FLASH_TEXT("Motion:"),
    .rows = teach_rows,
    .count = sizeof teach_rows / sizeof teach_rows[0],
};
