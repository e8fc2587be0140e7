/* Soft limits of one servo: the roster's own part that judges a write. */
#ifndef CDS_LIMITS_H
#define CDS_LIMITS_H

#include "cds55xx/roster.h" // struct cds_roster_servo

/* May these `length` bytes stand from `address` on? CDS_OK, or CDS_LIMIT: a goal or a speed beyond
 * a soft limit of the servo, or one that cannot be judged, as half of a word. */
enum cds_result cds_limits_check(const struct cds_roster_servo *servo, uint8_t address,
                                 const uint8_t *data, uint8_t length);

#endif
