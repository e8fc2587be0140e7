/* SPDX-License-Identifier: MIT */
/* Writes 5A to byte 0 of the EEPROM, and then A5, for a test that resets the chip meanwhile. PB0
 * says that the second write goes on. */
#include <avr/eeprom.h>

#include "chip.h"

int main(void)
{
    DDRB = 1;
    eeprom_write_byte(0, 0x5A);
    eeprom_write_byte(0, 0xA5);
    PORTB = 1;
    eeprom_busy_wait();
    PORTB = 0;
    for (;;) {
    }
}
