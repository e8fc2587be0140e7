/* SPDX-License-Identifier: MIT */
/* Lets the wire go when UDR is empty: one or two bytes too early. */
#define MUTANT_RELEASE_ON_UDRE
#include "half_duplex.h"
