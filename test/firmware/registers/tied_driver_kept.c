/* SPDX-License-Identifier: MIT */
/* TXEN stays on behind the last byte. */
#define TIED
#define MUTANT_DRIVER_KEPT
#include "wiring.h"
