/* SPDX-License-Identifier: MIT */
/* Texts that several files share; see messages.h. */
#include "console/messages.h"

const CDS_FLASH char message_nothing[] = "";
const CDS_FLASH char message_servo[] = "servo %u: %s";
const CDS_FLASH char message_too_fast[] = "servo %u needs %l ms";
