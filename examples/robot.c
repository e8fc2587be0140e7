/* SPDX-License-Identifier: MIT */
/* A robot of servos 1 to 12 that walks on the spot: goals at 250 Hz, feedback of all, soft limits,
 * a state check, and torque off for all as soon as something is wrong. Put your own gait into
 * gait(). Nothing here waits. */
#include <cds55xx/robot.h>
#include <cds55xx/avr.h>
#include "stop_report.h"

/* 62 degrees to both sides of the middle, 31 RPM. */
#define LEG(id, direction, name)                                                                   \
    CDS_JOINT(id, direction, 150000, -62000, 62000, 31000, CDS_JOINT_CDS55XX, name)

CDS_JOINTS(joints) = {
    LEG(1, CDS_REVERSED, "hip 1"),  LEG(2, CDS_FORWARD, "knee 1"),  LEG(3, CDS_REVERSED, "hip 2"),
    LEG(4, CDS_FORWARD, "knee 2"),  LEG(5, CDS_REVERSED, "hip 3"),  LEG(6, CDS_FORWARD, "knee 3"),
    LEG(7, CDS_REVERSED, "hip 4"),  LEG(8, CDS_FORWARD, "knee 4"),  LEG(9, CDS_REVERSED, "hip 5"),
    LEG(10, CDS_FORWARD, "knee 5"), LEG(11, CDS_REVERSED, "hip 6"), LEG(12, CDS_FORWARD, "knee 6"),
};
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

/* Goals of `period`: each joint swings 37.5 degrees to both sides, hips and knees in opposite
 * directions. */
static void gait(uint16_t period)
{
    int16_t phase = period & 0x1FF, swing = phase < 0x100 ? phase : 0x200 - phase;

    for (uint8_t joint = 0; joint < CDS_JOINT_COUNT(joints); joint++)
        cds_robot_set_goal_mdeg(&robot, joint, (swing - 128) * 293l);
}

int main(void)
{
    uint16_t now = 0;

    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    robot.on_event = stop_report_note;
    cds_robot_start(&robot);
    for (;;) {
        cds_robot_poll(&robot);
        stop_report_poll(&robot);
        if (robot.state == CDS_ROBOT_RUNNING && (uint16_t)robot.cycle.counters.periods != now) {
            now = (uint16_t)robot.cycle.counters.periods;
            gait(now);
        }
    }
}
