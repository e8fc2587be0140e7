/* The watch over host link and alarms; see keeper.h. */
#include "robot/failsafe.h"

#include <stddef.h>

#include "cds55xx/port.h" // cds_port_now_us()
#include "compiler.h"     // OPTIMIZER_BARRIER()

void keeper_begin(struct keeper *keeper, uint8_t reset_cause)
{
    keeper->reset_cause = reset_cause;
}

void keeper_heard(struct keeper *keeper)
{
    keeper->heard_us = cds_port_now_us();
    keeper->watching = true;
}

static bool is_at_its_rate(const struct keeper *keeper)
{
    return keeper->robot->bus->baud_reg == keeper->settings->bus_baud;
}

bool keeper_follow(struct keeper *keeper)
{
    const struct settings *settings = keeper->settings;
    struct cds_bus *bus = keeper->robot->bus;

    cds_bus_set_return_delay(bus, (uint16_t)(2u * settings->return_delay));
    cds_queue_set_retries(&keeper->robot->queue, settings->repeats);
    if (!is_at_its_rate(keeper))
        keeper->robot->strangers = ROBOT_NOT_SCANNED;
    keeper->unsettled =
        !is_at_its_rate(keeper) && cds_bus_set_baud(bus, settings->bus_baud) != CDS_OK;
    return !keeper->unsettled;
}

/* An operation may be at another rate for a while, but not for good unless it says so. */
static void watch_rate(struct keeper *keeper)
{
    if (keeper->unsettled)
        keeper_follow(keeper);
    else if (!robot_is_exclusive(keeper->robot) && !is_at_its_rate(keeper)) {
        keeper->settings->bus_baud = keeper->robot->bus->baud_reg;
        keeper->robot->strangers = ROBOT_NOT_SCANNED;
    }
}

/* Torque off comes with a hold: or the next goal would switch torque on again. */
static void lose_link(struct keeper *keeper)
{
    keeper->link_lost = true;
    if (keeper->settings->link_loss_action == KEEPER_TORQUE_OFF)
        robot_stop(keeper->robot);
    else if (keeper->settings->link_loss_action == KEEPER_HOLD)
        robot_inhibit(keeper->robot);
}

static void watch_link(struct keeper *keeper)
{
    uint32_t limit_us = keeper->settings->link_loss_ms * (uint32_t)1000;

    if (limit_us && keeper->watching && !keeper->link_lost &&
        cds_port_now_us() - keeper->heard_us >= limit_us)
        lose_link(keeper);
}

/* A servo whose torque was read as on behind the stop. A servo that the stop itself read as on does
 * not let go: it is told no more. */
static bool has_torque(const struct robot *robot)
{
    const struct cds_servo_state *servo = robot->states;

    for (uint8_t left = robot->servos.count; left; left--, servo++)
        if (servo->torque && servo->torque_off != CDS_TORQUE_OFF_ON)
            return true;
    return false;
}

/* A stop begins anew when the line is quiet again after the stop gave up, or if a servo did not
 * hear the stop. */
static void insist_on_stop(struct keeper *keeper)
{
    struct robot *robot = keeper->robot;

    if (robot->stop_told && !robot_is_stopping(robot) &&
        cds_bus_line(robot->bus) == CDS_BUS_LINE_QUIET &&
        (robot->stop.steps.result == CDS_LINE_BUSY || has_torque(robot)))
        robot_stop(robot);
}

/* Alarms that were acknowledged in the meantime are told again when they come again. */
static void watch_alarms(struct keeper *keeper)
{
    const struct cds_servos *servos = &keeper->robot->servos;
    const struct cds_servo_state *servo;
    uint8_t *told;

    if (keeper->alarm || !keeper->settings->alarm_report || servos->count == 0)
        return;
    if (keeper->next >= servos->count)
        keeper->next = 0;
    servo = &servos->states[keeper->next];
    told = &keeper->told[keeper->next++];
    keeper->alarm = (uint8_t)(servo->alarms & ~*told);
    keeper->alarm_id = servo->id;
    *told = servo->alarms;
}

void keeper_poll(struct keeper *keeper)
{
    OPTIMIZER_BARRIER(keeper);
    watch_rate(keeper);
    keeper->robot->servos.grows = keeper->settings->link_loss_ms // all are to be looked at then
                                      ? CDS_GROWS_ALWAYS
                                      : CDS_GROWS_ON_ALARM_OR_SETTING;
    watch_link(keeper);
    insist_on_stop(keeper);
    watch_alarms(keeper);
}

bool keeper_clear(struct keeper *keeper)
{
    if (!robot_allow(keeper->robot))
        return false;
    cds_servos_acknowledge(&keeper->robot->servos, NULL);
    keeper->link_lost = false;
    keeper_heard(keeper); // who has asked for this is there
    return true;
}
