/* What is to be known and done about resets before the program begins; see watchdog.h. */
#include "avr/watchdog.h"

#include <avr/io.h>

#ifdef MCUCSR // ATmega128
#define FLAGS MCUCSR
#else
#define FLAGS MCUSR
#endif

#define CAUSES 0x1F // the other bits of MCUCSR are none

/* Of the program, not of a module's user: there is one chip. Start-up code must not clear it. */
uint8_t avr_reset_cause __attribute__((section(".noinit")));

/* Runs before .data and .bss are set up, where r1 is 0 and the stack stands, but no call has been
 * made. After its own reset the watchdog of newer chips is on, with 16 ms, for as long as WDRF is
 * set: it must be cleared first, then the watchdog switched off, or it would bite again while the
 * program still starts. Main switches it on. */
__attribute__((naked, used, section(".init3"))) void avr_reset_cause_keep(void)
{
    uint8_t flags = FLAGS;

    avr_reset_cause = flags & CAUSES;
    FLAGS = flags & (uint8_t)~CAUSES;
    wdt_disable();
}
