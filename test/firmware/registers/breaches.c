/* SPDX-License-Identifier: MIT */
/* One breach of the rules of the wire after the other, for the list that the simulator must print.
 */
#include "chip.h"

int main(void)
{
    bus_talk();
    PORTD = RXD | TX_ENABLE | RX_ENABLE; // both-enables
    PORTD = TX_ENABLE;                   // floating-rxd
    PORTD = RXD | TX_ENABLE;
    UCSR1B = 0;  // floating-txd
    UDR1 = 0x11; // transmitter-off
    UCSR1B = 1 << TXEN1;
    PORTD = RXD;
    UDR1 = 0x22; // driver-off
    wait(100);
    PORTD = RXD | TX_ENABLE;
    UCSR1C = (1 << UCSZ11) | (1 << UCSZ10) | (1 << UPM11);
    UDR1 = 0x33; // frame-format
    wait(100);
    UCSR1C = (1 << UCSZ11) | (1 << UCSZ10);
    UDR1 = 0x44;
    wait(30);
    PORTD = RXD; // early-release
    end();
}
