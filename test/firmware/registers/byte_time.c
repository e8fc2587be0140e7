/* SPDX-License-Identifier: MIT */
/* A byte at 1 Mbps takes 160 cycles; simavr's takes 176. */
#include "chip.h"

int main(void)
{
    bus_talk();
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
