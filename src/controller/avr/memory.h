/* How much RAM was never used: what lies between the variables and the deepest stack there has
 * been. The start-up code paints it; what still has its paint is counted, a little at a time. There
 * is no heap. It belongs to the firmware, not to the library. */
#ifndef AVR_MEMORY_H
#define AVR_MEMORY_H

#include <stdbool.h>
#include <stdint.h>

/* Bytes looked at in one call: about 150 cycles, so that the bus is not held up. */
#define MEMORY_STEP 16

/* Zero it (static storage is). */
struct memory {
    const uint8_t *at;    // where the count goes on, or NULL
    uint16_t spare_bytes; // never used, as of the last count
};

/* Counts on. True: the count is over, after (RAM / MEMORY_STEP) calls at the most, and the next
 * call begins another. Main context. */
bool memory_poll(struct memory *memory);

/* Returns the bytes that the variables leave to the stack. */
uint16_t memory_room_bytes(void);

#endif
