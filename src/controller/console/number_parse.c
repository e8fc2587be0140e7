/* SPDX-License-Identifier: MIT */
/* Numbers with units, as they are typed; see number_parse.h. */
#include "console/number_parse.h"

#include <stdbool.h>

#include "console/errors.h"
#include "console/unit_names.h" // unit_shown[]

struct unit_name {
    char text[5];
    uint8_t kind;     // enum number_kind
    uint8_t exponent; // power of ten of the library's unit
};

/* Compared without regard to case: M means milli, but in Mbps mega. */
static const CDS_FLASH struct unit_name unit_names[] = {
    {"raw", NUMBER_RAW, 0},       {"deg", NUMBER_ANGLE, 3},
    {"mdeg", NUMBER_ANGLE, 0},    {"rpm", NUMBER_SPEED, 3},
    {"mrpm", NUMBER_SPEED, 0},    {"v", NUMBER_VOLTAGE, 3},
    {"mv", NUMBER_VOLTAGE, 0},    {"%", NUMBER_SHARE, 2},
    {"c", NUMBER_TEMPERATURE, 0}, {"us", NUMBER_TIME, 0},
    {"ms", NUMBER_TIME, 3},       {"s", NUMBER_TIME, 6},
    {"bps", NUMBER_RATE, 0},      {"kbps", NUMBER_RATE, 3},
    {"mbps", NUMBER_RATE, 6},     {"k", NUMBER_RATE, 3},
    {"m", NUMBER_RATE, 6},        {"\xC2\xB0", NUMBER_ANGLE, 3}, // degree sign
};

#define UNITS (sizeof unit_names / sizeof unit_names[0])

/* The value of a digit in `base`, or `base` if it is none. */
static uint8_t digit_value(char c, uint8_t base)
{
    uint8_t value = base;

    if (c >= '0' && c <= '9')
        value = (uint8_t)(c - '0');
    else if ((c | 0x20) >= 'a' && (c | 0x20) <= 'f')
        value = (uint8_t)((c | 0x20) - 'a' + 10);
    return value < base ? value : base;
}

/* A digit more; false when that exceeds 31 bits. */
static bool append(int32_t *digits, uint8_t base, uint8_t digit)
{
    uint32_t value;

    if (*digits > INT32_MAX / 10) // so digits * 16 + 15 fits 32 bits
        return false;
    value = (uint32_t)*digits * base + digit;
    if (value > INT32_MAX)
        return false;
    *digits = (int32_t)value;
    return true;
}

static bool is_unit(const char *from, const char *end, const CDS_FLASH char *name)
{
    for (; from < end; from++, name++) {
        char c = *from;

        if (c >= 'A' && c <= 'Z')
            c = (char)(c | 0x20);
        if (*name == '\0' || c != *name) // a NUL that was typed is not the end of the name
            return false;
    }
    return *name == '\0';
}

/* The unit at the end of the word, if there is one. */
static uint8_t take_unit(const char *from, const char *end, struct number *number)
{
    const CDS_FLASH struct unit_name *name = unit_names;

    if (from == end)
        return 0;
    for (uint8_t left = UNITS; left; left--, name++) {
        if (is_unit(from, end, name->text)) {
            number->kind = name->kind;
            number->exponent = name->exponent;
            return 0;
        }
    }
    return ERROR_UNIT;
}

const CDS_FLASH char *number_unit_name(const struct number *number)
{
    static const CDS_FLASH char none[] = "";

    for (uint8_t i = 0; i <= CDS_UNIT_BPS; i++) // these have their capitals
        if (unit_shown[i].kind == number->kind && unit_shown[i].exponent == number->exponent)
            return unit_shown[i].text;
    for (uint8_t i = 0; i < UNITS; i++)
        if (unit_names[i].kind == number->kind && unit_names[i].exponent == number->exponent)
            return unit_names[i].text;
    return none;
}

/* Digits and at most one point, and where they end; *error: 0, or why it is no number. */
static const char *take_digits(const char *at, const char *end, uint8_t base, struct number *number,
                               uint8_t *error)
{
    const char *begin = at;
    bool point = false;

    *error = 0;
    for (; at < end; at++) {
        uint8_t digit = digit_value(*at, base);

        if (*at == '.' && base == 10 && !point && at > begin)
            point = true;
        else if (digit == base)
            break;
        else if (!append(&number->digits, base, digit))
            *error = ERROR_OUT_OF_RANGE;
        else
            number->decimals = (uint8_t)(number->decimals + point);
    }
    if (at == begin || at[-1] == '.')
        *error = ERROR_NOT_A_NUMBER;
    return at;
}

uint8_t number_parse(const struct token *token, struct number *number)
{
    const char *at = token->text, *end;
    bool minus = token->length && *at == '-';
    bool hex = token->length > 2 && *at == '0' && (at[1] | 0x20) == 'x';
    uint8_t error, unit_error;

    *number = (struct number){.kind = NUMBER_BARE};
    if (token->length > TOKEN_MAX)
        return ERROR_NOT_A_NUMBER;
    end = at + token->length;
    at = take_digits(at + (hex ? 2 : minus), end, hex ? 16 : 10, number, &error);
    unit_error = take_unit(at, end, number);
    if (minus)
        number->digits = -number->digits;
    if (error == ERROR_NOT_A_NUMBER || (hex && unit_error))
        return ERROR_NOT_A_NUMBER;
    return unit_error ? unit_error : error;
}

uint8_t number_whole(const struct token *token, uint16_t highest, uint16_t *value)
{
    struct number number;
    uint8_t error = number_parse(token, &number);

    if (error)
        return error == ERROR_UNIT ? ERROR_NOT_A_NUMBER : error;
    if (number.kind != NUMBER_BARE || number.decimals)
        return ERROR_NOT_A_NUMBER;
    if (number.digits < 0 || number.digits > highest)
        return ERROR_OUT_OF_RANGE;
    *value = (uint16_t)number.digits;
    return 0;
}

/* In the library's unit: digits * 10^(exponent - decimals). */
static uint8_t scaled(const struct number *number, uint8_t exponent, int32_t *value)
{
    uint8_t steps;

    if (number->decimals > exponent)
        return ERROR_NOT_A_NUMBER;
    *value = number->digits;
    for (steps = (uint8_t)(exponent - number->decimals); steps; steps--) {
        if (*value > INT32_MAX / 10 || *value < -(INT32_MAX / 10))
            return ERROR_OUT_OF_RANGE;
        *value *= 10;
    }
    return 0;
}

/* A number of this kind, in the library's unit; `exponent`: what a bare one means. */
static uint8_t value_of(const struct number *number, uint8_t kind, uint8_t exponent, int32_t *value)
{
    if (number->kind != NUMBER_BARE && number->kind != kind)
        return ERROR_UNIT;
    return scaled(number, number->kind == NUMBER_BARE ? exponent : number->exponent, value);
}

/* True if a baud register is within 3 % of `bps`. */
static bool is_near(int32_t bps)
{
    uint8_t baud;
    int16_t error;

    return cds_units_baud(bps, &baud, &error) == CDS_OK && error <= CDS_BAUD_ERROR_MAX_PERMILLE &&
           error >= -CDS_BAUD_ERROR_MAX_PERMILLE;
}

uint8_t number_register(const struct number *number, enum cds_unit unit, uint16_t *raw)
{
    bool is_raw = number->kind == NUMBER_RAW || unit == CDS_UNIT_NONE;
    int32_t value;
    uint8_t error =
        is_raw ? value_of(number, NUMBER_RAW, 0, &value)
               : value_of(number, unit_shown[unit].kind, unit_shown[unit].exponent, &value);

    if (error)
        return error;
    if (is_raw) {
        if (value < 0 || value > UINT16_MAX)
            return ERROR_OUT_OF_RANGE;
        *raw = (uint16_t)value;
        return 0;
    }
    if (unit == CDS_UNIT_BPS && !is_near(value))
        return ERROR_OUT_OF_RANGE;
    return cds_units_to_register(&cds_profile_cds55xx, unit, value, raw) == CDS_OK
               ? 0
               : ERROR_OUT_OF_RANGE;
}

uint8_t number_within(const struct number *number, enum cds_unit unit, uint16_t *raw)
{
    int32_t value;
    uint8_t error = number_register(number, unit, raw);

    if (error == 0 && cds_units_from_register(&cds_profile_cds55xx, unit, *raw, &value) != CDS_OK)
        error = ERROR_OUT_OF_RANGE;
    return error;
}

uint8_t number_us(const struct number *number, uint32_t highest, uint32_t *us)
{
    int32_t value;
    uint8_t error = value_of(number, NUMBER_TIME, 3, &value);

    if (error)
        return error;
    *us = (uint32_t)value;
    return value < 0 || *us > highest ? (uint8_t)ERROR_OUT_OF_RANGE : 0;
}

uint8_t number_ms(const struct number *number, uint32_t highest, uint32_t *ms)
{
    uint32_t us = 0;
    uint8_t error = number_us(number, highest * 1000, &us);

    if (error)
        return error;
    *ms = us / 1000;
    return *ms * 1000 == us ? 0 : (uint8_t)ERROR_NOT_A_NUMBER;
}

uint8_t number_percent(const struct number *number, uint8_t *percent)
{
    int32_t share;
    uint8_t error = value_of(number, NUMBER_SHARE, 2, &share);

    if (error)
        return error;
    if (share < 0 || share > UINT8_MAX * 100L)
        return ERROR_OUT_OF_RANGE;
    *percent = (uint8_t)(share / 100);
    return *percent * 100 == share ? 0 : (uint8_t)ERROR_NOT_A_NUMBER;
}
