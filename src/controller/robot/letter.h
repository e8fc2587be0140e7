/* SPDX-License-Identifier: MIT */
/* Letters, for names and words. */
#ifndef CONTROLLER_LETTER_H
#define CONTROLLER_LETTER_H

#include <stdbool.h>

/* True for a letter from a to z or A to Z. */
static inline bool is_letter(char c)
{
    return (c | 0x20) >= 'a' && (c | 0x20) <= 'z';
}

#endif
