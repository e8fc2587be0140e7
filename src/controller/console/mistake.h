/* SPDX-License-Identifier: MIT */
/* Mistakes in a line and causes of an error that are easy to see. Their text stands in place of
 * that of the error:
 *
 *     error 39: servo 1: ANGLE '90,5': write a point, not a comma: 90.5 */
#ifndef CONTROLLER_MISTAKE_H
#define CONTROLLER_MISTAKE_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h" // CDS_FLASH

struct console;

enum mistake {
    MISTAKE_NONE,
    MISTAKE_LIST,     // a list of servos where one is due
    MISTAKE_BLANK,    // "1, 2"
    MISTAKE_REVERSED, // "3-1"
    MISTAKE_COMMA,    // "90,5"
    MISTAKE_UNIT,     // of a setting
    MISTAKE_KNOWN_ID, // `id` or `new` to the ID of a known servo
    MISTAKE_COUNT,    // too many words, or too few, for the one usage of the command
    MISTAKE_LIMITS,   // beyond the soft limits of the servo
    MISTAKE_RATE,     // the servo is known to be at another rate than the bus
    MISTAKE_LINE,     // the line is held low, so the servo may not be driven
    MISTAKE_OFFLINE,  // the servo does not answer, so it may not be driven
    MISTAKE_ADVISED,  // advice.h has a text
    MISTAKE_NOISE,    // noise is on the line
    MISTAKE_GROUP,    // no group is chosen, and stored poses name its servos
} __attribute__((packed));

/* Returns the mistake that has caused console->error. `is_of_word`: a word of the line, which the
 * console keeps, has caused the error. A text of advice.h is in the printer then: call
 * mistake_print() at once. */
enum mistake mistake_of(struct console *console, bool is_of_word);

/* For a profile with command_set.noise: true if noise is on the line, and explains `error`. */
bool mistake_is_noise(uint8_t error);

/* The text of such an error: the finding of `diagnose` for noise, or for a line that is never
 * quiet, if no packet could be sent. */
const CDS_FLASH char *mistake_noise_text(uint8_t error);

/* Prints the text of the mistake, not MISTAKE_NONE, and ends the line; after MISTAKE_COMMA
 * mistake_print_with_point() ends it, after MISTAKE_GROUP `group` of command_set.motion_words. The
 * printer must be ready. */
void mistake_print(struct console *console, enum mistake mistake);

/* Prints the word with a point in place of its comma, "90.5", and ends the line. The printer must
 * be ready. */
void mistake_print_with_point(struct console *console);

#endif
