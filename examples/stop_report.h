/* SPDX-License-Identifier: MIT */
/* Tells on the host USART of the board why a robot has stopped:
 *
 *     joint 2, elbow: offline
 *
 * or, if the program has stopped it because a move was refused or has ended early,
 *
 *     motion: joint 1, base: the limits of the servo do not permit this, it needs 1282 ms
 *     step 2: joint 1, base: the limits of the servo do not permit this, it needs 1282 ms
 *
 * stop_report_note() is the program's on_event, or is called from it. Call stop_report() when the
 * main loop has ended: it waits for each character. On a board without a host USART it tells
 * nothing. */
#ifndef STOP_REPORT_H
#define STOP_REPORT_H

#include <avr/io.h>
#include <avr/pgmspace.h>
#include <cds55xx/avr.h>
#include <cds55xx/motion.h>
#include <cds55xx/robot.h>
#include <stdlib.h>

/* The first event that stops the robot; kind CDS_ROBOT_EVENT_STARTED: there was none. */
static struct cds_robot_event stop_report_event;

static inline void stop_report_note(struct cds_robot *robot)
{
    bool is_tolerated = robot->tolerates & 1u << robot->event.kind;

    if (stop_report_event.kind == CDS_ROBOT_EVENT_STARTED && !is_tolerated &&
        robot->event.kind != CDS_ROBOT_EVENT_STOPPED)
        stop_report_event = robot->event;
}

#define STOP_REPORT_NO_JOINT 255

/* Why the program has stopped the robot; result CDS_OK: it has not. */
static struct {
    uint8_t result; // enum cds_result
    uint8_t step;   // of a sequence
    uint8_t joint;  // or STOP_REPORT_NO_JOINT
} stop_report_refusal;

/* Stops the robot: `joint` of a sequence was refused in `step`, or has ended it there. The first
 * call counts. */
static inline void stop_report_refused(struct cds_robot *robot, uint8_t step, uint8_t joint,
                                       uint8_t result)
{
    if (stop_report_refusal.result == CDS_OK) {
        stop_report_refusal.result = result;
        stop_report_refusal.step = step;
        stop_report_refusal.joint = joint;
    }
    cds_robot_stop(robot);
}

#ifdef BOARD_HOST_USART
#define STOP_REPORT_REGISTER(a, b) CDS_AVR_PASTE3(a, BOARD_HOST_USART, b)

static inline void stop_report_open(void)
{
    STOP_REPORT_REGISTER(UCSR, A) = 1 << 1; // U2X
    STOP_REPORT_REGISTER(UBRR, L) = (F_CPU + 4ul * BOARD_HOST_BAUD) / (8ul * BOARD_HOST_BAUD) - 1;
    STOP_REPORT_REGISTER(UCSR, B) = 1 << 3; // TXEN
}

static inline void stop_report_char(char c)
{
    while (!(STOP_REPORT_REGISTER(UCSR, A) & 1 << 5)) { // UDRE
    }
    CDS_AVR_PASTE(UDR, BOARD_HOST_USART) = (uint8_t)c;
}
#else
static inline void stop_report_open(void)
{
}

static inline void stop_report_char(char c)
{
    (void)c;
}
#endif

static inline void stop_report_text(const char *text)
{
    while (*text)
        stop_report_char(*text++);
}

static inline void stop_report_flash(const char *text)
{
    for (char c; (c = (char)pgm_read_byte(text)); text++)
        stop_report_char(c);
}

static inline void stop_report_number(uint32_t number)
{
    char digits[11];

    stop_report_text(ultoa(number, digits, 10));
}

/* "joint 2, elbow: " */
static inline void stop_report_joint(const struct cds_robot *robot, uint8_t joint)
{
    struct cds_joint row;

    if (cds_robot_joint(robot, joint, &row) != CDS_OK)
        return;
    stop_report_flash(PSTR("joint "));
    stop_report_number(joint);
    stop_report_flash(PSTR(", "));
    stop_report_text(row.name);
    stop_report_flash(PSTR(": "));
}

static inline void stop_report_result(uint8_t result)
{
    char text[CDS_RESULT_TEXT_SIZE];

    cds_result_text(result, text, sizeof text);
    stop_report_text(text);
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

static inline void stop_report_robot(const struct cds_robot *robot)
{
    const struct cds_robot_event *event = &stop_report_event;

    if (event->kind == CDS_ROBOT_EVENT_LINE_BUSY) {
        stop_report_flash(PSTR("line low or disturbed\n"));
        return;
    }
    stop_report_joint(robot, event->joint);
    switch (event->kind) {
    case CDS_ROBOT_EVENT_START_FAILED: stop_report_reason(event->why); break;
    case CDS_ROBOT_EVENT_ALARM: stop_report_flash(PSTR("alarm")); break;
    case CDS_ROBOT_EVENT_OFFLINE: stop_report_flash(PSTR("offline")); break;
    default: stop_report_flash(PSTR("lost its state")); break;
    }
    if (event->alarms) {
        stop_report_flash(PSTR(", error bits "));
        stop_report_number(event->alarms);
    }
    stop_report_char('\n');
}

/* "joint 2, elbow: no reply by the deadline" */
static inline void stop_report_reply(const struct cds_robot *robot, const struct cds_motion *motion,
                                     uint8_t joint, uint8_t result)
{
    stop_report_joint(robot, joint);
    stop_report_result(result);
    if (result == CDS_LIMIT && motion->move_result == CDS_LIMIT && motion->shortest_ms) {
        stop_report_flash(PSTR(", it needs "));
        stop_report_number(motion->shortest_ms);
        stop_report_flash(PSTR(" ms"));
    }
    stop_report_char('\n');
}

static inline void stop_report_motion(const struct cds_robot *robot,
                                      const struct cds_motion *motion)
{
    uint8_t result = motion->move_result > CDS_PENDING ? motion->move_result : motion->result;

    if (stop_report_refusal.result != CDS_OK) {
        stop_report_flash(PSTR("step "));
        stop_report_number(stop_report_refusal.step);
        stop_report_flash(PSTR(": "));
        stop_report_reply(robot, motion, stop_report_refusal.joint, stop_report_refusal.result);
    } else if (result > CDS_PENDING) {
        stop_report_flash(PSTR("motion: "));
        stop_report_reply(robot, motion, motion->joint, result);
    }
}

/* The robot was not opened, or not started: the arguments were refused, and there was no event. */
static inline void stop_report_arguments(const struct cds_robot *robot)
{
    if (robot->count) {
        stop_report_flash(PSTR("not started: argument out of range\n"));
        return;
    }
    stop_report_flash(PSTR("joint "));
    stop_report_number(robot->event.joint);
    stop_report_flash(PSTR(" of the table, or an ID: out of range\n"));
}

/* `motion`: NULL if the program has none. */
static inline void stop_report(const struct cds_robot *robot, const struct cds_motion *motion)
{
    stop_report_open();
    if (robot->event.kind != CDS_ROBOT_EVENT_STOPPED)
        stop_report_arguments(robot);
    else if (stop_report_event.kind != CDS_ROBOT_EVENT_STARTED)
        stop_report_robot(robot);
    else if (motion)
        stop_report_motion(robot, motion);
}

#endif
