/* The chip's watchdog, and why the chip was last reset. It belongs to the firmware, not to the
 * library.
 *
 * A main loop that does not come round for WATCHDOG_MS is ended by a reset: the handlers alone do
 * not keep the program alive. The loop turns at least every 33 ms, when the clock wakes it.
 */
#ifndef AVR_WATCHDOG_H
#define AVR_WATCHDOG_H

#include <stdint.h>

#include <avr/wdt.h>

/* By the watchdog's own oscillator: at 5 V and room temperature; 10 % to 20 % off elsewhere. */
#define WATCHDOG_MS 130

/* The flags of the last reset, bits 0 to 4 of MCUSR (MCUCSR) as they stood: 1 power-on, 2 external,
 * 4 brown-out, 8 watchdog, 16 JTAG. Several may be set: those of earlier resets are cleared at each
 * start, but power and brown-out come together. */
extern uint8_t avr_reset_cause;

/* Switches the watchdog on. Main context, once, before the main loop. */
static inline void watchdog_on(void)
{
    wdt_enable(WDTO_120MS); // a word for 2^14 cycles of 128 kHz
}

/* Once in each turn of the main loop, and nowhere else. Main context. */
static inline void watchdog_pet(void)
{
    wdt_reset();
}

#endif
