/* SPDX-License-Identifier: MIT */
/* Sends one PING by broadcast: with two servos on the wire, their replies collide. */
#include "chip.h"

int main(void)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 0xFE, 0x02, 0x01, 0xFE};
    UBRR0L = 8;
    UCSR0B = 1 << RXEN0; // the script may begin
    wait(10000);
    bus_send(ping, sizeof(ping));
    for (;;) {
        (void)UDR1;
    }
}
