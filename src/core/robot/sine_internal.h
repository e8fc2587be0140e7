/* SPDX-License-Identifier: MIT */
/* The sine of a gait; not installed. Any context. */
#ifndef CDS_SINE_INTERNAL_H
#define CDS_SINE_INTERNAL_H

#include <stdint.h>

/* Phases: a turn has 65536. The second half of a turn is the first one with the other sign. */
#define CDS_SINE_QUARTER 0x4000u
#define CDS_SINE_HALF    0x8000u

/* Returns the sine of `phase` without its sign, in 1/65536, at most 65535. Off by at most 19 of
 * 65536. */
uint16_t cds_sine_height(uint16_t phase);

#endif
