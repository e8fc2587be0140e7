/* SPDX-License-Identifier: MIT */
/* The unit in which the value of a register is shown, and in which a bare number is meant. */
#ifndef CONTROLLER_UNIT_NAMES_H
#define CONTROLLER_UNIT_NAMES_H

#include <stdint.h>

#include "cds55xx/units.h" // enum cds_unit
#include "flash.h"         // CDS_FLASH

/* The library's unit, times 10^exponent. */
struct unit_shown {
    char text[4];
    uint8_t kind; // enum number_kind
    uint8_t exponent;
};

extern const CDS_FLASH struct unit_shown unit_shown[]; // by enum cds_unit

#endif
