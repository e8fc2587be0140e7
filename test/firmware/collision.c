/* Pings whoever is there, once: with two servos on the wire, that collides. */
#include "chip.h"

int main(void)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 0xFE, 0x02, 0x01, 0xFE};
    UBRR0L = 8;
    UCSR0B = 1 << RXEN0; // the script may begin
    wait(10000);
    bus_talk();
    for (uint8_t i = 0; i < sizeof(ping); i++) {
        while (!(UCSR1A & (1 << UDRE1))) {
        }
        if (i == sizeof(ping) - 1) {
            UCSR1A = 1 << TXC1;
        }
        UDR1 = ping[i];
    }
    while (!(UCSR1A & (1 << TXC1))) {
    }
    PORTD = RXD;
    PORTD = RXD | RX_ENABLE;
    UCSR1B = 1 << RXEN1;
    for (;;) {
        (void)UDR1;
    }
}
