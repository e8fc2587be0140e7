/* SPDX-License-Identifier: MIT */
/* Behind an adapter, with the wire held low by a fault: RXD is high as long as the adapter drives.
 * So many cycles from the write to UDR, of one byte and of two without a gap. */
#include "chip.h"

static uint16_t driven(uint8_t bytes)
{
    clock_start();
    while (bytes--) {
        UDR1 = 0x55;
    }
    while (!(PIND & RXD)) {
    }
    while (PIND & RXD) {
    }
    return TCNT1;
}

int main(void)
{
    PORTD = RXD | (1 << PD3);
    DDRD = 1 << PD3;
    bus_rate_1M();
    UCSR1B = 1 << TXEN1;
    uint16_t one = driven(1);
    wait(100);
    uint16_t two = driven(2);
    UCSR1B = 0;
    print_open();
    print("one", one);
    print("two", two);
    end();
}
