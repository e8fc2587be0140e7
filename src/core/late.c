/* The answer of a servo that was given up may still come, where the bus was told not to wait for
 * the longest there is: for programs that tell it. In all others bus.c has nothing in the place of
 * these. */
#include "cds55xx/bus.h"

void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us)
{
    if (bus->flight == CDS_BUS_BEGUN)
        cds_bus_expect_(bus); // what has begun keeps what it has begun with
    bus->return_delay_us = return_delay_us;
}

void cds_bus_set_return_delay_of_(struct cds_request *request, uint16_t return_delay_us)
{
    request->return_delay_us = return_delay_us;
}

void cds_bus_note_given_up_(struct cds_bus *bus)
{
    bus->late_id = bus->request->id;
    bus->owed = true;
    bus->late_us = cds_port_now_us() + CDS_RETURN_DELAY_MAX_US - bus->request->return_delay_us;
}

/* It is so long at most: more is an old time, also where nobody has looked for half an hour. */
static bool is_ahead(uint32_t late_us, uint32_t now_us)
{
    return (uint32_t)(late_us - now_us - 1u) < CDS_RETURN_DELAY_MAX_US;
}

bool cds_bus_may_answer_late(const struct cds_bus *bus, uint8_t id, uint32_t now_us)
{
    return bus->owed &&
           (id == bus->late_id || id == CDS_BROADCAST_ID || bus->late_id == CDS_BROADCAST_ID) &&
           is_ahead(bus->late_us, now_us);
}

/* Once the time is over, for good: an hour later the clock would not tell. */
bool cds_bus_owes_(struct cds_bus *bus, uint8_t id)
{
    uint32_t now_us = cds_port_now_us();

    if (!is_ahead(bus->late_us, now_us))
        bus->owed = false;
    return cds_bus_may_answer_late(bus, id, now_us);
}
