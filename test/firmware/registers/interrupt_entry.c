/* SPDX-License-Identifier: MIT */
/* Entering a handler takes 4 cycles, and after SEI one instruction runs first. simavr charges
 * nothing and runs two. */
#include "chip.h"

static volatile uint16_t when;
static volatile uint8_t let_in;

ISR(TIMER1_COMPA_vect)
{
    when = TCNT1;
}

ISR(TIMER1_OVF_vect)
{
    let_in = 1;
}

int main(void)
{
    clock_start();
    OCR1A = 400;
    TIFR = 1 << OCF1A;
    TIMSK = 1 << OCIE1A;
    sei();
    __asm__ volatile(".rept 600\n\tnop\n\t.endr"); // one cycle each: no jitter
    cli();
    TCNT1 = 0xFFF0;
    TIFR = 1 << TOV1;
    TIMSK = 1 << TOIE1;
    wait(20);
    __asm__ volatile("sei\n\tnop\n\tcli");
    print_open();
    print("when", when);
    print("let_in", let_in);
    end();
}
