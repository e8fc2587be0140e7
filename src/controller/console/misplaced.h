/* SPDX-License-Identifier: MIT */
/* Words at the wrong place: a command behind another command, a word of the command in the place of
 * a name, a word of another form of the command, the name of a register or of a pose in front.
 *
 *     error 38: wait|off|at 'pause': a command of its own: 'pause'
 *
 * more_slips() returns these texts if the line has no other slip. */
#ifndef CONTROLLER_MISPLACED_H
#define CONTROLLER_MISPLACED_H

#include "flash.h" // CDS_FLASH

struct console;

/* Returns the message for console->error, with its values in the printer; NULL: no word of the line
 * is misplaced. The printer must be ready. */
const CDS_FLASH char *misplaced_text(struct console *console);

#endif
