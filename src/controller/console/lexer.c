/* One word of a console line; see lexer.h. */
#include "console/lexer.h"

void lexer_add(struct token *token, char c)
{
    if (token->length < TOKEN_MAX)
        token->text[token->length] = c;
    if (token->length <= TOKEN_MAX)
        token->length++;
}
