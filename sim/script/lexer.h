/* Words and numbers of a line of plain text. */
#ifndef SIM_LEXER_H
#define SIM_LEXER_H

#include <stdbool.h>
#include <stdint.h>

/* Without the space around it; cuts `text` in place. */
char *words_trim(char *text);

/* Cuts `text` in place into words; returns how many, room + 1 when there are more than `room`. */
unsigned words_split(char *text, char *word[], unsigned room);

/* Cuts `text` behind its first word; returns what follows, trimmed, or "". */
char *words_rest(char *text);

/* A whole number, decimal or 0x..., within the bounds; or one with decimals, in units of 1/scale.
 */
bool words_number(const char *text, int32_t lowest, int32_t highest, int32_t *value);
bool words_decimal(const char *text, int32_t scale, int32_t lowest, int32_t highest,
                   int32_t *value);

/* "on" or "off". */
bool words_switch(const char *text, bool *on);

/* One byte of a packet as it is written in a scenario: FF, .. for any, FF! with a framing error. */
struct words_byte {
    uint8_t byte;
    bool any;
    bool framing_error;
};

/* Takes the next byte off `text`. False at the end, and when it is none: then *text is not "". */
bool words_byte(const char **text, struct words_byte *byte);

#endif
