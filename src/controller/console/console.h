/* SPDX-License-Identifier: MIT */
/* The text console: one command a line. The reply is any number of lines, then exactly one line
 * `ok` or `error N: text; remedy`; the profile `console` leaves the remedy out. The console reads
 * the next line when the reply is printed. Input and output are rings. No call waits.
 *
 * Ctrl-X stops the robot at once, even behind other input. Then the console drops the text before
 * the Ctrl-X, ends a running command with an error, and runs the command command_set.on_stop.
 *
 * A mark in the input (host_demux.h) drops the unfinished line. After HOST_MARK_DROPPED the console
 * prints nothing. After HOST_MARK_LOST it prints an error. */
#ifndef CONTROLLER_CONSOLE_H
#define CONTROLLER_CONSOLE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"     // struct cds_bus
#include "console/parse.h"   // struct command_line
#include "console/editor.h"  // struct editor
#include "robot/failsafe.h"  // struct failsafe
#include "robot/robot.h"     // struct robot
#include "console/token.h"   // struct token
#include "console/printer.h" // struct printer

#define CONSOLE_LINE_MAX 1400 // characters; 50 servos x 4 bytes in a SYNC WRITE, all hexadecimal
#define CONSOLE_STOP     0x18 // Ctrl-X

#define CONSOLE_FACTORY_ID 1 // what `reset` and `factory` leave (R11, R25)

enum console_state {
    CONSOLE_READING, // takes keys of a line
    CONSOLE_RUNNING, // a command is under way
    CONSOLE_ENDING,  // prints the end of the reply
} __attribute__((packed));

/* Bytes that a command may keep from one poll to the next. */
#define CONSOLE_JOB_SIZE 128

/* State of a command that runs for each servo of a list: servo_list.h. */
struct servo_list {
    uint8_t next;  // index of the servo that is next
    uint8_t phase; // of the servo that is served now: enum list_phase
    /* Error of the last servo that failed. ERROR_SOME: it had a text of its own, so that of the
     * next servo is not shortened. 0: none has failed. */
    uint8_t error;
    bool some_went_well; // a servo of the list did not fail
};

/* The buffer of the console's request. A command with an instruction in its row builds its packet
 * while the line is read and may use the whole buffer. Every other command has its job at the end
 * of it. */
union console_buffer {
    uint8_t packet[CDS_LENGTH_MAX + 4]; // the longest packet
    struct {
        uint8_t packet[2 * PARSE_LIST_MAX]; // a short packet, or the words of a list
        union {
            uint8_t bytes[CONSOLE_JOB_SIZE];
            void *alignment;
        } job;
        struct servo_list list;
    } command;
};

/* The fields that commands use stand first: an AVR reaches the first 64 bytes of a struct with less
 * code. */
struct console {
    struct printer printer;
    struct cds_bus *bus;
    struct robot *robot;
    struct failsafe *failsafe;
    uint8_t step;        // number of finished calls of the command's poll, up to 255
    uint8_t phase;       // for the command; 0 when it begins
    uint8_t index;       // for a command that prints a list; 0 when it begins
    uint8_t part;        // for a command that prints an entry in parts; 0 when it begins
    uint8_t error;       // number of the error the reply ends with, 0 for ok
    uint8_t servo_error; // CDS_ERROR_* bits not yet printed
    uint16_t raw;        // result of console_number() or console_ms()
    struct command_line line;
    struct cds_ring *input;
    uint16_t characters;     // number of characters of the line that the parser has taken
    uint8_t state;           // enum console_state
    bool reply_ended : 1;    // the last line of the reply is printed
    bool skipping : 1;       // the line is wrong: its remaining characters are ignored
    bool completing : 1;     // a Tab has come: the word before the cursor is being completed
    bool stop_asked : 1;     // Ctrl-X has come, and the command on_stop has not begun yet
    bool line_complete : 1;  // the end of the line has come; the parser takes what remains of its
                             // text
    bool new_is_refused : 1; // the last `sequence NAME new` was refused: so is `add` (sequences.c)
    uint8_t explained;       // parts of the error's line that are printed; without an error: of the
                             // note before `ok`
    uint8_t faults_told;     // FAULT_* bits, and in the upper five bits FAULT_LOW_LOOK times the
                             // looks in a row that have found the line low
    uint8_t fed;             // locked characters that the parser has taken
    uint8_t looked;          // position in the input ring: there is no Ctrl-X before it
    struct token token;      // the word that comes, or the one that is wrong
    struct editor editor;
    struct cds_request request;
    union console_buffer buffer; // the packet of `request`, or the job of the command
    // the reply to `request`; a command that sends nothing may keep data here
    uint8_t reply[CDS_REPLY_MAX] __attribute__((aligned(__alignof__(void *))));
};

/* Zero *console first (static storage is). The robot of `failsafe` must have begun; the console
 * uses its bus. */
void console_open(struct console *console, struct failsafe *failsafe, struct cds_ring *input,
                  struct cds_ring *output);

/* Takes some characters, moves a command on, or prints a piece of the reply. Call it from the main
 * loop, as cds_bus_poll() and robot_poll(). */
void console_poll(struct console *console);

/* Prints `line`, at most PRINTER_PIECE - 2 characters without a %, between two replies. False:
 * there is no room now, and nothing was printed. */
bool console_say(struct console *console, const CDS_FLASH char *line);

/* Ctrl-X has come. Stops the robot at once and drops the input up to the last Ctrl-X. */
void console_stop(struct console *console);

/* True if the console waits for input and has nothing else to do. */
bool console_idle(const struct console *console);

/* True if the setting echo is SETTINGS_ECHO_PERSON (mode person): banner, prompt and echo. */
bool console_is_for_person(const struct console *console);

/* A new line begins: in mode person the editor prints a prompt before it. */
void console_prompt(struct console *console);

/* Call it before a line that no command asked for: in mode person the line overwrites the prompt,
 * and the prompt comes again below it. Only a profile with command_set.unasked may call it while a
 * line is half typed, or in a pause of `monitor`. */
void console_move_prompt(struct console *console);

/* ---- for the commands ---- */

/* Returns CONSOLE_JOB_SIZE bytes in which the running command keeps its state from poll to poll;
 * zero when the command begins. Only for a command without an instruction in its row. The packets
 * of such a command have at most 100 bytes; at most 50 if its row has an ID, because the list of
 * servos stands behind them. */
static inline void *console_job(struct console *console)
{
    return console->buffer.command.job.bytes;
}

/* The error to print: in place of CDS_INHIBITED and ERROR_STOPPED the error of what inhibits all
 * servos, a stop or a lost host link; other errors as they are. */
uint8_t console_remedied(const struct console *console, uint8_t error);

/* Clears console_job(), and step, phase, index and part of the console; the command is under way.
 * The console calls it for each command, servo_list.c for each servo of a list. */
void console_begin_job(struct console *console);

/* Converts number `index` of the line, 0 to 2, to a register value of `unit` (number_within()).
 * Returns 0, and console->raw is the value; or an error, and console->raw is undefined. */
uint8_t console_number(struct console *console, uint8_t index, enum cds_unit unit);

/* Converts number 0 of the line to milliseconds (number_ms()). Returns 0, and console->raw is the
 * value; or an error, and console->raw is undefined. */
uint8_t console_ms(struct console *console);

/* Converts number `index` of the line, 0 to 2, to the time of a move in milliseconds. Returns 0 and
 * *ms, 1 to CDS_MOTION_TIME_MAX_MS; ERROR_TIME: out of this range; or an error of number_ms(). */
uint8_t console_move_ms(struct console *console, uint8_t index, uint32_t *ms);

/* For the poll of a command that has sent line.request. Returns true while the transaction goes on.
 * When it returns false, it has stored the outcome in console->error and console->servo_error. */
bool console_waits(struct console *console);

/* After console_waits() has returned false: true if the transaction succeeded and the servo did not
 * refuse. */
bool console_answered(const struct console *console);

/* For the poll of a command that has started an operation of the robot; a key aborts the operation.
 * Returns true while the operation goes on. When it returns false, it has stored the outcome in
 * console->error. */
bool console_operates(struct console *console);

/* Returns the robot's entry of servo line.id, or NULL. */
struct cds_servo_state *console_servo(const struct console *console);

/* Faults of the whole robot that are there now. */
#define FAULT_LINK_LOST 1
#define FAULT_LINE_LOW  2
#define FAULT_NOISE     4
#define FAULT_LOW_LOOK  8 // only in faults_told
uint8_t console_faults(const struct console *console);

/* True if there is noise on the line, or a person was told so and not yet that it is over. Only for
 * a profile with command_set.noise. */
bool console_is_noisy(const struct console *console);

/* True if a key was pressed since the command began. The key stays in the input: it is the first
 * one of the next line. */
bool console_key(struct console *console);

#endif
