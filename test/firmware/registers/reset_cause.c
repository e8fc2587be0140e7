/* SPDX-License-Identifier: MIT */
/* What each life of the chip finds: the flags of MCUCSR, RAM that no start-up code touches, pins.
 * The first two end by the watchdog, which an ATmega128 finds switched off after its reset. */
#include <avr/wdt.h>

#include "chip.h"

static uint8_t lives __attribute__((section(".noinit")));
static uint8_t flags[4] __attribute__((section(".noinit")));
static uint8_t pins[4] __attribute__((section(".noinit")));
static uint8_t dog[4] __attribute__((section(".noinit")));

int main(void)
{
    flags[lives] = MCUCSR;
    pins[lives] = DDRD | PORTD | UCSR1B;
    dog[lives] = WDTCR;
    lives++;
    DDRD = 0x5A;
    PORTD = 0xA5;
    UCSR1B = 1 << TXEN1;
    if (lives == 2) {
        MCUCSR = 0;
    }
    if (lives < 4) {
        wdt_enable(WDTO_15MS);
        for (;;) {
        }
    }
    DDRD = 0;
    PORTD = RXD;
    UCSR1B = 0;
    print_open();
    print("first", flags[0]);
    print("second", flags[1]);
    print("third", flags[2]);
    print("fourth", flags[3]);
    print("pins", pins[1] | pins[2] | pins[3]);
    print("dog", dog[3]);
    end();
}
