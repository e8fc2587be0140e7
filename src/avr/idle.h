/* Sleeping until the next interrupt. */
#ifndef AVR_IDLE_H
#define AVR_IDLE_H

#include <avr/interrupt.h>
#include <avr/sleep.h>
#include <stdbool.h>

/* Sleeps until an interrupt, unless `busy(context)`, asked with interrupts off, says that there is
 * work: an interrupt between the question and the sleep would otherwise be slept through. */
static inline void avr_idle(bool (*busy)(const void *context), const void *context)
{
    if (busy(context)) // asked first with interrupts on: a busy loop must not hold up a handler
        return;
    cli();
    if (!busy(context)) {
        sleep_enable();
        sei(); // takes effect after the next instruction, the sleep
        sleep_cpu();
        sleep_disable();
    }
    sei();
}

#endif
