/* SPDX-License-Identifier: MIT */
/* An adapter, right: nothing to switch, the receiver always on, TXD an output and high. */
#define ADAPTER
#include "wiring.h"
