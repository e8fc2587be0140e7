/* SPDX-License-Identifier: MIT */
/* Splits a line of text into words and numbers. */
#ifndef SIM_LEXER_H
#define SIM_LEXER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Returns `text` without the space around it. Cuts it in place. */
char *lexer_trim(char *text);

/* Returns the number of lines, with empty ones and comments. */
size_t lexer_count_lines(const char *text);

/* Cuts the next line off `*text` in place and counts `number` up for each line of the text. Returns
 * the line, trimmed, without empty lines and lines that begin with #, or 0 at the end of the text.
 */
char *lexer_next_line(char **text, unsigned *number);

/* Cuts `text` in place into words. Returns their number, or capacity + 1 if there are more than
 * `capacity`. */
unsigned lexer_split(char *text, char *word[], unsigned capacity);

/* Cuts `text` after its first word. Returns what follows the word, trimmed, or "". */
char *lexer_rest(char *text);

/* Parse a whole number, decimal or 0x..., or a number with decimals in units of 1/scale. Return
 * false if it is outside the bounds. */
bool lexer_number(const char *text, int32_t lowest, int32_t highest, int32_t *value);
bool lexer_decimal(const char *text, int32_t scale, int32_t lowest, int32_t highest,
                   int32_t *value);

/* Cuts `within MS` off the end of `text` and stores MS. Returns false, without a change, if the
 * text does not end so, or if MS is above `highest`. */
bool lexer_within(char *text, int32_t highest, uint32_t *ms);

/* Parses "on" or "off". */
bool lexer_switch(const char *text, bool *on);

/* One byte of a packet in a scenario: FF; .. for any byte; FF! for a byte with a framing error. */
struct lexer_byte {
    uint8_t byte;
    bool any;
    bool framing_error;
};

/* Parses the next byte and moves `text` past it. Returns false at the end, and at text that is no
 * byte: then *text is not "". */
bool lexer_byte(const char **text, struct lexer_byte *byte);

#endif
