/* Behind the device's registers; see values.h. */
#include "values.h"

#include "cds55xx/link.h" // cds_link_count()
#include "flash.h"

static void reset(void *owner)
{
    static const CDS_FLASH uint16_t initial[DEVICE_KEPT] = {
        [DEVICE_ID] = 253,
        [DEVICE_HOST_BAUD] = VALUES_HOST_BAUD_OWN,
        [DEVICE_BUS_BAUD] = CDS_BAUD_1M,
        [DEVICE_RETURN_DELAY] = CDS_RETURN_DELAY_MAX_US / 2,
        [DEVICE_ECHO] = 1,
        [DEVICE_LINK_LOSS_ACTION] = 1,
        [DEVICE_CYCLE_US] = 10000,
    };
    struct values *values = owner;

    for (uint8_t i = 0; i < DEVICE_KEPT; i++)
        values->kept[i] = initial[i];
}

static uint16_t bus_counter(const struct values *values, uint8_t reg)
{
    const struct cds_counters *c = &values->bus->counters;
    const struct cds_link *link = &values->bus->link;

    switch (reg) {
    case DEVICE_BUS_SENT: return c->sent;
    case DEVICE_BUS_REPEATED: return c->repeated;
    case DEVICE_BUS_OK: return c->ok;
    case DEVICE_BUS_TIMEOUTS: return c->timeouts;
    case DEVICE_BUS_CORRUPT: return c->corrupt;
    case DEVICE_BUS_UNSENT: return c->unsent;
    case DEVICE_BUS_REFUTED: return c->refuted;
    case DEVICE_BUS_LATE: return c->late;
    case DEVICE_BUS_EXTRA: return c->extra;
    case DEVICE_BUS_FOREIGN: return c->foreign;
    case DEVICE_BUS_FRAMING: return cds_link_count(&link->framing_errors);
    case DEVICE_BUS_OVERRUNS: return cds_link_count(&link->overruns);
    case DEVICE_BUS_OVERFLOWS: return cds_link_count(&link->ring_overflows);
    default: return cds_link_count(&link->echo_errors);
    }
}

static uint16_t host_counter(const struct values *values, uint8_t reg)
{
    const struct host_counters *host = &values->host->counters;
    const struct bridge_counters *bridge = &values->bridge->counters;

    switch (reg) {
    case DEVICE_HOST_PACKETS: return host->packets;
    case DEVICE_HOST_BROKEN: return host->broken;
    case DEVICE_HOST_SILENT: return host->silent;
    case DEVICE_HOST_GAPS: return host->gaps;
    case DEVICE_HOST_OVERFLOWS: return cds_link_count(values->gaps);
    case DEVICE_BRIDGE_PASSED: return bridge->passed;
    case DEVICE_BRIDGE_ANSWERED: return bridge->answered;
    case DEVICE_BRIDGE_UNANSWERED: return bridge->unanswered;
    default: return bridge->refused;
    }
}

static uint16_t get(void *owner, uint8_t reg)
{
    struct values *values = owner;

    if (reg < DEVICE_KEPT)
        return values->kept[reg];
    switch (reg) {
    case DEVICE_SAVE: return values->save;
    case DEVICE_BUS_STATE: return cds_bus_state(values->bus);
    case DEVICE_RESET_CAUSE: return values->reset_cause;
    case DEVICE_LINK_LOST: return values->link_lost;
    case DEVICE_ALARMS: return values->alarms;
    case DEVICE_ALARM_ID: return values->alarm_id;
    default: break;
    }
    return reg < DEVICE_HOST_PACKETS ? bus_counter(values, reg) : host_counter(values, reg);
}

static void set(void *owner, uint8_t reg, uint16_t value)
{
    struct values *values = owner;

    if (reg < DEVICE_KEPT)
        values->kept[reg] = value;
    else if (reg == DEVICE_SAVE)
        values->save = (uint8_t)value;
    else if (reg == DEVICE_LINK_LOST)
        values->link_lost = (uint8_t)value;
    else if (reg == DEVICE_ALARMS)
        values->alarms = (uint8_t)value;
}

/* The rate of the bus can change between two exchanges only. */
static bool settled(void *owner)
{
    struct values *values = owner;
    uint8_t baud = (uint8_t)values->kept[DEVICE_BUS_BAUD];

    cds_bus_set_return_delay(values->bus, (uint16_t)(2 * values->kept[DEVICE_RETURN_DELAY]));
    cds_bus_set_repeats(values->bus, (uint8_t)values->kept[DEVICE_REPEATS]);
    return values->bus->baud == baud || cds_bus_set_baud(values->bus, baud) == CDS_OK;
}

void values_open(struct values *values, struct cds_bus *bus, const struct host *host,
                 const struct bridge *bridge, const volatile uint16_t *gaps)
{
    *values = (struct values){
        .bus = bus,
        .host = host,
        .bridge = bridge,
        .gaps = gaps,
        .world = {.owner = values, .get = get, .set = set, .reset = reset, .settled = settled}};
    reset(values);
}
