/* SPDX-License-Identifier: MIT */
/* What the console tells a person without a command: that a fault is over, or that the autostart
 * has not begun, and how it makes room
 * for such a line while a line is half typed or the table of `monitor` stands there:
 *
 *     servo 2 answers again; it may be driven
 *
 * Only in mode person. Chips with room for it link it (command_set.unasked). Main context. */
#ifndef CONTROLLER_UNASKED_H
#define CONTROLLER_UNASKED_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h"       // CDS_FLASH
#include "robot/robot.h" // ROBOT_SERVOS

struct console;

/* Zero it (static storage is). The fields are internal. */
struct unasked {
    uint32_t tick_us;           // time of the last tick
    uint16_t remedied;          // conditions (reply.h) whose remedy a person has just read: bits
    uint8_t remedied_ticks;     // ticks since then
    uint8_t away[ROBOT_SERVOS]; // of each servo: 0, or 1 since it was told as offline, and 1 more
                                // for each tick at which it is online again
    uint8_t line_ticks;         // 0, or 1 since a fault of the line was told, and so on
    bool stop_failed;           // torque is not read back as off at all servos
    bool stop_is_late;          // it is now
    bool autostart_told;        // that its sequence does not play
    bool is_looking;            // there may be something to tell since the last tick
};

/* A command begins: remedies may be printed again. */
void unasked_begin(void);

/* Returns the remedy for `condition` of a warning or an alarm, with "; " in front; "" if a person
 * has just read it. */
const CDS_FLASH char *unasked_remedy(const struct console *console, uint8_t condition);

/* Does the same for an alarm. The remedy of an instruction error is that of a checksum error if
 * noise has damaged the packet. `is_offline`: the alarm says that the servo is offline. */
const CDS_FLASH char *unasked_alarm_remedy(const struct console *console, uint8_t condition,
                                           bool is_offline);

/* The reply of a command prints error `number` with its remedy. */
void unasked_note_error(uint8_t number);

/* Entry `from` of the robot's list, the last one, has moved to entry `to`. */
void unasked_move_servo(uint8_t from, uint8_t to);

/* A fault of the line is printed: its end will be. */
void unasked_note_fault(void);

/* `stop` has printed that the torque of all servos is off. */
void unasked_note_stop(void);

/* Drops what the line about the return of a servo that was told as offline will tell: that it has
 * lost its state, or that it was offline more than once before. */
void unasked_silence(const struct console *console);

/* Prints a fault that is over. False: there is nothing to print. */
bool unasked_report(struct console *console);

/* True if a line may be printed above the line that is half typed. */
bool unasked_may_redraw(const struct console *console);

/* Makes room for a line: clears the line that is half typed, which comes again below it, or the
 * table of `monitor`. */
void unasked_make_room(struct console *console);

#endif
