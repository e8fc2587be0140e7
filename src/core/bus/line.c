/* SPDX-License-Identifier: MIT */
/* The line between two packets, and deadlines; see line_internal.h. */
#include "bus/line_internal.h"

#include "compiler.h" // NOCLONE

/* ---- time ---- */

static uint16_t now_65ms(void)
{
    return (uint16_t)(cds_port_now_us() >> 16);
}

NOCLONE void cds_line_set_deadline(struct cds_bus *bus, uint16_t from, uint16_t bytes,
                                   uint16_t more_us)
{
    bus->timer_wraps = cds_port_set_timer(bus->port, from, bytes, bus->byte_time_us, more_us);
    if (bus->timer_wraps)
        bus->deadline_65ms = (uint16_t)(now_65ms() + bus->timer_wraps + 1u);
}

/* If no expiry is left, the deadline is over. A poll that is more than one wrap of the timer late
 * sees several expiries as one. Therefore the deadline is also over once the clock has passed
 * `deadline_65ms`. */
NOCLONE uint8_t cds_line_take_expiry(struct cds_bus *bus)
{
    if (bus->timer_wraps == 0 || (int16_t)(now_65ms() - bus->deadline_65ms) >= 0)
        return true;
    bus->timer_wraps--;
    cds_port_restart_timer(bus->port);
    return false;
}

/* ---- the rest: a pause of the bus ---- */

static uint16_t two_byte_times_us(const struct cds_bus *bus)
{
    return (uint16_t)(2u * bus->byte_time_us);
}

/* Microseconds since the rest began, 65535 at the most. */
static NOCLONE uint16_t rested_us(const struct cds_bus *bus)
{
    uint32_t elapsed_us = cds_port_now_us() - bus->rest_from_us;

    return elapsed_us > UINT16_MAX ? UINT16_MAX : (uint16_t)elapsed_us;
}

/* Moves the begin of the rest under way to now; its end stays. Returns the microseconds that
 * remain. */
ALWAYS_INLINE uint16_t count_from_now(struct cds_bus *bus)
{
    uint16_t elapsed_us = rested_us(bus), rest_us = bus->rest_us;

    bus->rest_from_us += elapsed_us;
    rest_us = rest_us > elapsed_us ? (uint16_t)(rest_us - elapsed_us) : 0;
    bus->rest_us = rest_us;
    return rest_us;
}

NOCLONE void cds_line_rest(struct cds_bus *bus, uint16_t stale_us)
{
    bus->gate = (uint8_t)((bus->gate & ~GATE_LOW) | GATE_SUSPECT | GATE_STALE);
    if (bus->rest_us > stale_us && count_from_now(bus) > stale_us)
        return;
    bus->rest_us = stale_us;
    bus->rest_from_us = cds_port_now_us();
}

COLD void cds_line_check_rest(struct cds_bus *bus)
{
    uint16_t elapsed_us = rested_us(bus);
    bool is_over = elapsed_us >= two_byte_times_us(bus);
    uint8_t gate = bus->gate;

    if (elapsed_us >= bus->rest_us) {
        bus->rest_us = 0;
        gate &= (uint8_t)~GATE_STALE;
    }
    if (cds_port_line_is_high(bus->port)) {
        if (!is_over || !(gate & GATE_LOW)) {
            bus->gate = is_over ? gate & (uint8_t)~GATE_LINE : gate;
            return;
        }
    } else if (gate & GATE_LINE) {
        if (!is_over && !(gate & GATE_FAULT)) {
            bus->gate = gate | GATE_LOW;
            return;
        }
        gate |= GATE_FAULT;
    }
    bus->gate = gate;
    cds_line_rest(bus, 0); // the two byte times begin again
}

bool cds_bus_is_resting(const struct cds_bus *bus)
{
    return bus->gate & GATE_STALE;
}

enum cds_bus_line cds_bus_line(const struct cds_bus *bus)
{
    if (bus->gate & GATE_FAULT)
        return CDS_BUS_LINE_FAULT;
    return bus->gate & GATE_SUSPECT ? CDS_BUS_LINE_SUSPECT : CDS_BUS_LINE_QUIET;
}
