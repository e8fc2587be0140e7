/* Words and numbers of a line of plain text. */
#ifndef SIM_LEXER_H
#define SIM_LEXER_H

#include <stdbool.h>
#include <stdint.h>

/* Without the space around it; cuts `text` in place. */
char *lexer_trim(char *text);

/* Cuts `text` in place into words; returns how many, room + 1 when there are more than `room`. */
unsigned lexer_split(char *text, char *word[], unsigned capacity);

/* Cuts `text` behind its first word; returns what follows, trimmed, or "". */
char *lexer_rest(char *text);

/* A whole number, decimal or 0x..., within the bounds; or one with decimals, in units of 1/scale.
 */
bool lexer_number(const char *text, int32_t lowest, int32_t highest, int32_t *value);
bool lexer_decimal(const char *text, int32_t scale, int32_t lowest, int32_t highest,
                   int32_t *value);

/* "on" or "off". */
bool lexer_switch(const char *text, bool *on);

/* One byte of a packet as it is written in a scenario: FF, .. for any, FF! with a framing error. */
struct lexer_byte {
    uint8_t byte;
    bool any;
    bool framing_error;
};

/* Takes the next byte off `text`. False at the end, and when it is none: then *text is not "". */
bool lexer_byte(const char **text, struct lexer_byte *byte);

#endif
