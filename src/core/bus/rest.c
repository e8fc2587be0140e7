/* The rest after a timeout: no transaction that expects a reply begins while a stale reply may
 * still come; and the return delay, on which the length of the rest depends. See bus.h. */
#include "cds55xx/bus.h"

void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us)
{
    if (bus->flight == CDS_BUS_BEGUN)
        cds_bus_expect_(bus); // a packet on the wire keeps the return delay it has begun with
    bus->return_delay_us = return_delay_us;
}

void cds_bus_set_return_delay_of_(struct cds_request *request, uint16_t return_delay_us)
{
    request->return_delay_us = return_delay_us;
}

bool cds_bus_rests(const struct cds_bus *bus, uint32_t now_us)
{
    return bus->rests && (uint32_t)(bus->rest_until_us - now_us - 1u) < CDS_STALE_REPLY_US;
}
