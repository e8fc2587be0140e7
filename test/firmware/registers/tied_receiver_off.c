/* SPDX-License-Identifier: MIT */
/* RXEN only behind the last stop bit: too late for a reply without return delay. */
#define TIED
#define MUTANT_RECEIVER_OFF
#include "wiring.h"
