/* SPDX-License-Identifier: MIT */
/* The robot on the bus; see robot.h. */
#include "robot/robot.h"

#include <stddef.h>
#include <string.h>

#include "compiler.h" // NOINLINE

void robot_begin(struct robot *robot, struct cds_bus *bus, uint8_t shortest_delay)
{
    OPTIMIZER_BARRIER(robot);
    robot->bus = bus;
    robot->unlisted = ROBOT_NOT_SCANNED;
    cds_servos_begin(&robot->servos,
                     &(struct cds_servos_config){.bus = bus,
                                                 .queue = &robot->queue,
                                                 .states = robot->states,
                                                 .capacity = ROBOT_SERVOS,
                                                 .grows = CDS_GROWS_ON_ALARM_OR_SETTING,
                                                 .shortest_delay = shortest_delay});
}

static void store(const struct robot *robot, uint8_t state)
{
    if (robot->reset_copy)
        kept_store(&robot->reset_copy->state, state);
}

void robot_inhibit(struct robot *robot)
{
    if (robot->reset_copy && reset_copy_state(robot->reset_copy) != INHIBIT_STOPPING)
        store(robot, INHIBIT_ON); // else a stop is not finished: the copy keeps INHIBIT_STOPPING
    cds_servos_inhibit_all(&robot->servos);
}

bool robot_allow(struct robot *robot)
{
    if (robot_is_stopping(robot))
        return false;
    cds_servos_allow(&robot->servos);
    robot->stop_begun = false;
    store(robot, INHIBIT_FREE);
    return true;
}

bool robot_release(struct robot *robot)
{
    if (!robot_allow(robot))
        return false;
    cds_servos_release_all(&robot->servos);
    return true;
}

void robot_resume(struct robot *robot, struct reset_copy *copy, bool powered_on)
{
    uint8_t state = powered_on ? INHIBIT_FREE : reset_copy_state(copy);

    robot->reset_copy = copy;
    store(robot, state);
    if (state == INHIBIT_STOPPING)
        robot_stop(robot);
    else if (state != INHIBIT_FREE)
        robot_inhibit(robot);
}

uint8_t robot_unlisted(const struct robot *robot)
{
    if (robot->unlisted == ROBOT_NOT_SCANNED)
        return (uint8_t)(CDS_ID_MAX + 1 - robot->servos.count);
    return robot->unlisted == 0 && robot->servos.is_full ? 1 : robot->unlisted;
}

bool robot_is_exclusive(const struct robot *robot)
{
    return robot->operation && robot->cycle == NULL;
}

bool robot_idle(const struct robot *robot)
{
    return robot->operation == NULL && !robot_is_stopping(robot);
}

bool robot_cycle_drives(const struct robot *robot, uint8_t id)
{
    return robot->cycle && (id == CDS_BROADCAST_ID || memchr(robot->group, id, robot->group_count));
}

/* The state check sends between the goals of the cycle. If the goals leave no time, the check
 * pauses. */
static void check_beside_cycle(struct robot *robot)
{
    robot->health_pauses =
        robot->health_servos && cds_health_set_cycle(&robot->health, robot->cycle) != CDS_OK;
}

void robot_share_bus(struct robot *robot, struct cds_cycle *cycle)
{
    robot->cycle = cycle;
    check_beside_cycle(robot);
}

NOINLINE static void end_operation(struct robot *robot)
{
    robot->cycle = NULL;
    check_beside_cycle(robot);
    robot->operation = NULL;
    robot->servos.is_paused = false;
}

NOINLINE uint8_t robot_busy(const struct robot *robot)
{
    if (robot_is_stopping(robot))
        return ROBOT_STOPPED;
    if (robot->operation == NULL)
        return 0;
    return robot_is_in_motion(robot) ? ROBOT_IN_MOTION : ROBOT_BUSY;
}

uint8_t robot_start(struct robot *robot, const CDS_FLASH struct robot_operation *operation,
                    const void *config)
{
    uint8_t begun = robot_busy(robot);

    if (begun)
        return begun;
    robot->operation = operation;
    robot->result = CDS_PENDING;
    robot->baud_reg = robot->bus->baud_reg;
    robot->servos.is_paused = operation->changes_rate;
    begun = (uint8_t)operation->begin(robot, config);
    if (begun != CDS_OK)
        end_operation(robot);
    return begun;
}

void robot_abort(struct robot *robot)
{
    if (robot->operation && robot->operation->abort)
        robot->operation->abort(robot);
}

NOINLINE static void begin_stop(struct robot *robot)
{
    robot->stop_begun = true;
    robot->stopping = true;
    robot->servos.is_paused = false;
    cds_torque_off_begin(&robot->stop, &robot->servos);
}

/* True if the bus is not at another rate because of an operation. */
static bool is_at_own_rate(const struct robot *robot)
{
    return !robot_is_exclusive(robot) || robot->bus->baud_reg == robot->baud_reg;
}

/* At another rate no servo of the robot hears the stop, so the stop begins when the bus is back at
 * its rate. An operation may leave a servo and the bus at another rate than before, so the stop
 * begins once more when the operation ends. */
void robot_stop(struct robot *robot)
{
    robot_abort(robot);
    store(robot, INHIBIT_STOPPING);
    robot_inhibit(robot);
    robot->stop_waits = robot_is_exclusive(robot);
    robot->stop_begun = false;
    if (is_at_own_rate(robot))
        begin_stop(robot);
}

static void poll_stop(struct robot *robot)
{
    if (robot->stop_waits && robot->operation == NULL) {
        robot->stop_waits = false;
        begin_stop(robot);
    } else if (robot->stop_waits && !robot->stop_begun && is_at_own_rate(robot)) {
        begin_stop(robot);
    }
    if (!is_at_own_rate(robot)) // torque off would abort a change of rate
        return;
    if (robot->stopping && cds_torque_off_poll(&robot->stop) != CDS_PENDING) {
        robot->stopping = false;
        if (!robot->stop_waits && robot->stop.steps.result != CDS_LINE_BUSY)
            store(robot, INHIBIT_ON);
    }
}

/* NOINLINE: a turn without a stop and an operation saves no registers for them. */
NOINLINE static void poll_work(struct robot *robot)
{
    poll_stop(robot);
    if (robot->operation == NULL)
        return;
    robot->result = (uint8_t)robot->operation->poll(robot);
    if (robot->result != CDS_PENDING)
        end_operation(robot);
}

/* Begins the state check again, because the number of servos has changed. False: not yet, a request
 * of the check is on its way. */
static bool begin_health(struct robot *robot)
{
    struct cds_health *health = &robot->health;

    if (cds_health_begin(health, &(struct cds_health_config){.servos = &robot->servos,
                                                             .period_us = CDS_HEALTH_PERIOD_US}) !=
        CDS_OK)
        return false;
    health->look_us += health->step_us; // a servo that has joined has just sent a packet
    robot->health_servos = robot->servos.count;
    if (robot->cycle)
        check_beside_cycle(robot);
    return true;
}

/* The state check goes on beside a cycle. During every other operation it pauses. */
NOINLINE static void poll_health(struct robot *robot)
{
    if (robot->stopping || robot->health_pauses || robot_is_exclusive(robot))
        return;
    if (robot->servos.count != robot->health_servos && !begin_health(robot))
        return;
    if (!robot->chosen)
        robot_delay_health(robot);
    cds_health_poll(&robot->health);
}

/* Each turn of the main loop calls it. It saves no registers while there is nothing to do. */
void robot_poll(struct robot *robot)
{
    if (!robot_idle(robot))
        poll_work(robot);
    if (robot->servos.count)
        poll_health(robot);
}

bool robot_add(struct robot *robot, uint8_t id)
{
    robot->chosen = true;
    return cds_servos_find(&robot->servos, id) || cds_servos_add(&robot->servos, id) == CDS_OK;
}

bool robot_has_room(struct robot *robot, const uint8_t *ids, uint8_t count)
{
    uint8_t room = (uint8_t)(ROBOT_SERVOS - robot->servos.count);

    for (; count; count--) {
        if (cds_servos_find(&robot->servos, *ids++))
            continue;
        if (room == 0)
            return false;
        room--;
    }
    return true;
}

uint8_t robot_choose_group(struct robot *robot, const uint8_t *ids, uint8_t count)
{
    uint8_t busy = robot_busy(robot);

    if (busy)
        return busy;
    if (!robot_has_room(robot, ids, count))
        return ROBOT_TOO_MANY;
    for (uint8_t i = 0; i < count; i++)
        robot_add(robot, ids[i]);
    memcpy(robot->group, ids, count);
    robot->group_count = count;
    robot->group_acts = false;
    return 0;
}

const struct cds_servo_state *robot_servo_from(const struct robot *robot, uint8_t id)
{
    const struct cds_servo_state *servo = robot->states, *found = NULL;

    for (uint8_t left = robot->servos.count; left; left--, servo++)
        if (servo->id >= id && (!found || servo->id < found->id))
            found = servo;
    return found;
}

void robot_rename(struct robot *robot, uint8_t id, uint8_t new_id)
{
    uint8_t *place = memchr(robot->group, id, robot->group_count);

    if (place)
        *place = new_id;
}

NOINLINE void robot_delay_health(struct robot *robot)
{
    struct cds_health *health = &robot->health;

    health->look_us = cds_port_now_us() + ROBOT_HEALTH_DELAY_US;
    if (health->sought >= robot->servos.count ||
        robot->states[health->sought].presence != CDS_PRESENCE_RETURNED)
        health->seek_us = health->look_us;
}

void robot_forget(struct robot *robot)
{
    cds_servos_forget(&robot->servos);
    robot->unlisted = ROBOT_NOT_SCANNED;
    robot->group_count = 0;
    robot->health_servos = 0;
    robot->chosen = false;
    if (!robot->stopping)          // else the stop goes on
        robot->stop.servos = NULL; // no servo of the last stop is left
}

bool robot_forget_servo(struct robot *robot, struct cds_servo_state *servo)
{
    uint8_t id = servo->id;
    uint8_t *place = memchr(robot->group, id, robot->group_count);

    if (cds_servos_forget_one(&robot->servos, servo) != CDS_OK)
        return false;
    robot->unlisted = ROBOT_NOT_SCANNED;
    robot->health_servos = 0; // the state check begins again
    if (place) {
        robot->group_count--;
        memmove(place, place + 1, (size_t)(robot->group + robot->group_count - place));
    }
    return true;
}

void robot_forget_group(struct robot *robot, uint8_t count)
{
    robot->group_count = 0;
    for (uint8_t i = count; i < robot->servos.count; i++)
        if (robot->states[i].alarms || robot->states[i].inhibits)
            return;
    cds_servos_forget_from(&robot->servos, count);
    if (count == 0)
        robot->chosen = false;
}
