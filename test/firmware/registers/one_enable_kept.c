/* SPDX-License-Identifier: MIT */
/* The one enable stays high too long. */
#define MUTANT_ENABLE_KEPT
#include "wiring.h"
