/* SPDX-License-Identifier: MIT */
/* Counts the RAM that was never used, between the variables and the deepest stack so far. The
 * start-up code fills that RAM with a pattern; memory_poll() counts the bytes that still have it, a
 * few in each call. There is no heap. */
#ifndef AVR_MEMORY_H
#define AVR_MEMORY_H

#include <stdbool.h>
#include <stdint.h>

/* Bytes counted in one call: about 150 cycles, so the bus is not held up. */
#define MEMORY_STEP 16

/* Zero it (static storage is). */
struct memory {
    const uint8_t *at;    // the byte at which the count goes on, or NULL
    uint16_t spare_bytes; // never used, as of the last count
};

/* Goes on counting. True: the count has ended, after at most RAM / MEMORY_STEP calls; the next call
 * begins another one. Main context. */
bool memory_poll(struct memory *memory);

/* Returns the bytes that the variables leave to the stack. */
uint16_t memory_room_bytes(void);

#endif
