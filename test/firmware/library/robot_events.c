/* SPDX-License-Identifier: MIT */
/* A robot of three joints that makes one timed move and stops. It says each event, and where the
 * joints are behind the move. */
#include <cds55xx/robot.h>
#include <cds55xx/avr.h>

#include "say.h"

#define MOVE_MS     600
#define STOP_PERIOD 400 // 1.6 s

CDS_JOINTS(joints) = {
    CDS_JOINT(1, CDS_FORWARD, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "hip"),
    CDS_JOINT(2, CDS_REVERSED, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "knee"),
    CDS_JOINT(3, CDS_FORWARD, 100000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "foot"),
};
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

static struct cds_motion motion;
static struct cds_motion_joint motion_joints[CDS_JOINT_COUNT(joints)];
static uint16_t pose[CDS_JOINT_COUNT(joints)];

static void begin_move(void)
{
    cds_robot_begin_motion(&robot, &motion, motion_joints, NULL);
    for (uint8_t i = 0; i < CDS_JOINT_COUNT(joints); i++)
        cds_robot_to_position(&robot, i, 20000, &pose[i]);
    cds_motion_move(&motion, &(struct cds_move){.pose = pose, .time_ms = MOVE_MS});
}

static void on_event(struct cds_robot *it)
{
    say("kind", it->event.kind);
    say("joint", it->event.joint);
    say("why", it->event.why);
    say("result", it->event.result);
    say("alarms", it->event.alarms);
    if (it->event.kind == CDS_ROBOT_EVENT_STARTED)
        begin_move();
}

static void say_positions(void)
{
    int32_t mdeg = 0;

    for (uint8_t i = 0; i < CDS_JOINT_COUNT(joints); i++) {
        cds_robot_position_mdeg(&robot, i, &mdeg);
        say_signed("mdeg", mdeg);
    }
}

int main(void)
{
    say_open();
    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    robot.on_event = on_event;
    cds_robot_start(&robot);
    while (cds_robot_poll(&robot) != CDS_ROBOT_STOPPED)
        if (robot.state == CDS_ROBOT_RUNNING && robot.cycle.counters.periods == STOP_PERIOD)
            cds_robot_stop(&robot);
    say("move", motion.result);
    say_positions();
    for (;;) { // the script ends the run
    }
}
