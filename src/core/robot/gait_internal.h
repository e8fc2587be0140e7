/* SPDX-License-Identifier: MIT */
/* What gait.c and gait_plan.c need of each other; not installed. Main context. */
#ifndef CDS_GAIT_INTERNAL_H
#define CDS_GAIT_INTERNAL_H

#include "cds55xx/gait.h"

#define CDS_GAIT_HALF_STEP 0x8000u         // positions are in 1/65536 step
#define CDS_GAIT_1         16384           // of scales, speed and rate
#define CDS_GAIT_SPEED     CDS_GAIT_GROUPS // index of the speed among the ramped values
#define CDS_GAIT_RESERVE   4 // 1 / 4 of the highest speed of a joint is added to its speeds

/* Checks the positions of joint `index` and prepares it; if `is_second`, checks its speed, when the
 * positions of all joints are checked. Returns CDS_OK, or why the gait is refused. If a joint is
 * too fast, gait->shortest_ms is not 0 in the end. */
enum cds_result cds_gait_check(struct cds_gait *gait, uint8_t index, bool is_second);

/* Returns period_us / time_ms, in 1/2^32. */
uint32_t cds_gait_share(uint16_t period_us, uint16_t time_ms);

#endif
