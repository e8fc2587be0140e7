/* SPDX-License-Identifier: MIT */
/* TXD is an output of the port while TXEN is off: the servos cannot pull the wire low. */
#define TIED
#define MUTANT_TXD_OUTPUT
#include "wiring.h"
