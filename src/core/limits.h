/* Soft limits of one servo: the roster's own part that judges a write, and knows what that needs of
 * what the servo holds. */
#ifndef CDS_LIMITS_H
#define CDS_LIMITS_H

#include "cds55xx/roster.h" // struct cds_roster_servo

enum cds_mode { CDS_MODE_UNKNOWN, CDS_MODE_POSITION, CDS_MODE_TURN };

static inline enum cds_mode cds_limits_mode(const struct cds_roster_servo *servo)
{
    if ((servo->cw_limit | servo->ccw_limit) & CDS_ANGLE_SET)
        return CDS_MODE_POSITION;
    return servo->cw_limit & servo->ccw_limit ? CDS_MODE_TURN : CDS_MODE_UNKNOWN;
}

/* Is there any limit of its goal, or of its speed? */
bool cds_limits_any(const struct cds_roster_servo *servo);

/* May these `length` bytes be written from `address` on? CDS_OK, or CDS_LIMIT: with them, or with
 * what it holds already, the servo would go beyond a soft limit, or nobody knows whether it would.
 */
enum cds_result cds_limits_check(const struct cds_roster_servo *servo, uint8_t address,
                                 const uint8_t *data, uint8_t length);

/* The servo holds these bytes from `address` on: mode, goal and speed are known by that. Not
 * `certain`: it may hold them, or what it held before. */
void cds_limits_learn(struct cds_roster_servo *servo, uint8_t address, const uint8_t *data,
                      uint8_t length, bool certain);

#endif
