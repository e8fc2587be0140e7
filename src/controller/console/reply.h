/* SPDX-License-Identifier: MIT */
/* The end of every reply of the console: warnings, and `ok` or `error`. */
#ifndef CONTROLLER_REPLY_H
#define CONTROLLER_REPLY_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h" // CDS_FLASH

struct console;

/* Prints the next piece of the end; the printer must be ready. False when the reply is complete. */
bool reply_piece(struct console *console);

/* The name of a condition by the number of its CDS_ERROR_* bit: 0 to 6. 7: FAILSAFE_OFFLINE. */
extern const CDS_FLASH char *const CDS_FLASH reply_conditions[];

/* The name of the lowest condition in `bits`, CDS_ERROR_* bits or FAILSAFE_OFFLINE but not 0, into
 * *text; returns the bits that are left. */
uint8_t reply_condition(uint8_t bits, const CDS_FLASH char **text);

/* The remedy for the lowest of `bits`, which are not 0, with "; " in front. Returns "" in a
 * firmware profile whose errors have no remedies. */
const CDS_FLASH char *reply_remedy(uint8_t bits);

#endif
