/* Requests that wait behind the one in flight: for programs that have a queue. In all others bus.c
 * has nothing in the place of these. */
#include "cds55xx/bus.h"

void cds_bus_set_queue(struct cds_bus *bus, bool on)
{
    bus->has_queue = on;
}

bool cds_bus_queues_(const struct cds_bus *bus)
{
    return bus->has_queue;
}

struct cds_request *cds_bus_next_of_(const struct cds_request *request)
{
    return request->next;
}

/* Puts the request before those that are less urgent than `urgent`, but never before one in flight,
 * which is the first. */
bool cds_bus_insert_(struct cds_bus *bus, struct cds_request *request, uint8_t urgent)
{
    struct cds_request **place = cds_bus_is_in_flight_(bus) ? &bus->request->next : &bus->request;

    while (*place && (*place)->urgent >= urgent)
        place = &(*place)->next;
    request->next = *place;
    *place = request;
    if (place != &bus->request)
        return false;
    bus->flight = CDS_BUS_IDLE; // what time is left is of the one that has waited so far
    return true;
}

/* Behind a bad end a poll has done enough, and the next one looks whether the line is quiet. If the
 * observer has changed its mind, the next poll sees, too. */
void cds_bus_begin_next_(struct cds_bus *bus, uint8_t result)
{
    if (!bus->request)
        return;
    if (result == CDS_OK && cds_bus_judge_(bus, bus->request) == CDS_OK)
        cds_bus_begin_turn_(bus);
    else
        cds_bus_wait_for_turn_(bus);
}
