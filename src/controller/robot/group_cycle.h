/* SPDX-License-Identifier: MIT */
/* The cycle of the group: an operation of the robot that shares the bus with other requests.
 *
 * Main context. */
#ifndef CONTROLLER_GROUP_CYCLE_H
#define CONTROLLER_GROUP_CYCLE_H

#include "robot/robot.h" // struct robot

/* Time in which each servo must have answered once. */
#define GROUP_CYCLE_KNOWN_US 1000000ul

/* Its config: the period in us, a uint16_t. The servos are robot->group. */
extern const CDS_FLASH struct robot_operation group_cycle;

/* The functions of this operation, for one that does more than it. */
enum cds_result group_cycle_begin(struct robot *robot, const void *config);
enum cds_result group_cycle_poll(struct robot *robot);
void group_cycle_abort(struct robot *robot);

/* Returns CDS_PENDING until each servo of the running cycle has answered once; CDS_OK; or, at
 * GROUP_CYCLE_KNOWN_US after `begun_us`, how the READ of a servo failed. */
enum cds_result group_cycle_await_positions(const struct robot *robot, uint32_t begun_us);

#endif
