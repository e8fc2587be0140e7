/* How much RAM was never used: what lies between the variables and the deepest stack there has
 * been. The start-up code paints it; what still has its paint is counted, a little at a time. There
 * is no heap. It belongs to the firmware, not to the library. */
#ifndef AVR_MEMORY_H
#define AVR_MEMORY_H

#include <stdint.h>

/* Bytes looked at in one call: about 300 cycles. */
#define MEMORY_STEP 32

/* Zero it (static storage is). */
struct memory {
    const uint8_t *at;    // where the count goes on, or NULL
    uint16_t spare_bytes; // never used, as of the last count; 0 before the first is over
};

/* Counts on: `spare_bytes` is new every (RAM / MEMORY_STEP) calls. Main context. */
void memory_poll(struct memory *memory);

/* Counts at once: up to 5 ms with 8 KB of RAM. Main context. */
void memory_count(struct memory *memory);

/* Returns the bytes that the variables leave to the stack. */
uint16_t memory_room_bytes(void);

#endif
