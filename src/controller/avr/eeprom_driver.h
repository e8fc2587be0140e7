/* The chip's EEPROM, a byte at a time, without waiting. It belongs to the firmware, not to the
 * library.
 *
 * A byte takes 8.5 ms to write (ATmega128) or 3.4 ms (the others), and until then nothing can be
 * read. There is no interrupt: whoever writes asks avr_eeprom_ready() in its turn. This header
 * knows no chip, so that what is built on it also runs on a host;
 * test/support/eeprom_fake.c is the other port.
 */
#ifndef AVR_EEPROM_H
#define AVR_EEPROM_H

#include <stdbool.h>
#include <stdint.h>

/* Is no write under way? After a reset one may still be. Main context. */
bool avr_eeprom_ready(void);

/* Returns the byte at `address`, 0 to the chip's last one. Only when ready. The CPU stands still
 * for 4 cycles, with interrupts as they are. Main context. */
uint8_t avr_eeprom_read(uint16_t address);

/* Begins to write `byte` at `address`, 0 to the chip's last one; the old byte is erased first. Only
 * when ready, and while no boot loader writes flash. Interrupts are off for 7 cycles, the 2 that
 * the CPU stands still among them, and for the instruction behind: a servo's reply may begin 32
 * cycles after the last stop bit (return delay 1), so the turnaround bears it. Main context. */
void avr_eeprom_write(uint16_t address, uint8_t byte);

#endif
