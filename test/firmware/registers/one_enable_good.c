/* SPDX-License-Identifier: MIT */
/* One enable, right. */
#include "wiring.h"
