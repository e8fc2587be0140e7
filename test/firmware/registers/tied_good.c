/* SPDX-License-Identifier: MIT */
/* Tied pins, right: TXEN cleared with two bytes to go, the receiver always on. */
#define TIED
#include "wiring.h"
