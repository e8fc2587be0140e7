/* SPDX-License-Identifier: MIT */
/* Poses of the store for the group; see stored_pose.h. */
#include "robot/stored_pose.h"

#include <string.h>

#include "cds55xx/motion.h" // CDS_POSE_NONE

void stored_joints_find(struct stored_joints *joints, const struct motion_store *store,
                        const struct robot *robot)
{
    uint8_t ids[MOTION_STORE_JOINTS];
    uint8_t count = motion_store_read_joints(store, ids);

    joints->group_count = robot->group_count;
    memset(joints->index, MOTION_STORE_NONE, sizeof joints->index);
    for (uint8_t i = 0; i < count; i++) {
        const uint8_t *at = memchr(robot->group, ids[i], robot->group_count);

        if (at)
            joints->index[i] = (uint8_t)(at - robot->group);
    }
}

static void clear(uint16_t *pose, uint8_t count)
{
    memset(pose, UINT8_MAX, 2 * (size_t)count); // CDS_POSE_NONE
}

enum stored_pose_result stored_pose_read(const struct motion_store *store,
                                         const struct stored_joints *joints, uint8_t place,
                                         uint16_t *pose)
{
    uint16_t positions[MOTION_STORE_JOINTS];

    clear(pose, joints->group_count);
    if (!motion_store_read_pose(store, place, positions))
        return STORED_POSE_MISSING;
    for (uint8_t joint = 0; joint < MOTION_STORE_JOINTS; joint++) {
        if (positions[joint] == CDS_POSE_NONE)
            continue;
        if (joints->index[joint] == MOTION_STORE_NONE) {
            clear(pose, joints->group_count);
            return STORED_POSE_ABSENT;
        }
        pose[joints->index[joint]] = positions[joint];
    }
    return STORED_POSE_READ;
}

enum stored_pose_result stored_step_pose(const struct motion_store *store,
                                         const struct stored_joints *joints, uint8_t place,
                                         uint8_t index, uint16_t *pose)
{
    struct motion_store_step step;

    if (!motion_store_read_step(store, place, index, &step))
        return STORED_POSE_END;
    return stored_pose_read(store, joints, motion_store_pose_of(store, step.pose), pose);
}
