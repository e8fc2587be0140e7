/* SPDX-License-Identifier: MIT */
/* What robot.c and robot_start.c need of each other; not installed. Main context. */
#ifndef CDS_ROBOT_INTERNAL_H
#define CDS_ROBOT_INTERNAL_H

#include "cds55xx/robot.h"
#include "flash.h" // CDS_FLASH

/* Returns the configuration, which is in flash. */
static inline const CDS_FLASH struct cds_robot_config *
cds_robot_config_of(const struct cds_robot *robot)
{
    return (const CDS_FLASH struct cds_robot_config *)robot->config;
}

/* Reports robot->event. */
void cds_robot_report(struct cds_robot *robot);

/* Begins the steps of a start. */
void cds_robot_begin_steps(struct cds_robot *robot);

/* Moves the start on by at most one transaction. CDS_PENDING; CDS_OK: torque of all servos is on,
 * and feedback has their positions; else a servo is not well, and events have told which. */
enum cds_result cds_robot_poll_steps(struct cds_robot *robot);

#endif
