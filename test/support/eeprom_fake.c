/* SPDX-License-Identifier: MIT */
/* An EEPROM for tests; see eeprom_fake.h. */
#include "eeprom_fake.h"

#include <string.h>

#include "avr/eeprom_driver.h" // what is implemented here

struct eeprom_fake eeprom_fake;

void eeprom_fake_reset_to(uint8_t *bytes, uint16_t size)
{
    memset(bytes, 0xFF, size);
    eeprom_fake = (struct eeprom_fake){.bytes = bytes, .size = size, .dead = FAKE_NO_CELL};
}

void eeprom_fake_reset(void)
{
    static uint8_t bytes[FAKE_EEPROM_SIZE];

    eeprom_fake_reset_to(bytes, sizeof bytes);
}

void eeprom_fake_power_up(void)
{
    eeprom_fake.has_no_power = false;
    eeprom_fake.cut_at = 0;
    eeprom_fake.busy = 0;
}

static bool is_allowed(uint16_t address)
{
    bool good = eeprom_fake.busy == 0 && address < eeprom_fake.size;

    eeprom_fake.breaches = (uint16_t)(eeprom_fake.breaches + !good);
    return good;
}

uint16_t avr_eeprom_size(void)
{
    return eeprom_fake.size;
}

bool avr_eeprom_ready(void)
{
    if (eeprom_fake.busy == 0)
        return true;
    eeprom_fake.busy--;
    return false;
}

uint8_t avr_eeprom_read(uint16_t address)
{
    if (eeprom_fake.has_more && address >= eeprom_fake.size)
        return 0xFF;
    return is_allowed(address) ? eeprom_fake.bytes[address] : 0;
}

static uint8_t byte_after_cut(uint8_t old, uint8_t byte)
{
    switch (eeprom_fake.cut) {
    case CUT_OLD: return old;
    case CUT_HALF_ERASED: return old | 0x0F;
    case CUT_ERASED: return 0xFF;
    case CUT_HALF_WRITTEN: return byte | 0xF0;
    default: return byte;
    }
}

void avr_eeprom_write(uint16_t address, uint8_t byte)
{
    if (!is_allowed(address) || eeprom_fake.has_no_power)
        return;
    if (++eeprom_fake.writes == eeprom_fake.cut_at) {
        eeprom_fake.has_no_power = true;
        byte = byte_after_cut(eeprom_fake.bytes[address], byte);
    }
    eeprom_fake.bytes[address] = address == eeprom_fake.dead ? 0x55 : byte;
    eeprom_fake.busy = eeprom_fake.slow;
}
