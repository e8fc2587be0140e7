/* SPDX-License-Identifier: MIT */
/* What cycle.c needs of cycle_goals.c, the two packets of goals; and what a motion or a gait needs
 * of its cycle beside cycle.h. Not installed. Main context. */
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

/* True if goals are no longer sent: the cycle was aborted, or begun again, since `begun` was
 * cycle->begun. */
static inline bool cds_cycle_has_ended_since(const struct cds_cycle *cycle, uint8_t begun)
{
    return cycle->is_aborted || cycle->begun != begun;
}

#endif
