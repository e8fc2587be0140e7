/* The text console: a command a line; the reply is zero or more lines, then exactly one of `ok` or
 * `error N: text; remedy`. The next line is looked at when the reply to this one is out. Bytes in
 * and text out are rings; nothing waits.
 *
 * Ctrl-X stops the robot wherever it comes, and at once: what was typed before it is dropped, a
 * command under way ends with an error, and then `stop` is answered as if it had been typed.
 *
 * Marks in the input (host.h) say that the line so far is gone: because of a packet, and nothing is
 * said; or because something was lost, which is answered by an error.
 */
#ifndef CONTROLLER_CONSOLE_H
#define CONTROLLER_CONSOLE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"      // struct cds_bus
#include "cds55xx/feedback.h" // struct cds_feedback
#include "cds55xx/setup.h"    // struct cds_setup
#include "console/parse.h"    // struct command_line
#include "console/editor.h"   // struct editor
#include "robot/failsafe.h"   // struct failsafe
#include "robot/robot.h"      // struct robot
#include "console/lexer.h"    // struct token
#include "console/printer.h"  // struct printer

#define CONSOLE_LINE_MAX 1400 // characters; 50 servos x 4 bytes in a SYNC WRITE, all hexadecimal
#define CONSOLE_STOP     0x18 // Ctrl-X

enum console_state { CONSOLE_READING, CONSOLE_RUNNING, CONSOLE_CLOSING } __attribute__((packed));

/* Servos that monitor draws. */
#define MONITOR_SERVOS 8

struct monitor {
    uint32_t next_us; // when the next line begins
    uint32_t period_us;
    struct cds_feedback feedback;
    uint16_t lines;
    uint16_t failed;
    uint8_t ids[MONITOR_SERVOS];
    uint8_t count;
    uint8_t index; // servo being read
    uint8_t value; // of it, being told
    bool begun;    // something stands in the line
};

/* What a command remembers from one poll to the next; one runs at a time. Zero when it begins. */
union console_job {
    struct {
        struct cds_setup setup;
        uint8_t data[4];      // what it writes
        uint8_t no_limits[4]; // angle limits that make an endless turn
    } set;
    struct monitor monitor;
    uint32_t since_us;
};

/* What the console's request sends. A line that is a packet itself may take all of it; any other
 * command has the end of it for what it remembers. */
union console_buffer {
    uint8_t packet[CDS_LENGTH_MAX + 4]; // the longest
    struct {
        uint8_t packet[2 * PARSE_LIST_MAX]; // words of a list, too
        union console_job job;
    } command;
};

/* What commands use is first: an AVR reaches 64 bytes of a struct easily. */
struct console {
    struct printer printer;
    struct cds_bus *bus;
    struct robot *robot;
    struct failsafe *failsafe;
    uint8_t step;        // calls of the command's poll so far, 255 at most
    uint8_t phase;       // the command's own, 0 when it begins
    uint8_t index;       // likewise: of a list that is being told
    uint8_t part;        // likewise: of what is told of one of them
    uint8_t error;       // number of the error the reply ends with, 0 for ok
    uint8_t servo_error; // CDS_ERROR_* bits not yet told
    uint16_t raw;        // what console_number() or console_ms() has made of a number
    struct command_line line;
    struct cds_ring *input;
    uint16_t characters; // of the line so far
    uint8_t state;       // enum console_state
    bool closed : 1;     // the reply's last line is written
    bool skipping : 1;   // the rest of this line counts for nothing but its end
    bool stop_asked : 1; // by Ctrl-X, and not answered yet
    bool ending : 1;     // what is locked of the text is all of the line
    uint8_t fed;         // characters of what is locked that the parser has
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

/* Moves on: takes some characters, or goes on with a command, or writes a piece of the reply. To be
 * called from the main loop, beside cds_bus_poll() and robot_poll(). */
void console_poll(struct console *console);

/* Ctrl-X has come, wherever it is by now: the robot is stopped at once. */
void console_stop(struct console *console);

/* Nothing to do but wait for input? */
bool console_idle(const struct console *console);

/* ---- for the commands ---- */

/* What a command remembers: one without an instruction in its row of the table, whose packets are
 * 100 bytes at the most. */
static inline union console_job *console_job(struct console *console)
{
    return &console->buffer.command.job;
}

/* A number of the line, 0 to 2, as a register value of `unit` (number_within()), and number 0 as
 * milliseconds (number_ms()): 0 and console->raw; or an error, and console->raw is as it was. */
uint8_t console_number(struct console *console, uint8_t index, enum cds_unit unit);
uint8_t console_ms(struct console *console);

/* Is the exchange of line.request still under way? If not, its outcome is in console->error and
 * console->servo_error: go on only if both say so. */
bool console_waits(struct console *console);

/* console_waits(), and it went well, the servo has not refused, and there are data if some were
 * due. */
bool console_answered(const struct console *console);

/* True while the robot's operation is under way; a key ends it. Then its outcome is in
 * console->error. */
bool console_operates(struct console *console);

/* The robot's servo line.id, or NULL. */
struct cds_servo_state *console_servo(const struct console *console);

/* Has a key been pressed since the command began? It is taken away, with all that came with it. */
bool console_key(struct console *console);

#endif
