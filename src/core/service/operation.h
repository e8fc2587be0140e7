/* What operations that take the whole bus have in common: they set its rate and its return delay,
 * and give both back, unless somebody has opened the bus anew meanwhile: then it is his. */
#ifndef CDS_OPERATION_H
#define CDS_OPERATION_H

#include <stdbool.h>

#include "bus/bus_internal.h" // cds_was_not_sent()
#include "cds55xx/bus.h"      // struct cds_bus

/* What an operation has the bus wait: the longest, and 1 us more, by which the operation knows its
 * own setting again. Opening sets CDS_RETURN_DELAY_MAX_US, and no servo waits as long as this. */
#define CDS_OPERATION_DELAY_US (CDS_RETURN_DELAY_MAX_US + 1)

/* Is the bus still as cds_operation_take() left it? If not, it was opened anew, or told another
 * return delay. */
static inline bool cds_operation_has(const struct cds_bus *bus)
{
    return bus->return_delay_us == CDS_OPERATION_DELAY_US;
}

/* Takes the bus. Returns the return delay to be given back: the longest, if another operation has
 * the bus and this one's caller did not wait for its end. */
static inline uint16_t cds_operation_take(struct cds_bus *bus)
{
    uint16_t delay_us = cds_operation_has(bus) ? CDS_RETURN_DELAY_MAX_US : bus->return_delay_us;

    cds_bus_set_return_delay(bus, CDS_OPERATION_DELAY_US);
    return delay_us;
}

/* The bus at this rate; false while it is busy. */
static inline bool cds_operation_tune(struct cds_bus *bus, uint8_t baud)
{
    return bus->baud == baud || cds_bus_set_baud(bus, baud) == CDS_OK;
}

#endif
