/* SPDX-License-Identifier: MIT */
/* Lets the wire go 320 cycles late: the reply has begun. Every simulator with a wire sees it. */
#define MUTANT_LATE_RELEASE
#include "half_duplex.h"
