/* One word of a console line. */
#ifndef CONTROLLER_LEXER_H
#define CONTROLLER_LEXER_H

#include <stdint.h>

#define TOKEN_MAX 23 // characters; the longest register name has 22

struct token {
    uint8_t length; // TOKEN_MAX + 1: longer than any word we know
    char text[TOKEN_MAX];
};

void lexer_add(struct token *token, char c);

#endif
