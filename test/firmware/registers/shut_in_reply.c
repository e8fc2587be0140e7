/* SPDX-License-Identifier: MIT */
/* Shuts the way to its receiver in the middle of a reply: first by the RX enable, then by RXEN. */
#include "chip.h"

static void ping_and_hear_three_bytes(void)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};
    bus_send(ping, sizeof(ping));
    for (uint8_t i = 0; i < 3; i++) {
        while (!(UCSR1A & (1 << RXC1))) {
        }
        (void)UDR1;
    }
}

int main(void)
{
    ping_and_hear_three_bytes();
    wait(10); // into the next byte
    PORTD = RXD;
    wait(1000);
    ping_and_hear_three_bytes();
    wait(10);
    UCSR1B = 0;
    wait(1000);
    print_open();
    end();
}
