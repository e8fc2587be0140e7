/* SPDX-License-Identifier: MIT */
/* The last line of a reply with an error: it names servo, argument, value and allowed range:
 *
 *     error 33: servo 1: ANGLE 400deg is out of range: 0 to 300deg
 *     error 34: REG 'GOAL': unknown register; name it as in docs/registers.md, or give ...
 *     error 2: servo 7: no reply by the deadline; check power, wiring, ID and baud rate ...
 *
 * If a word of the line has caused the error, the argument is line.usage and the value is
 * console->token. A number that a command refuses is found by its place in the usage and the range
 * of its name. A few mistakes that are easy to see have a text of their own (mistake.h). */
#ifndef CONTROLLER_EXPLAIN_H
#define CONTROLLER_EXPLAIN_H

#include <stdbool.h>
#include <stdint.h>

struct console;
struct command_line;

/* The values an argument may have. */
struct range {
    uint16_t lowest, highest; // registers of `unit`, or the numbers themselves
    uint8_t unit;             // enum cds_unit, or one of these:
};

#define UNIT_MS      UINT8_MAX       // milliseconds
#define UNIT_PERCENT (UINT8_MAX - 1) // percent
#define UNIT_US      (UINT8_MAX - 2) // microseconds
#define UNIT_S       (UINT8_MAX - 3) // whole seconds
#define UNIT_ADDRESS (UINT8_MAX - 4) // of a register: printed in hexadecimal digits

/* Returns true if the command of the line is `settings`. `set` and `restore` have a VALUE, too. */
bool explain_is_settings(const struct command_line *line);

/* `explain` of struct command_set: prints the next part of the line for console->error;
 * console->explained counts the parts. The printer must be ready. False: that was the last part. */
bool explain_error(struct console *console);

/* Returns the ID of the servo that console->error is about, or a number above CDS_ID_MAX. */
uint8_t explain_servo(const struct console *console);

/* Returns the servo whose limits have caused console->error, CDS_LIMIT: that of the line or, with
 * room for it, the one for which a packet to several servos was refused. NULL: it is not known. */
const struct cds_servo_state *explain_limited(const struct console *console);

/* Finds the unit of the argument that console->error is about, enum cds_unit or UNIT_MS and so on.
 * False: the error is about no argument with a unit. */
bool explain_unit(const struct console *console, uint8_t *unit);

/* Returns ERROR_OUT_OF_RANGE if a number of the line is out of the range of its argument; else 0.
 * The command checks raw values. Call it after parse_end(). */
uint8_t explain_numbers(struct console *console);

/* The line that is printed now names console->error: notes its remedy, or its alarm, as told, so
 * that it is not repeated at once. Main context. */
void explain_note_told(struct console *console);

#endif
