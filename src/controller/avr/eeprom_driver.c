/* SPDX-License-Identifier: MIT */
/* The chip's EEPROM; see eeprom_driver.h. */
#include "avr/eeprom_driver.h"

#include <avr/io.h>
#include <avr/interrupt.h>

#ifdef EEWE // ATmega128: names of the older data sheets
#define EEPE  EEWE
#define EEMPE EEMWE
#endif

uint16_t avr_eeprom_size(void)
{
    return E2END + 1;
}

bool avr_eeprom_ready(void)
{
    return !(EECR & 1 << EEPE);
}

uint8_t avr_eeprom_read(uint16_t address)
{
    EEAR = address;
    EECR |= 1 << EERE; // sbi
    return EEDR;
}

/* EEPE has an effect only within four cycles after EEMPE, so no handler may run between them. In
 * assembly: code that a compiler makes of C could take more than four cycles. */
void avr_eeprom_write(uint16_t address, uint8_t byte)
{
    uint8_t sreg = SREG;

    EEAR = address;
    EEDR = byte;
    __asm__ volatile("cli            \n\t"
                     "sbi %[c], %[m] \n\t"   // 2 cycles
                     "sbi %[c], %[w] \n\t"   // 2, and the CPU halts for 2
                     "out __SREG__, %[sreg]" // 1
                     :
                     : [c] "I"(_SFR_IO_ADDR(EECR)), [m] "I"(EEMPE), [w] "I"(EEPE), [sreg] "r"(sreg)
                     : "memory");
}
