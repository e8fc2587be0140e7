/* SPDX-License-Identifier: MIT */
/* TXCIE set while TXC is set already: the handler runs at once. In simavr it never does. */
#include "chip.h"

static volatile uint8_t count;

ISR(USART1_TX_vect)
{
    count++;
}

int main(void)
{
    bus_talk();
    sei();
    UDR1 = 0x11;
    while (!(UCSR1A & (1 << TXC1))) {
    }
    UCSR1B = (1 << TXEN1) | (1 << TXCIE1);
    wait(300);
    cli();
    uint8_t flag = (UCSR1A & (1 << TXC1)) != 0;
    print_open();
    print("interrupts", count);
    print("flag", flag);
    end();
}
