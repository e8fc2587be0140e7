/* SPDX-License-Identifier: MIT */
/* Takes longer over a byte than a byte takes. */
#define MUTANT_SLOW_HANDLER
#include "half_duplex.h"
