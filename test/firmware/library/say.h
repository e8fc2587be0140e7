/* SPDX-License-Identifier: MIT */
/* Output of a test program: words and numbers on the host USART of the board, polled. On a board
 * without one, only the numbers, as text in the EEPROM from byte 0 on. say_end() ends the run: it
 * sleeps with interrupts off. */
#ifndef SAY_H
#define SAY_H

#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdint.h>
#include <stdlib.h>

#include "board.h"
#include "cds55xx/avr/usart.h" // CDS_AVR_PASTE, CDS_AVR_PASTE3

#ifdef BOARD_HOST_USART
#define SAY_REGISTER_(a, b) CDS_AVR_PASTE3(a, BOARD_HOST_USART, b)
#define SAY_STATUS          SAY_REGISTER_(UCSR, A)
#define SAY_CONTROL         SAY_REGISTER_(UCSR, B)
#define SAY_DATA            CDS_AVR_PASTE(UDR, BOARD_HOST_USART)
#define SAY_DIVISOR         ((F_CPU + 4ul * BOARD_HOST_BAUD) / (8ul * BOARD_HOST_BAUD))

enum { // where all these chips have them
    SAY_RXC = 1 << 7,
    SAY_TXC = 1 << 6,
    SAY_UDRE = 1 << 5,
    SAY_U2X = 1 << 1,
    SAY_RXEN = 1 << 4,
    SAY_TXEN = 1 << 3,
};

static inline void say_open(void)
{
    SAY_STATUS = SAY_U2X;
    SAY_REGISTER_(UBRR, L) = SAY_DIVISOR - 1;
    SAY_CONTROL = SAY_TXEN;
}

static inline void say_text(const char *text)
{
    for (; *text; text++) {
        while (!(SAY_STATUS & SAY_UDRE)) {
        }
        SAY_STATUS = SAY_TXC | SAY_U2X;
        SAY_DATA = (uint8_t)*text;
    }
}

static inline void say_name(const char *name)
{
    say_text(name);
    say_text(" ");
}

static inline void say_flush(void)
{
    while (!(SAY_STATUS & SAY_TXC)) {
    }
}

/* Reads a line from the PC, without its end, and cuts it off after `capacity` - 1 characters. */
static inline void say_hear(char *line, uint8_t capacity)
{
    uint8_t size = 0, byte;

    SAY_CONTROL = SAY_TXEN | SAY_RXEN;
    do {
        while (!(SAY_STATUS & SAY_RXC)) {
        }
        byte = SAY_DATA;
        if (byte != '\n' && size < capacity - 1)
            line[size++] = (char)byte;
    } while (byte != '\n');
    line[size] = 0;
}
#else
static inline void say_open(void)
{
}

static inline void say_text(const char *text)
{
    static uint8_t *place;

    for (; *text && place <= (uint8_t *)E2END; text++, place++)
        eeprom_write_byte(place, (uint8_t)*text);
}

static inline void say_name(const char *name)
{
    (void)name; // to save EEPROM
}

static inline void say_flush(void)
{
    eeprom_busy_wait();
}
#endif

/* "name 123\n" */
static inline void say(const char *name, uint32_t number)
{
    char digits[11];

    say_name(name);
    say_text(ultoa(number, digits, 10));
    say_text("\n");
}

static inline void say_signed(const char *name, int32_t value)
{
    char digits[12];

    say_name(name);
    say_text(ltoa(value, digits, 10));
    say_text("\n");
}

static inline void say_end(void)
{
    say_flush();
    cli();
    sleep_enable();
    sleep_cpu();
}

#endif
