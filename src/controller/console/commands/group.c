/* group, pose: several servos, all at once. */
#include <string.h>

#include "cds55xx/sync_write.h" // cds_sync_write_begin()
#include "console/console.h"
#include "console/errors.h"
#include "console/handlers.h"
#include "console/messages.h"

/* 20 RPM, if nobody says how fast: gentle. */
#define POSE_SPEED 330

/* Is there room for those that are not known yet? All of them, or none, are taken in. */
static bool fit(struct robot *robot, const uint8_t *ids, uint8_t count)
{
    uint8_t room = (uint8_t)(ROBOT_SERVOS - robot->servos.count);

    for (; count; count--) {
        if (cds_servos_find(&robot->servos, *ids++))
            continue;
        if (room == 0)
            return false;
        room--;
    }
    return true;
}

uint8_t group_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    const uint8_t *ids = line->request->packet.bytes;
    struct robot *robot = console->robot;

    if (line->values == 0)
        return robot->group_count ? 0 : ERROR_NO_GROUP;
    if (robot->operation != ROBOT_IDLE)
        return ERROR_CYCLE;
    if (!fit(robot, ids, line->values))
        return ERROR_TOO_MANY;
    for (uint8_t i = 0; i < line->values; i++)
        robot_add(robot, ids[i]);
    memcpy(robot->group, ids, line->values);
    robot->group_count = line->values;
    robot->group_acts = line->choice == 2;
    return 0;
}

/* "group 1 2 3 sync", an ID at a time. */
bool group_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;

    if (*index == robot->group_count) {
        printer_line(&console->printer, robot->group_acts ? TEXT_BY_ACTION : TEXT_BY_SYNC);
        return false;
    }
    console->printer.values[0] = robot->group[*index];
    printer_text(&console->printer, *index ? TEXT_ONE_MORE : TEXT_GROUP);
    (*index)++;
    return true;
}

/* ---- pose ---- */

enum pose_phase { POSE_SYNC, POSE_ACTION, POSE_CYCLE } __attribute__((packed));

static uint16_t angle_of(const struct console *console, uint8_t index)
{
    const uint8_t *words = console->line.request->packet.bytes;

    return (uint16_t)(words[2 * index] | words[2 * index + 1] << 8);
}

/* The goals, out of the request's buffer, which the packet needs. */
static void keep_goals(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_goal *goal = robot->work.move.goals;

    for (uint8_t i = 0; i < robot->group_count; i++)
        *goal++ = (struct cds_goal){
            .id = robot->group[i], .position = angle_of(console, i), .speed = console->raw};
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

static uint8_t act(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_registered_move *move = &robot->work.move.move;
    uint8_t error = robot_claim(robot, ROBOT_MOVE);

    if (error)
        return error;
    console->phase = POSE_ACTION;
    return robot_begun(robot, cds_registered_move_begin(move, &(struct cds_registered_move_config){
                                                                  .bus = console->bus,
                                                                  .request = console->line.request,
                                                                  .goals = robot->work.move.goals,
                                                                  .count = robot->group_count,
                                                                  .verify = true}));
}

uint8_t pose_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint8_t error;

    console->raw = POSE_SPEED;
    error = line->numbers ? console_number(console, 0, CDS_UNIT_MRPM) : 0;
    if (error)
        return error;
    if (console->robot->group_count == 0)
        return ERROR_NO_GROUP;
    if (line->values != console->robot->group_count)
        return ERROR_GROUP_SIZE;
    if (console->robot->operation == ROBOT_CYCLE) {
        console->phase = POSE_CYCLE;
        return 0;
    }
    keep_goals(console);
    return console->robot->group_acts ? act(console) : sync(console);
}

/* Goals into the packet that the cycle sends next; it is busy with it for a period at most. */
static bool cycle_poll_goals(struct console *console)
{
    struct cds_cycle *cycle = &console->robot->work.cycle.cycle;
    uint8_t *index = &console->index;
    enum cds_result result = CDS_OK;

    if (console->robot->operation != ROBOT_CYCLE) {
        console->error = ERROR_NO_CYCLE;
        return false;
    }
    while (*index < console->robot->group_count) {
        result = cds_cycle_goal(cycle, *index, angle_of(console, *index), console->raw);
        if (result == CDS_BUSY)
            return true;
        if (console->error == 0)
            console->error = (uint8_t)result;
        (*index)++;
    }
    result = cds_cycle_commit(cycle);
    if (console->error == 0)
        console->error = (uint8_t)result;
    return false;
}

/* Those for which it failed: "servo 3: no reply by the deadline; ..." */
static bool action_poll(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t *index = &console->index;

    if (robot->operation == ROBOT_MOVE)
        return true;
    console->error = robot->result;
    while (console->error && *index < robot->group_count) {
        const struct cds_goal *goal = &robot->work.move.goals[(*index)++];

        if (goal->result == CDS_OK || goal->result == CDS_PENDING)
            continue;
        console->printer.values[0] = goal->id;
        console->printer.values[1] = goal->registered ? TEXT_ARMED : TEXT_NOTHING;
        console->printer.values[2] = error_text(goal->result);
        printer_line(&console->printer, TEXT_SERVO_FAILED);
        return true;
    }
    return false;
}

bool pose_poll(struct console *console)
{
    switch (console->phase) {
    case POSE_CYCLE: return cycle_poll_goals(console);
    case POSE_ACTION: return action_poll(console);
    default: return console_waits(console);
    }
}
