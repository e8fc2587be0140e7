/* SPDX-License-Identifier: MIT */
/* Timed moves of a robot; see robot.h. In a file of its own: a program without timed moves does not
 * link motion.c. */
#include "cds55xx/robot.h"

/* A robot that stops sends no more goals, so the move cannot come to rest on its way. */
static void poll_motion(struct cds_robot *robot)
{
    struct cds_motion *motion = (struct cds_motion *)robot->context;

    if (robot->state == CDS_ROBOT_RUNNING) {
        cds_motion_poll(motion);
        return;
    }
    if (motion->result == CDS_PENDING)
        motion->result = CDS_INHIBITED;
    if (motion->move_result == CDS_PENDING)
        motion->move_result = CDS_INHIBITED;
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
