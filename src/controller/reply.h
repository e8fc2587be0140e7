/* What the console says to a command: piece by piece, as the PC takes it. */
#ifndef CONTROLLER_REPLY_H
#define CONTROLLER_REPLY_H

#include <stdbool.h>

struct console;

/* Writes the next piece of the reply; the writer must be ready. False when the reply is complete.
 */
bool reply_piece(struct console *console);

#endif
