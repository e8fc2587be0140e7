/* SPDX-License-Identifier: MIT */
/* Reads and writes the chip's EEPROM one byte at a time, and never waits.
 *
 * Writing a byte takes 8.5 ms (ATmega128) or 3.4 ms (the other chips); until then no byte can be
 * read. The driver uses no interrupt: the caller polls avr_eeprom_ready(). This header names no
 * chip, so its callers also run on a PC, over test/support/eeprom_fake.c.
 */
#ifndef AVR_EEPROM_H
#define AVR_EEPROM_H

#include <stdbool.h>
#include <stdint.h>

/* Returns the bytes of the chip's EEPROM. Any context. */
uint16_t avr_eeprom_size(void);

/* True if no write is under way. After a reset a write may still be. Main context. */
bool avr_eeprom_ready(void);

/* Returns the byte at `address`, 0 to the chip's last one. Only when ready. The CPU halts for 4
 * cycles. Main context. */
uint8_t avr_eeprom_read(uint16_t address);

/* Begins to write `byte` at `address`, 0 to the chip's last one; the chip erases the old byte
 * first. Only when ready, and while no boot loader writes flash. Interrupts are off for 7 cycles
 * and one more instruction. The turnaround of the bus bears that: with return delay 1 a reply
 * begins 32 cycles after the last stop bit. Main context. */
void avr_eeprom_write(uint16_t address, uint8_t byte);

#endif
