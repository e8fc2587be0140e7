/* SPDX-License-Identifier: MIT */
/* Why a motion has failed, with step, pose, value and allowed range: "servo 1 is the cause in step
 * 3, pose far: 263.930deg is out of range: 100deg to 200deg"; how it has ended; and what the errors
 * of a motion name. Only for chips with room for it. */
#include <stddef.h>
#include <string.h> // memchr()

#include "cds55xx/diagnose.h" // CDS_FINDING_LINE_LOW
#include "console/advice.h"   // advice_pose_gone
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "console/mistake.h" // mistake_is_noise()
#include "console/reply.h"
#include "console/slips.h"      // slip_text()
#include "console/unasked.h"    // unasked_bus_noise()
#include "robot/angle_limits.h" // ANGLE_LIMITS_NO_JOINT
#include "robot/moves.h"
#include "robot/stored_group.h"

static const CDS_FLASH char message_is_the_cause[] = " is the cause";
static const CDS_FLASH char message_needs[] = " needs ";
static const CDS_FLASH char message_needs_ms[] = " ms";
static const CDS_FLASH char message_in[] = " in ";
static const CDS_FLASH char message_begins_in[] = "in ";
static const CDS_FLASH char message_step[] = "step ";
static const CDS_FLASH char message_pose[] = ", pose ";
static const CDS_FLASH char message_goal_range[] = ": %a is out of range: %a to %a";
static const CDS_FLASH char message_own_range[] =
    ": %a is out of range: %a to %a, CW_ANGLE_LIMIT to CCW_ANGLE_LIMIT of the servo";
static const CDS_FLASH char message_rests[] = ": it stands beyond its limits, %a to %a";
static const CDS_FLASH char message_no_speed[] = ": its speed limit is 0";
static const CDS_FLASH char message_deleted[] = ": the pose is deleted";
static const CDS_FLASH char message_under_way[] =
    "a motion is under way; 'motion off' ends it, 'motion wait' waits for it, 'motion at PERCENT' "
    "changes its speed";
static const CDS_FLASH char message_is_paused[] =
    "a motion is paused; 'resume' goes on with it, 'motion off' ends it; torque off always works";
static const CDS_FLASH char message_not_paused[] = "the motion is not paused; 'pause' stops it";
static const CDS_FLASH char message_was_ended[] =
    "the last motion did not reach its end: 'motion off' or 'cycle off' ended it";
static const CDS_FLASH char message_was_stopped[] =
    "the last motion was ended by a stop or a lost host link; driving is allowed again";
static const CDS_FLASH char message_wait_ended[] =
    "a key has ended the wait; the motion goes on, 'motion off' ends it";
static const CDS_FLASH char message_of_poses[] = "' chooses the servos of the stored poses";
static const CDS_FLASH char message_last_motion[] = "last motion: %s";
static const CDS_FLASH char message_begun[] = "has begun; no motion is under way, the last one: %s";
static const CDS_FLASH char message_went_well[] = "ended as it should";
static const CDS_FLASH char message_ended[] = "ended on its way by 'motion off' or 'cycle off'";
static const CDS_FLASH char message_end_by_stop[] =
    "ended on its way by a stop or a lost host link; 'status' shows both";
static const CDS_FLASH char message_end_by_link[] =
    "ended on its way, as the host link was lost; 'clear' when it is back";
static const CDS_FLASH char message_limited[] = ", at %u%: a servo can go no faster, so not at %u%";
static const CDS_FLASH char message_comes_to_rest[] = ", comes to rest";
static const CDS_FLASH char message_robot_silent[] =
    "no servo of the robot answers; check the supply and the cable: 'diagnose'";
static const CDS_FLASH char message_no_torque[] =
    "torque of servo %u is off; 'teach off %u' switches it on where the servo is, 'torque %u on' "
    "moves it to its goal";
static const CDS_FLASH char message_absent[] =
    "servo %u of the pose is not in the group; 'pose show NAME' prints the 'group' that the pose "
    "needs";
static const CDS_FLASH char message_give_time[] = "too fast for a servo; give it %lms or more";
static const CDS_FLASH char message_give_step_time[] =
    "too fast for a servo; 'sequence NAME set N POSE TIME' gives step N more time";
static const CDS_FLASH char message_give_tens[] =
    "%lms is not a multiple of 10 ms, nothing was stored; give %lms";
static const CDS_FLASH char message_reply_in_noise[] =
    "no good reply, and bytes without a packet came in this motion, as of noise or a loose plug; "
    "check plugs, power, ground: 'diagnose %i'";
static const CDS_FLASH char message_voltage[] =
    "warning: since 'clear' servo %u has reported a supply outside of MIN_VOLTAGE to MAX_VOLTAGE: "
    "'get %u PRESENT_VOLTAGE'";

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

/* The first servo of the pose at this place that is not in the group, or CDS_NO_ID. */
static uint8_t absent_servo(const struct console *console, uint8_t pose)
{
    const struct robot *robot = console->robot;
    uint16_t positions[MOTION_STORE_JOINTS];
    uint8_t ids[MOTION_STORE_JOINTS];
    uint8_t count = motion_store_read_joints(console_store(), ids);

    if (!motion_store_read_pose(console_store(), pose, positions))
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

/* If the servo did not answer and is known at another rate than the bus, prints ": not at the rate
 * of the bus: 'bus 1000000bps' first" and returns true. */
static bool print_rate(struct console *console, const struct motion_outcome *outcome)
{
    const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, outcome->id);
    struct printer *printer = &console->printer;

    if (outcome->result != CDS_TIMEOUT || !servo || !servo_is_at_other_rate(console, servo))
        return false;
    printer_flash(printer, message_colon);
    printer->values[0].number = servo->baud_reg;
    printer_line(printer, message_at_rate);
    return true;
}

static void print_cause_at(struct console *console, const struct motion_outcome *outcome,
                           const struct step_at *at)
{
    struct printer *printer = &console->printer;
    uint8_t id =
        outcome->result == MOTION_ABSENT ? absent_servo(console, pose_of_step(at)) : outcome->id;

    if (id == CDS_NO_ID)
        print_step_at(printer, at); // the step itself
    else
        reply_print_servo(printer, id);
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
    else if (!print_rate(console, outcome))
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

/* The text of the error with which a motion has ended, or of the fault of the line that is the
 * cause. */
static const CDS_FLASH char *text_of_error(const struct console *console, uint8_t error)
{
    if (mistake_is_noise(error))
        return mistake_noise_text(error);
    if (error == CDS_LIMIT)
        return message_not_within;
    if (error == ERROR_POSE_GONE)
        return advice_pose_gone;
    if ((error == CDS_TIMEOUT || error == CDS_CORRUPT) &&
        unasked_bus_noise(console) != command_set.ended_motion->noise_bytes)
        return message_reply_in_noise;
    if (error == CDS_TIMEOUT && command_set.ended_motion->concerns_all)
        return message_robot_silent;
    return error == CDS_LINE_BUSY && servos_line_is_low(&console->robot->servos)
               ? diagnose_findings[CDS_FINDING_LINE_LOW]
               : error_text(error);
}

static void keep_end(struct console *console)
{
    const struct motion_outcome *outcome = motion_outcome(console->robot);
    const struct failsafe *failsafe = console->failsafe;
    struct ended_motion *end = command_set.ended_motion;

    if (outcome->result == CDS_PENDING && end->is_kept)
        end->noise_bytes = unasked_bus_noise(console);
    if (outcome->result == CDS_PENDING)
        end->is_kept = false;
    if (outcome->result == CDS_PENDING || end->is_kept)
        return;
    end->is_kept = true;
    end->concerns_all = motion_concerns_all(console, outcome);
    end->is_by_link = failsafe->link_lost && failsafe->settings->link_loss_action;
    end->error = console_remedied(console, outcome->result);
    end->text = text_of_error(console, end->error);
}

/* How the last motion has ended, with its values in the printer from values[1] on. */
static const CDS_FLASH char *text_of_end(struct console *console)
{
    keep_end(console);
    switch (motion_outcome(console->robot)->result) {
    case CDS_OK: return message_went_well;
    case MOTION_NONE: return message_ended;
    case ROBOT_STOPPED:
        return command_set.ended_motion->is_by_link ? message_end_by_link : message_end_by_stop;
    default: return motion_failure(console, console->printer.values + 1);
    }
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
        reply_print_servo(printer, outcome->id);
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
    case AUTOSTART_BEGUN:
        if (robot_is_in_motion(console->robot))
            return false;
        printer->values[0].text = text_of_end(console);
        printer_line(printer, message_begun);
        return true;
    default: return false;
    }
}

/* ---- errors ---- */

/* No cycle runs without a group: reading the store may take its time. */
static bool has_poses(void)
{
    uint8_t ids[MOTION_STORE_JOINTS];

    return stored_may_read() == 0 && motion_store_read_servos(console_store(), ids);
}

static bool uses_servo(uint8_t id)
{
    uint8_t ids[MOTION_STORE_JOINTS];

    return stored_may_read() == 0 &&
           memchr(ids, id, motion_store_read_servos(console_store(), ids));
}

/* Ends the line "no group chosen; 'group 1 2 3' chooses the servos of the stored poses". */
static bool print_group(struct console *console, uint8_t index)
{
    struct printer *printer = &console->printer;
    uint8_t ids[MOTION_STORE_JOINTS];

    if (stored_may_read() == 0 && index < motion_store_read_servos(console_store(), ids)) {
        printer_char(printer, ' ');
        printer_decimal(printer, ids[index]);
        return true;
    }
    printer_line(printer, message_of_poses);
    return false;
}

/* True for `motion wait`, which takes its error from the end of the motion. */
static bool is_wait(const struct command_line *line)
{
    static const CDS_FLASH char motion[] = "motion";

    return parse_has_name(line->command->usage, motion) && line->choice == 1 && !line->numbers;
}

/* The servo without torque that keeps the motion from beginning. */
static const CDS_FLASH char *advise_torque(struct console *console)
{
    const struct motion_outcome *outcome = motion_outcome(console->robot);
    union printer_value *values = console->printer.values;

    if (outcome->result != MOTION_TORQUE_OFF || outcome->id > CDS_ID_MAX)
        return NULL;
    for (uint8_t i = 0; i < 3; i++)
        values[i].number = outcome->id;
    return message_no_torque;
}

/* A servo would have to move too fast; the line above tells the time that it needs. */
static const CDS_FLASH char *advise_time(struct console *console)
{
    const struct motion_outcome *outcome = motion_outcome(console->robot);
    const CDS_FLASH char *message = slip_text(console); // 2ms in place of 2s
    union printer_value *values = console->printer.values;

    if (message || outcome->result != MOTION_TOO_FAST)
        return message;
    if (outcome->step != MOTION_NO_STEP)
        return message_give_step_time;
    values[0].number = (uint16_t)outcome->shortest_ms;
    values[1].number = (uint16_t)(outcome->shortest_ms >> 16);
    return message_give_time;
}

/* No servo answers the command that begins a motion, or waits for its end. */
static const CDS_FLASH char *advise_timeout(const struct console *console)
{
    static const CDS_FLASH char play[] = "play", motion[] = "motion";
    const struct motion_outcome *outcome = motion_outcome(console->robot);
    const struct command_line *line = &console->line;

    return (parse_is_command(line, play) || parse_is_command(line, motion)) &&
                   outcome->result == CDS_TIMEOUT && motion_concerns_all(console, outcome)
               ? message_robot_silent
               : NULL;
}

/* `pose NAME in TIME`: the servo of the pose that is not in the group. */
static const CDS_FLASH char *advise_group(struct console *console)
{
    static const CDS_FLASH char pose[] = "pose";
    uint8_t id;

    if (!parse_is_command(&console->line, pose) || stored_may_read())
        return NULL;
    id = absent_servo(console, stored_find(console, MOTION_STORE_POSE, 0));
    console->printer.values[0].number = id;
    return id == CDS_NO_ID ? NULL : message_absent;
}

/* Finds the last time of the line that is no multiple of 10 ms, and advises the next multiple. */
static const CDS_FLASH char *advise_time_step(struct console *console)
{
    union printer_value *values = console->printer.values;
    uint8_t index = console->line.numbers;
    uint32_t ms = 0, step_ms;

    while (index && ms % 10 == 0)
        number_ms(&console->line.number[--index], CDS_MOTION_TIME_MAX_MS, &ms);
    step_ms = motion_store_round_up(ms);
    values[0].number = (uint16_t)ms;
    values[1].number = (uint16_t)(ms >> 16);
    values[2].number = (uint16_t)step_ms;
    values[3].number = (uint16_t)(step_ms >> 16);
    return message_give_tens;
}

static const CDS_FLASH char *advise(struct console *console)
{
    static const CDS_FLASH char play[] = "play";

    switch (console->error) {
    case CDS_LIMIT:
        return parse_is_command(&console->line, play) || is_wait(&console->line)
                   ? message_not_within
                   : NULL;
    case ERROR_TIME_STEP: return advise_time_step(console);
    case ERROR_TORQUE_OFF: return advise_torque(console);
    case ERROR_TOO_FAST: return advise_time(console);
    case ERROR_ABSENT: return advise_group(console);
    case CDS_TIMEOUT: return advise_timeout(console);
    case ERROR_MOTION:
        return motion_is_paused(console->robot) ? message_is_paused : message_under_way;
    case ERROR_NO_MOTION:
        if (is_wait(&console->line))
            return message_was_ended;
        return robot_is_in_motion(console->robot) ? message_not_paused : NULL;
    case ERROR_STOPPED:
        return is_wait(&console->line) && !robot_is_inhibited(console->robot) ? message_was_stopped
                                                                              : NULL;
    case ERROR_KEY: return is_wait(&console->line) ? message_wait_ended : NULL;
    default: return NULL;
    }
}

/* ---- motion, play, group ---- */

/* Called only if the motion has not failed: play.c prints the line of a failure. */
static void print_end(struct console *console)
{
    if (motion_outcome(console->robot)->result == CDS_OK)
        return;
    console->printer.values[0].text = text_of_end(console);
    printer_line(&console->printer, message_last_motion);
}

static const CDS_FLASH char *limit(struct console *console)
{
    const struct moves *moves = console->robot->moves;
    const struct cds_motion *motion = &moves->motion;

    if (motion->is_ending)
        return message_comes_to_rest;
    if (motion->override <= motion->plan.rate_most)
        return message_at_percent;
    console->printer.values[5].number = moves->percent;
    return message_limited;
}

static void warn(struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;

    for (uint8_t i = 0; i < servos->count; i++) {
        uint8_t id = servos->states[i].id;

        if (!(servos->states[i].alarms & CDS_ERROR_VOLTAGE) ||
            !memchr(console->robot->group, id, console->robot->group_count))
            continue;
        console->printer.values[0].number = console->printer.values[1].number = id;
        printer_line(&console->printer, message_voltage);
        return;
    }
}

static uint8_t choose(struct console *console)
{
    uint8_t error = console->robot->group_count ? 0 : stored_may_read();

    if (error == 0)
        error = stored_group_choose(console->robot, console_store());
    stored_group_keep(console->robot);
    return error;
}

const CDS_FLASH struct command_motion_words motion_words = {
    .cause = print_cause,
    .step = print_step,
    .autostart = print_autostart,
    .show_autostart = autostart_show_or_off_poll,
    .advise = advise,
    .end = print_end,
    .keep_end = keep_end,
    .limit = limit,
    .begin = fast_steps_begin,
    .tries_again = fast_steps_try_again,
    .warn = warn,
    .has_poses = has_poses,
    .uses_servo = uses_servo,
    .group = print_group,
    .choose = choose,
};
