/* The console's commands about the controller itself: settings, save, defaults, status, alarms,
 * clear. */
#ifndef CONTROLLER_CMD_KEEPER_H
#define CONTROLLER_CMD_KEEPER_H

#include <stdbool.h>
#include <stdint.h>

struct console;

/* Starts the command of console->line, if it is one of these: 0, or the number of the error that it
 * ends with. */
uint8_t cmd_keeper_begin(struct console *console);

/* Called whenever a piece of its reply may be written, until it returns false. An error is left in
 * console->error. */
bool cmd_keeper_poll(struct console *console);

/* In each turn of the main loop: writes a piece of what is told unasked, if there is something to
 * tell and the console is idle. */
void cmd_keeper_tell(struct console *console);

#endif
