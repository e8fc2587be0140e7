/* The chip's EEPROM; see eeprom.h. */
#include "avr/eeprom_driver.h"

#include <avr/io.h>
#include <avr/interrupt.h>

#ifdef EEWE // ATmega128: the names of the older data sheets
#define EEPE  EEWE
#define EEMPE EEMWE
#endif

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

/* EEPE counts only within four cycles of EEMPE, so no handler may come between them. Two sbi: what
 * a compiler makes of C could grow. */
void avr_eeprom_write(uint16_t address, uint8_t byte)
{
    uint8_t sreg = SREG;

    EEAR = address;
    EEDR = byte;
    __asm__ volatile("cli            \n\t"
                     "sbi %[c], %[m] \n\t"   // 2 cycles
                     "sbi %[c], %[w] \n\t"   // 2, and 2 that the CPU stands still
                     "out __SREG__, %[sreg]" // 1
                     :
                     : [c] "I"(_SFR_IO_ADDR(EECR)), [m] "I"(EEMPE), [w] "I"(EEPE), [sreg] "r"(sreg)
                     : "memory");
}
