/* SPDX-License-Identifier: MIT */
/* A reset by the watchdog in the middle of a byte: the pins float, the clock of the simulation goes
 * on, and the second life works. */
#include <avr/wdt.h>

#include "chip.h"

int main(void)
{
    uint8_t second_life = (MCUCSR & (1 << WDRF)) != 0;
    MCUCSR = 0;
    wdt_disable();
    bus_talk();
    clock_start();
    if (!second_life) {
        wdt_enable(WDTO_15MS);
        for (;;) {
            while (!(UCSR1A & (1 << UDRE1))) {
            }
            UDR1 = 0x11;
        }
    }
    uint16_t start = TCNT1;
    UDR1 = 0x55;
    while (!(UCSR1A & (1 << TXC1))) {
    }
    uint16_t cycles = TCNT1 - start;
    print_open();
    print("cycles", cycles);
    end();
}
