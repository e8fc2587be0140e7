/* SPDX-License-Identifier: MIT */
/* More slips of a line than slips.h has: words of other consoles, several commands in a line, an
 * angle for each servo of a list, numbers in another notation, a number where none stands; and
 * refusals that name the values behind them: limits, a locked servo.
 *
 * The profile `full` links them on chips with room for them (command_set.more_slips). */
#ifndef CONTROLLER_MORE_SLIPS_H
#define CONTROLLER_MORE_SLIPS_H

#include <stdbool.h>

#include "console/token.h" // struct token
#include "flash.h"         // CDS_FLASH

struct console;

/* True if a word of the line has caused the error; it is console->token. */
bool more_slips_has_word(const struct console *console);

/* The first name of the line, as a word. */
struct token more_slips_name(const struct console *console);

/* What to type to move to a stored pose. */
extern const CDS_FLASH char more_slips_pose_line[];

/* Returns the message for console->error, with its values in the printer; NULL: the line has none
 * of these slips. The printer must be ready. */
const CDS_FLASH char *more_slips(struct console *console);

#endif
