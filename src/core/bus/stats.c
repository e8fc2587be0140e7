/* SPDX-License-Identifier: MIT */
/* What the bus counts; see bus.h. */
#include "cds55xx/bus.h"

#include "bus/bus_internal.h" // cds_stats_add_link()
#include "compiler.h"         // NOINLINE

/* Brings a total up to date with a count of its last 8 bits. */
static NOINLINE void catch_up(uint16_t *total, uint8_t count)
{
    *total = (uint16_t)(*total + (uint8_t)(count - *total));
}

/* The handlers count modulo 256. A full ring that broke the stream is counted by
 * bus->ring_overflows, further bytes without room by the handlers. */
void cds_stats_add_link(struct cds_bus *bus)
{
    const struct cds_link *link = &bus->link;
    uint8_t both = link->both_errors;

    if (link->broken == CDS_LINK_FULL)
        bus->ring_overflows++;
    catch_up(&bus->stats.framing_errors, (uint8_t)(link->framing_errors + both));
    catch_up(&bus->stats.overruns, (uint8_t)(link->overruns + both));
    catch_up(&bus->stats.ring_overflows, (uint8_t)(link->ring_overflows + bus->ring_overflows));
}

void cds_bus_stats(const struct cds_bus *bus, struct cds_stats *out)
{
    const struct cds_bus_counts *counts = &bus->stats;
    const struct cds_link *link = &bus->link;
    uint8_t both = link->both_errors, full = bus->ring_overflows;

    if (link->broken == CDS_LINK_FULL)
        full++;
    // one by one: a struct in braces is put together on the stack, for 150 bytes more
    out->sent = counts->sent;
    out->retried = counts->retried;
    out->ok = (uint16_t)(counts->sent - counts->timeouts - counts->corrupt);
    if (bus->state >= CDS_BUS_SENDING)
        out->ok--; // the packet in flight
    out->timeouts = counts->timeouts;
    out->corrupt = counts->corrupt;
    out->line_busy = counts->line_busy;
    out->malformed = counts->malformed;
    out->noise_bytes = bus->parser.noise_bytes;
    out->stale_replies = counts->not_due[CDS_EVENT_STALE_REPLY];
    out->duplicate_replies = counts->not_due[CDS_EVENT_DUPLICATE_REPLY];
    out->unexpected_packets = counts->not_due[CDS_EVENT_UNEXPECTED_PACKET];
    out->framing_errors = counts->framing_errors;
    out->overruns = counts->overruns;
    out->ring_overflows = counts->ring_overflows;
    out->echo_errors = cds_link_count(&link->echo_errors);
    catch_up(&out->framing_errors, (uint8_t)(link->framing_errors + both));
    catch_up(&out->overruns, (uint8_t)(link->overruns + both));
    catch_up(&out->ring_overflows, (uint8_t)(link->ring_overflows + full));
}
