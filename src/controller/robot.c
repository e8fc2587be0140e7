/* The robot at the bus; see robot.h. */
#include "robot.h"

#include <stddef.h>

#include "errors.h"

static void watch(struct robot *robot)
{
    cds_watch_begin(&robot->watch, &robot->roster, CDS_WATCH_PERIOD_US);
}

void robot_begin(struct robot *robot, struct cds_bus *bus)
{
    robot->bus = bus;
    cds_roster_begin(&robot->roster, bus, robot->servos, 0);
    watch(robot);
}

bool robot_is_exclusive(const struct robot *robot)
{
    return robot->operation > ROBOT_CYCLE;
}

bool robot_idle(const struct robot *robot)
{
    return robot->operation == ROBOT_IDLE && !robot->stopping && !robot->stop_waits;
}

uint8_t robot_claim(struct robot *robot, enum robot_operation operation)
{
    if (robot->stopping || robot->stop_waits)
        return ERROR_STOPPED;
    if (robot->operation != ROBOT_IDLE)
        return ERROR_CYCLE;
    robot->operation = (uint8_t)operation;
    robot->result = CDS_PENDING;
    robot->baud = robot->bus->baud;
    if (operation == ROBOT_SCAN || operation == ROBOT_DIAGNOSE)
        robot->bus->observer = NULL; // who is silent at another rate is not away
    return 0;
}

static void let_go(struct robot *robot)
{
    if (robot->operation == ROBOT_CYCLE)
        cds_watch_set_cycle(&robot->watch, NULL);
    robot->watch_rests = false;
    robot->operation = ROBOT_IDLE;
    robot->bus->observer = &robot->roster.observer;
}

uint8_t robot_begun(struct robot *robot, enum cds_result begun)
{
    if (begun != CDS_OK)
        let_go(robot);
    else if (robot->operation == ROBOT_CYCLE) // goals that leave no time for it go before it
        robot->watch_rests = cds_watch_set_cycle(&robot->watch, &robot->work.cycle.cycle) != CDS_OK;
    return (uint8_t)begun;
}

void robot_abort(struct robot *robot)
{
    switch (robot->operation) {
    case ROBOT_CYCLE: cds_cycle_stop(&robot->work.cycle.cycle); break;
    case ROBOT_SCAN: cds_scan_abort(&robot->work.scan.scan); break;
    case ROBOT_DIAGNOSE: cds_diagnose_abort(&robot->work.diagnose); break;
    default: break;
    }
}

static void begin_stop(struct robot *robot)
{
    robot->stop_waits = false;
    robot->stopping = true;
    robot->bus->observer = &robot->roster.observer;
    cds_stop_begin(&robot->stop, &robot->roster, robot->outcomes);
}

void robot_stop(struct robot *robot)
{
    robot_abort(robot);
    cds_roster_hold(&robot->roster, NULL, CDS_HOLD_STOPPED);
    // elsewhere nobody would hear it; at home its requests keep the bus from being taken away
    if (robot->operation != ROBOT_IDLE && robot->bus->baud != robot->baud)
        robot->stop_waits = true;
    else
        begin_stop(robot);
}

static void poll_stop(struct robot *robot)
{
    if (robot->stop_waits && (robot->operation == ROBOT_IDLE || robot->bus->baud == robot->baud))
        begin_stop(robot);
    if (robot->stopping && cds_stop_poll(&robot->stop) != CDS_PENDING)
        robot->stopping = false;
}

static enum cds_result poll_operation(struct robot *robot)
{
    switch (robot->operation) {
    case ROBOT_CYCLE: return cds_cycle_poll(&robot->work.cycle.cycle);
    case ROBOT_SCAN: return cds_scan_poll(&robot->work.scan.scan);
    case ROBOT_DIAGNOSE: return cds_diagnose_poll(&robot->work.diagnose);
    case ROBOT_IDENTITY: return cds_identity_poll(&robot->work.identity);
    default: return cds_group_move_poll(&robot->work.move.move);
    }
}

/* Not inlined, so that a turn in which there is nothing of this saves no registers for it. */
static __attribute__((noinline)) void poll_work(struct robot *robot)
{
    poll_stop(robot);
    if (robot->operation == ROBOT_IDLE)
        return;
    robot->result = (uint8_t)poll_operation(robot);
    if (robot->result != CDS_PENDING)
        let_go(robot);
}

void robot_poll(struct robot *robot)
{
    if (!robot_idle(robot))
        poll_work(robot);
    if (robot->roster.count && !robot->stopping && !robot->watch_rests &&
        !robot_is_exclusive(robot))
        cds_watch_poll(&robot->watch);
}

bool robot_add(struct robot *robot, uint8_t id)
{
    if (cds_roster_find(&robot->roster, id))
        return true;
    if (cds_roster_add(&robot->roster, id, ROBOT_SERVOS) != CDS_OK)
        return false;
    watch(robot);
    return true;
}

void robot_forget(struct robot *robot)
{
    cds_roster_begin(&robot->roster, robot->bus, robot->servos, 0);
    robot->group_count = 0;
    watch(robot);
}
