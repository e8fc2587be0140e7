/* SPDX-License-Identifier: MIT */
/* Timed moves of a robot; see robot.h. In a file of its own: a program without timed moves does not
 * link motion.c. */
#include "cds55xx/robot.h"

/* A robot that stops aborts its cycle: the motion then ends as CDS_INHIBITED. */
static void poll_motion(struct cds_robot *robot)
{
    cds_motion_poll((struct cds_motion *)robot->context);
}

enum cds_result cds_robot_begin_motion(struct cds_robot *robot, struct cds_motion *motion,
                                       struct cds_motion_joint *joints,
                                       const struct cds_register_profile *const *profiles)
{
    enum cds_result result;

    if (robot->state != CDS_ROBOT_RUNNING)
        return CDS_INHIBITED;
    result = cds_motion_begin(motion, &(struct cds_motion_config){.cycle = &robot->cycle,
                                                                  .servos = &robot->servos,
                                                                  .joints = joints,
                                                                  .profiles = profiles});
    if (result != CDS_OK)
        return result;
    robot->context = motion;
    robot->on_poll = poll_motion;
    return CDS_OK;
}
