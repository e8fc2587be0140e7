/* SPDX-License-Identifier: MIT */
/* RXC is a level: RXCIE enabled while it is set interrupts at once, and a handler that does not
 * read UDR is entered again after one instruction. simavr repeats itself once a byte time. Servo 1
 * sends. */
#include "chip.h"

static volatile uint16_t when;
static volatile uint8_t entries;

ISR(USART1_RX_vect)
{
    if (entries == 0) {
        when = TCNT1;
    }
    if (++entries == 20) {
        UCSR1B = 1 << RXEN1;
    }
}

int main(void)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};
    bus_send(ping, sizeof(ping));
    while (!(UCSR1A & (1 << RXC1))) {
    }
    clock_start();
    UCSR1B = (1 << RXEN1) | (1 << RXCIE1);
    sei();
    wait(250);
    cli();
    print_open();
    print("when", when);
    print("entries", entries);
    end();
}
