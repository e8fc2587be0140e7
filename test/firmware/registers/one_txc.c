/* SPDX-License-Identifier: MIT */
/* TXC comes once, when the last of a row of bytes has left; simavr's comes with every byte. */
#include "chip.h"

static volatile uint8_t count;
static volatile uint16_t when;

ISR(USART1_TX_vect)
{
    when = TCNT1;
    count++;
}

int main(void)
{
    bus_talk();
    sei();
    clock_start();
    UCSR1B = (1 << TXEN1) | (1 << TXCIE1);
    for (uint8_t i = 0; i < 5; i++) {
        while (!(UCSR1A & (1 << UDRE1))) {
        }
        UDR1 = i;
    }
    wait(300);
    cli();
    print_open();
    print("interrupts", count);
    print("last", when);
    end();
}
