/* SPDX-License-Identifier: MIT */
/* The EEPROM of an ATmega128: a write takes 8.5 ms, with EEWE set; the CPU stands still for 2
 * cycles when a write begins and for 4 when a byte is read; EEWE counts within 4 cycles after
 * EEMWE; the interrupt comes as long as no write goes on. simavr's own writes at once and never
 * halts. */
#include "chip.h"

static volatile uint16_t ready;

ISR(EE_READY_vect)
{
    if (++ready == 3) {
        EECR = 0;
    }
}

/* Timer 1 at one tick for 8 cycles. */
static inline void slow_clock(void)
{
    TCCR1B = 1 << CS11;
    TCNT1 = 0;
}

static void write_in_time(uint16_t address, uint8_t byte)
{
    EEAR = address;
    EEDR = byte;
    __asm__ volatile("sbi %0, 2\n\tsbi %0, 1" ::"I"(_SFR_IO_ADDR(EECR)));
}

static void write_too_late(uint16_t address, uint8_t byte)
{
    EEAR = address;
    EEDR = byte;
    __asm__ volatile(
        "sbi %0, 2\n\tnop\n\tnop\n\tnop\n\tnop\n\tsbi %0, 1" ::"I"(_SFR_IO_ADDR(EECR)));
}

static uint8_t read(uint16_t address)
{
    EEAR = address;
    EECR = 1 << EERE;
    return EEDR;
}

static uint16_t cycles_of_reading(void)
{
    clock_start();
    uint16_t start = TCNT1;
    EECR = 1 << EERE;
    return TCNT1 - start;
}

static uint16_t cycles_of_starting(void)
{
    EEAR = 2;
    EEDR = 0x33;
    clock_start();
    EECR = 1 << EEMWE;
    uint16_t start = TCNT1L;
    __asm__ volatile("sbi %0, 1" ::"I"(_SFR_IO_ADDR(EECR)));
    return TCNT1L - start;
}

int main(void)
{
    slow_clock();
    write_in_time(1, 0x5A);
    uint8_t busy = (EECR & (1 << EEWE)) != 0;
    EEAR = 7; // locked meanwhile
    while (EECR & (1 << EEWE)) {
    }
    uint16_t took = TCNT1;
    uint8_t moved = EEAR == 7;
    uint8_t stored = read(1);
    write_too_late(1, 0x77);
    uint8_t late = (EECR & (1 << EEWE)) != 0;
    uint8_t kept = read(1);
    uint16_t reading = cycles_of_reading();
    uint16_t starting = cycles_of_starting();
    uint16_t early = ready;
    EECR = 1 << EERIE;
    sei();
    wait(1000);
    early = ready; // the write goes on: none
    cli();
    while (EECR & (1 << EEWE)) {
    }
    sei();
    wait(1000);
    cli();
    print_open();
    print("us", took / 2);
    print("busy", busy);
    print("moved", moved);
    print("stored", stored);
    print("late", late);
    print("kept", kept);
    print("reading", reading);
    print("starting", starting);
    print("early", early);
    print("ready", ready);
    end();
}
