/* The text console: a command a line; the reply is zero or more lines, then exactly one of `ok` or
 * `error N: text`. The next line is looked at when the reply to this one is out. Bytes in and text
 * out are rings; nothing waits. */
#ifndef CONTROLLER_CONSOLE_H
#define CONTROLLER_CONSOLE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus
#include "command.h"     // struct command_line
#include "keeper.h"      // struct keeper
#include "token.h"       // struct token
#include "writer.h"      // struct writer

#define CONSOLE_LINE_MAX 1400 // characters; 50 servos x 4 bytes in a SYNC WRITE, all hexadecimal

enum console_state { CONSOLE_READING, CONSOLE_WAITING, CONSOLE_REPLYING };

/* The command's own lines; warnings and `ok` or `error`; all is written. */
enum reply_phase { REPLY_BODY, REPLY_CLOSING, REPLY_CLOSED };

struct console {
    struct cds_bus *bus;
    struct keeper *keeper; // of the commands in cmd_keeper.c; set before the first of them
    struct cds_ring *input;
    struct writer writer;
    struct command_line line;
    struct token token;
    uint16_t characters; // of the line so far
    bool skipping;       // the rest of this line counts for nothing but its end
    uint8_t state;       // enum console_state
    uint8_t phase;       // enum reply_phase
    uint8_t step;        // of the body
    uint8_t error;       // number of the error the reply ends with, 0 for ok
    uint8_t servo_error; // CDS_ERROR_* bits not yet told
};

/* Zero *console first (static storage is). `request` has room for the longest packet, 258 bytes. */
void console_open(struct console *console, struct cds_bus *bus, struct cds_request *request,
                  struct cds_ring *input, struct cds_ring *output);

/* Moves on: takes some characters, or looks at the exchange, or writes a piece of the reply. To be
 * called from the main loop, beside cds_bus_poll(). */
void console_poll(struct console *console);

/* The input has a gap here (call only when console_idle()): the line it fell into is not carried
 * out and is answered by an error. */
void console_input_lost(struct console *console);

/* Nothing to do but wait for input? */
bool console_idle(const struct console *console);

#endif
