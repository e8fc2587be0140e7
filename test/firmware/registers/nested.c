/* SPDX-License-Identifier: MIT */
/* Handlers that interrupt each other: 10 deep, then 40 deep. Then a handler that does not end. */
#include "chip.h"

static volatile uint8_t handlers_left;

/* UDRE stays pending as the data register is empty: SEI lets the next handler in. */
ISR(USART0_UDRE_vect)
{
    if (--handlers_left == 0) {
        UCSR0B = 1 << TXEN0;
    }
    __asm__ volatile("sei\n\tnop\n\tnop\n\tcli");
}

ISR(TIMER1_COMPA_vect)
{
    __asm__ volatile("ldi r24, 250\n1:\tnop\n\tdec r24\n\tbrne 1b" ::: "r24");
    end();
}

static void nest(uint8_t handlers)
{
    handlers_left = handlers;
    UCSR0B = 1 << TXEN0 | 1 << UDRIE0;
    wait(5000);
}

int main(void)
{
    print_open();
    sei();
    nest(10);
    nest(40);
    clock_start();
    OCR1A = 100;
    TIFR = 1 << OCF1A;
    TIMSK = 1 << OCIE1A;
    for (;;) {
    }
}
