/* SPDX-License-Identifier: MIT */
/* A plain polling driver for a bus without an enable for each direction: TXD and RXD tied (TIED
 * defined), an adapter that finds the direction by itself (ADAPTER), or one enable on PD6. It gives
 * servo 1 a return delay of 0 (adapter: 2 us, one enable: 16 us), pings it eight times and prints
 * how many replies came in whole behind the echo, if there is one. A mutant defines one of the
 * MUTANT_ words and includes this file.
 */
#ifndef WIRING_H
#define WIRING_H

#include "chip.h"

#define TXD (1 << PD3)

#if defined(TIED) || defined(ADAPTER)
#ifdef TIED
#define DELAY    0
#define CHECKSUM 0xF5
#else
#define DELAY    1
#define CHECKSUM 0xF4
#endif
#define LISTEN ((1 << RXEN1))
#ifdef MUTANT_RECEIVER_OFF
#define TALK (1 << TXEN1)
#else
#define TALK ((1 << TXEN1) | (1 << RXEN1))
#endif
#else
#define DELAY    8
#define CHECKSUM 0xED
#define LISTEN   (1 << RXEN1)
#define TALK     (1 << TXEN1)
#endif

static uint8_t heard[20];
static uint8_t count;

static void hear(void)
{
    while (UCSR1A & (1 << RXC1)) {
        uint8_t byte = UDR1;
        if (count < sizeof(heard)) {
            heard[count++] = byte;
        }
    }
}

static void talk(const uint8_t *packet, uint8_t size)
{
    count = 0;
    UCSR1B = TALK;
#ifndef TIED
    PORTD |= TX_ENABLE;
#endif
    for (uint8_t i = 0; i < size; i++) {
        while (!(UCSR1A & (1 << UDRE1))) {
            hear();
        }
        UDR1 = packet[i];
        UCSR1A = 1 << TXC1;
    }
#if defined(TIED) && !defined(MUTANT_DRIVER_KEPT) && !defined(MUTANT_RECEIVER_OFF)
    UCSR1B = LISTEN; // with two bytes still to go
#endif
    while (!(UCSR1A & (1 << TXC1))) {
        hear();
    }
#ifdef MUTANT_DRIVER_KEPT
    wait(80);
#endif
#ifdef MUTANT_ENABLE_KEPT
    UCSR1B = TALK | LISTEN;
    wait(160);
#endif
#ifndef TIED
    PORTD &= (uint8_t)~TX_ENABLE;
#endif
    UCSR1B = LISTEN;
    for (uint16_t patience = 300; patience; patience--) {
        hear();
    }
}

int main(void)
{
    static const uint8_t delay[] = {0xFF, 0xFF, 0xFE, 0x04, 0x03, 0x05, DELAY, CHECKSUM};
    static const uint8_t ping[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};
    uint8_t whole = 0, echo = 0;
    PORTD = RXD | TXD;
#ifdef MUTANT_TXD_FLOATS
    PORTD = 0; // RXD too, which an adapter drives
#endif
#ifdef MUTANT_TXD_OUTPUT
    DDRD = TXD;
#endif
#if !defined(TIED) && !defined(MUTANT_TXD_FLOATS)
    DDRD = TXD | TX_ENABLE;
#endif
    bus_rate_1M();
    talk(delay, sizeof(delay));
    for (uint8_t i = 0; i < 8; i++) {
        talk(ping, sizeof(ping));
        if (count >= 6 && heard[count - 1] == 0xFC) {
            whole++;
        }
        echo = (uint8_t)(echo + (count == 12 && heard[5] == 0xFB));
    }
    UCSR1B = 0;
    print_open();
    print("whole", whole);
    print("echo", echo);
    end();
}

#endif
