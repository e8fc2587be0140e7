/* SPDX-License-Identifier: MIT */
#include "avr/gdb_memory.h"

#include <string.h>

#define EEPROM_BASE 0x810000u

/* Registers in gdb's order; 0 to 31 are r0 to r31. */
enum { REGISTER_SREG = 32, REGISTER_SP = 33, REGISTER_PC = 34 };

static uint8_t sreg(const avr_t *avr)
{
    unsigned value = 0;
    for (unsigned bit = 0; bit < 8; bit++) {
        value |= (unsigned)(avr->sreg[bit] != 0) << bit;
    }
    return (uint8_t)value;
}

static void store_data(const struct gdb_machine *machine, uint32_t address, uint8_t byte)
{
    avr_t *avr = machine->avr;
    uint32_t io = AVR_DATA_TO_IO(address);
    if (address == R_SREG) {
        for (unsigned bit = 0; bit < 8; bit++) {
            avr->sreg[bit] = byte >> bit & 1;
        }
    } else if (address > 31 && address <= avr->ioend && io < MAX_IOs && avr->io[io].w.c) {
        avr->io[io].w.c(avr, (avr_io_addr_t)address, byte, avr->io[io].w.param);
        return;
    }
    avr->data[address] = byte;
}

/* Reads a byte at gdb's address: flash from 0, data space from 0x800000, EEPROM from 0x810000.
 * Reads I/O registers without the side effects that a read by the CPU has. */
bool gdb_memory_load(const struct gdb_machine *machine, uint32_t address, uint8_t *byte)
{
    const avr_t *avr = machine->avr;
    const avr_eeprom_t *eeprom = machine->eeprom->registers;
    if (address <= avr->flashend) {
        *byte = avr->flash[address];
    } else if (address >= EEPROM_BASE && eeprom && address - EEPROM_BASE < eeprom->size) {
        *byte = eeprom->eeprom[address - EEPROM_BASE];
    } else if (address >= GDB_DATA_SPACE && address - GDB_DATA_SPACE <= avr->ramend + 2u) {
        address -= GDB_DATA_SPACE; // gdb looks for a return address beyond an empty stack, too
        *byte = address == R_SREG ? sreg(avr) : avr->data[address];
    } else {
        return false;
    }
    return true;
}

bool gdb_memory_store(const struct gdb_machine *machine, uint32_t address, uint8_t byte)
{
    const avr_eeprom_t *eeprom = machine->eeprom->registers;
    if (address <= machine->avr->flashend) {
        machine->avr->flash[address] = byte;
    } else if (address >= EEPROM_BASE && eeprom && address - EEPROM_BASE < eeprom->size) {
        eeprom->eeprom[address - EEPROM_BASE] = byte;
    } else if (address >= GDB_DATA_SPACE && address - GDB_DATA_SPACE <= machine->avr->ramend) {
        store_data(machine, address - GDB_DATA_SPACE, byte);
    } else {
        return false;
    }
    return true;
}

unsigned gdb_register_load(const struct gdb_machine *machine, unsigned number, uint8_t bytes[4])
{
    const avr_t *avr = machine->avr;
    switch (number) {
    case REGISTER_SREG: bytes[0] = sreg(avr); return 1;
    case REGISTER_SP: memcpy(bytes, &avr->data[R_SPL], 2); return 2;
    case REGISTER_PC:
        for (unsigned i = 0; i < 4; i++) {
            bytes[i] = (uint8_t)(avr->pc >> 8 * i);
        }
        return 4;
    default: bytes[0] = avr->data[number]; return 1;
    }
}

unsigned gdb_register_store(const struct gdb_machine *machine, unsigned number,
                            const uint8_t bytes[4])
{
    avr_t *avr = machine->avr;
    switch (number) {
    case REGISTER_SREG: store_data(machine, R_SREG, bytes[0]); return 1;
    case REGISTER_SP: memcpy(&avr->data[R_SPL], bytes, 2); return 2;
    case REGISTER_PC:
        avr->pc = (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16;
        return 4;
    default: avr->data[number] = bytes[0]; return 1;
    }
}
