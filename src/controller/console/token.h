/* SPDX-License-Identifier: MIT */
/* One word of a console line. */
#ifndef CONTROLLER_TOKEN_H
#define CONTROLLER_TOKEN_H

#include <stdint.h>

#define TOKEN_MAX 23 // characters; the longest register name has 22

struct token {
    uint8_t length; // TOKEN_MAX + 1: longer than any known word
    char text[TOKEN_MAX];
};

/* Adds a character. A word of more than TOKEN_MAX characters keeps its first TOKEN_MAX. */
void token_add(struct token *token, char c);

#endif
