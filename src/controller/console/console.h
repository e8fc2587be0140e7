/* The text console: one command a line. The reply is zero or more lines, then exactly one of `ok`
 * or `error N: text; remedy`. The console reads the next line when the reply has been printed.
 * Input and output are rings; nothing waits.
 *
 * Ctrl-X stops the robot at once, wherever it stands in the input: text before it is dropped, a
 * running command ends with an error, and the command of command_set.on_stop runs.
 *
 * A mark in the input (host_demux.h) drops the line so far: a packet came, and the console says
 * nothing; or bytes were lost, and the console replies an error. */
#ifndef CONTROLLER_CONSOLE_H
#define CONTROLLER_CONSOLE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"     // struct cds_bus
#include "console/parse.h"   // struct command_line
#include "console/editor.h"  // struct editor
#include "robot/failsafe.h"  // struct failsafe
#include "robot/robot.h"     // struct robot
#include "console/lexer.h"   // struct token
#include "console/printer.h" // struct printer

#define CONSOLE_LINE_MAX 1400 // characters; 50 servos x 4 bytes in a SYNC WRITE, all hexadecimal
#define CONSOLE_STOP     0x18 // Ctrl-X

enum console_state { CONSOLE_READING, CONSOLE_RUNNING, CONSOLE_CLOSING } __attribute__((packed));

/* Bytes that a command may keep from one poll to the next. */
#define CONSOLE_JOB_SIZE 128

/* The buffer of the console's request. A line that is a packet itself may fill it; any other
 * command has the end of it for its job. */
union console_buffer {
    uint8_t packet[CDS_LENGTH_MAX + 4]; // the longest
    struct {
        uint8_t packet[2 * PARSE_LIST_MAX]; // and the words of a list
        union {
            uint8_t bytes[CONSOLE_JOB_SIZE];
            void *alignment;
        } job;
    } command;
};

/* The fields that commands use stand first: an AVR reaches 64 bytes of a struct by displacement. */
struct console {
    struct printer printer;
    struct cds_bus *bus;
    struct robot *robot;
    struct failsafe *failsafe;
    uint8_t step;        // calls of the command's poll so far, 255 at most
    uint8_t phase;       // of the command; 0 when it begins
    uint8_t index;       // in a list that the command prints; 0 when it begins
    uint8_t part;        // of the entry that it prints; 0 when it begins
    uint8_t error;       // number of the error the reply ends with, 0 for ok
    uint8_t servo_error; // CDS_ERROR_* bits not yet printed
    uint16_t raw;        // result of console_number() or console_ms()
    struct command_line line;
    struct cds_ring *input;
    uint16_t characters; // of the line so far
    uint8_t state;       // enum console_state
    bool closed : 1;     // the reply's last line is written
    bool skipping : 1;   // the rest of this line is ignored up to its end
    bool stop_asked : 1; // by Ctrl-X, and on_stop has not begun yet
    bool ending : 1;     // the locked text is the whole rest of the line
    uint8_t fed;         // locked characters that the parser has taken
    uint8_t looked;      // index of the input ring: no Ctrl-X before it
    struct token token;
    struct editor editor;
    struct cds_request request;
    union console_buffer buffer;  // of its packet
    uint8_t reply[CDS_REPLY_MAX]; // of its reply
};

/* Zero *console first (static storage is). The robot of `failsafe` has begun; it is on the bus that
 * the console uses. */
void console_open(struct console *console, struct failsafe *failsafe, struct cds_ring *input,
                  struct cds_ring *output);

/* Takes some characters, or goes on with a command, or prints a piece of the reply. Call it from
 * the main loop, beside cds_bus_poll() and robot_poll(). */
void console_poll(struct console *console);

/* Ctrl-X has come: stops the robot at once and drops the input up to it. */
void console_stop(struct console *console);

/* True if the console waits for input and has nothing else to do. */
bool console_idle(const struct console *console);

/* ---- for the commands ---- */

/* What the running command keeps from one poll to the next: CONSOLE_JOB_SIZE bytes, zero when the
 * command begins. Only for a command without an instruction in its row; its packets have at most
 * 100 bytes. */
static inline void *console_job(struct console *console)
{
    return console->buffer.command.job.bytes;
}

/* A number of the line, 0 to 2, as a register value of `unit` (number_within()), and number 0 as
 * milliseconds (number_ms()): 0 and console->raw; or an error, and console->raw is as it was. */
uint8_t console_number(struct console *console, uint8_t index, enum cds_unit unit);
uint8_t console_ms(struct console *console);

/* True while the transaction of line.request is under way. Then its outcome is in console->error
 * and console->servo_error. */
bool console_waits(struct console *console);

/* After console_waits(): true if the transaction succeeded and the servo did not refuse. */
bool console_answered(const struct console *console);

/* True while the robot's operation is under way; a key ends it. Then its outcome is in
 * console->error. */
bool console_operates(struct console *console);

/* The robot's servo line.id, or NULL. */
struct cds_servo_state *console_servo(const struct console *console);

/* True if a key was pressed since the command began. Drops all input so far. */
bool console_key(struct console *console);

#endif
