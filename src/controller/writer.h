/* Text for the PC, into a ring that empties at its own pace. Nothing waits: whoever writes asks
 * first whether there is room (writer_ready()), writes a short piece, and comes back later. */
#ifndef CONTROLLER_WRITER_H
#define CONTROLLER_WRITER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring
#include "flash.h"        // CDS_FLASH

/* Characters a piece may have, end of line included, besides one text out of flash, which may be of
 * any length. */
#define WRITER_PIECE 58

/* A packed text has bytes of 0x80 and above, and below 0x20, which stand for two bytes each:
 * scripts/texts.py. This deep within each other at most. */
#define WRITER_DEPTH 6

struct writer {
    struct cds_ring *ring;
    uint8_t depth;              // of `rest`
    uint8_t rest[WRITER_DEPTH]; // of the packed byte under way, the last one first
    const CDS_FLASH char *text; // what is left of the text being written, or NULL
    bool within;                // a line has begun
};

/* Writes on what is left; true when a new piece may be written. */
bool writer_ready(struct writer *writer);

/* The parts of a piece. Numbers: decimal, or two hexadecimal digits. */
void writer_char(struct writer *writer, char c);
void writer_string(struct writer *writer, const char *string);
void writer_decimal(struct writer *writer, uint16_t number);
void writer_hex(struct writer *writer, uint8_t byte);

/* A text out of flash, not packed, counted as part of the piece; and one that is written where it
 * is said. */
void writer_flash(struct writer *writer, const CDS_FLASH char *text);
#define WRITER_TEXT(writer, literal)                                                               \
    do {                                                                                           \
        static const CDS_FLASH char text_[] = literal;                                             \
        writer_flash(writer, text_);                                                               \
    } while (0)

/* value / 10^decimals (0 to 3), without zeros at the end: "-3.5". At most 12 characters. */
void writer_fixed(struct writer *writer, int32_t value, uint8_t decimals);

/* The last part of a piece: the end of the line; or a text out of flash, packed or not, and the
 * end of the line, which follow as the ring empties. */
void writer_end_of_line(struct writer *writer);
void writer_text_line(struct writer *writer, const CDS_FLASH char *text);

#endif
