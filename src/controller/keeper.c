/* The watch over host link and alarms; see keeper.h. */
#include "keeper.h"

#include <stddef.h>

#include "cds55xx/port.h" // cds_port_now_us()

void keeper_begin(struct keeper *keeper, uint8_t reset_cause)
{
    for (uint8_t i = 0; i < keeper->crew->room; i++)
        keeper->told[i] = 0;
    keeper->stop = (struct cds_stop){.roster = NULL};
    keeper->reset_cause = reset_cause;
    keeper->next = 0;
    keeper->alarm = 0;
    keeper->watching = false;
    keeper->link_lost = false;
}

void keeper_heard(struct keeper *keeper)
{
    keeper->heard_us = cds_port_now_us();
    keeper->watching = keeper->settings->link_loss_ms != 0;
}

bool keeper_is_stopping(const struct keeper *keeper)
{
    return keeper->stop.roster && keeper->stop.result == CDS_PENDING;
}

void keeper_stop(struct keeper *keeper)
{
    crew_hold(keeper->crew);
    for (uint8_t i = 0; !keeper_is_stopping(keeper) && i < keeper->crew->room; i++)
        keeper->outcomes[i] = CDS_STOP_UNKNOWN; // who is met meanwhile is looked at, too
    cds_stop_begin(&keeper->stop, &keeper->crew->roster, keeper->outcomes);
}

/* Torque off comes with a hold: or the next goal would switch torque on again. */
static void lose_link(struct keeper *keeper)
{
    keeper->watching = false;
    keeper->link_lost = true;
    if (keeper->settings->link_loss_action == KEEPER_TORQUE_OFF)
        keeper_stop(keeper);
    else if (keeper->settings->link_loss_action == KEEPER_HOLD)
        crew_hold(keeper->crew);
}

static void watch_link(struct keeper *keeper)
{
    uint32_t limit_us = keeper->settings->link_loss_ms * (uint32_t)1000;

    if (limit_us == 0)
        keeper->watching = false; // armed anew, it waits for the host's next byte
    else if (keeper->watching && !keeper->link_lost &&
             cds_port_now_us() - keeper->heard_us >= limit_us)
        lose_link(keeper);
}

/* A line that is never quiet is no reason to give up. */
static void move_stop_on(struct keeper *keeper)
{
    if (keeper_is_stopping(keeper) && cds_stop_poll(&keeper->stop) == CDS_LINE_BUSY)
        keeper_stop(keeper);
}

/* Alarms that were acknowledged in the meantime are told again when they come again. */
static void watch_alarms(struct keeper *keeper)
{
    const struct cds_roster *roster = &keeper->crew->roster;
    const struct cds_roster_servo *servo;
    uint8_t *told;

    if (keeper->alarm || !keeper->settings->alarm_report || roster->count == 0)
        return;
    if (keeper->next >= roster->count)
        keeper->next = 0;
    servo = &roster->servos[keeper->next];
    told = &keeper->told[keeper->next++];
    keeper->alarm = (uint8_t)(servo->alarms & ~*told);
    keeper->alarm_id = servo->id;
    *told = servo->alarms;
}

void keeper_poll(struct keeper *keeper)
{
    watch_link(keeper);
    move_stop_on(keeper);
    watch_alarms(keeper);
}

bool keeper_clear(struct keeper *keeper)
{
    struct cds_roster *roster = &keeper->crew->roster;

    if (keeper_is_stopping(keeper))
        return false;
    crew_unhold(keeper->crew);
    for (uint8_t i = 0; i < roster->count; i++)
        if (roster->servos[i].held == CDS_HOLD_STOPPED)
            cds_roster_release(roster, &roster->servos[i]);
    cds_roster_acknowledge(roster, NULL);
    keeper->link_lost = false;
    keeper->watching = false;
    return true;
}
