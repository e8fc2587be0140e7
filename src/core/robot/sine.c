/* SPDX-License-Identifier: MIT */
/* The sine of a gait: a quarter of a turn in flash, with interpolation. */
#include "robot/sine_internal.h"

#include "flash.h" // CDS_FLASH

/* sin(i / 64 of a quarter turn), in 1/8192. Neighbours differ by less than 256. */
static const CDS_FLASH uint16_t quarter[] = {
    0,    201,  402,  603,  803,  1003, 1202, 1401, 1598, 1795, 1990, 2185, 2378,
    2570, 2760, 2948, 3135, 3320, 3503, 3683, 3862, 4038, 4212, 4383, 4551, 4717,
    4880, 5040, 5197, 5351, 5501, 5649, 5793, 5933, 6070, 6203, 6333, 6458, 6580,
    6698, 6811, 6921, 7027, 7128, 7225, 7317, 7405, 7489, 7568, 7643, 7713, 7779,
    7839, 7895, 7946, 7993, 8035, 8071, 8103, 8130, 8153, 8170, 8182, 8190, 8191,
};

uint16_t cds_sine_height(uint16_t phase)
{
    const CDS_FLASH uint16_t *entry;
    uint16_t low;
    uint8_t rise;

    if (phase & CDS_SINE_QUARTER) // downwards
        phase = (uint16_t)~phase;
    entry = &quarter[(uint8_t)(phase >> 8) & 0x3F];
    low = *entry++;
    rise = (uint8_t)((uint8_t)*entry - (uint8_t)low);
    return (uint16_t)((low + ((uint16_t)(rise * (uint8_t)phase) >> 8)) * 8);
}
