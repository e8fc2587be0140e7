/* SPDX-License-Identifier: MIT */
/* The end of every reply of the console: warnings, and `ok` or `error`. */
#ifndef CONTROLLER_REPLY_H
#define CONTROLLER_REPLY_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h" // CDS_FLASH

struct console;
struct printer;

/* Prints "servo 3". */
void reply_print_servo(struct printer *printer, uint8_t id);

/* Prints the next piece of the end; the printer must be ready. False when the reply is complete. */
bool reply_piece(struct console *console);

/* Prints a warning for one condition of console->servo_error, and clears its bit; names the servo
 * of a list. The printer must be ready. False: none is left. */
bool reply_warn(struct console *console);

/* Conditions: 0 to 6 are the numbers of the CDS_ERROR_* bits. */
#define REPLY_TORQUE_LOST 7 // the servo has switched its torque off by itself
#define REPLY_OFFLINE     8
#define REPLY_CONDITIONS  9

/* The name of each condition. */
extern const CDS_FLASH char *const CDS_FLASH reply_conditions[];

/* The number of the lowest of `bits`, which are not 0. */
uint8_t reply_condition(uint8_t bits);

/* The error whose remedy helps against the condition. */
uint8_t reply_remedy_error(uint8_t condition);

/* The remedy for a condition, with "; " in front. Returns "" in a firmware profile whose errors
 * have no remedies. */
const CDS_FLASH char *reply_remedy(uint8_t condition);

#endif
