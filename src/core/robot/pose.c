/* SPDX-License-Identifier: MIT */
/* Helpers for poses; see pose.h. */
#include "cds55xx/pose.h"

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "cds55xx/motion.h"        // CDS_POSE_NONE

static uint16_t mirrored(uint16_t position, bool is_turned)
{
    return is_turned && position != CDS_POSE_NONE ? (uint16_t)(CDS_VALUE_MAX - position) : position;
}

void cds_pose_mirror(uint16_t *pose, const struct cds_pose_pair *pairs, uint8_t count)
{
    for (; count; count--, pairs++) {
        uint16_t one = pose[pairs->one];

        pose[pairs->one] = mirrored(pose[pairs->other], pairs->is_turned);
        pose[pairs->other] = mirrored(one, pairs->is_turned);
    }
}

bool cds_pose_add(uint16_t *pose, const int16_t *offsets, uint8_t count)
{
    bool fits = true;

    for (; count; count--, pose++, offsets++) {
        int16_t sum = (int16_t)((int16_t)*pose + *offsets);

        if (*pose == CDS_POSE_NONE)
            continue;
        *pose = (uint16_t)sum;
        if (sum < 0)
            *pose = 0;
        else if (sum > CDS_VALUE_MAX)
            *pose = CDS_VALUE_MAX;
        fits &= *pose == (uint16_t)sum;
    }
    return fits;
}
