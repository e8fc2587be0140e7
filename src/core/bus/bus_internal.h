/* SPDX-License-Identifier: MIT */
/* What modules of the core need of the bus beside bus.h; not installed. Main context. */
#ifndef CDS_BUS_INTERNAL_H
#define CDS_BUS_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus
#include "compiler.h"    // ALWAYS_INLINE

/* True if a request that ended with this result sent no packet, not even as a retry. False for
 * CDS_CANCELLED, which does not tell: cds_bus_open() also cancels a packet on the wire, and
 * cds_bus_cancel() a retry whose first packet was sent. */
static inline bool cds_was_not_sent(uint8_t result)
{
    return result >= CDS_LINE_BUSY;
}

/* A request ends as CDS_LINE_BUSY when it has waited for a quiet line for so many byte times and
 * microseconds: the longest reply. */
#define CDS_LINE_WAIT_BYTES CDS_PACKET_SIZE(CDS_REPLY_MAX)
#define CDS_LINE_WAIT_US    (CDS_RETURN_DELAY_MAX_US + CDS_REPLY_MARGIN_US)

/* Adds the counts of the handlers to the stats. Call it before `broken` of the link is cleared. */
void cds_stats_add_link(struct cds_bus *bus);

/* Returns CDS_OK, or what is wrong with the request; CDS_BUSY: it is on its way. */
enum cds_result cds_request_check(const struct cds_request *request);

/* In `prechecked_epoch`: the permit has not checked the packet. */
#define CDS_NOT_PRECHECKED 0

/* Submits a packet that the permit has already found good in its epoch `prechecked_epoch`: the
 * permit skips its check while that epoch lasts. With CDS_NOT_PRECHECKED it does what
 * cds_bus_submit() does. Outside of bus.c only the cycle may give an epoch: it has asked the permit
 * for each goal. */
enum cds_result cds_bus_submit_prechecked(struct cds_bus *bus, struct cds_request *request,
                                          uint16_t prechecked_epoch);

/* Begins a packet; every packet begins here. The caller has asked the permit if there is one.
 * CDS_OK: the packet is on its way, or waits for the line. Outside of bus.c only
 * cds_bus_submit_valid() calls it. */
enum cds_result cds_bus_send(struct cds_bus *bus, struct cds_request *request);

/* The slow path of a submit: asks the permit. Then the packet leaves, waits for the line, or waits
 * until the bus is free. `prechecked_epoch`: see cds_bus_submit_prechecked(). */
enum cds_result cds_bus_send_or_wait(struct cds_bus *bus, struct cds_request *request,
                                     uint16_t prechecked_epoch);

/* The second half of cds_bus_submit(), for a request whose fields are valid and that is not on its
 * way. Inline: a READ leaves 25 cycles sooner. */
ALWAYS_INLINE enum cds_result cds_bus_submit_valid(struct cds_bus *bus, struct cds_request *request)
{
    if (bus->state != CDS_BUS_IDLE || bus->gate)
        return cds_bus_send_or_wait(bus, request, CDS_NOT_PRECHECKED);
    return cds_bus_send(bus, request);
}

#endif
