/* SPDX-License-Identifier: MIT */
/* What main.c knows of its board, for the tests of the controller. */
#include "console/messages.h"

const CDS_FLASH char message_own_rate[] = ", 115200bps, the board's own";
