/* SPDX-License-Identifier: MIT */
/* A handler hangs until the watchdog resets the chip, 16 ms later. Then the firmware ends. */
#include <avr/wdt.h>

#include "chip.h"

ISR(TIMER1_COMPA_vect)
{
    for (;;) {
    }
}

int main(void)
{
    if (MCUCSR & 1 << WDRF) {
        wdt_disable();
        end();
    }
    wdt_enable(WDTO_15MS);
    clock_start();
    OCR1A = 100;
    TIFR = 1 << OCF1A;
    TIMSK = 1 << OCIE1A;
    sei();
    for (;;) {
    }
}
