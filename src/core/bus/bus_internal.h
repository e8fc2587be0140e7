/* What modules of the core need of the bus beside bus.h; not installed. Main context. */
#ifndef CDS_BUS_INTERNAL_H
#define CDS_BUS_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus
#include "compiler.h"    // ALWAYS_INLINE

/* True if a request with this result ended before its packet left. CDS_CANCELLED is not among them:
 * only the caller of cds_bus_cancel() knows. */
static inline bool cds_was_not_sent(uint8_t result)
{
    return result == CDS_LINE_BUSY || result == CDS_NO_REPLY_DUE || result == CDS_LIMIT ||
           result == CDS_INHIBITED || result == CDS_TOO_EARLY;
}

/* Adds what the handlers have counted to the stats: before `broken` of the link is cleared. */
void cds_stats_add_link(struct cds_bus *bus);

/* CDS_OK, or what is wrong with the request; CDS_BUSY: it is on its way. */
enum cds_result cds_request_check(const struct cds_request *request);

/* As cds_bus_submit(), for the cycle only: its packet was found good, goal by goal, in the permit's
 * epoch `check`; 0: it was not. The permit skips its check while that epoch lasts. */
enum cds_result cds_bus_submit_checked(struct cds_bus *bus, struct cds_request *request,
                                       uint16_t check);

/* The one function that begins a packet, after the permit. CDS_OK: the packet is on its way, or
 * waits for the line. Only for cds_bus_submit_good(). */
enum cds_result cds_bus_send(struct cds_bus *bus, struct cds_request *request);

/* For a request that may not leave at once, or for which the permit must be asked. */
enum cds_result cds_bus_submit_later(struct cds_bus *bus, struct cds_request *request,
                                     uint16_t check);

/* The second half of cds_bus_submit(), for a request that was found good and is not on its way.
 * Inline: a READ leaves 25 cycles sooner. */
ALWAYS_INLINE enum cds_result cds_bus_submit_good(struct cds_bus *bus, struct cds_request *request)
{
    if (bus->state != CDS_BUS_IDLE || bus->gate)
        return cds_bus_submit_later(bus, request, 0);
    return cds_bus_send(bus, request);
}

#endif
