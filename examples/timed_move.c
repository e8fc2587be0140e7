/* SPDX-License-Identifier: MIT */
/* Two joints, servos 1 and 2, go to and fro by timed moves: both arrive after 1.5 s, smoothly. The
 * program of docs/motion.md. */
#include <cds55xx/motion.h>
#include <cds55xx/robot.h>
#include <cds55xx/avr.h>
#include "stop_report.h"

CDS_JOINTS(joints) = {
    CDS_JOINT(1, CDS_FORWARD, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "left"),
    CDS_JOINT(2, CDS_REVERSED, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "right"),
};
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

static struct cds_motion motion;
static struct cds_motion_joint motion_joints[CDS_JOINT_COUNT(joints)];
static uint16_t pose[CDS_JOINT_COUNT(joints)]; // stays in place until the move is over

static void on_event(struct cds_robot *self)
{
    stop_report_note(self);
    if (self->event.kind == CDS_ROBOT_EVENT_STARTED)
        cds_robot_begin_motion(self, &motion, motion_joints, NULL);
}

static void move_to(int32_t left_mdeg, int32_t right_mdeg)
{
    uint8_t result = CDS_OK;

    if (cds_robot_to_position(&robot, 0, left_mdeg, &pose[0]) != CDS_OK)
        stop_report_beyond(&robot, STOP_REPORT_NO_STEP, 0, left_mdeg);
    else if (cds_robot_to_position(&robot, 1, right_mdeg, &pose[1]) != CDS_OK)
        stop_report_beyond(&robot, STOP_REPORT_NO_STEP, 1, right_mdeg);
    else
        result = cds_motion_move(&motion, &(struct cds_move){.pose = pose, .time_ms = 1500});
    if (result != CDS_OK)
        stop_report_refused(&robot, result, STOP_REPORT_NO_STEP, &motion);
}

int main(void)
{
    int32_t mdeg = 60000;
    uint8_t result;

    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    robot.on_event = on_event;
    cds_robot_start(&robot);
    for (;;) {
        cds_robot_poll(&robot);
        stop_report_poll(&robot);
        if (robot.state != CDS_ROBOT_RUNNING || cds_motion_is_busy(&motion) ||
            motion.result == CDS_PENDING)
            continue;
        result = motion.move_result != CDS_OK ? motion.move_result : motion.result;
        if (result != CDS_OK) // refused, or ended early
            stop_report_refused(&robot, result, STOP_REPORT_NO_STEP, &motion);
        else
            move_to(mdeg, mdeg / 2);
        mdeg = -mdeg;
    }
}
