/* SPDX-License-Identifier: MIT */
/* A register of two bytes in a packet, for modules of the core; not installed. Any context.
 * Manual: 3.1. */
#ifndef CDS_WORD_INTERNAL_H
#define CDS_WORD_INTERNAL_H

#include <stdint.h>

#include "compiler.h" // ALWAYS_INLINE

/* Returns the word at `bytes`: the low byte comes first. */
ALWAYS_INLINE uint16_t cds_word_at(const uint8_t *bytes)
{
    return (uint16_t)(bytes[0] | (uint16_t)bytes[1] << 8);
}

#endif
