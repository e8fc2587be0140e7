/* SPDX-License-Identifier: MIT */
/* Opening a bus, its rate, its hooks and its lock; see bus.h. */
#include <string.h>

#include "bus/line_internal.h"
#include "cds55xx/bus.h"
#include "compiler.h" // OPTIMIZER_BARRIER()

static void cancel_all(struct cds_request *request, const struct cds_bus_hooks *hooks)
{
    if (request) {
        request->result = CDS_CANCELLED;
        request->retries = 0;
    }
    if (hooks)
        hooks->cancel(hooks->context, NULL);
}

static void set_rate(struct cds_bus *bus, uint8_t baud_reg)
{
    bus->baud_reg = baud_reg;
    bus->byte_time_us = (uint16_t)(5u * (baud_reg + 1u)); // ten bits of (baud_reg + 1) / 2 us
    bus->last_id = CDS_NO_ID; // what was asked before is not answered at this rate
}

void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud_reg)
{
    const struct cds_bus_hooks *hooks;
    uint8_t gate;
    bool again;

    OPTIMIZER_BARRIER(bus);
    hooks = bus->hooks;
    gate = bus->gate & GATE_PERMIT;
    again = bus->state != CDS_BUS_CLOSED;
    cds_port_open(port, baud_reg); // first: no handler may run while the struct is cleared
    cancel_all(bus->request, hooks);
    memset(bus, 0, sizeof *bus);
    bus->hooks = hooks;
    bus->gate = gate;
    bus->port = port;
    set_rate(bus, baud_reg);
    bus->return_delay_us = CDS_RETURN_DELAY_MAX_US;
    bus->state = CDS_BUS_IDLE;
    if (again)
        cds_line_rest(bus, CDS_STALE_REPLY_US); // what was asked before may be answered yet
    cds_link_open(&bus->link, port);
}

enum cds_result cds_bus_set_baud(struct cds_bus *bus, uint8_t baud_reg)
{
    if (bus->state == CDS_BUS_CLOSED || baud_reg > CDS_BAUD_MAX)
        return CDS_BAD_ARGUMENT;
    if (bus->request)
        return CDS_BUSY;
    if (bus->baud_reg == baud_reg)
        return CDS_OK;
    cds_port_open(bus->port, baud_reg);
    set_rate(bus, baud_reg);
    bus->gate &= (uint8_t)~GATE_LINE;
    cds_link_open(&bus->link, bus->port);
    return CDS_OK;
}

enum cds_result cds_bus_attach(struct cds_bus *bus, const struct cds_bus_hooks *hooks)
{
    if (bus->request || (bus->hooks && bus->hooks != hooks))
        return CDS_BUSY;
    bus->hooks = hooks;
    bus->gate &= (uint8_t)~GATE_PERMIT;
    if (hooks->permit)
        bus->gate |= GATE_PERMIT;
    return CDS_OK;
}

enum cds_result cds_bus_lock(struct cds_bus *bus, const struct cds_bus_lock *lock)
{
    if (bus->state == CDS_BUS_CLOSED)
        return CDS_BAD_ARGUMENT;
    if (bus->lock && bus->lock != lock)
        return CDS_BUSY;
    bus->lock = lock;
    bus->gate |= GATE_LOCKED;
    return CDS_OK;
}

void cds_bus_unlock(struct cds_bus *bus, const struct cds_bus_lock *lock)
{
    if (bus->lock != lock)
        return;
    bus->lock = NULL;
    bus->gate &= (uint8_t)~GATE_LOCKED;
}
