/* SPDX-License-Identifier: MIT */
/* Why a motion has failed, with step, pose, value and allowed range: "servo 1 is the cause in step
 * 3, pose far: 263.930deg is out of range: 100deg to 200deg". Only for chips with room for it. */
#include <stddef.h>
#include <string.h>

#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/messages.h"
#include "robot/angle_limits.h" // ANGLE_LIMITS_NO_JOINT
#include "robot/moves.h"

static const CDS_FLASH char message_is_the_cause[] = " is the cause";
static const CDS_FLASH char message_needs[] = " needs ";
static const CDS_FLASH char message_needs_ms[] = " ms";
static const CDS_FLASH char message_in[] = " in ";
static const CDS_FLASH char message_begins_in[] = "in ";
static const CDS_FLASH char message_step[] = "step ";
static const CDS_FLASH char message_pose[] = ", pose ";
static const CDS_FLASH char message_colon[] = ": ";
static const CDS_FLASH char message_goal_range[] = ": %a is out of range: %a to %a";
static const CDS_FLASH char message_own_range[] =
    ": %a is out of range: %a to %a, CW_ANGLE_LIMIT to CCW_ANGLE_LIMIT of the servo";
static const CDS_FLASH char message_rests[] = ": it stands beyond its limits, %a to %a";
static const CDS_FLASH char message_no_speed[] = ": its speed limit is 0";
static const CDS_FLASH char message_deleted[] = ": the pose is deleted";

/* A step of a stored sequence. */
struct step_at {
    uint8_t place;
    uint8_t step;  // MOTION_NO_STEP: of no sequence
    uint8_t saves; // store->saves, modulo 256, when `place` was valid
};

/* The pose of the step. MOTION_STORE_NONE: it is not known, or what is stored has changed. */
static uint8_t pose_of_step(const struct step_at *at)
{
    const struct motion_store *store = console_store();
    struct motion_store_step step;

    if (at->step == MOTION_NO_STEP || at->saves != (uint8_t)store->saves ||
        !motion_store_read_step(store, at->place, at->step, &step))
        return MOTION_STORE_NONE;
    return motion_store_pose_of(store, step.pose);
}

/* Prints "step 3, pose far". */
static void print_step_at(struct printer *printer, const struct step_at *at)
{
    char name[MOTION_STORE_NAME + 1];

    printer_flash(printer, message_step);
    printer_decimal(printer, (uint16_t)(at->step + 1));
    if (!motion_store_read_name(console_store(), MOTION_STORE_POSE, pose_of_step(at), name))
        return;
    printer_flash(printer, message_pose);
    printer_string(printer, name);
}

static struct step_at step_of_outcome(const struct console *console,
                                      const struct motion_outcome *outcome)
{
    const struct moves *moves = console->robot->moves;

    return (struct step_at){
        .place = moves->start.place, .step = outcome->step, .saves = moves->noted_saves};
}

/* The goal of a servo in the move that has failed; CDS_POSE_NONE: it is not known. */
static uint16_t goal_of(const struct console *console, const struct step_at *at, uint8_t id)
{
    const struct robot *robot = console->robot;
    const uint8_t *joint = memchr(robot->group, id, robot->group_count);
    uint16_t positions[MOTION_STORE_JOINTS];
    uint8_t ids[MOTION_STORE_JOINTS];
    uint8_t count;

    if (at->step == MOTION_NO_STEP)
        return joint ? robot->moves->player.poses[joint - robot->group] : CDS_POSE_NONE;
    count = motion_store_read_joints(console_store(), ids);
    joint = memchr(ids, id, count);
    return joint && motion_store_read_pose(console_store(), pose_of_step(at), positions)
               ? positions[joint - ids]
               : CDS_POSE_NONE;
}

/* The first servo of the pose that is not in the group, or CDS_NO_ID. */
static uint8_t absent_servo(const struct console *console, const struct step_at *at)
{
    const struct robot *robot = console->robot;
    uint16_t positions[MOTION_STORE_JOINTS];
    uint8_t ids[MOTION_STORE_JOINTS];
    uint8_t count = motion_store_read_joints(console_store(), ids);

    if (!motion_store_read_pose(console_store(), pose_of_step(at), positions))
        return CDS_NO_ID;
    for (uint8_t i = 0; i < count; i++)
        if (positions[i] != CDS_POSE_NONE && !memchr(robot->group, ids[i], robot->group_count))
            return ids[i];
    return CDS_NO_ID;
}

/* Ends the line: why a goal is not within the limits of its servo: those that the servo keeps
 * itself, or the soft limits. */
static void print_limits(struct console *console, const struct step_at *at, uint8_t id)
{
    const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, id);
    struct printer *printer = &console->printer;
    union printer_value *values = printer->values;
    const struct motion_start *start = &console->robot->moves->start;
    uint16_t goal = goal_of(console, at, id);

    if (start->beyond != ANGLE_LIMITS_NO_JOINT) {
        values[0].number = start->beyond_goal;
        values[1].number = start->limits[start->beyond].lowest;
        values[2].number = start->limits[start->beyond].highest;
        printer_line(printer, message_own_range);
        return;
    }
    if (servo == NULL || goal == CDS_POSE_NONE) {
        printer_end_of_line(printer);
        return;
    }
    if (servo->fastest == 0) {
        printer_line(printer, message_no_speed);
        return;
    }
    values[0].number = goal;
    if (goal < servo->lowest || goal > servo->highest)
        values++;
    values[0].number = servo->lowest;
    values[1].number = servo->highest;
    printer_line(printer, values == printer->values ? message_rests : message_goal_range);
}

static void print_servo(struct printer *printer, uint8_t id)
{
    printer_flash(printer, message_servo_label);
    printer_decimal(printer, id);
}

static void print_cause_at(struct console *console, const struct motion_outcome *outcome,
                           const struct step_at *at)
{
    struct printer *printer = &console->printer;
    uint8_t id = outcome->result == MOTION_ABSENT ? absent_servo(console, at) : outcome->id;

    if (id == CDS_NO_ID)
        print_step_at(printer, at); // the step itself
    else
        print_servo(printer, id);
    if (outcome->result == MOTION_TOO_FAST) {
        printer_flash(printer, message_needs);
        printer_fixed(printer, (int32_t)outcome->shortest_ms, 0);
        printer_flash(printer, message_needs_ms);
    } else {
        printer_flash(printer, message_is_the_cause);
    }
    if (id != CDS_NO_ID && at->step != MOTION_NO_STEP) {
        printer_flash(printer, message_in);
        print_step_at(printer, at);
    }
    if (outcome->result == CDS_LIMIT)
        print_limits(console, at, id);
    else
        printer_end_of_line(printer);
}

static void print_cause(struct console *console, const struct motion_outcome *outcome)
{
    struct step_at at = step_of_outcome(console, outcome);

    print_cause_at(console, outcome, &at);
}

static void print_step(struct console *console, const struct motion_outcome *outcome)
{
    struct step_at at = step_of_outcome(console, outcome);

    if (at.step == MOTION_NO_STEP)
        return;
    printer_flash(&console->printer, message_begins_in);
    print_step_at(&console->printer, &at);
    printer_flash(&console->printer, message_colon);
}

static bool print_autostart(struct console *console)
{
    const struct autostart *autostart = &console->robot->moves->autostart;
    const struct motion_outcome *outcome = &autostart->outcome;
    struct printer *printer = &console->printer;
    struct step_at at = {
        .place = autostart->place, .step = outcome->step, .saves = autostart->saves};

    switch (autostart->state) {
    case AUTOSTART_LIMITS:
        print_servo(printer, outcome->id);
        printer_flash(printer, message_in);
        print_step_at(printer, &at);
        printer->values[0].number = goal_of(console, &at, outcome->id);
        printer->values[1].number = autostart->lowest;
        printer->values[2].number = autostart->highest;
        printer_line(printer, message_goal_range);
        return true;
    case AUTOSTART_POSE_GONE:
        print_step_at(printer, &at);
        printer_line(printer, message_deleted);
        return true;
    case AUTOSTART_REFUSED:
        if (outcome->result != MOTION_TOO_FAST)
            return false;
        print_cause_at(console, outcome, &at);
        return true;
    default: return false;
    }
}

const CDS_FLASH struct command_motion_words motion_words = {
    .cause = print_cause, .step = print_step, .autostart = print_autostart};
