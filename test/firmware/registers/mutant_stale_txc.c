/* SPDX-License-Identifier: MIT */
/* Never clears TXC: a pause within a packet sets it, and the driver lets go during the last byte.
 */
#define MUTANT_STALE_TXC
#include "half_duplex.h"
