/* SPDX-License-Identifier: MIT */
/* A gripper, servo 1, on a board of its own (board/). The jaw closes slowly. If it lags behind its
 * goal, it holds a thing: then the goal stays a little beyond the thing. If the robot stops, the
 * program prints why on the host USART (stop_report.h). */
#include <cds55xx/avr.h>
#include <cds55xx/robot.h>

#include "stop_report.h"

#define OPEN_MDEG   60000
#define CLOSED_MDEG 0
#define STEP_MDEG   120  // in a period of 4 ms: 30 degrees a second
#define BEHIND_MDEG 6000 // the jaw is so far behind its goal: it holds something
#define GRIP_MDEG   3000 // how far the goal stays beyond the thing

CDS_JOINTS(joints) = {
    CDS_JOINT(1, CDS_FORWARD, 150000, -1000, 61000, 31000, CDS_JOINT_CDS55XX, "jaw"),
};
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

/* The goal of the next period, after the goal of this one. */
static int32_t next_goal_mdeg(int32_t goal, bool *is_holding)
{
    int32_t jaw;

    if (*is_holding || goal <= CLOSED_MDEG || cds_robot_position_mdeg(&robot, 0, &jaw) != CDS_OK)
        return goal;
    if (jaw - goal > BEHIND_MDEG) {
        *is_holding = true;
        return jaw - GRIP_MDEG;
    }
    return goal - STEP_MDEG;
}

int main(void)
{
    uint32_t period = 0;
    int32_t goal = OPEN_MDEG;
    bool is_holding = false;

    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    robot.on_event = stop_report_note;
    cds_robot_start(&robot);
    for (;;) { // a robot that is not well stops, and stays so until power is switched off
        stop_report_poll(&robot);
        if (cds_robot_poll(&robot) == CDS_ROBOT_RUNNING && robot.cycle.counters.periods != period) {
            period = robot.cycle.counters.periods;
            if (period > 500) // the jaw has 2 s to open
                goal = next_goal_mdeg(goal, &is_holding);
            cds_robot_set_goal_mdeg(&robot, 0, goal);
        }
    }
}
