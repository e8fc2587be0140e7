/* SPDX-License-Identifier: MIT */
/* The simulated AVR as gdb addresses it: memory in one address space, and numbered registers. */
#ifndef SIM_GDB_MEMORY_H
#define SIM_GDB_MEMORY_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

#include "avr/eeprom_model.h"

#define GDB_DATA_SPACE 0x800000u // address of the data space; flash is at 0, EEPROM at 0x810000
#define GDB_REGISTERS  35        // r0 to r31, SREG, SP, PC

struct gdb_machine {
    avr_t *avr;
    const struct eeprom_model *eeprom;
};

/* Read and write a byte. Return false if there is no such address. */
bool gdb_memory_load(const struct gdb_machine *machine, uint32_t address, uint8_t *byte);
bool gdb_memory_store(const struct gdb_machine *machine, uint32_t address, uint8_t byte);

/* Read and write a register, low byte first. Return its size: 1, 2 or 4 bytes. */
unsigned gdb_register_load(const struct gdb_machine *machine, unsigned number, uint8_t bytes[4]);
unsigned gdb_register_store(const struct gdb_machine *machine, unsigned number,
                            const uint8_t bytes[4]);

#endif
