/* SPDX-License-Identifier: MIT */
/* Servo 1 sweeps 60 degrees to both sides and back, every 2 s, in small steps at 250 Hz. The robot
 * object checks the servo first, and switches torque off if the servo reports an alarm, loses its
 * power or does not answer. */
#include <cds55xx/avr.h>
#include <cds55xx/robot.h>

#define SWEEP_PERIODS 512 // of 4 ms; a power of two
#define STEP_MDEG     468 // 256 steps are 120 degrees

CDS_JOINTS(joints) = {
    CDS_JOINT(1, CDS_FORWARD, 150000, -75000, 75000, 45000, CDS_JOINT_CDS55XX, "arm"),
};
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

/* Where the arm is to be in this period: a triangle from -60 to 60 degrees. */
static int32_t angle_mdeg(uint32_t period)
{
    int16_t step = (int16_t)(period & (SWEEP_PERIODS - 1));

    if (step >= SWEEP_PERIODS / 2)
        step = (int16_t)(SWEEP_PERIODS - step);
    return (int32_t)STEP_MDEG * (step - SWEEP_PERIODS / 4);
}

int main(void)
{
    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    cds_robot_start(&robot);
    for (;;) // a robot that is not well stops, and stays so until power is switched off
        if (cds_robot_poll(&robot) == CDS_ROBOT_RUNNING)
            cds_robot_set_goal_mdeg(&robot, 0, angle_mdeg(robot.cycle.counters.periods));
}
