/* What the bus counts; see bus.h. */
#include "cds55xx/bus.h"

#include "bus/bus_internal.h" // cds_stats_add_link()

/* Brings a total up to date with a count of its last 8 bits. */
static void catch_up(uint16_t *total, uint8_t count)
{
    *total = (uint16_t)(*total + (uint8_t)(count - *total));
}

/* The handlers count modulo 256. A full ring that broke the stream is counted by `full`, further
 * bytes without room by the handlers. */
static void add(struct cds_stats *stats, const struct cds_link *link, uint8_t full)
{
    uint8_t both = link->both_errors;

    catch_up(&stats->framing_errors, (uint8_t)(link->framing_errors + both));
    catch_up(&stats->overruns, (uint8_t)(link->overruns + both));
    catch_up(&stats->ring_overflows, (uint8_t)(link->ring_overflows + full));
}

void cds_stats_add_link(struct cds_bus *bus)
{
    if (bus->link.broken == CDS_LINK_FULL)
        bus->ring_overflows++;
    add(&bus->stats, &bus->link, bus->ring_overflows);
}

void cds_bus_stats(const struct cds_bus *bus, struct cds_stats *out)
{
    *out = bus->stats;
    add(out, &bus->link, (uint8_t)(bus->ring_overflows + (bus->link.broken == CDS_LINK_FULL)));
    out->noise_bytes = bus->parser.noise_bytes;
    out->echo_errors = cds_link_count(&bus->link.echo_errors);
}
