/* SPDX-License-Identifier: MIT */
/* TXD is an open input while TXEN is off. */
#define ADAPTER
#define MUTANT_TXD_FLOATS
#include "wiring.h"
