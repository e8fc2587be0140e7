/* What was asked is known when the reply has taken the packet's place: for programs with news or
 * repeats. In all others bus.c has nothing in the place of this. */
#include "cds55xx/bus.h"

void cds_bus_note_packet_(struct cds_bus *bus)
{
    const struct cds_packet *packet = &bus->request->packet;

    bus->what.instruction = packet->bytes[CDS_AT_INSTRUCTION];
    bus->what.first = packet->bytes[CDS_AT_PARAMETERS];
    bus->what.last = packet->bytes[packet->size - 2u];
}

const struct cds_bus_asked *cds_bus_asked_(const struct cds_bus *bus)
{
    return &bus->what;
}
