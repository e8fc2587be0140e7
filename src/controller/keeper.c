/* The watch over host link and alarms; see keeper.h. */
#include "keeper.h"

#include <stddef.h>

#include "cds55xx/port.h" // cds_port_now_us()

void keeper_begin(struct keeper *keeper, const struct settings *settings, struct cds_roster *roster,
                  uint8_t *told, uint8_t reset_cause)
{
    *keeper = (struct keeper){
        .settings = settings, .roster = roster, .told = told, .reset_cause = reset_cause};
    if (roster && told)
        for (uint8_t i = 0; i < roster->count; i++)
            told[i] = 0;
}

void keeper_heard(struct keeper *keeper)
{
    keeper->heard_us = cds_port_now_us();
    keeper->watching = keeper->settings->link_loss_ms != 0;
}

/* Torque off comes with a hold: or the next goal would switch torque on again. */
static void lose_link(struct keeper *keeper)
{
    keeper->watching = false;
    keeper->link_lost = true;
    if (keeper->settings->link_loss_action == KEEPER_SHOW)
        return;
    keeper->hold = true;
    if (keeper->roster)
        cds_roster_hold(keeper->roster, NULL, CDS_HOLD_STOPPED);
    keeper->torque_off_wanted = keeper->settings->link_loss_action == KEEPER_TORQUE_OFF;
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

/* Alarms that were acknowledged in the meantime are told again when they come again. */
static void watch_alarms(struct keeper *keeper)
{
    struct cds_roster *roster = keeper->roster;
    const struct cds_roster_servo *servo;
    uint8_t *told;

    if (!roster || !keeper->told || keeper->alarm || !keeper->settings->alarm_report)
        return;
    if (keeper->next >= roster->count)
        keeper->next = 0;
    if (roster->count == 0)
        return;
    servo = &roster->servos[keeper->next];
    told = &keeper->told[keeper->next++];
    keeper->alarm = (uint8_t)(servo->alarms & ~*told);
    keeper->alarm_id = servo->id;
    *told = servo->alarms;
}

void keeper_poll(struct keeper *keeper)
{
    watch_link(keeper);
    watch_alarms(keeper);
}

void keeper_clear(struct keeper *keeper)
{
    struct cds_roster *roster = keeper->roster;

    if (keeper->hold && roster)
        for (uint8_t i = 0; i < roster->count; i++)
            if (roster->servos[i].held == CDS_HOLD_STOPPED)
                cds_roster_release(roster, &roster->servos[i]);
    keeper->link_lost = false;
    keeper->hold = false;
    keeper->torque_off_wanted = false;
    keeper->watching = false;
}
