/* SPDX-License-Identifier: MIT */
/* What to do about alarms, in a firmware without unasked.h. Linked where advice.h is. */
#ifndef CONTROLLER_ADVICE_ALARMS_H
#define CONTROLLER_ADVICE_ALARMS_H

#include <stdint.h>

#include "flash.h" // CDS_FLASH

struct console;

/* Returns the remedy of a new alarm of servo `failsafe->next`, with "; " in front: after damaged
 * packets it names them; "" if this remedy was told before. Its value is in value 4 of the printer.
 * For a firmware without unasked.h. */
const CDS_FLASH char *advice_alarm_remedy(struct console *console, uint8_t condition);

/* Marks the alarm of this refusal as reported: the reply has just named it. In mode person, for a
 * firmware without unasked.h. */
void advice_note_refused(struct console *console, uint8_t error);

#endif
