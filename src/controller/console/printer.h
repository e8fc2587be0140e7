/* SPDX-License-Identifier: MIT */
/* Text for the PC, into a ring that empties at its own pace. Nothing waits: a caller asks first
 * whether there is room (printer_ready()), prints a short piece, and comes back later.
 *
 * A message is a string in flash. These conversions in it print the printer's values, in order:
 *   %u  a number              %s  another message, whose values, if it has any, are the next ones
 *   %l  two numbers: 32 bits, low word first, shown up to 2 147 483 647
 *   %a %r %v %c %b  a register's angle, signed speed, voltage, temperature, baud rate, with unit
 *   %i  the ID of printer_set_id(), else the word "ID"; only on chips with room: write SERVO_ID
 *   %m  the command of printer_set_command(), else the word "COMMAND": write COMMAND_NAME
 *   %x %n  only on chips with room: an address as 0x1E, and the name of the register at an address
 * A % before any other character is printed. */
#ifndef CONTROLLER_PRINTER_H
#define CONTROLLER_PRINTER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring
#include "flash.h"        // CDS_FLASH

/* In a message: the ID of its servo where the flash has room for the conversion %i, else the word
 * "ID"; and the name of its command for the conversion %m, else the word "COMMAND". */
#ifdef __AVR__
#include <avr/io.h> // FLASHEND
#define PRINTER_HAS_ROOM (FLASHEND > 0x1FFFF)
#else
#define PRINTER_HAS_ROOM 1
#endif
#if PRINTER_HAS_ROOM
#define SERVO_ID     "%i"
#define COMMAND_NAME "%m"
#else
#define SERVO_ID     "ID"
#define COMMAND_NAME "COMMAND"
#endif

/* Characters a piece may have, end of line included, besides one message of any length. */
#define PRINTER_PIECE 58

#define PRINTER_VALUES 6 // of a message and of those that stand in it

union printer_value {
    uint16_t number;
    const CDS_FLASH char *text;
};

struct printer {
    struct cds_ring *ring;
    const CDS_FLASH char *text;  // what remains of the message being printed, or NULL
    const CDS_FLASH char *outer; // what remains of the message that has `text` in it, or NULL
    bool ends;                   // the message is the end of its line
    bool within;                 // a line has begun
    uint8_t next;                // index of the next value
#if PRINTER_HAS_ROOM
    uint16_t id_for_remedy;                   // what %i prints, plus 1; 0: the word "ID"
    const CDS_FLASH char *command_for_remedy; // %m prints its first word; NULL: the word "COMMAND"
#endif
    union printer_value values[PRINTER_VALUES];
};

/* Prints on; true when a new piece may be printed. */
bool printer_ready(struct printer *printer);

/* `id`, 0 to 253, is what %i prints until the end of the message, so that a remedy can be typed as
 * it stands. A larger number: %i prints the word "ID". Without %i it does nothing. */
#if PRINTER_HAS_ROOM
void printer_set_id(struct printer *printer, uint8_t id);

/* Until the end of the message %m prints the first word of `usage`; NULL: the word "COMMAND". */
void printer_set_command(struct printer *printer, const CDS_FLASH char *usage);
#else
static inline void printer_set_id(struct printer *printer, uint8_t id)
{
    (void)printer;
    (void)id;
}

static inline void printer_set_command(struct printer *printer, const CDS_FLASH char *usage)
{
    (void)printer;
    (void)usage;
}
#endif

/* The parts of a piece. Numbers: decimal, or two hexadecimal digits. */
void printer_char(struct printer *printer, char c);
void printer_string(struct printer *printer, const char *string);
void printer_decimal(struct printer *printer, uint16_t number);
void printer_hex(struct printer *printer, uint8_t byte);

/* Characters out of flash, up to a NUL, as they are. */
void printer_flash(struct printer *printer, const CDS_FLASH char *text);

/* A character that was typed, or '?' for a control character or a byte from 0x7F on, which a
 * terminal may obey. */
void printer_typed_char(struct printer *printer, char c);

/* " = ", and "0x1E". */
void printer_equals(struct printer *printer);
void printer_address(struct printer *printer, uint8_t address);

/* value / 10^decimals (0 to 3), without zeros at the end: "-3.5". At most 12 characters. */
void printer_fixed(struct printer *printer, int32_t value, uint8_t decimals);

/* The last part of a piece: the end of the line; or a message; or a message and the end of the
 * line. A message follows as the ring empties; its values must be set before. */
void printer_end_of_line(struct printer *printer);
void printer_text(struct printer *printer, const CDS_FLASH char *message);
void printer_line(struct printer *printer, const CDS_FLASH char *message);

#endif
