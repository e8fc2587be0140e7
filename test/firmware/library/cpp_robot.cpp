/* SPDX-License-Identifier: MIT */
// A robot in C++11 with a table in flash; built and run by test/runs/test_cpp.py.
#include <cds55xx/robot.h>
#include <cds55xx/avr.h>

namespace
{
CDS_JOINTS(joints) = {
    CDS_JOINT(1, CDS_FORWARD, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "hip"),
    CDS_JOINT(2, CDS_REVERSED, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "knee"),
};
CDS_ROBOT(robot, joints);
} // namespace

CDS_AVR_ROBOT(robot, 0)

int main()
{
    cds_joint row;

    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    if (cds_robot_joint(&robot, 1, &row) != CDS_OK)
        return 1;
    cds_robot_start(&robot);
    for (;;)
        if (cds_robot_poll(&robot) == CDS_ROBOT_RUNNING)
            for (uint8_t i = 0; i < CDS_JOINT_COUNT(joints); i++)
                cds_robot_set_goal_mdeg(&robot, i, row.id * 10000l);
}
