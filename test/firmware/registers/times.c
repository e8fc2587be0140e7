/* SPDX-License-Identifier: MIT */
/* Two steps of PB0, 102 cycles apart. Interrupts off for 299. A handler of 31 within one of 72.
 * Two bytes with 140 idle cycles between them, and the line turned round 41 behind the last;
 * another one, and the driver lets go 90 behind it, though the receiver is on before. */
#include "chip.h"

ISR(TIMER1_COMPA_vect, ISR_NAKED) // entry 4, jmp 3, sei 1, 60, reti 4
{
    __asm__ volatile("sei\n\t.rept 60\n\tnop\n\t.endr\n\treti");
}

ISR(TIMER1_COMPB_vect, ISR_NAKED)
{
    __asm__ volatile(".rept 20\n\tnop\n\t.endr\n\treti");
}

static void marks(void)
{
    DDRB = 1 << PB0;
    __asm__ volatile(
        "sbi %0, 0\n\t.rept 100\n\tnop\n\t.endr\n\tcbi %0, 0" ::"I"(_SFR_IO_ADDR(PORTB)));
}

static void handlers(void)
{
    __asm__ volatile("sei\n\tnop\n\tcli\n\t.rept 298\n\tnop\n\t.endr\n\tsei");
    clock_start();
    OCR1A = 100;
    OCR1B = 120;
    TIFR = 1 << OCF1A | 1 << OCF1B;
    TIMSK = 1 << OCIE1A | 1 << OCIE1B;
    wait(100);
    TIMSK = 0;
}

/* STS takes two cycles, and its writes take effect after the same time. */
static void transmission(void)
{
    uint8_t byte = 0x55, released = RXD | RX_ENABLE, control = 1 << RXEN1;

    bus_talk();
    wait(50);
    __asm__ volatile("sts %0, %3\n\t.rept 298\n\tnop\n\t.endr\n\t"
                     "sts %0, %3\n\t.rept 198\n\tnop\n\t.endr\n\t"
                     "out %1, %4\n\tsts %2, %5" ::"n"(_SFR_MEM_ADDR(UDR1)),
                     "I"(_SFR_IO_ADDR(PORTD)), "n"(_SFR_MEM_ADDR(UCSR1B)), "r"(byte), "r"(released),
                     "r"(control));
}

static void transmission_with_both_on(void)
{
    uint8_t byte = 0x55, both = RXD | RX_ENABLE | TX_ENABLE, released = RXD | RX_ENABLE;
    uint8_t control = 1 << RXEN1 | 1 << TXEN1;

    bus_talk();
    wait(50);
    __asm__ volatile("sts %0, %3\n\t.rept 198\n\tnop\n\t.endr\n\t"
                     "sts %2, %6\n\tout %1, %4\n\t.rept 47\n\tnop\n\t.endr\n\t"
                     "out %1, %5" ::"n"(_SFR_MEM_ADDR(UDR1)),
                     "I"(_SFR_IO_ADDR(PORTD)), "n"(_SFR_MEM_ADDR(UCSR1B)), "r"(byte), "r"(both),
                     "r"(released), "r"(control));
}

int main(void)
{
    marks();
    handlers();
    cli(); // not a time with interrupts off: it does not end
    transmission();
    transmission_with_both_on();
    end();
}
