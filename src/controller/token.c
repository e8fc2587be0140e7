/* One word of a console line; see token.h. */
#include "token.h"

void token_add(struct token *token, char c)
{
    if (token->length < TOKEN_MAX)
        token->text[token->length] = c;
    if (token->length <= TOKEN_MAX)
        token->length++;
}

/* The value of a digit in `base`, or `base` if it is none. */
static uint8_t digit_value(char c, uint8_t base)
{
    uint8_t value = base;

    if (c >= '0' && c <= '9')
        value = (uint8_t)(c - '0');
    else if (c >= 'a' && c <= 'f')
        value = (uint8_t)(c - 'a' + 10);
    else if (c >= 'A' && c <= 'F')
        value = (uint8_t)(c - 'A' + 10);
    return value < base ? value : base;
}

bool token_number(const struct token *token, uint16_t *value, bool *too_large)
{
    bool hex = token->length > 2 && token->text[0] == '0' && (token->text[1] | 0x20) == 'x';
    uint8_t base = hex ? 16 : 10;
    uint32_t number = 0;

    *too_large = false;
    if (token->length == 0 || token->length > TOKEN_MAX)
        return false;
    for (uint8_t i = hex ? 2 : 0; i < token->length; i++) {
        uint8_t digit = digit_value(token->text[i], base);

        if (digit == base)
            return false;
        number = number * base + digit;
        if (number > UINT16_MAX) {
            *too_large = true;
            number = UINT16_MAX;
        }
    }
    *value = (uint16_t)number;
    return true;
}
