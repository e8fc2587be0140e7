/* SPDX-License-Identifier: MIT */
/* The registers of the device; see device_registers.h. */
#include "host/device_registers.h"

#include <stddef.h>
#include <string.h>

#include "cds55xx/link.h" // cds_link_count()

_Static_assert(DEVICE_SETTING_COUNT == SETTINGS_COUNT, "the first registers are the settings");

static bool reset(void *context)
{
    struct device_registers *registers = context;

    settings_default(registers->failsafe->settings);
    return true;
}

/* Counter registers have the order of the fields of their struct. */
static uint16_t counter(const struct device_registers *registers, uint8_t reg)
{
    const struct cds_bus *bus = registers->failsafe->robot->bus;
    struct cds_stats stats;
    const void *counters = &stats;
    uint8_t first = DEVICE_BUS_SENT;
    uint16_t value;

    if (reg == DEVICE_HOST_OVERFLOWS)
        return cds_link_count(registers->gaps);
    if (reg >= DEVICE_BRIDGE_PASSED) {
        counters = &registers->bridge->counters;
        first = DEVICE_BRIDGE_PASSED;
    } else if (reg >= DEVICE_HOST_PACKETS) {
        counters = &registers->host->counters;
        first = DEVICE_HOST_PACKETS;
    } else {
        cds_bus_stats(bus, &stats);
    }
    memcpy(&value, (const uint8_t *)counters + (uint8_t)(reg - first) * sizeof value, sizeof value);
    return value;
}

/* True for the registers of motion_registers.h. */
static bool is_of_motion(uint8_t reg)
{
    return reg >= DEVICE_MOTION_PLAY && reg <= DEVICE_MOTION_ERROR;
}

/* The value of register SAVE. */
static uint16_t saving(const struct settings_store *store)
{
    return store->result == SETTINGS_SAVING ? 1 : store->result == SETTINGS_FAILED ? 2 : 0;
}

/* ID of the first servo with an alarm; UINT8_MAX: no known servo has one. */
static uint16_t alarm_id(const struct cds_servos *servos)
{
    const struct cds_servo_state *servo = servos->states;

    for (uint8_t left = servos->count; left; left--, servo++)
        if (servo->alarms)
            return servo->id;
    return UINT8_MAX;
}

static uint16_t get(void *context, uint8_t reg)
{
    const struct device_registers *registers = context;
    const struct failsafe *failsafe = registers->failsafe;
    const struct robot *robot = failsafe->robot;

    if (reg < DEVICE_SETTING_COUNT)
        return settings_get(failsafe->settings, reg);
    if (is_of_motion(reg))
        return 0;
    switch (reg) {
    case DEVICE_SAVE: return saving(failsafe->store);
    case DEVICE_BUS_STATE: return cds_bus_line(robot->bus);
    case DEVICE_RESET_CAUSE: return failsafe->reset_cause;
    case DEVICE_LINK_LOST: return failsafe->link_lost;
    case DEVICE_INHIBIT: return robot_is_inhibited(robot);
    case DEVICE_DELAYS_REFUSED: return robot->servos.too_early;
    case DEVICE_ALARMS: return robot->servos.alarms;
    case DEVICE_ALARM_ID: return alarm_id(&robot->servos);
    default: return counter(registers, reg);
    }
}

static void set(void *context, uint8_t reg, uint16_t value)
{
    struct device_registers *registers = context;

    if (reg < DEVICE_SETTING_COUNT)
        settings_set(registers->failsafe->settings, reg, value);
    else if (reg == DEVICE_SAVE)
        registers->to_save = value;
    else if (reg == DEVICE_LINK_LOST)
        failsafe_clear(registers->failsafe);
    else if (reg == DEVICE_INHIBIT)
        robot_release(registers->failsafe->robot);
    else if (reg == DEVICE_ALARMS)
        cds_servos_acknowledge(&registers->failsafe->robot->servos, NULL);
}

/* The same rules as at the console: neither LINK_LOST nor INHIBIT may be cleared while torque off
 * is under way, and LINK_LOST must be cleared before INHIBIT. */
static bool allows(void *context, uint8_t reg, uint16_t value)
{
    const struct failsafe *failsafe = ((const struct device_registers *)context)->failsafe;

    (void)value;
    if (is_of_motion(reg))
        return false;
    if (reg != DEVICE_INHIBIT && reg != DEVICE_LINK_LOST)
        return true;
    return !robot_is_stopping(failsafe->robot) && (reg == DEVICE_LINK_LOST || !failsafe->link_lost);
}

/* Carries out what was set. The rate of the bus changes between two transactions, and a save waits
 * until the save before it has ended. True when all is done. */
static bool settled(void *context)
{
    struct device_registers *registers = context;
    struct failsafe *failsafe = registers->failsafe;

    registers->to_save = registers->to_save && !settings_save(failsafe->store, failsafe->settings);
    return failsafe_apply_settings(failsafe) && !registers->to_save;
}

const CDS_FLASH struct device_ops device_registers_ops = {get, set, allows, reset, settled};

void device_registers_open(struct device_registers *registers, struct failsafe *failsafe,
                           const struct host_demux *host, const struct bridge *bridge,
                           const volatile uint16_t *gaps)
{
    *registers = (struct device_registers){
        .failsafe = failsafe, .host = host, .bridge = bridge, .gaps = gaps};
}
