/* SPDX-License-Identifier: MIT */
/* The two packets of goals of a cycle: what cycle.c needs of cycle_goals.c; not installed. Main
 * context. */
#ifndef CDS_CYCLE_INTERNAL_H
#define CDS_CYCLE_INTERNAL_H

#include "cds55xx/cycle.h" // struct cds_cycle

/* Builds both packets, `size` bytes each, with goals that are not set. */
void cds_cycle_build_goals(struct cds_cycle *cycle, uint16_t size);

/* True if every goal in front is good, as far as the permit knows now. Else checks, or writes, at
 * most 8 blocks. */
bool cds_cycle_check_goals(struct cds_cycle *cycle);

/* True if every servo is left out of the goals in front. */
bool cds_cycle_goals_are_empty(const struct cds_cycle *cycle);

#endif
