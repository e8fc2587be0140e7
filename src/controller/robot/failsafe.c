/* SPDX-License-Identifier: MIT */
/* Host link, alarms and repeated stops; see failsafe.h. */
#include "robot/failsafe.h"

#include <stddef.h>

#include "cds55xx/port.h" // cds_port_now_us()
#include "compiler.h"     // OPTIMIZER_BARRIER()

void failsafe_begin(struct failsafe *failsafe, uint8_t reset_cause)
{
    failsafe->reset_cause = reset_cause;
}

void failsafe_heard(struct failsafe *failsafe)
{
    failsafe->heard_us = cds_port_now_us();
    failsafe->watching = true;
}

static bool is_at_its_rate(const struct failsafe *failsafe)
{
    return failsafe->robot->bus->baud_reg == failsafe->settings->bus_baud;
}

/* The bus has another rate, at which the robot has not scanned. If no servo is in the list, nobody
 * has answered the stop: it is sent again, to servos of this rate. */
static void note_new_rate(struct robot *robot)
{
    robot->unlisted = ROBOT_NOT_SCANNED;
    if (robot->stop_begun && robot->servos.count == 0)
        robot_stop(robot);
}

bool failsafe_apply_settings(struct failsafe *failsafe)
{
    const struct settings *settings = failsafe->settings;
    struct cds_bus *bus = failsafe->robot->bus;

    cds_bus_set_return_delay(bus, (uint16_t)(2u * settings->return_delay));
    cds_queue_set_retries(&failsafe->robot->queue, settings->repeats);
    failsafe->unsettled = false;
    if (!is_at_its_rate(failsafe)) {
        failsafe->unsettled = cds_bus_set_baud(bus, settings->bus_baud) != CDS_OK;
        if (!failsafe->unsettled)
            note_new_rate(failsafe->robot);
    }
    return !failsafe->unsettled;
}

/* If an operation has left the bus at another rate, that rate becomes the setting. While an
 * operation runs it may use other rates. */
static void watch_rate(struct failsafe *failsafe)
{
    if (failsafe->unsettled)
        failsafe_apply_settings(failsafe);
    else if (!robot_is_exclusive(failsafe->robot) && !is_at_its_rate(failsafe)) {
        failsafe->settings->bus_baud = failsafe->robot->bus->baud_reg;
        note_new_rate(failsafe->robot);
    }
}

/* Torque off also inhibits driving: the next goal would switch torque on again. */
static void lose_link(struct failsafe *failsafe)
{
    failsafe->link_lost = true;
    if (failsafe->settings->link_loss_action == FAILSAFE_TORQUE_OFF)
        robot_stop(failsafe->robot);
    else if (failsafe->settings->link_loss_action == FAILSAFE_INHIBIT)
        robot_inhibit(failsafe->robot);
}

/* A link stays lost until failsafe_clear(). If driving is allowed all the same, as link_loss_action
 * was 0, the next silence of the host takes the action that is set by then. */
static void watch_link(struct failsafe *failsafe)
{
    uint32_t limit_us = failsafe->settings->link_loss_ms * (uint32_t)1000;

    if (limit_us && failsafe->watching &&
        !(failsafe->link_lost && robot_is_inhibited(failsafe->robot)) &&
        cds_port_now_us() - failsafe->heard_us >= limit_us)
        lose_link(failsafe);
}

/* True if the torque of a servo was read as on after the stop. A servo whose torque the stop itself
 * read as on cannot be switched off: it is not counted. */
static bool has_torque(const struct robot *robot)
{
    const struct cds_servo_state *servo = robot->states;

    for (uint8_t left = robot->servos.count; left; left--, servo++)
        if (servo->torque && servo->torque_off != CDS_TORQUE_OFF_ON)
            return true;
    return false;
}

/* A stop begins again when the line is quiet after the stop gave up, or if a servo did not receive
 * the stop. */
static void insist_on_stop(struct failsafe *failsafe)
{
    struct robot *robot = failsafe->robot;

    if (robot->stop_begun && !robot_is_stopping(robot) &&
        cds_bus_line(robot->bus) == CDS_BUS_LINE_QUIET &&
        (robot->stop.steps.result == CDS_LINE_BUSY || has_torque(robot)))
        robot_stop(robot);
}

/* True if the servo gave the stop no good answer, and answers now. A servo of status return level 0
 * never answers the stop. */
static bool has_missed_stop(const struct robot *robot, const struct cds_servo_state *servo)
{
    return servo->torque_off >= CDS_TORQUE_OFF_SILENT && servo->status_return_level != 0 &&
           servo->presence == CDS_PRESENCE_ONLINE && servo->misses == 0 &&
           servo->baud_reg == robot->bus->baud_reg;
}

void failsafe_confirm_stop(struct failsafe *failsafe)
{
    struct robot *robot = failsafe->robot;

    if (!robot->stop_begun || cds_bus_line(robot->bus) != CDS_BUS_LINE_QUIET)
        return;
    for (uint8_t i = 0; i < robot->servos.count; i++) {
        if (has_missed_stop(robot, &robot->states[i])) {
            robot_stop(robot);
            failsafe->stop_is_repeated = true;
            return;
        }
    }
}

/* Alarms are printed unasked if the setting alarm_report says so, or in mode person: a host that
 * sends packets may not understand text. An alarm that was acknowledged is reported again when it
 * comes again, and so is a servo that goes OFFLINE or loses its state again. */
static void watch_alarms(struct failsafe *failsafe)
{
    const struct settings *settings = failsafe->settings;
    const struct cds_servos *servos = &failsafe->robot->servos;
    uint8_t index = (uint8_t)(failsafe->next + 1u), alarms;
    struct cds_servo_state *servo;

    if (!settings->alarm_report &&
        (!failsafe->host_types || settings->echo != SETTINGS_ECHO_PERSON))
        return;
    if (failsafe->alarm || servos->count == 0)
        return;
    if (index >= servos->count)
        index = 0;
    failsafe->next = index;
    servo = &servos->states[index];
    alarms = servo->alarms;
    if (servo->presence == CDS_PRESENCE_OFFLINE)
        alarms |= FAILSAFE_OFFLINE;
    failsafe->alarm_id = servo->id;
    failsafe->alarm = (uint8_t)(alarms & ~failsafe->reported[index]);
    failsafe->reported[index] = alarms;
    if (failsafe->alarm || servo->presence != CDS_PRESENCE_ONLINE ||
        !(servo->inhibits & CDS_INHIBIT_STATE_LOST) || servo->held & CDS_HELD_LOSS_TOLD ||
        (servo->status_return_level == 0 && servo->misses == 0)) // it is read again first: health.h
        return;
    servo->held |= CDS_HELD_LOSS_TOLD;
    failsafe->alarm = FAILSAFE_TORQUE_LOST;
}

void failsafe_move_servo(struct failsafe *failsafe, uint8_t from, uint8_t to, uint8_t id)
{
    failsafe->reported[to] = failsafe->reported[from];
    failsafe->reported[from] = 0;
    if (failsafe->alarm_id == id)
        failsafe->alarm = 0;
}

void failsafe_poll(struct failsafe *failsafe)
{
    OPTIMIZER_BARRIER(failsafe);
    watch_rate(failsafe);
    failsafe->robot->servos.grows =
        failsafe->settings->link_loss_ms // a lost link stops every servo
            ? CDS_GROWS_ALWAYS
            : CDS_GROWS_ON_ALARM_OR_SETTING;
    watch_link(failsafe);
    insist_on_stop(failsafe);
    watch_alarms(failsafe);
}

bool failsafe_clear(struct failsafe *failsafe)
{
    if (!robot_allow(failsafe->robot))
        return false;
    cds_servos_acknowledge(&failsafe->robot->servos, NULL);
    failsafe->link_lost = false;
    failsafe_heard(failsafe); // the request came from the host
    return true;
}
