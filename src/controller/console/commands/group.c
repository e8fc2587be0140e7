/* SPDX-License-Identifier: MIT */
/* group, pose: moves several servos at once. */
#include <string.h>

#include "cds55xx/sync_write.h" // cds_sync_write_begin()
#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/messages.h"
#include "robot/motion_start.h" // motion_check_group()
#include "robot/stored_group.h"

static const CDS_FLASH char message_by_action[] = " action";
static const CDS_FLASH char message_by_sync[] = " sync";
static const CDS_FLASH char message_one_more[] = " %u";
static const CDS_FLASH char message_group[] = "group %u";
static const CDS_FLASH char message_silent[] = "no answer now from servo %u";
static const CDS_FLASH char message_silent_remedy[] =
    ": 'ping %u'; if not there: 'servos forget %u', then 'group' without it";
static const CDS_FLASH char message_registered[] = ", may still be registered";
static const CDS_FLASH char message_without_torque[] =
    "torque of servo %u is off: it moves once torque is on";
static const CDS_FLASH char message_servos_without_torque[] =
    "servos without torque: %u, the first: %u; they move once torque is on";
static const CDS_FLASH char message_servo_failed[] = "servo %u%s: %s";

/* 20 RPM, the default speed. */
#define POSE_SPEED 330

static uint8_t group_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    struct robot *robot = console->robot;
    uint8_t error;

    if (line->values == 0)
        return robot->group_count ? 0 : ERROR_NO_GROUP;
    error = robot_choose_group(robot, line->request->packet.bytes, line->values);
    if (error == 0)
        robot->group_acts = line->choice == 2;
    if (command_set.moves) // else the linker drops it
        stored_group_keep(robot);
    return error;
}

/* True if the servo is in the list and does not answer. */
static bool is_silent(struct console *console, uint8_t id)
{
    const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, id);

    return servo && !servo_answers(servo);
}

/* Prints "no answer now from servo 4 5 6: ...", one ID in each call; nothing if all answer.
 * console->part counts the servos looked at, console->raw is the first silent ID and 1. */
static bool print_silent(struct console *console)
{
    const struct robot *robot = console->robot;
    union printer_value *values = console->printer.values;

    while (console->part < robot->group_count) {
        uint8_t id = robot->group[console->part++];

        if (!is_silent(console, id))
            continue;
        values[0].number = id;
        printer_text(&console->printer, console->raw ? message_one_more : message_silent);
        if (console->raw == 0)
            console->raw = id + 1u;
        return true;
    }
    values[0].number = values[1].number = (uint16_t)(console->raw - 1);
    if (console->raw)
        printer_line(&console->printer, message_silent_remedy);
    return false;
}

/* Prints "group 1 2 3 sync", one ID in each call; for a person then the servos that are not there.
 */
static bool group_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;

    if (command_set.has_room && *index > robot->group_count)
        return print_silent(console);
    if (*index == robot->group_count) {
        printer_line(&console->printer, robot->group_acts ? message_by_action : message_by_sync);
        if (!command_set.has_room)
            return false;
        (*index)++;
        console->raw = 0;
        return robot->unlisted != ROBOT_NOT_SCANNED && console_is_for_person(console);
    }
    console->printer.values[0].number = robot->group[*index];
    printer_text(&console->printer, *index ? message_one_more : message_group);
    (*index)++;
    return true;
}

/* ---- pose ---- */

enum pose_phase {
    POSE_SYNC,
    POSE_ACTION,
    POSE_CYCLE,
    POSE_WAIT, // the cycle of a motion is ending: it takes no goals
} __attribute__((packed));

uint16_t pose_angle(const struct console *console, uint8_t index)
{
    const uint8_t *words = console->line.request->packet.bytes;

    return (uint16_t)(words[2 * index] | words[2 * index + 1] << 8);
}

/* Copies the goals out of the request's buffer, which the packet needs. */
uint8_t pose_keep_goals(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_goal *goal = robot->work.move.goals;
    uint8_t error = robot_busy(robot);

    if (error)
        return error;
    for (uint8_t i = 0; i < robot->group_count; i++)
        *goal++ = (struct cds_goal){
            .id = robot->group[i], .position = pose_angle(console, i), .speed = console->raw};
    return 0;
}

static uint8_t sync(struct console *console)
{
    const struct robot *robot = console->robot;
    const struct cds_goal *goal = robot->work.move.goals;
    struct cds_request *request = console->line.request;

    cds_sync_write_begin(request, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t left = robot->group_count; left; left--, goal++)
        cds_sync_write_add_goal(request, goal->id, goal->position, goal->speed);
    return (uint8_t)cds_sync_write_send(console->bus, request);
}

static enum cds_result begin_move(struct robot *robot, const void *config)
{
    return cds_registered_move_begin(&robot->work.move.move, config);
}

static enum cds_result poll_move(struct robot *robot)
{
    return cds_registered_move_poll(&robot->work.move.move);
}

static const CDS_FLASH struct robot_operation registered_move = {.begin = begin_move,
                                                                 .poll = poll_move};

static uint8_t act(struct console *console)
{
    struct robot *robot = console->robot;

    console->phase = POSE_ACTION;
    return robot_start(robot, &registered_move,
                       &(struct cds_registered_move_config){.bus = console->bus,
                                                            .request = console->line.request,
                                                            .goals = robot->work.move.goals,
                                                            .count = robot->group_count,
                                                            .verify = true});
}

uint8_t pose_send(struct console *console)
{
    return console->robot->group_acts ? act(console) : sync(console);
}

/* The speed of the pose into console->raw, or its time into the struct move_job. Returns an error
 * or 0. */
static uint8_t take_number(struct console *console)
{
    console->raw = POSE_SPEED;
    switch (console->line.choice) {
    case POSE_AT: return console_number(console, 0, CDS_UNIT_MRPM);
    case POSE_IN: return console_move_ms(console, 0, &move_job(console)->ms);
    default: return 0;
    }
}

static uint8_t pose_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    struct robot *robot = console->robot;
    uint8_t error = take_number(console);

    if (error)
        return error;
    if (robot->group_count == 0)
        return ERROR_NO_GROUP;
    if (line->values != robot->group_count)
        return ERROR_GROUP_SIZE;
    // A timed move by a motion checks this itself, and names the servo.
    if (line->choice != POSE_IN || !command_set.moves)
        error = motion_check_group(robot);
    if (error)
        return error;
    if (line->choice == POSE_IN)
        return command_set.pose_in->begin(console);
    if (command_set.moves && motion_cycle_is_ending(robot)) {
        console->phase = POSE_WAIT;
        return 0;
    }
    if (robot->cycle && !robot_is_in_motion(robot)) {
        console->phase = POSE_CYCLE;
        return 0;
    }
    error = pose_keep_goals(console);
    return error ? error : pose_send(console);
}

/* Puts the goals into the next packet of the cycle, which is busy for one period at most. */
static bool cycle_poll_goals(struct console *console)
{
    struct cds_cycle *cycle = &console->robot->work.cycle.cycle;
    uint8_t *index = &console->index;
    enum cds_result result = CDS_OK;

    if (console->robot->cycle == NULL) {
        console->error = ERROR_NO_CYCLE;
        return false;
    }
    while (*index < console->robot->group_count) {
        result = cds_cycle_goal(cycle, *index, pose_angle(console, *index), console->raw);
        if (result == CDS_BUSY)
            return true;
        if (console->error == 0)
            console->error = (uint8_t)result;
        (*index)++;
    }
    cds_cycle_commit(cycle);
    return false;
}

/* Prints the servos that failed: "servo 3: no reply by the deadline; ..." */
static bool action_poll(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t *index = &console->index;

    if (robot->operation)
        return true;
    console->error = robot->result;
    while (console->error && *index < robot->group_count) {
        const struct cds_goal *goal = &robot->work.move.goals[(*index)++];

        if (goal->result == CDS_OK || goal->result == CDS_PENDING)
            continue;
        console->printer.values[0].number = goal->id;
        console->printer.values[1].text = goal->registered ? message_registered : message_nothing;
        console->printer.values[2].text = command_set.has_room && goal->result == CDS_LIMIT
                                              ? message_not_within
                                              : error_text(goal->result);
        printer_line(&console->printer, message_servo_failed);
        return true;
    }
    return false;
}

bool pose_sent_poll(struct console *console)
{
    return console->phase == POSE_ACTION ? action_poll(console) : console_waits(console);
}

/* True if torque of a servo of the group is off, as far as is known. */
static bool lacks_torque(const struct robot *robot)
{
    const struct cds_servo_state *servo = robot->states;

    for (uint8_t left = robot->servos.count; left; left--, servo++)
        if (!servo->torque && servo->presence == CDS_PRESENCE_ONLINE &&
            memchr(robot->group, servo->id, robot->group_count))
            return true;
    return false;
}

void servos_tell_torque(struct console *console, const uint8_t *ids, uint8_t count)
{
    const struct cds_servos *servos = &console->robot->servos;
    union printer_value *values = console->printer.values;
    uint8_t without = 0;

    for (uint8_t i = 0; i < servos->count; i++) {
        const struct cds_servo_state *servo = &servos->states[i];

        if (servo->torque || servo->presence != CDS_PRESENCE_ONLINE || servo->inhibits ||
            cds_servo_is_endless(servo) || (ids && !memchr(ids, servo->id, count)))
            continue;
        if (without++ == 0)
            values[0].number = values[1].number = servo->id;
    }
    if (without == 0)
        return;
    if (without > 1)
        values[0].number = without;
    printer_line(&console->printer,
                 without > 1 ? message_servos_without_torque : message_without_torque);
}

/* Sends the pose. A chip without room tells before it that a servo has no torque. */
static bool send_poll(struct console *console)
{
    if (command_set.explain && !command_set.has_room && console->part == 0) {
        console->part = 1; // the first poll
        if (lacks_torque(console->robot))
            printer_line(&console->printer, message_torque_is_off);
        return true;
    }
    if (console->line.choice == POSE_IN)
        return command_set.pose_in->poll(console);
    if (command_set.moves && console->phase == POSE_WAIT) {
        console->phase = POSE_SYNC;
        console->error = console->line.command->begin(console); // the group may have changed
        return console->error == 0;
    }
    return console->phase == POSE_CYCLE ? cycle_poll_goals(console) : pose_sent_poll(console);
}

static bool pose_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    bool goes_on = send_poll(console);

    /* 'pose in' without torque is refused: no hint. */
    if (command_set.has_room && !goes_on && !console->error && console->line.choice != POSE_IN)
        servos_tell_torque(console, robot->group, robot->group_count);
    return goes_on;
}

static const CDS_FLASH struct command group_rows[] = {
    {
        .usage = FLASH_TEXT("group [ID... [sync|action]]"),
        .what = FLASH_TEXT("servos of pose and cycle"),
        .details = COMMAND_DETAILS(
            "sync (default): one SYNC WRITE, no replies. action: REG WRITE to each, one "
            "ACTION; if a servo fails, none starts"),
        .example = COMMAND_DETAILS("group 1 2 3 action"),
        .begin = group_begin,
        .poll = group_poll,
    },
    {
        .usage = FLASH_TEXT("pose ANGLE... [at|in SPEED|TIME]"),
        .what = FLASH_TEXT("move the group"),
        .details =
            COMMAND_DETAILS("An angle for each servo of the group, 0 to 300deg. SPEED: 0 to 62rpm, "
                            "0 the fastest, default 20rpm. In TIME, 1ms to 600s: all arrive "
                            "together. A cycle takes over the goals"),
        .example = COMMAND_DETAILS("pose 90 150.5 210 at 20rpm"),
        .begin = pose_begin,
        .poll = pose_poll,
    },
};

const CDS_FLASH struct command_group group_commands = {
    .heading = FLASH_TEXT("Many servos:"),
    .rows = group_rows,
    .count = sizeof group_rows / sizeof group_rows[0],
};
