/* SPDX-License-Identifier: MIT */
/* Longer texts. Errors whose remedy depends on the line or on what is known of the servo: these
 * texts stand in place of that of the error (mistake.h):
 *
 *     error 39: servo 1: ANGLE 90rpm: wrong unit; units: deg, mdeg, raw
 *
 * Also what a lost link has done. The profile `full` links them on chips with flash for them
 * (command_set.advise). */
#ifndef CONTROLLER_ADVICE_H
#define CONTROLLER_ADVICE_H

#include "flash.h" // CDS_FLASH

struct console;

/* Returns the message for console->error, with its values in the printer; NULL: the text of the
 * error itself is the best. The printer must be ready. */
const CDS_FLASH char *advice(struct console *console);

/* Text and remedy of ERROR_POSE_GONE, where the steps of a sequence have commands of their own. */
extern const CDS_FLASH char advice_pose_gone[];

/* For ERROR_UNKNOWN_WORD: prints the words that all rows of the command have at the place of the
 * wrong word, "wait|off|at". `words` of struct command_set. */
void advice_words(struct console *console);

/* Returns the text of ERROR_LINK_LOST with what the controller did then; its values are in the
 * printer, which must be ready. `link_lost` of struct command_set. */
const CDS_FLASH char *advice_link_lost(struct console *console);

#endif
