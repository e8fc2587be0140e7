/* SPDX-License-Identifier: MIT */
/* What the console tells a person without a command: that a fault is over, or that the autostart
 * has not begun. It also knows which latched alarms last. It makes room for such a line while a
 * line is half typed or the table of `monitor` stands there:
 *
 *     servo 2 answers again, torque on; it may be driven
 *
 * Only in mode person. Chips with room for it link it (command_set.unasked). Main context. */
#ifndef CONTROLLER_UNASKED_H
#define CONTROLLER_UNASKED_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h"       // CDS_FLASH
#include "robot/robot.h" // ROBOT_SERVOS

struct console;

/* Of one servo: sets of conditions, CDS_ERRORS_OF_CONDITION. `seen` and `lasts` have a bit more:
 * the servo has replied. */
struct unasked_alarms {
    uint8_t told;  // alarms that were told and have not ended
    uint8_t ended; // told alarms that have ended; their end is to be told
    uint8_t seen;  // conditions in replies to the state check since the window began
    uint8_t lasts; // `seen` at the end of the last window
    uint8_t damaged, stale, timeouts; // counters, modulo 256, when the servo last answered well:
                                      // damaged replies, late ones, and transactions without one
    uint8_t silenced;      // refusals that were not told, as a told fault of the line lasted
    bool may_share_id : 1; // its replies came damaged before it was told as offline, so two servos
                           // may have its ID
    bool was_offline : 1;  // it was told as offline since the last `clear`
    bool was_lost : 1;     // its lost torque was told since the last `clear`
    uint8_t mode : 2;      // enum servo_mode, as it was last known
};

/* The mode of a servo. A loss of power clears the state of the servo in the list, but the servo
 * keeps its angle limits. */
enum servo_mode { UNASKED_UNKNOWN, UNASKED_POSITION, UNASKED_TURN } __attribute__((packed));

/* Zero it (static storage is). The fields are internal. */
struct unasked {
    uint32_t tick_us;           // time of the last tick
    uint16_t noise_bytes;       // of the bus, when the last command began
    uint16_t remedied;          // conditions (reply.h) whose remedy a person has just read: bits
    uint8_t remedied_ticks;     // ticks since the latest of them
    uint8_t away[ROBOT_SERVOS]; // of each servo: 0, or 1 since it was told as offline, and 1 more
                                // for each tick at which it is online again
    struct unasked_alarms alarms[ROBOT_SERVOS];
    uint32_t window_us;  // time of the begin of the window of `alarms`
    uint8_t next_mode;   // index of the servo whose mode is noted next
    bool is_checking;    // the state check waits for a reply
    uint8_t line_ticks;  // 0: nothing to tell; 1: a fault of the line was told; 2 and more:
                         // ticks without it, plus 1
    bool stop_failed;    // torque is not read back as off at all servos
    bool stop_is_late;   // a failed stop has succeeded since; not told yet
    bool autostart_told; // that its sequence does not play
    bool is_looking;     // there may be something to tell since the last tick
};

/* A command begins: remedies may be printed again. Keeps the count of noise bytes. */
void unasked_begin(struct unasked *unasked, const struct console *console);

/* Bytes without a packet that the bus has received since the reset, modulo 65536. */
uint16_t unasked_bus_noise(const struct console *console);

/* Bytes without a packet that the bus has received since the command began. */
uint16_t unasked_noise_bytes(const struct unasked *unasked, const struct console *console);

/* Returns the remedy for `condition` of a warning of servo line.id, with "; " in front, and notes
 * it as printed; "" if it was printed just before, or if the error at the end of the reply has it.
 */
const CDS_FLASH char *unasked_warning_remedy(struct unasked *unasked, struct console *console,
                                             uint8_t condition);

/* Does the same for an alarm, whatever the error of the last reply. The remedy of an instruction
 * error is that of a checksum error if noise has damaged the packet. */
const CDS_FLASH char *unasked_alarm_remedy(struct unasked *unasked, struct console *console,
                                           uint8_t condition);

/* The reply of a command prints the text of error `number` with its remedy. */
void unasked_note_error(struct unasked *unasked, uint8_t number);

/* Entry `index` of the robot's list is told as offline: its return will be told. */
void unasked_note_offline(struct unasked *unasked, uint8_t index);

/* `condition` of entry `index` of the robot's list is told as an alarm: its end will be. */
void unasked_note_alarm(struct unasked *unasked, uint8_t index, uint8_t condition);

/* Call it in each turn while the console waits for input, and in the pauses of `monitor`: takes the
 * replies to the state check, and notes the mode of one servo. An alarm whose end was told is told
 * again when it comes again. */
void unasked_check_alarms(struct unasked *unasked, const struct console *console);

/* Notes that entry `index` of the robot's list has refused packets (`bits`: CDS_ERROR_*) while a
 * fault of the line, already told, lasted: no alarm is printed. */
void unasked_note_silenced(struct unasked *unasked, uint8_t index, uint8_t bits);

/* `clear`: what was told as offline or lost is no longer listed. */
void unasked_clear(struct unasked *unasked);

/* Returns the next condition from `condition` on, REPLY_TORQUE_LOST or REPLY_OFFLINE, that was told
 * of entry `index` since the last `clear` and is over; REPLY_CONDITIONS: none. */
uint8_t unasked_next_ended(const struct unasked *unasked, const struct console *console,
                           uint8_t index, uint8_t condition);

/* The mode of entry `index` of the robot's list. */
enum servo_mode unasked_mode(const struct unasked *unasked, uint8_t index);

/* " (over)" */
extern const CDS_FLASH char unasked_is_over[];

/* Returns " (now)" if the latched alarm `bit` of entry `index` lasts, " (over)" if it does not, ""
 * if the servo has not answered the state check for a while. Of a refusal: where it was not told,
 * that the line was disturbed. */
const CDS_FLASH char *unasked_alarm_state(const struct unasked *unasked, uint8_t index,
                                          uint8_t bit);

/* Entry `from` of the robot's list, the last one, has moved to entry `to`. */
void unasked_move_servo(struct unasked *unasked, uint8_t from, uint8_t to);

/* The robot's list was emptied. */
void unasked_forget(struct unasked *unasked);

/* A fault of the line is printed: its end will be. */
void unasked_note_fault(struct unasked *unasked);

/* `stop` has printed that the torque of all servos is off. */
void unasked_note_stop(struct unasked *unasked);

/* Drops the alarm that the line about the return of a servo will replace: the servo has lost its
 * state, or was offline again before that line. A lost state stays untold until that line is
 * printed: if a program takes over before, the alarm comes again. From a stop to its release the
 * alarm of a lost state is dropped, too: the stop itself has switched torque off. */
void unasked_silence(const struct unasked *unasked, const struct console *console);

/* Prints a fault that is over. False: there is nothing to print. */
bool unasked_report(struct unasked *unasked, struct console *console);

/* True if a line may be printed above the line that is half typed. */
bool unasked_may_redraw(const struct console *console);

/* Makes room for a line: clears the line that is half typed, which comes again below it, or the
 * table of `monitor`. */
void unasked_make_room(struct console *console);

#endif
