/* SPDX-License-Identifier: MIT */
#include "script/lexer.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static bool is_space(char c)
{
    return isspace((unsigned char)c);
}

char *lexer_trim(char *text)
{
    while (is_space(*text)) {
        text++;
    }
    size_t size = strlen(text);
    while (size && is_space(text[size - 1])) {
        text[--size] = 0;
    }
    return text;
}

char *lexer_rest(char *text)
{
    while (*text && !is_space(*text)) {
        text++;
    }
    if (!*text) {
        return text;
    }
    *text = 0;
    return lexer_trim(text + 1);
}

size_t lexer_count_lines(const char *text)
{
    size_t lines = 1;
    for (; *text; text++) {
        lines += *text == '\n';
    }
    return lines;
}

char *lexer_next_line(char **text, unsigned *number)
{
    while (*text) {
        char *line = *text;
        *text = strchr(line, '\n');
        if (*text) {
            *(*text)++ = 0;
        }
        ++*number;
        line = lexer_trim(line);
        if (*line && *line != '#') {
            return line;
        }
    }
    return 0;
}

unsigned lexer_split(char *text, char *word[], unsigned capacity)
{
    unsigned count = 0;
    for (text = lexer_trim(text); *text; count++) {
        if (count == capacity) {
            return capacity + 1;
        }
        word[count] = text;
        text = lexer_rest(text);
    }
    return count;
}

bool lexer_number(const char *text, int32_t lowest, int32_t highest, int32_t *value)
{
    bool minus = *text == '-';
    const char *digits = text + minus;
    bool hexadecimal = digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X');
    digits += hexadecimal ? 2 : 0;
    char *end = 0;
    unsigned long number = strtoul(digits, &end, hexadecimal ? 16 : 10);
    if (!isxdigit((unsigned char)*digits) || *end || number > INT32_MAX) {
        return false;
    }
    *value = minus ? -(int32_t)number : (int32_t)number;
    return *value >= lowest && *value <= highest;
}

bool lexer_decimal(const char *text, int32_t scale, int32_t lowest, int32_t highest, int32_t *value)
{
    char whole[16] = "";
    const char *point = strchr(text, '.');
    size_t size = point ? (size_t)(point - text) : strlen(text);
    int32_t number = 0;
    if (size >= sizeof(whole) || strchr(text, 'x') || strchr(text, 'X')) {
        return false;
    }
    memcpy(whole, text, size);
    if (!lexer_number(whole, -INT32_MAX / scale + 1, INT32_MAX / scale - 1, &number)) {
        return false;
    }
    int32_t fraction = 0;
    int32_t weight = scale;
    for (const char *c = point ? point + 1 : ""; *c; c++) {
        weight /= 10;
        if (!isdigit((unsigned char)*c) || weight == 0) {
            return false;
        }
        fraction += (*c - '0') * weight;
    }
    *value = number * scale + (text[0] == '-' ? -fraction : fraction);
    return (!point || point[1]) && *value >= lowest && *value <= highest;
}

bool lexer_within(char *text, int32_t highest, uint32_t *ms)
{
    char *within = 0;
    int32_t number = 0;
    for (char *at = strstr(text, " within "); at; at = strstr(at + 1, " within ")) {
        within = at;
    }
    if (!within || !lexer_number(lexer_trim(within + strlen(" within ")), 0, highest, &number)) {
        return false;
    }
    *within = 0;
    lexer_trim(text);
    *ms = (uint32_t)number;
    return true;
}

bool lexer_switch(const char *text, bool *on)
{
    *on = strcmp(text, "on") == 0;
    return *on || strcmp(text, "off") == 0;
}

static int digit(char c)
{
    return isdigit((unsigned char)c) ? c - '0' : tolower((unsigned char)c) - 'a' + 10;
}

bool lexer_byte(const char **text, struct lexer_byte *byte)
{
    const char *c = *text;
    while (is_space(*c)) {
        c++;
    }
    *text = c;
    *byte = (struct lexer_byte){.any = c[0] == '.' && c[1] == '.'};
    if (!byte->any && !(isxdigit((unsigned char)c[0]) && isxdigit((unsigned char)c[1]))) {
        return false;
    }
    byte->byte = (uint8_t)(byte->any ? 0 : digit(c[0]) << 4 | digit(c[1]));
    byte->framing_error = !byte->any && c[2] == '!';
    *text = c + 2 + byte->framing_error;
    return true;
}
