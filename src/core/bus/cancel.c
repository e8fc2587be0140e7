/* SPDX-License-Identifier: MIT */
/* Taking a request back before its packet is sent: the one step of the transaction outside bus.c,
 * from WAITING_FOR_LINE to IDLE. See bus.h. */
#include <stddef.h>

#include "bus/bus_internal.h"
#include "cds55xx/bus.h"

struct cds_request *cds_bus_take_back(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;

    if (bus->state != CDS_BUS_WAITING_FOR_LINE)
        return NULL;
    bus->request = NULL;
    bus->state = CDS_BUS_IDLE;
    return request;
}

enum cds_result cds_bus_cancel(struct cds_bus *bus, struct cds_request *request)
{
    const struct cds_bus_hooks *hooks = bus->hooks;

    if (bus->request != request || !request)
        return request && hooks && hooks->cancel(hooks->context, request) ? CDS_OK
                                                                          : CDS_BAD_ARGUMENT;
    if (!cds_bus_take_back(bus))
        return CDS_BUSY;
    request->result = CDS_CANCELLED;
    if (hooks)
        hooks->request_ended(hooks->context, request, CDS_CANCELLED);
    return CDS_OK;
}
