/* SPDX-License-Identifier: MIT */
/* Notes the reset cause before main() begins; see watchdog.h. */
#include "avr/watchdog.h"

#include <avr/io.h>

#ifdef MCUCSR // ATmega128
#define FLAGS MCUCSR
#else
#define FLAGS MCUSR
#endif

#define CAUSES 0x1F // the other bits of MCUCSR are no flags

/* At file scope: the chip has one. Start-up code must not clear it. */
uint8_t avr_reset_cause __attribute__((section(".noinit")));

/* Runs before .data and .bss are set up; r1 is 0 and the stack is usable. After a watchdog reset
 * the watchdog of newer chips stays on, with 16 ms, as long as WDRF is set. So the code clears WDRF
 * and then turns the watchdog off, or it would reset the chip again during start-up. main() turns
 * it on.
 */
__attribute__((naked, used, section(".init3"))) void avr_reset_cause_keep(void)
{
    uint8_t flags = FLAGS;

    avr_reset_cause = flags & CAUSES;
    FLAGS = flags & (uint8_t)~CAUSES;
    wdt_disable();
}
