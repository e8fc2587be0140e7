/* SPDX-License-Identifier: MIT */
/* A correct half-duplex driver, small and plain, for one packet at a time; and the places where a
 * mutant departs from it. TXEN stays on, since simavr's own USART hangs when it is toggled. A
 * mutant defines one of the MUTANT_ words and includes this file.
 *
 * main() gives all servos a return delay of 16 us, pings servo 1 eight times and prints how many
 * replies came in whole.
 */
#ifndef HALF_DUPLEX_H
#define HALF_DUPLEX_H

#include "chip.h"

#define REPLY_SIZE 6

static volatile uint8_t reply[REPLY_SIZE];
static volatile uint8_t replied;

/* Release, then listen. */
static inline void listen(void)
{
#ifdef MUTANT_LATE_RELEASE
    wait(80); // 320 cycles
#endif
    PORTD &= (uint8_t)~TX_ENABLE;
    PORTD |= RX_ENABLE;
#ifdef MUTANT_LATE_TURNAROUND
    wait(80); // 320 cycles
#endif
    UCSR1B = (1 << TXEN1) | (1 << RXEN1) | (1 << RXCIE1);
}

ISR(USART1_TX_vect)
{
    listen();
}

ISR(USART1_RX_vect)
{
#ifdef MUTANT_SLOW_HANDLER
    wait(70); // 280 cycles: more than a byte
#endif
    uint8_t byte = UDR1;
    if (replied < REPLY_SIZE) {
        reply[replied++] = byte;
    }
}

static inline void put(uint8_t byte)
{
    while (!(UCSR1A & (1 << UDRE1))) {
    }
    UDR1 = byte;
}

/* All but the last byte, then the end game: write, clear TXC, arm TXCIE, nothing in between. */
static inline void talk(const uint8_t *packet, uint8_t size)
{
    replied = 0;
    PORTD &= (uint8_t)~RX_ENABLE;
    UCSR1B = 1 << TXEN1;
    PORTD |= TX_ENABLE;
    while (--size) {
        put(*packet++);
#ifdef MUTANT_STALE_TXC
        wait(100); // another handler takes its time: the transmitter runs empty, TXC is set
#endif
    }
    while (!(UCSR1A & (1 << UDRE1))) {
    }
    cli();
    UDR1 = *packet;
#ifdef MUTANT_RELEASE_ON_UDRE
    while (!(UCSR1A & (1 << UDRE1))) {
    }
    listen();
#else
#ifndef MUTANT_STALE_TXC
    UCSR1A = 1 << TXC1;
#endif
    UCSR1B = (1 << TXEN1) | (1 << TXCIE1);
#endif
    sei();
}

int main(void)
{
    static const uint8_t delay[] = {0xFF, 0xFF, 0xFE, 0x04, 0x03, 0x05, 0x08, 0xED};
    static const uint8_t ping[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};
    uint8_t whole = 0;
    PORTD = RXD | RX_ENABLE;
    DDRD = TX_ENABLE | RX_ENABLE;
    bus_rate_1M();
    UCSR1B = (1 << TXEN1) | (1 << RXEN1) | (1 << RXCIE1);
    sei();
    talk(delay, sizeof(delay));
    wait(4000);
    for (uint8_t i = 0; i < 8; i++) {
        talk(ping, sizeof(ping));
        wait(2000);
        if (replied == REPLY_SIZE && reply[5] == 0xFC) {
            whole++;
        }
    }
    cli();
    UCSR1B = 0;
    print_open();
    print("whole", whole);
    end();
}

#endif
