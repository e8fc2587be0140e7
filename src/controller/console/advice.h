/* SPDX-License-Identifier: MIT */
/* Longer texts. Errors whose remedy depends on the line or on what is known of the servo: these
 * texts stand in place of that of the error (mistake.h):
 *
 *     error 39: servo 1: ANGLE 90rpm: wrong unit; units: deg, mdeg, raw
 *
 * Also notes before `ok`, what a lost link has done, and what a reset means for the robot.
 * The profile `full` links them on chips with flash for them (command_set.advise). */
#ifndef CONTROLLER_ADVICE_H
#define CONTROLLER_ADVICE_H

#include <stdint.h>

#include "flash.h" // CDS_FLASH

struct console;

/* Returns the message for console->error, with its values in the printer; NULL: the text of the
 * error itself is the best. The printer must be ready. */
const CDS_FLASH char *advice(struct console *console);

/* For ERROR_UNKNOWN_WORD: prints the words that all rows of the command have at the place of the
 * wrong word, "wait|off|at". `words` of struct command_set. */
void advice_words(struct console *console);

/* Returns a message to print before the `ok` of the command: what the wire cannot show. NULL: none.
 * Its values are in the printer, which must be ready. `note` of struct command_set. */
const CDS_FLASH char *advice_note(struct console *console);

/* Returns the text of ERROR_LINK_LOST with what the controller did then; its values are in the
 * printer, which must be ready. `link_lost` of struct command_set. */
const CDS_FLASH char *advice_link_lost(struct console *console);

/* Returns what a change of the bus from the rate of register value `old` means for the servos that
 * are known; its values are in the printer, which must be ready. `bus_changed` of struct
 * command_set. */
const CDS_FLASH char *advice_bus_changed(struct console *console, uint8_t old);

/* Puts two lines of the banner into values 2 and 3 of the printer, each empty or with its end of
 * line: what a reset that was not power-on means for the robot, and that driving is inhibited.
 * `after_reset` of struct command_set. */
void advice_after_reset(struct console *console);

/* Returns the remedy of a new alarm of servo `failsafe->next`, with "; " in front: after damaged
 * packets it names them; "" if this remedy was told before. Its value is in value 4 of the printer.
 * For a firmware without unasked.h. */
const CDS_FLASH char *advice_alarm_remedy(struct console *console, uint8_t condition);

/* Marks the alarm of this refusal as reported: the reply has just named it. In mode person, for a
 * firmware without unasked.h. */
void advice_note_refused(struct console *console, uint8_t error);

#endif
