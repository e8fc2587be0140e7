/* SPDX-License-Identifier: MIT */
/* An overflow of timer 1 that waits for its handler, while the flag of a compare match is cleared.
 * In simavr both are gone. */
#include "chip.h"

static volatile uint8_t count;

ISR(TIMER1_OVF_vect)
{
    count++;
}

int main(void)
{
    uint8_t both, one;

    TCCR1B = 1 << CS11;
    TIMSK = 1 << TOIE1;
    TCNT1 = 0xFFF0;
    OCR1A = 4;
    wait(1000);
    both = TIFR & ((1 << TOV1) | (1 << OCF1A));
    TIFR = 1 << OCF1A;
    one = TIFR & ((1 << TOV1) | (1 << OCF1A));
    sei();
    wait(100);
    cli();
    print_open();
    print("before", both);
    print("after", one);
    print("interrupts", count);
    end();
}
