/* SPDX-License-Identifier: MIT */
/* TXEN off and on again leaves UDR writable; in simavr `while (!UDRE)` then hangs for ever. And
 * what was written before TXEN went off still leaves, in full. */
#include "chip.h"

int main(void)
{
    bus_talk();
    PORTD |= 1 << PD3; // TXD is pulled up while the USART leaves it alone
    clock_start();
    uint16_t start = TCNT1;
    UDR1 = 0x5A;
    UCSR1B = 0;
    while (!(UCSR1A & (1 << TXC1))) {
    }
    uint16_t gone = TCNT1 - start;
    UCSR1B = 1 << TXEN1;
    uint8_t ready = (UCSR1A & (1 << UDRE1)) != 0;
    print_open();
    print("gone", gone);
    print("ready", ready);
    end();
}
