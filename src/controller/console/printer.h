/* Text for the PC, into a ring that empties at its own pace. Nothing waits: whoever writes asks
 * first whether there is room (printer_ready()), writes a short piece, and comes back later. */
#ifndef CONTROLLER_PRINTER_H
#define CONTROLLER_PRINTER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring
#include "flash.h"        // CDS_FLASH

/* Characters a piece may have, end of line included, besides one text, which may be of any length.
 */
#define PRINTER_PIECE 58

/* Pairs within pairs of a packed text: scripts/texts.py. */
#define PRINTER_DEPTH 6

#define PRINTER_VALUES 6 // for the marks of a text, and of those that stand in it

struct printer {
    struct cds_ring *ring;
    const CDS_FLASH uint8_t *text;   // what is left of the text being written, or NULL
    const CDS_FLASH uint8_t *outer;  // ... of the one that it stands in
    uint8_t left, outer_left;        // bytes of both
    uint8_t depth;                   // of `rest`
    uint8_t rest[PRINTER_DEPTH];     // of the pair under way, the last code first
    bool ends;                       // the text is the end of its line
    bool within;                     // a line has begun
    uint8_t next;                    // of `values`
    uint16_t values[PRINTER_VALUES]; // what the marks of a text stand for, in their order
};

/* Writes on what is left; true when a new piece may be written. */
bool printer_ready(struct printer *printer);

/* The parts of a piece. Numbers: decimal, or two hexadecimal digits. */
void printer_char(struct printer *printer, char c);
void printer_string(struct printer *printer, const char *string);
void printer_decimal(struct printer *printer, uint16_t number);
void printer_hex(struct printer *printer, uint8_t byte);

/* Characters out of flash, up to a NUL. */
void printer_flash(struct printer *printer, const CDS_FLASH char *text);

/* " = ", and "0x1E". */
void printer_equals(struct printer *printer);
void printer_address(struct printer *printer, uint8_t address);

/* value / 10^decimals (0 to 3), without zeros at the end: "-3.5". At most 12 characters. */
void printer_fixed(struct printer *printer, int32_t value, uint8_t decimals);

/* The last part of a piece: the end of the line; or a text, TEXT_... of texts.h, or a text and the
 * end of the line, which follow as the ring empties. Where the text has marks (sentences.h), the
 * printer's values are to be set before. */
void printer_end_of_line(struct printer *printer);
void printer_text(struct printer *printer, uint16_t text);
void printer_line(struct printer *printer, uint16_t text);

/* The text `index` places behind `text`, and that as a line. */
uint16_t printer_text_at(uint16_t text, uint8_t index);
void printer_line_at(struct printer *printer, uint16_t text, uint8_t index);

#endif
