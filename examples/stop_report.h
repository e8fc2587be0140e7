/* SPDX-License-Identifier: MIT */
/* Tells on the host USART of the board why a robot has stopped, as in
 *
 *     servo 2 (joint 1, elbow): offline
 *     step 2: servo 1 (joint 0, base): too fast, it needs 1282 ms
 *
 * Joints and steps count from 0, as in their tables. stop_report_note() is the program's on_event,
 * or is called from it. Call stop_report_poll() in the main loop, also after the robot has stopped.
 * It never waits, and begins when torque off has left, or could not be sent for 20 ms and 20 turns
 * of the main loop. On a board without a host USART it tells nothing. */
#ifndef STOP_REPORT_H
#define STOP_REPORT_H

#include <avr/io.h>
#include <avr/pgmspace.h>
#include <cds55xx/avr.h>
#include <cds55xx/motion.h>
#include <cds55xx/robot.h>
#include <stdlib.h>
#include <string.h>

#define STOP_REPORT_NO_STEP  255
#define STOP_REPORT_NO_JOINT 255
// Torque off counts as stuck after both: this time, and so many turns of the main loop.
#define STOP_REPORT_UNSENT_US    20000
#define STOP_REPORT_UNSENT_TURNS 20

/* What is known of a stop, and the text about it. */
static struct {
    struct cds_robot_event event; // the first that stops the robot; CDS_ROBOT_EVENT_STARTED: none
    bool has_cause;               // a move; step, joint, is_beyond, mdeg and why tell it
    uint8_t step;                 // of the sequence, or STOP_REPORT_NO_STEP
    uint8_t joint;                // or STOP_REPORT_NO_JOINT
    bool is_beyond;               // the goal is beyond the limits of the joint
    int32_t mdeg;                 // that goal
    bool is_made;                 // the text is complete
    uint32_t ran_us;              // when the robot was running last
    uint8_t turns;                // of the main loop since then
#ifdef BOARD_HOST_USART
    char why[CDS_RESULT_TEXT_SIZE]; // in words, unless is_beyond
    uint8_t size, sent;             // of the text
    char text[160];
#endif
} stop_report;

static inline void stop_report_note(struct cds_robot *robot)
{
    bool is_tolerated = robot->tolerates & 1u << robot->event.kind;

    if (stop_report.event.kind == CDS_ROBOT_EVENT_STARTED && !is_tolerated &&
        robot->event.kind != CDS_ROBOT_EVENT_STOPPED)
        stop_report.event = robot->event;
}

/* Stores the first cause. False: there is one already. */
static inline bool stop_report_note_cause(uint8_t step, uint8_t joint)
{
    if (stop_report.has_cause)
        return false;
    stop_report.has_cause = true;
    stop_report.step = step;
    stop_report.joint = joint;
    return true;
}

/* Stops the robot: a move was refused, or has ended early, as `result`. `step`: of a sequence, or
 * STOP_REPORT_NO_STEP. */
static inline void stop_report_refused(struct cds_robot *robot, uint8_t result, uint8_t step,
                                       const struct cds_motion *motion)
{
    bool has_joint = result != CDS_BAD_ARGUMENT; // CDS_BAD_ARGUMENT concerns the whole move

    if (stop_report_note_cause(step, has_joint ? motion->joint : STOP_REPORT_NO_JOINT)) {
#ifdef BOARD_HOST_USART
        cds_motion_text(motion, result, stop_report.why, sizeof stop_report.why);
#endif
    }
    cds_robot_stop(robot);
}

/* Stops the robot: the goal `mdeg` is beyond the limits of `joint`. */
static inline void stop_report_beyond(struct cds_robot *robot, uint8_t step, uint8_t joint,
                                      int32_t mdeg)
{
    if (stop_report_note_cause(step, joint)) {
        stop_report.mdeg = mdeg;
        stop_report.is_beyond = true;
    }
    cds_robot_stop(robot);
}

/* Stops the robot: `joint` does not follow its goals (follow.h). */
static inline void stop_report_not_following(struct cds_robot *robot, uint8_t step, uint8_t joint)
{
    if (stop_report_note_cause(step, joint)) {
#ifdef BOARD_HOST_USART
        strcpy_P(stop_report.why, PSTR("does not follow its goals: blocked or pushed away"));
#endif
    }
    cds_robot_stop(robot);
}

#ifdef BOARD_HOST_USART
#define STOP_REPORT_REGISTER(a, b) CDS_AVR_PASTE3(a, BOARD_HOST_USART, b)

static inline void stop_report_open(void)
{
    STOP_REPORT_REGISTER(UCSR, A) = 1 << 1; // U2X
    STOP_REPORT_REGISTER(UBRR, L) = (F_CPU + 4ul * BOARD_HOST_BAUD) / (8ul * BOARD_HOST_BAUD) - 1;
    STOP_REPORT_REGISTER(UCSR, B) |= 1 << 3; // TXEN
}

/* Sends the next character if the USART has room for it. */
static inline void stop_report_send(void)
{
    if (STOP_REPORT_REGISTER(UCSR, A) & 1 << 5) // UDRE
        CDS_AVR_PASTE(UDR, BOARD_HOST_USART) = (uint8_t)stop_report.text[stop_report.sent++];
}

/* ---- the text ---- */

static inline void stop_report_text(const char *text)
{
    while (*text && stop_report.size < sizeof stop_report.text)
        stop_report.text[stop_report.size++] = *text++;
}

static inline void stop_report_flash(const char *text)
{
    char copy[80];

    strncpy_P(copy, text, sizeof copy - 1);
    copy[sizeof copy - 1] = 0;
    stop_report_text(copy);
}

static inline void stop_report_number(int32_t number)
{
    char digits[12];

    stop_report_text(ltoa(number, digits, 10));
}

/* As in -90 or 90.500. */
static inline void stop_report_degrees(int32_t mdeg)
{
    char digits[12];

    if (mdeg < 0)
        stop_report_flash(PSTR("-"));
    stop_report_number(labs(mdeg) / 1000);
    if (mdeg % 1000) {
        ltoa(1000 + labs(mdeg) % 1000, digits, 10);
        digits[0] = '.';
        stop_report_text(digits);
    }
}

/* "servo 3 (joint 2, wrist): " */
static inline void stop_report_joint(const struct cds_robot *robot, uint8_t joint)
{
    struct cds_joint row;

    if (cds_robot_joint(robot, joint, &row) != CDS_OK)
        return;
    stop_report_flash(PSTR("servo "));
    stop_report_number(row.id);
    stop_report_flash(PSTR(" (joint "));
    stop_report_number(joint);
    if (*row.name)
        stop_report_flash(PSTR(", "));
    stop_report_text(row.name);
    stop_report_flash(PSTR("): "));
}

/* Of CDS_ROBOT_EVENT_START_FAILED: enum cds_reason. */
static inline void stop_report_reason(uint8_t why)
{
    static const char reasons[][24] PROGMEM = {
        [CDS_REASON_NO_REPLY] = "no reply",
        [CDS_REASON_ALARM] = "alarm",
        [CDS_REASON_RETURN_DELAY] = "return delay not taken",
        [CDS_REASON_MODE] = "endless turn",
        [CDS_REASON_VOLTAGE] = "supply voltage",
        [CDS_REASON_POSITION] = "beyond its limits",
        [CDS_REASON_REFUSED] = "goal or torque refused",
        [CDS_REASON_INHIBITED] = "inhibited",
    };

    stop_report_flash(reasons[why]);
}

/* " (of its replies 3 were missing, 45 damaged)", if one was damaged */
static inline void stop_report_replies(const struct cds_robot *robot, uint8_t joint)
{
    const struct cds_servo_counters *counters = &robot->servos.states[joint].counters;

    if (counters->corrupt == 0)
        return;
    stop_report_flash(PSTR(" (of its replies "));
    stop_report_number(counters->timeouts);
    stop_report_flash(PSTR(" were missing, "));
    stop_report_number(counters->corrupt);
    stop_report_flash(PSTR(" damaged)"));
}

/* ": overload" */
static inline void stop_report_alarms(uint8_t alarms)
{
    if (alarms & CDS_ERROR_VOLTAGE)
        stop_report_flash(PSTR(": input voltage"));
    if (alarms & CDS_ERROR_OVERHEATING)
        stop_report_flash(PSTR(": overheating"));
    if (alarms & CDS_ERROR_OVERLOAD)
        stop_report_flash(PSTR(": overload"));
}

static inline void stop_report_event(const struct cds_robot *robot)
{
    const struct cds_robot_event *event = &stop_report.event;

    if (event->kind == CDS_ROBOT_EVENT_LINE_BUSY || event->result == CDS_LINE_BUSY) {
        stop_report_flash(PSTR("line low or disturbed"));
        return;
    }
    stop_report_joint(robot, event->joint);
    switch (event->kind) {
    case CDS_ROBOT_EVENT_START_FAILED:
        stop_report_reason(event->why);
        if (event->result == CDS_CORRUPT)
            stop_report_flash(PSTR(": replies damaged (noise, or two servos with this ID)"));
        break;
    case CDS_ROBOT_EVENT_ALARM: stop_report_flash(PSTR("alarm")); break;
    case CDS_ROBOT_EVENT_OFFLINE:
        stop_report_flash(PSTR("offline"));
        stop_report_replies(robot, event->joint);
        break;
    case CDS_ROBOT_EVENT_FEEDBACK_OLD:
        stop_report_flash(PSTR("feedback too old, the main loop is too slow"));
        break;
    default: stop_report_flash(PSTR("lost its state")); break;
    }
    stop_report_alarms(event->alarms);
}

static inline void stop_report_goal(const struct cds_robot *robot)
{
    struct cds_joint row;

    stop_report_degrees(stop_report.mdeg);
    cds_robot_joint(robot, stop_report.joint, &row);
    stop_report_flash(PSTR(" degrees, its limits are "));
    stop_report_degrees(row.lowest_mdeg);
    stop_report_flash(PSTR(" and "));
    stop_report_degrees(row.highest_mdeg);
}

static inline void stop_report_move(const struct cds_robot *robot)
{
    if (stop_report.step == STOP_REPORT_NO_STEP) {
        stop_report_flash(PSTR("motion: "));
    } else {
        stop_report_flash(PSTR("step "));
        stop_report_number(stop_report.step);
        stop_report_flash(PSTR(": "));
    }
    stop_report_joint(robot, stop_report.joint); // nothing if there is none
    if (stop_report.is_beyond)
        stop_report_goal(robot);
    else
        stop_report_text(stop_report.why);
}

/* The robot was not opened, or not started: the arguments were refused, and there was no event. */
static inline void stop_report_arguments(const struct cds_robot *robot)
{
    if (robot->count) {
        stop_report_flash(PSTR("not started: argument out of range"));
        return;
    }
    stop_report_flash(PSTR("joint "));
    stop_report_number(robot->event.joint);
    stop_report_flash(PSTR(" of the table: its ID stands twice, or a value is out of range"));
}

/* True if torque off cannot leave: the line is low or never quiet. A slow main loop alone delays
 * it, so turns of the loop count, too. */
static inline bool stop_report_is_stuck(const struct cds_robot *robot)
{
    return robot->torque_off.broadcasts == 0 && stop_report.turns >= STOP_REPORT_UNSENT_TURNS &&
           cds_port_now_us() - stop_report.ran_us > STOP_REPORT_UNSENT_US;
}

static inline void stop_report_make(const struct cds_robot *robot)
{
    bool is_asked = robot->state == CDS_ROBOT_STOPPING ||
                    robot->event.kind == CDS_ROBOT_EVENT_STOPPED; // by cds_robot_stop()

    if (!is_asked)
        stop_report_arguments(robot);
    else if (stop_report.event.kind != CDS_ROBOT_EVENT_STARTED)
        stop_report_event(robot);
    else if (stop_report.has_cause)
        stop_report_move(robot);
    else
        stop_report_flash(PSTR("stopped by the program"));
    if (is_asked && stop_report_is_stuck(robot))
        stop_report_flash(PSTR("; torque off cannot be sent, switch the power off"));
    stop_report_flash(PSTR("\n"));
}

/* True if torque off does not need this poll: it has left, or cannot leave. */
static inline bool stop_report_may_begin(const struct cds_robot *robot)
{
    return robot->state == CDS_ROBOT_STOPPED ||
           robot->torque_off.broadcasts >= CDS_TORQUE_OFF_BROADCASTS || stop_report_is_stuck(robot);
}

static inline void stop_report_poll(const struct cds_robot *robot)
{
    if (robot->state < CDS_ROBOT_STOPPING) {
        if (stop_report.is_made) // the robot was started again
            memset(&stop_report, 0, sizeof stop_report);
        stop_report.ran_us = cds_port_now_us();
        stop_report.turns = 0;
    } else if (stop_report.is_made) {
        if (stop_report.sent < stop_report.size)
            stop_report_send();
    } else if (stop_report_may_begin(robot)) {
        stop_report_make(robot);
        stop_report_open();
        stop_report.is_made = true;
    } else if (stop_report.turns < STOP_REPORT_UNSENT_TURNS) {
        stop_report.turns++;
    }
}
#else
static inline void stop_report_poll(const struct cds_robot *robot)
{
    (void)robot;
}
#endif

#endif
