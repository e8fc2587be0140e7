/* What modules of the core need of the bus beside bus.h; not installed. Main context. */
#ifndef CDS_BUS_INTERNAL_H
#define CDS_BUS_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus
#include "compiler.h"    // ALWAYS_INLINE

/* True if no packet left of a request that ended with this result, retries included. CDS_CANCELLED
 * is not among them: only the caller of cds_bus_cancel() knows. */
static inline bool cds_was_not_sent(uint8_t result)
{
    return result == CDS_LINE_BUSY || result == CDS_NO_REPLY_DUE || result == CDS_LIMIT ||
           result == CDS_INHIBITED || result == CDS_TOO_EARLY;
}

/* Adds what the handlers have counted to the stats: before `broken` of the link is cleared. */
void cds_stats_add_link(struct cds_bus *bus);

/* CDS_OK, or what is wrong with the request; CDS_BUSY: it is on its way. */
enum cds_result cds_request_check(const struct cds_request *request);

/* As cds_bus_submit(), for a packet that the permit has found good in its epoch `permit_epoch`; 0:
 * it was not asked. The permit skips its check while that epoch lasts. Outside of bus.c only the
 * cycle, which asks for each goal, may give another value than 0. */
enum cds_result cds_bus_submit_permitted(struct cds_bus *bus, struct cds_request *request,
                                         uint16_t permit_epoch);

/* The one function that begins a packet. The permit was asked before, or there is none. CDS_OK: the
 * packet is on its way, or waits for the line. Outside of bus.c only for cds_bus_submit_valid(). */
enum cds_result cds_bus_send(struct cds_bus *bus, struct cds_request *request);

/* The slow way of a submit: asks the permit; the packet leaves, waits for the line, or waits until
 * the bus is free. `permit_epoch`: as for cds_bus_submit_permitted(). */
enum cds_result cds_bus_send_or_wait(struct cds_bus *bus, struct cds_request *request,
                                     uint16_t permit_epoch);

/* The second half of cds_bus_submit(), for a request whose fields are valid and that is not on its
 * way. Inline: a READ leaves 25 cycles sooner. */
ALWAYS_INLINE enum cds_result cds_bus_submit_valid(struct cds_bus *bus, struct cds_request *request)
{
    if (bus->state != CDS_BUS_IDLE || bus->gate)
        return cds_bus_send_or_wait(bus, request, 0);
    return cds_bus_send(bus, request);
}

#endif
