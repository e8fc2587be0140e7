/* The end of every reply of the console: warnings, and `ok` or `error`. */
#ifndef CONTROLLER_REPLY_H
#define CONTROLLER_REPLY_H

#include <stdbool.h>
#include <stdint.h>

struct console;
struct writer;

/* Writes the next piece of it; the writer must be ready. False when the reply is complete. */
bool reply_piece(struct console *console);

/* The conditions among the CDS_ERROR_* bits `bits`, a name at a time: writes that of one, as part
 * of a line, and returns the bits that are left; 0 and nothing if there is none. */
uint8_t reply_condition(struct writer *writer, uint8_t bits);

#endif
