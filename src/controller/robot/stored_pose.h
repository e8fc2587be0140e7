/* SPDX-License-Identifier: MIT */
/* Poses of the store (motion_store.h) for the robot's group. A stored pose has positions of joints,
 * and a joint is the ID of a servo.
 *
 * Main context. */
#ifndef CONTROLLER_STORED_POSE_H
#define CONTROLLER_STORED_POSE_H

#include "robot/motion_store.h" // struct motion_store
#include "robot/robot.h"        // struct robot

/* Where the joints of the store are in the group. */
struct stored_joints {
    uint8_t group_count;
    uint8_t index[MOTION_STORE_JOINTS]; // in the group; MOTION_STORE_NONE: the joint is not in it
};

/* Finds the joints in the present group; none if no joints are stored, or while the EEPROM is being
 * written. */
void stored_joints_find(struct stored_joints *joints, const struct motion_store *store,
                        const struct robot *robot);

enum stored_pose_result {
    STORED_POSE_READ,
    STORED_POSE_MISSING, // there is no whole pose at the place, or the EEPROM is being written
    STORED_POSE_ABSENT,  // a joint of the pose is not in the group
    STORED_POSE_END,     // stored_step_pose(): the sequence has no such step
} __attribute__((packed));

/* Reads the pose at `place` (motion_store_find(), motion_store_pose_of()): `pose` gets a position
 * for each servo of the group, in its order, or CDS_POSE_NONE; all are CDS_POSE_NONE unless it
 * returns STORED_POSE_READ. Takes up to 0.3 ms at 16 MHz. */
enum stored_pose_result stored_pose_read(const struct motion_store *store,
                                         const struct stored_joints *joints, uint8_t place,
                                         uint16_t *pose);

/* Reads the pose of step `index` of the sequence at `place`, as stored_pose_read(). While the
 * EEPROM is being written no step can be read: STORED_POSE_END, and `pose` stays as it was. */
enum stored_pose_result stored_step_pose(const struct motion_store *store,
                                         const struct stored_joints *joints, uint8_t place,
                                         uint8_t index, uint16_t *pose);

#endif
