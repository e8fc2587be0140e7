/* SPDX-License-Identifier: MIT */
/* One word of a console line; see token.h. */
#include "console/token.h"

void token_add(struct token *token, char c)
{
    if (token->length < TOKEN_MAX)
        token->text[token->length] = c;
    if (token->length <= TOKEN_MAX)
        token->length++;
}
