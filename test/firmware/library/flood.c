/* The firmware, its own main.c, whose cycle is begun at once: 18 servos at 250 Hz, all goals and as
 * much feedback as there is time for. For a host that floods the link meanwhile. The cycle stands
 * where the firmware has it: of a second one, the stack of 4 KiB of RAM would run into the data. */
#include "console/commands/shared.h" // cycle_operation
#include "robot/robot.h"

static void begin_once(void);
#define robot_poll(robot) (begin_once(), robot_poll(robot))

#include "main.c"

/* In each turn, before the robot is polled. */
static void begin_once(void)
{
    struct robot *robot = &controller.robot;
    struct cds_cycle *cycle = &robot->work.cycle.cycle;

    if (robot->operation)
        return;
    for (uint8_t i = 0; i < ROBOT_SERVOS; i++)
        robot->group[i] = (uint8_t)(i + 1);
    robot->group_count = ROBOT_SERVOS;
    robot_start(robot, &cycle_operation, &(uint16_t){CDS_CYCLE_PERIOD_US});
    for (uint8_t i = 0; i < ROBOT_SERVOS; i++)
        cds_cycle_goal(cycle, i, 512, 0);
    cds_cycle_commit(cycle);
}
