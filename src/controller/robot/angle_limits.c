/* SPDX-License-Identifier: MIT */
/* The angle limits of the servos; see angle_limits.h. */
#include "robot/angle_limits.h"

#include <string.h> // memcpy()

#include "cds55xx/motion.h" // CDS_POSE_NONE

void angle_limits_take(struct angle_limits *limits, const uint8_t *registers)
{
    memcpy(limits, registers, sizeof *limits); // the low byte first, as in the chip
}

uint8_t angle_limits_beyond(const struct angle_limits *limits, const uint16_t *pose, uint8_t count)
{
    for (uint8_t joint = 0; joint < count; joint++, pose++, limits++)
        if (*pose != CDS_POSE_NONE && (*pose < limits->lowest || *pose > limits->highest))
            return joint;
    return ANGLE_LIMITS_NO_JOINT;
}
