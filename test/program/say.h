/* What a test program says: words and numbers on the host USART, polled; and the end of its run,
 * asleep with interrupts off. */
#ifndef SAY_H
#define SAY_H

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdint.h>
#include <stdlib.h>

static inline void say_open(void)
{
    UCSR0A = 1 << U2X0;
    UBRR0L = 16; // 115200 bit/s
    UCSR0B = 1 << TXEN0;
}

static inline void say_text(const char *text)
{
    for (; *text; text++) {
        loop_until_bit_is_set(UCSR0A, UDRE0);
        UCSR0A = 1 << TXC0 | 1 << U2X0;
        UDR0 = (uint8_t)*text;
    }
}

/* "name 123\n" */
static inline void say(const char *name, uint32_t number)
{
    char digits[11];

    say_text(name);
    say_text(" ");
    say_text(ultoa(number, digits, 10));
    say_text("\n");
}

static inline void say_end(void)
{
    loop_until_bit_is_set(UCSR0A, TXC0);
    cli();
    sleep_enable();
    sleep_cpu();
}

#endif
