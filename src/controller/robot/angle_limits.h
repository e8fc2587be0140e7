/* SPDX-License-Identifier: MIT */
/* The angle limits that each servo of the group keeps itself, CW_ANGLE_LIMIT and CCW_ANGLE_LIMIT:
 * it does not take a goal beyond them. A motion and the autostart check poses before they begin.
 *
 * Main context. */
#ifndef CONTROLLER_ANGLE_LIMITS_H
#define CONTROLLER_ANGLE_LIMITS_H

#include "robot/robot.h" // struct angle_limits

#define ANGLE_LIMITS_NO_JOINT UINT8_MAX

/* Stores the limits of a servo. `registers`: CW_ANGLE_LIMIT and those behind. */
void angle_limits_take(struct angle_limits *limits, const uint8_t *registers);

/* Returns the first of `count` joints whose position is beyond its limits, or
 * ANGLE_LIMITS_NO_JOINT. `limits`: of each joint. */
uint8_t angle_limits_beyond(const struct angle_limits *limits, const uint16_t *pose, uint8_t count);

#endif
