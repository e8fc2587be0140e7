/* SPDX-License-Identifier: MIT */
/* CRC-16 of what is kept in the EEPROM: polynomial 0x1021, bits reflected, from 0xFFFF, not
 * inverted (CRC-16/MCRF4XX; what avr-libc calls ccitt). Of "123456789" it is 0x6F91. */
#ifndef CONTROLLER_CRC_H
#define CONTROLLER_CRC_H

#include <stdint.h>

#include "compiler.h" // ALWAYS_INLINE

#define CRC_BEGIN 0xFFFFu

/* Returns `crc` with one more byte. */
ALWAYS_INLINE uint16_t crc_add(uint16_t crc, uint8_t byte)
{
    uint8_t low = (uint8_t)(byte ^ crc);

    low = (uint8_t)(low ^ low << 4);
    crc = (uint16_t)(((uint16_t)low << 8 | crc >> 8) ^ low >> 4);
    /* low << 3 in two bytes: an AVR shifts 16 bits in a loop */
    return (uint16_t)(crc ^ (uint16_t)(low >> 5) << 8 ^ (uint8_t)(low << 3));
}

#endif
