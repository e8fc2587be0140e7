/* SPDX-License-Identifier: MIT */
/* How much RAM was never used; see memory.h. */
#include "avr/memory.h"

#include <avr/io.h>
#include <stddef.h>

#define PAINT 0xA5

extern uint8_t __heap_start; // set by the linker: the end of the variables

#define BOTTOM (&__heap_start)
#define TOP    ((const uint8_t *)RAMEND + 1)

/* Runs when .data and .bss are set up and the stack is empty. In assembly: a naked function has no
 * stack frame in which compiled code could save registers. */
__attribute__((naked, used, section(".init5"))) void avr_memory_paint(void)
{
    __asm__ volatile("ldi r30, lo8(__heap_start) \n\t"
                     "ldi r31, hi8(__heap_start) \n\t"
                     "ldi r24, %[paint]          \n\t"
                     "ldi r25, hi8(%[top])       \n\t"
                     "1: st Z+, r24              \n\t"
                     "cpi r30, lo8(%[top])       \n\t"
                     "cpc r31, r25               \n\t"
                     "brne 1b                    \n\t"
                     :
                     : [paint] "n"(PAINT), [top] "n"(RAMEND + 1));
}

bool memory_poll(struct memory *memory)
{
    const volatile uint8_t *at = memory->at ? memory->at : BOTTOM;
    const volatile uint8_t *stop = at + MEMORY_STEP; // the stack above ends each count

    while (at < stop && *at == PAINT)
        at++;
    memory->at = (const uint8_t *)at;
    if (at == stop)
        return false;
    memory->spare_bytes = (uint16_t)(at - BOTTOM);
    memory->at = NULL;
    return true;
}

uint16_t memory_room_bytes(void)
{
    return (uint16_t)(TOP - BOTTOM);
}
