/* SPDX-License-Identifier: MIT */
/* Accepted by simavr as it is and by the exact USART. */
#include "half_duplex.h"
