/* SPDX-License-Identifier: MIT */
/* Slips of a line: words in another order, a comma, a wrong kind of name, a command of another
 * name, a number without its unit, a long unit, a move that is too fast as its time is in ms, a
 * read-only register, `limits` without angles. The text of the error names the line to type:
 *
 *     error 32: ID|254 'on': the ID comes first: 'torque 1 on'
 *
 * advice() returns these texts. */
#ifndef CONTROLLER_SLIPS_H
#define CONTROLLER_SLIPS_H

#include "flash.h" // CDS_FLASH

struct console;

/* Returns the message for console->error, with its values in the printer; NULL: the line has none
 * of these slips. The printer must be ready. */
const CDS_FLASH char *slip_text(struct console *console);

#endif
