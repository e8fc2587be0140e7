/* SPDX-License-Identifier: MIT */
/* The controller's firmware, main.c, which begins a cycle at once: 18 servos at 250 Hz, all goals,
 * and READs in the remaining time of each period. For tests whose host floods the link meanwhile.
 * The cycle is the one of the firmware: a second one would not fit into 4 KiB of RAM. */
#include "robot/group_cycle.h" // group_cycle
#include "robot/robot.h"

static void begin_once(void);
#define robot_poll(robot) (begin_once(), robot_poll(robot))

#include "main.c"

/* Called in each turn of the main loop, before the robot is polled. */
static void begin_once(void)
{
    struct robot *robot = &controller.robot;
    struct cds_cycle *cycle = &robot->work.cycle.cycle;

    if (robot->operation)
        return;
    for (uint8_t i = 0; i < ROBOT_SERVOS; i++)
        robot->group[i] = (uint8_t)(i + 1);
    robot->group_count = ROBOT_SERVOS;
    robot_start(robot, &group_cycle, &(uint16_t){CDS_CYCLE_PERIOD_US});
    for (uint8_t i = 0; i < ROBOT_SERVOS; i++)
        cds_cycle_goal(cycle, i, 512, 0);
    cds_cycle_commit(cycle);
}
