/* SPDX-License-Identifier: MIT */
/* UDR is free again as soon as its byte is in the shift register; in simavr only when it has left.
 */
#include "chip.h"

int main(void)
{
    bus_talk();
    clock_start();
    uint16_t start = TCNT1;
    UDR1 = 0x11;
    while (!(UCSR1A & (1 << UDRE1))) {
    }
    uint16_t first = TCNT1 - start;
    UDR1 = 0x22;
    while (!(UCSR1A & (1 << UDRE1))) {
    }
    uint16_t second = TCNT1 - start;
    print_open();
    print("first", first);
    print("second", second);
    end();
}
