/* The end of every reply of the console: warnings, and `ok` or `error`. */
#ifndef CONTROLLER_REPLY_H
#define CONTROLLER_REPLY_H

#include <stdbool.h>
#include <stdint.h>

struct console;

/* Writes the next piece of it; the printer must be ready. False when the reply is complete. */
bool reply_piece(struct console *console);

/* The CDS_ERROR_* bits `bits` (not 0), a name at a time: that of the lowest one, for the printer,
 * into *text; returns the bits that are left. */
uint8_t reply_condition(uint8_t bits, uint16_t *text);

#endif
