/* SPDX-License-Identifier: MIT */
/* The chip's watchdog, and the cause of the last reset.
 *
 * The watchdog resets the chip if the main loop takes longer than WATCHDOG_MS for one turn. The
 * clock wakes the main loop at least every 33 ms.
 */
#ifndef AVR_WATCHDOG_H
#define AVR_WATCHDOG_H

#include <stdint.h>

#include <avr/wdt.h>

/* At 5 V and room temperature; elsewhere the oscillator of the watchdog is 10 % to 20 % off. */
#define WATCHDOG_MS 130

/* Flags of the last reset, bits 0 to 4 of MCUSR (MCUCSR): 1 power-on, 2 external, 4 brown-out, 8
 * watchdog, 16 JTAG. Several may be set: power-on and brown-out come together. */
extern uint8_t avr_reset_cause;

/* Switches the watchdog on. Main context, once, before the main loop. */
static inline void watchdog_on(void)
{
    wdt_enable(WDTO_120MS); // 2^14 cycles of 128 kHz
}

/* Restarts its time. Called once in each turn of the main loop, and nowhere else. Main context. */
static inline void watchdog_pet(void)
{
    wdt_reset();
}

#endif
