/* SPDX-License-Identifier: MIT */
/* Sleeping until the next interrupt. */
#ifndef AVR_IDLE_H
#define AVR_IDLE_H

#include <avr/interrupt.h>
#include <avr/sleep.h>

/* Sleeps until an interrupt. Call it with interrupts off, so that no interrupt comes between the
 * caller's last check and the sleep: sei takes effect after the next instruction, which is the
 * sleep. Interrupts are on when it returns. */
static inline void avr_sleep(void)
{
    sleep_enable();
    sei();
    sleep_cpu();
    sleep_disable();
}

#endif
