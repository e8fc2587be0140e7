/* SPDX-License-Identifier: MIT */
/* For the small firmwares that test the simulator: ATmega128 at 16 MHz, plain registers, nothing of
 * the library. USART1 is the bus (1 Mbps), PD6 the TX enable, PD7 the RX enable, USART0 the PC.
 *
 * A firmware measures first, with timer 1 at one tick a cycle, and then prints lines "name value".
 */
#ifndef CHIP_H
#define CHIP_H

#include <stdint.h>

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

#define TX_ENABLE (1 << PD6)
#define RX_ENABLE (1 << PD7)
#define RXD       (1 << PD2)

/* UBRRL last: simavr's own USART takes its byte time from that write. */
static inline void bus_rate_1M(void)
{
    UCSR1A = 0;
    UCSR1C = (1 << UCSZ11) | (1 << UCSZ10);
    UBRR1H = 0;
    UBRR1L = 0;
}

/* The wire is ours, nothing is to be received. */
static inline void bus_talk(void)
{
    PORTD = RXD | RX_ENABLE;
    DDRD = TX_ENABLE | RX_ENABLE;
    bus_rate_1M();
    UCSR1B = 1 << TXEN1;
    PORTD = RXD;
    PORTD = RXD | TX_ENABLE;
}

/* Polls a whole packet out, lets go when its last stop bit has left, and listens. */
static inline void bus_send(const uint8_t *packet, uint8_t size)
{
    bus_talk();
    for (uint8_t i = 0; i < size; i++) {
        while (!(UCSR1A & (1 << UDRE1))) {
        }
        if (i == size - 1) {
            UCSR1A = 1 << TXC1;
        }
        UDR1 = packet[i];
    }
    while (!(UCSR1A & (1 << TXC1))) {
    }
    PORTD = RXD;
    PORTD = RXD | RX_ENABLE;
    UCSR1B = 1 << RXEN1;
}

static inline void clock_start(void)
{
    TCCR1A = 0;
    TCCR1B = 1 << CS10;
    TCNT1 = 0;
}

static inline void print_char(char c)
{
    while (!(UCSR0A & (1 << UDRE0))) {
    }
    UDR0 = (uint8_t)c;
}

static inline void print_text(const char *text)
{
    while (*text) {
        print_char(*text++);
    }
}

static inline void print_open(void)
{
    UCSR0A = 1 << U2X0;
    UCSR0C = (1 << UCSZ01) | (1 << UCSZ00);
    UBRR0H = 0;
    UBRR0L = 16; // 117 647 baud
    UCSR0B = 1 << TXEN0;
}

static inline void print(const char *name, uint16_t value)
{
    char digits[5];
    uint8_t count = 0;
    do {
        digits[count++] = (char)('0' + value % 10);
        value /= 10;
    } while (value);
    print_text(name);
    print_char(' ');
    while (count) {
        print_char(digits[--count]);
    }
    print_char('\n');
}

/* Sleeping with interrupts off ends the simulation; not before the last byte is out. */
static inline void end(void)
{
    for (uint16_t i = 0; i < 4000; i++) {
        __asm__ volatile("nop");
    }
    cli();
    sleep_enable();
    sleep_cpu();
    for (;;) {
    }
}

static inline void wait(uint16_t rounds) // of 4 cycles
{
    __asm__ volatile("1: sbiw %0, 1\n\tbrne 1b" : "+w"(rounds));
}

#endif
