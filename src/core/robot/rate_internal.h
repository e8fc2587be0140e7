/* SPDX-License-Identifier: MIT */
/* What motion.c and gait.c share: the rate at which their time runs, and the end of their cycle;
 * not installed. Any context. */
#ifndef CDS_RATE_INTERNAL_H
#define CDS_RATE_INTERNAL_H

#include "cds55xx/cycle.h" // struct cds_cycle

/* Returns the rate of the next period: `rate`, changed towards `goal` by at most `step`. */
static inline uint32_t cds_rate_next(uint32_t rate, uint32_t goal, uint32_t step)
{
    if (rate < goal)
        return goal - rate > step ? rate + step : goal;
    return rate - goal > step ? rate - step : goal;
}

/* True if goals are no longer sent: the cycle was aborted, or begun again. `begun`: cycle->begun
 * when the motion or the gait began. */
static inline bool cds_cycle_is_lost(const struct cds_cycle *cycle, uint8_t begun)
{
    return cycle->is_aborted || cycle->begun != begun;
}

#endif
