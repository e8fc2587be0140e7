/* SPDX-License-Identifier: MIT */
/* The byte time follows UBRR and U2X as they stand when the byte starts, in whatever order they
 * were written; simavr computes it when UBRRL is written. */
#include "chip.h"

int main(void)
{
    bus_talk();
    UBRR1L = 1;
    UCSR1A = 1 << U2X1; // the same 1 Mbps
    clock_start();
    uint16_t start = TCNT1;
    UDR1 = 0x55;
    while (!(UCSR1A & (1 << TXC1))) {
    }
    uint16_t cycles = TCNT1 - start;
    print_open();
    print("cycles", cycles);
    end();
}
