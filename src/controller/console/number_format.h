/* SPDX-License-Identifier: MIT */
/* Values of registers as people read them: 150.147deg, -3.5rpm, 6.5V, 32C. */
#ifndef CONTROLLER_NUMBER_FORMAT_H
#define CONTROLLER_NUMBER_FORMAT_H

#include <stdint.h>

#include "cds55xx/units.h"   // enum cds_unit
#include "console/printer.h" // struct printer

/* Prints the value of a register in its unit, "150.147deg", "-3.5rpm", "6.5V", "32C": at most 14
 * characters. A value that the unit does not have: "?". */
void number_print(struct printer *printer, enum cds_unit unit, uint16_t raw);

/* number_print() without the unit's name, for programs that read it. */
void number_print_bare(struct printer *printer, enum cds_unit unit, uint16_t raw);

/* Prints "GOAL_POSITION = ", at most 25 characters, of the register at `address`. */
void number_print_name(struct printer *printer, uint8_t address);

#endif
