/* SPDX-License-Identifier: MIT */
/* Numbers as people write them, with a unit or without: 90, 90.5deg, 512raw, 0x200, -30rpm, 6.0V.
 * Whole numbers throughout: the decimals are a power of ten. */
#ifndef CONTROLLER_NUMBER_PARSE_H
#define CONTROLLER_NUMBER_PARSE_H

#include <stdint.h>

#include "cds55xx/units.h" // enum cds_unit
#include "console/token.h" // struct token
#include "flash.h"         // CDS_FLASH

/* What is counted, if it was said. */
enum number_kind {
    NUMBER_BARE, // no unit
    NUMBER_RAW,  // as the register has it
    NUMBER_ANGLE,
    NUMBER_SPEED,
    NUMBER_VOLTAGE,
    NUMBER_SHARE,
    NUMBER_TEMPERATURE,
    NUMBER_TIME,
    NUMBER_RATE,
} __attribute__((packed));

/* digits / 10^decimals * 10^exponent, in millidegrees, mRPM, mV, 0.01 %, degrees Celsius,
 * microseconds or bit/s. */
struct number {
    int32_t digits;
    uint8_t decimals;
    uint8_t kind;     // enum number_kind
    uint8_t exponent; // of its unit; of a bare one 0
};

/* The number that `token` is: 0 and *number; else ERROR_NOT_A_NUMBER, ERROR_UNIT or
 * ERROR_OUT_OF_RANGE (of 32 bits), and *number is not to be used. */
uint8_t number_parse(const struct token *token, struct number *number);

/* The name of the number's unit: "deg", or "" of a bare number. */
const CDS_FLASH char *number_unit_name(const struct number *number);

/* A bare whole number from 0 to `highest`, for IDs, bytes and lengths: 0 and *value; else
 * ERROR_NOT_A_NUMBER or ERROR_OUT_OF_RANGE. */
uint8_t number_whole(const struct token *token, uint16_t highest, uint16_t *value);

/* The register value of `unit` that is nearest; a bare number is in the unit that number_print()
 * shows. 0 and *raw; else ERROR_UNIT: it has another one; ERROR_NOT_A_NUMBER: more decimals than
 * the unit has; ERROR_OUT_OF_RANGE. */
uint8_t number_register(const struct number *number, enum cds_unit unit, uint16_t *raw);

/* number_register(); a raw value that no register of that unit holds is ERROR_OUT_OF_RANGE, too. */
uint8_t number_within(const struct number *number, enum cds_unit unit, uint16_t *raw);

/* A share in percent, 0 to 255, which a bare number is: 0 and *percent; else as number_register().
 */
uint8_t number_percent(const struct number *number, uint8_t *percent);

/* A time in microseconds from 0 to `highest`, at most 2 000 000 000; a bare number is milliseconds.
 * Returns 0 and stores *us, or returns an error as number_register() does. */
uint8_t number_us(const struct number *number, uint32_t highest, uint32_t *us);

/* A time in whole milliseconds, which a bare number is, from 0 to `highest`, at most 2 000 000.
 * Returns 0 and stores *ms, or returns an error as number_register() does. */
uint8_t number_ms(const struct number *number, uint32_t highest, uint32_t *ms);

#endif
