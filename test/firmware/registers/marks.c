/* SPDX-License-Identifier: MIT */
/* Holds PB0 high for 1000 cycles, for 500, and for 400 in which a handler interrupts it; then PB1,
 * which is not looked at. */
#include "chip.h"

ISR(TIMER1_COMPA_vect)
{
    __asm__ volatile(".rept 100\n\tnop\n\t.endr");
}

int main(void)
{
    DDRB = 1 << PB0 | 1 << PB1;
    PORTB |= 1 << PB0; // 2 cycles
    __asm__ volatile(".rept 998\n\tnop\n\t.endr");
    PORTB &= (uint8_t) ~(1 << PB0);
    PORTB |= 1 << PB0;
    __asm__ volatile(".rept 498\n\tnop\n\t.endr");
    PORTB &= (uint8_t) ~(1 << PB0);
    clock_start();
    OCR1A = 100;
    TIFR = 1 << OCF1A;
    TIMSK = 1 << OCIE1A;
    PORTB |= 1 << PB0;
    __asm__ volatile("sei\n\t.rept 396\n\tnop\n\t.endr\n\tcli");
    PORTB &= (uint8_t) ~(1 << PB0);
    PORTB |= 1 << PB1;
    __asm__ volatile(".rept 500\n\tnop\n\t.endr");
    end();
}
