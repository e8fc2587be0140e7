/* SPDX-License-Identifier: MIT */
/* Two joints, servos 1 and 2, to and fro in step: the program of the README. */
#include <cds55xx/robot.h>
#include <cds55xx/avr.h>

CDS_JOINTS(joints) = {
    /*        id direction     offset   lowest highest mRPM   profile            name */
    CDS_JOINT(1, CDS_FORWARD, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "left"),
    CDS_JOINT(2, CDS_REVERSED, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "right"),
};
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

int main(void)
{
    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    cds_robot_start(&robot);
    for (;; cds_robot_poll(&robot))
        for (uint8_t i = 0; i < CDS_JOINT_COUNT(joints); i++)
            cds_robot_set_goal_mdeg(&robot, i, robot.cycle.counters.periods & 256 ? 60000 : -60000);
}
