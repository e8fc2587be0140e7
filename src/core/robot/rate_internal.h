/* SPDX-License-Identifier: MIT */
/* The rate at which the time of a motion or a gait runs; not installed. Any context. */
#ifndef CDS_RATE_INTERNAL_H
#define CDS_RATE_INTERNAL_H

#include <stdint.h>

/* Returns the rate of the next period: `rate`, changed towards `goal` by at most `step`. */
static inline uint32_t cds_rate_next(uint32_t rate, uint32_t goal, uint32_t step)
{
    if (rate < goal)
        return goal - rate > step ? rate + step : goal;
    return rate - goal > step ? rate - step : goal;
}

#endif
