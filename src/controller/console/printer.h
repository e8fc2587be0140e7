/* Text for the PC, into a ring that empties at its own pace. Nothing waits: whoever writes asks
 * first whether there is room (writer_ready()), writes a short piece, and comes back later. */
#ifndef CONTROLLER_WRITER_H
#define CONTROLLER_WRITER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring
#include "flash.h"        // CDS_FLASH

/* Characters a piece may have, end of line included, besides one text, which may be of any length.
 */
#define WRITER_PIECE 58

/* Pairs within pairs of a packed text: scripts/texts.py. */
#define WRITER_DEPTH 6

#define WRITER_VALUES 6 // for the marks of a text, and of those that stand in it

struct writer {
    struct cds_ring *ring;
    const CDS_FLASH uint8_t *text;  // what is left of the text being written, or NULL
    const CDS_FLASH uint8_t *outer; // ... of the one that it stands in
    uint8_t left, outer_left;       // bytes of both
    uint8_t depth;                  // of `rest`
    uint8_t rest[WRITER_DEPTH];     // of the pair under way, the last code first
    bool ends;                      // the text is the end of its line
    bool within;                    // a line has begun
    uint8_t next;                   // of `values`
    uint16_t values[WRITER_VALUES]; // what the marks of a text stand for, in their order
};

/* Writes on what is left; true when a new piece may be written. */
bool writer_ready(struct writer *writer);

/* The parts of a piece. Numbers: decimal, or two hexadecimal digits. */
void writer_char(struct writer *writer, char c);
void writer_string(struct writer *writer, const char *string);
void writer_decimal(struct writer *writer, uint16_t number);
void writer_hex(struct writer *writer, uint8_t byte);

/* Characters out of flash, up to a NUL. */
void writer_flash(struct writer *writer, const CDS_FLASH char *text);

/* " = ", and "0x1E". */
void writer_equals(struct writer *writer);
void writer_address(struct writer *writer, uint8_t address);

/* value / 10^decimals (0 to 3), without zeros at the end: "-3.5". At most 12 characters. */
void writer_fixed(struct writer *writer, int32_t value, uint8_t decimals);

/* The last part of a piece: the end of the line; or a text, TEXT_... of texts.h, or a text and the
 * end of the line, which follow as the ring empties. Where the text has marks (sentences.h), the
 * writer's values are to be set before. */
void writer_end_of_line(struct writer *writer);
void writer_text(struct writer *writer, uint16_t text);
void writer_line(struct writer *writer, uint16_t text);

/* The text `index` places behind `text`, and that as a line. */
uint16_t writer_text_at(uint16_t text, uint8_t index);
void writer_line_at(struct writer *writer, uint16_t text, uint8_t index);

#endif
