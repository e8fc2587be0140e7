/* SPDX-License-Identifier: MIT */
/* Two bytes and the shift register is all that a receiver holds; later bytes are lost, and DOR says
 * so. simavr keeps 63. Servo 1 sends six bytes that nobody reads in time. */
#include "chip.h"

int main(void)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};
    uint8_t bytes[8];
    uint8_t count = 0;
    uint8_t overrun = 0;
    bus_send(ping, sizeof(ping));
    wait(500);
    for (uint8_t i = 0; i < 100; i++) {
        wait(60); // simavr offers its bytes one by one
        uint8_t status = UCSR1A;
        if ((status & (1 << RXC1)) && count < sizeof(bytes)) {
            if (status & (1 << DOR1)) {
                overrun = 1;
            }
            bytes[count++] = UDR1;
        }
    }
    print_open();
    print("count", count);
    print("overrun", overrun);
    print("last", bytes[count ? count - 1 : 0]);
    end();
}
