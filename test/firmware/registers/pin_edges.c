/* SPDX-License-Identifier: MIT */
/* How long RXD is low in a reply, as PIND tells: every time, in bits of 16 cycles. Servo 1 answers.
 */
#include "chip.h"

#define LOWS 8 // in FF FF 01 02 00 FC

int main(void)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};
    static uint16_t edge[2 * LOWS];
    uint16_t *next = edge;
    bus_send(ping, sizeof(ping));
    clock_start();
    while (next != edge + 2 * LOWS) {
        while (PIND & RXD) {
        }
        *next++ = TCNT1;
        while (!(PIND & RXD)) {
        }
        *next++ = TCNT1;
    }
    print_open();
    for (uint8_t i = 0; i < LOWS; i++) {
        static const char *const name[] = {"low0", "low1", "low2", "low3",
                                           "low4", "low5", "low6", "low7"};
        print(name[i], (uint16_t)(edge[2 * i + 1] - edge[2 * i] + 8) / 16);
    }
    end();
}
