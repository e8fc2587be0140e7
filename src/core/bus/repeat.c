/* Sending again what has got no good reply: for programs that ask for it. In all others bus.c and
 * servo.c have nothing in the place of these. */
#include "cds55xx/bus.h"
#include "cds55xx/control_table.h"

static bool writes_to(uint8_t address, uint8_t first, uint8_t last)
{
    return first <= address && address <= last;
}

/* May the packet be sent again when nobody knows whether it was carried out? Not if that does
 * something twice, if the servo may answer under another ID or at another rate by then, or if it
 * refuses the second one: a lock is set once (R6). */
static bool bears_repeating(const uint8_t *bytes)
{
    uint8_t first = bytes[CDS_AT_PARAMETERS];
    uint8_t last = (uint8_t)(first + bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN - 2);

    switch (bytes[CDS_AT_INSTRUCTION]) {
    case CDS_PING:
    case CDS_READ: return true;
    case CDS_WRITE:
        return !writes_to(CDS_REG_ID, first, last) && !writes_to(CDS_REG_BAUD_RATE, first, last) &&
               !writes_to(CDS_REG_LOCK, first, last);
    default: return false;
    }
}

void cds_bus_set_repeats(struct cds_bus *bus, uint8_t repeats)
{
    bus->repeats = repeats;
}

uint8_t cds_bus_repeats_of_(const struct cds_bus *bus, const uint8_t *bytes)
{
    return bus->repeats && bears_repeating(bytes) ? bus->repeats : 0;
}

/* Parameters of a reply that was not found good may stand in the place of the packet: a READ is
 * built again. False: it could not be. */
static bool restore(const struct cds_bus *bus)
{
    const struct cds_bus_asked *what = cds_bus_asked_(bus);
    struct cds_request *request = bus->request;

    if (request->reply_parameters == 0 && !request->any_length)
        return true; // there were none
    if (what->instruction != CDS_READ || request->packet.size != CDS_PACKET_SIZE(2))
        return false;
    cds_packet_build_read_(&request->packet, bus->asked, what->first, what->last);
    return true;
}

/* Only what is more urgent goes before it. */
bool cds_bus_repeat_(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;

    if (request->repeats == 0 || !restore(bus))
        return false;
    request->repeats--;
    cds_bus_count_(&bus->counters.repeated);
    bus->flight = CDS_BUS_IDLE;
    bus->request = cds_bus_next_of_(request);
    cds_bus_insert_(bus, request, (uint8_t)(request->urgent + 1u));
    cds_bus_wait_for_turn_(bus);
    return true;
}
