/* SPDX-License-Identifier: MIT */
/* Where a joint rests before a move or a gait begins; for motion_path.c and gait_plan.c; not
 * installed. Main context. */
#ifndef CDS_REST_INTERNAL_H
#define CDS_REST_INTERNAL_H

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "cds55xx/cycle.h"         // struct cds_cycle
#include "cds55xx/motion.h"        // CDS_MOTION_NEAR_STEPS
#include "cds55xx/port.h"          // cds_port_now_us()

#define CDS_REST_OLD_US ((uint32_t)500000) // older feedback is ignored

/* Sets *position to where joint `index` of the cycle rests: at its last goal `goal`, or if its
 * servo reports a position more than CDS_MOTION_NEAR_STEPS away from that, at the reported
 * position. `goal`: 0 to 1023, or CDS_CYCLE_NO_GOAL. False: the servo has not reported within
 * 0.5 s; nothing was set. */
static inline bool cds_rest_find(const struct cds_cycle *cycle, uint8_t index, uint16_t goal,
                                 uint16_t *position)
{
    const struct cds_feedback *feedback = &cycle->feedback[index];
    uint16_t reported = feedback->position;

    if (!feedback->known || cds_port_now_us() - feedback->time_us > CDS_REST_OLD_US)
        return false;
    if (goal > CDS_VALUE_MAX ||
        (uint16_t)(reported - goal + CDS_MOTION_NEAR_STEPS) > 2 * CDS_MOTION_NEAR_STEPS)
        goal = reported;
    *position = goal;
    return true;
}

#endif
