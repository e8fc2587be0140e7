/* SPDX-License-Identifier: MIT */
/* What the wire cannot show: notes before the `ok` of a command, what another rate of the bus
 * means, and what a reset means for the robot. Linked where advice.h is. */
#ifndef CONTROLLER_ADVICE_NOTES_H
#define CONTROLLER_ADVICE_NOTES_H

#include <stdint.h>

#include "flash.h" // CDS_FLASH

struct console;

/* Returns a message to print before the `ok` of the command: what the wire cannot show. NULL: none.
 * Its values are in the printer, which must be ready. `note` of struct command_set. */
const CDS_FLASH char *advice_note(struct console *console);

/* Returns what a change of the bus from the rate of register value `old` means for the servos that
 * are known; its values are in the printer, which must be ready. `bus_changed` of struct
 * command_set. */
const CDS_FLASH char *advice_bus_changed(struct console *console, uint8_t old);

/* Puts two lines of the banner into the printer, each empty or with its end of line. Value 2:
 * driving is inhibited. Value 3: what a reset other than power-on means; value 4 is the rate in it.
 * `after_reset` of struct command_set. */
void advice_after_reset(struct console *console);

#endif
