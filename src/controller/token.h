/* One word of a console line, and the number it may be. */
#ifndef CONTROLLER_TOKEN_H
#define CONTROLLER_TOKEN_H

#include <stdbool.h>
#include <stdint.h>

#define TOKEN_MAX 23 // characters; the longest register name has 22

struct token {
    uint8_t length; // TOKEN_MAX + 1: longer than any word we know
    char text[TOKEN_MAX];
};

void token_add(struct token *token, char c);

/* Decimal, or 0x and hexadecimal digits, 0 to 65535. True and *value, or false if it is no number;
 * a number above 65535 gives UINT16_MAX and *too_large. */
bool token_number(const struct token *token, uint16_t *value, bool *too_large);

#endif
