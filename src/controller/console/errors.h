/* SPDX-License-Identifier: MIT */
/* The numbered errors of the console: those of the library (result.h, numbers below 20), and these.
 * One table: the console's texts and docs/errors.md come from it. */
#ifndef CONTROLLER_ERRORS_H
#define CONTROLLER_ERRORS_H

#include <stdint.h>

#include "cds55xx/result.h"  // CDS_RESULTS
#include "console/printer.h" // SERVO_ID
#include "flash.h"           // CDS_FLASH

/* X(name, number, text, remedy): errors of every profile with a console. */
#define CONSOLE_ERRORS(X)                                                                          \
    X(ERROR_UNKNOWN_COMMAND, 30, "unknown command", "'help' lists the commands")                   \
    X(ERROR_COUNT, 31, "wrong number of arguments", "'help " COMMAND_NAME "' shows what it takes") \
    X(ERROR_NOT_A_NUMBER, 32, "not a number",                                                      \
      "write 90, 90.5deg, 512raw, -30rpm, 0x1F; for ID: 1, 1-3 or all")                            \
    X(ERROR_OUT_OF_RANGE, 33, "number out of range", "'help " COMMAND_NAME "' has the range")      \
    X(ERROR_UNKNOWN_REGISTER, 34, "unknown register", "'info ID' lists names and addresses")       \
    X(ERROR_LINE_TOO_LONG, 35, "line too long", "at most 1400 characters")                         \
    X(ERROR_INPUT_LOST, 36, "input lost",                                                          \
      "send the next line after the reply to this one, as scripts/send-lines.py does")             \
    X(ERROR_BLOCK, 37, "malformed block", "write ID:BYTE,BYTE,... with as many bytes as LENGTH")   \
    X(ERROR_UNKNOWN_WORD, 38, "unknown word", "'help " COMMAND_NAME "' shows the words")           \
    X(ERROR_UNIT, 39, "wrong unit", "'help " COMMAND_NAME "' shows the unit")                      \
    X(ERROR_TOO_MANY, 40, "too many servos",                                                       \
      "a line takes 50 servos or angles, 'monitor' 8, the robot 18: 'servos forget' empties it")   \
    X(ERROR_TWICE, 41, "an ID is given twice", "give each servo once")                             \
    X(ERROR_NOT_WRITABLE, 42, "register cannot be set",                                            \
      "it is read-only or reserved; 'id' and 'baud' change ID and BAUD_RATE")                      \
    X(ERROR_CYCLE, 43, "a cycle is running",                                                       \
      "'cycle off' first; while a cycle runs, 'pose' sets the goals")                              \
    X(ERROR_NO_CYCLE, 44, "no cycle is running", "'cycle every 4ms' starts one")                   \
    X(ERROR_NO_GROUP, 45, "no group chosen", "choose its servos, as by 'group 1 2 3'")             \
    X(ERROR_GROUP_SIZE, 46, "not as many angles as servos",                                        \
      "give one for each servo of the group; 'group' shows them")                                  \
    X(ERROR_ENDLESS, 47, "the servo is in endless turn",                                           \
      "'torque " SERVO_ID " off', else it moves to its old goal; then 'set " SERVO_ID              \
      " CCW_ANGLE_LIMIT 300'")                                                                     \
    X(ERROR_NOT_KNOWN, 48, "not one of the robot's servos",                                        \
      "'scan' finds them, 'servos' lists them")                                                    \
    X(ERROR_KEY, 49, "ended by a key or packet", "the output so far is valid")                     \
    X(ERROR_PLACE_TAKEN, 50, "the new ID or rate is taken",                                        \
      "nothing was written: choose another, or change the other servo first")                      \
    X(ERROR_LOST, 51, "no answer after the change",                                                \
      "wait a second and 'scan all'; it may have lost its power")                                  \
    X(ERROR_BOTH, 52, "servos answer at old and new ID or rate",                                   \
      "two servos had one ID: connect one of them alone")                                          \
    X(ERROR_FORCE, 53, "nothing was reset",                                                        \
      "all servos would get ID 1; 'factory 254 force' sends it")                                   \
    X(ERROR_STOPPED, 54, "stopped: driving is inhibited",                                          \
      "remove the cause, 'release'; 'torque on' moves to the last goal, 'teach off' does not")     \
    X(ERROR_OMITTED, 55, "not in this firmware",                                                   \
      "boards arduino-mega, atmega1284p, cm510 have it, and the library")                          \
    X(ERROR_TIME, 56, "time out of range", "'help " COMMAND_NAME "' has the range")                \
    X(ERROR_TOO_FAST, 57, "too fast for a servo", "give it more time")                             \
    X(ERROR_UNKNOWN_SETTING, 60, "unknown setting", "'settings' lists them")                       \
    X(ERROR_NOT_SAVED, 62, "the EEPROM keeps nothing new",                                         \
      "the older data stay valid; try again, or replace the chip")                                 \
    X(ERROR_SAVING, 63, "the EEPROM is being written", "try again in 0.2 s")                       \
    X(ERROR_STOPPING, 64, "torque off is under way", "try again when 'status' says how it went")   \
    X(ERROR_LINK_LOST, 65, "the host link was lost",                                               \
      "no byte for link_loss_ms: see 'status'; 'clear' when it is back")                           \
    X(ERROR_SERVO_INSTRUCTION, 20, "servo: instruction error",                                     \
      "the servo does not know the instruction, or ACTION found nothing registered")               \
    X(ERROR_SERVO_RANGE, 21, "servo: range error",                                                 \
      "a value or address is out of its range, read-only, or locked until power-off")              \
    X(ERROR_SERVO_CHECKSUM, 22, "servo: checksum error",                                           \
      "it came damaged: look for noise, then send it again")                                       \
    X(ERROR_SERVO_ANGLE, 23, "servo: angle limit error",                                           \
      "the goal lies outside CW_ANGLE_LIMIT to CCW_ANGLE_LIMIT")

/* X(name, number, text, remedy): errors of the profile `full`. */
#define FULL_ERRORS(X)                                                                             \
    X(ERROR_MOTION, 58, "a motion is under way",                                                   \
      "'motion off' ends it; 'motion wait' waits for it")                                          \
    X(ERROR_GOAL, 70, "the servo does not take its goal",                                          \
      "torque stays off; hold it still, look for noise")                                           \
    X(ERROR_NAME, 71, "not a name", "a letter, then letters and digits, up to 8 characters")       \
    X(ERROR_NAME_LONG, 72, "name too long", "at most 8 characters")                                \
    X(ERROR_KEYWORD, 73, "the name is a word of the console", "choose another name")               \
    X(ERROR_NO_POSE, 74, "unknown pose", "'pose list' shows the poses")                            \
    X(ERROR_NO_SEQUENCE, 75, "unknown sequence", "'sequence list' shows the sequences")            \
    X(ERROR_STORE_FULL, 76, "the EEPROM has no room for another pose or sequence",                 \
      "delete one, as by 'pose delete NAME'; 'status' shows the room")                             \
    X(ERROR_STEPS, 77, "the sequence has 16 steps already", "store the rest under another name")   \
    X(ERROR_POSE_GONE, 78, "a step names a deleted pose",                                          \
      "'sequence show NAME' shows the steps; store all again, from 'new' on")                      \
    X(ERROR_NO_MOTION, 79, "no motion is under way", "'play NAME' begins one")                     \
    X(ERROR_JOINTS, 80, "too many servos in stored poses",                                         \
      "at most 18 together: delete poses, or give fewer servos")                                   \
    X(ERROR_STUCK, 83, "a servo does not follow its goals; the motion has ended",                  \
      "'torque " SERVO_ID " off', free it; or power, limits: 'diagnose " SERVO_ID "'")             \
    X(ERROR_TORQUE_OFF, 84, "torque of a servo is off",                                            \
      "switch it on where the servos are, as by 'teach off 1 2 3'")                                \
    X(ERROR_ALARM, 85, "the servo reports an alarm",                                               \
      "'torque " SERVO_ID " off', unload it; when cool, 'clear', 'release " SERVO_ID "'")          \
    X(ERROR_VOLTAGE, 86, "voltage outside of the servo's limits",                                  \
      "compare PRESENT_VOLTAGE, MIN_VOLTAGE, MAX_VOLTAGE; mend supply or limits, then 'clear'")    \
    X(ERROR_OVERRIDE, 82, "percentage of the speed out of range", "give 10 to 200%")               \
    X(ERROR_ABSENT, 81, "a servo of the pose is not in the group",                                 \
      "'pose show NAME' prints the 'group' that the pose needs")                                   \
    X(ERROR_SOME, 87, "some servos of the list failed", "the lines above name them, and why")      \
    X(ERROR_NO_SERVO, 88, "no servo answers at any rate",                                          \
      "check power, plug, wiring; then 'new' with this servo alone, 'scan rescue' or 'diagnose'")  \
    X(ERROR_NOT_ALONE, 89, "the new servo is not alone, nothing was written",                      \
      "connect only the new servo, then 'new'")                                                    \
    X(ERROR_DAMAGED, 90, "the replies of the servo stay damaged",                                  \
      "two servos have one ID, or noise: see 'diagnose'")                                          \
    X(ERROR_TIME_STEP, 91, "the time is not a multiple of 10 ms, nothing was stored",              \
      "give 1230ms or 1.23s, not 1234ms")                                                          \
    X(ERROR_PAUSED, 92, "a motion is paused", "'resume' goes on with it, 'motion off' ends it")    \
    X(ERROR_AUTOSTART, 93, "the sequence plays after power-up, nothing was deleted",               \
      "'settings autostart off' first")                                                            \
    X(ERROR_NO_NEW, 94, "the 'sequence NAME new' before was refused or lost, nothing was stored",  \
      "send that line again; to add to a stored sequence: 'sequence list' first")                  \
    X(ERROR_NOT_NEW, 95, "this ID is in the robot's list, nothing was written",                    \
      "unplug the servo of the robot; if the new servo has this ID, 'servos forget' first")

enum console_error {
#define CONSOLE_ERROR_ENUM_(name, number, text, remedy) name = number,
    CONSOLE_ERRORS(CONSOLE_ERROR_ENUM_) FULL_ERRORS(CONSOLE_ERROR_ENUM_)
#undef CONSOLE_ERROR_ENUM_
} __attribute__((packed));

/* Messages for the printer, by number: "text; remedy", and "text" for the profile `console`, which
 * leaves the remedies to docs/errors.md. A profile names one of them in its command_set. */
extern const CDS_FLASH char *const CDS_FLASH errors_with_remedies[];
extern const CDS_FLASH char *const CDS_FLASH errors_without_remedies[];

/* The message of an error of either table. */
const CDS_FLASH char *error_text(uint8_t number);

/* The same without "servo: " at its begin, for a line that names the servo. Not for the profile
 * `console`, whose lines keep the word. */
const CDS_FLASH char *error_text_of_servo(uint8_t number);

/* Returns the console's error for one of the CDS_ERROR_* bits that refuse a packet, and clears the
 * bit in *bits. Several bits: the first of instruction, range, checksum, angle. No such bit: 0. */
uint8_t error_of_servo(uint8_t *bits);

#endif
