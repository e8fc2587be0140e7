/* SPDX-License-Identifier: MIT */
/* The group of a motion when no group is chosen: the servos of the stored poses.
 *
 * Main context. */
#ifndef CONTROLLER_STORED_GROUP_H
#define CONTROLLER_STORED_GROUP_H

#include "robot/motion_store.h" // struct motion_store
#include "robot/robot.h"        // struct robot

/* If no group is chosen, the servos of the stored poses become the group, if there are any. Returns
 * 0, or as robot_choose_group(). */
uint8_t stored_group_choose(struct robot *robot, const struct motion_store *store);

/* A motion that is refused drops the group that stored_group_choose() has chosen for it, and the
 * servos that have joined with the group. A motion that has begun, and a user who chooses a group,
 * keep it. */
void stored_group_drop(struct robot *robot);
void stored_group_keep(struct robot *robot);

#endif
