/* What modules of the core need of the bus beside bus.h; not installed. Main context. */
#ifndef CDS_BUS_INTERNAL_H
#define CDS_BUS_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/result.h" // enum cds_result

/* True if a request with this result ended before its packet left. CDS_CANCELLED is not among them:
 * only the caller of cds_bus_cancel() knows. */
static inline bool cds_was_not_sent(uint8_t result)
{
    return result == CDS_LINE_BUSY || result == CDS_NO_REPLY_DUE || result == CDS_LIMIT ||
           result == CDS_INHIBITED || result == CDS_TOO_EARLY;
}

#endif
