/* SPDX-License-Identifier: MIT */
/* Turns the receiver on 320 cycles late. */
#define MUTANT_LATE_TURNAROUND
#include "half_duplex.h"
