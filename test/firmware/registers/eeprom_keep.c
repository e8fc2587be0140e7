/* SPDX-License-Identifier: MIT */
/* Counts its starts in the EEPROM. Byte 1 comes with the ELF. */
#include <avr/eeprom.h>

#include "chip.h"

uint8_t EEMEM starts = 0;
uint8_t EEMEM marked = 0x42;

int main(void)
{
    uint8_t count = eeprom_read_byte(&starts);
    eeprom_write_byte(&starts, (uint8_t)(count + 1));
    eeprom_busy_wait();
    print_open();
    print("starts", count);
    print("marked", eeprom_read_byte(&marked));
    end();
}
