/* SPDX-License-Identifier: MIT */
/* The group that a motion chooses; see stored_group.h. */
#include "robot/stored_group.h"

#include "robot/moves.h"

uint8_t stored_group_choose(struct robot *robot, const struct motion_store *store)
{
    uint8_t ids[MOTION_STORE_JOINTS], before = robot->servos.count, error;

    if (robot->group_count)
        return 0;
    error = robot_choose_group(robot, ids, motion_store_read_servos(store, ids));
    if (error == 0 && robot->moves) {
        robot->moves->group_is_tried = true;
        robot->moves->tried_from = before;
    }
    return error;
}

void stored_group_keep(struct robot *robot)
{
    if (robot->moves)
        robot->moves->group_is_tried = false;
}

void stored_group_drop(struct robot *robot)
{
    if (!robot->moves || !robot->moves->group_is_tried)
        return;
    robot->moves->group_is_tried = false;
    robot_forget_group(robot, robot->moves->tried_from);
}
