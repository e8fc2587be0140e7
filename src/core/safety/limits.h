/* Soft limits of one servo: the roster's own part that judges a write, and knows what that needs of
 * what the servo holds. */
#ifndef CDS_LIMITS_H
#define CDS_LIMITS_H

#include "cds55xx/servos.h" // struct cds_servo_state

/* What is written, or was read: `length` bytes from register `address` on. */
struct cds_span {
    const uint8_t *data;
    uint8_t address, length;
};

/* The register `reg` of one byte; NULL if it is not among them. */
const uint8_t *cds_span_byte(const struct cds_span *span, uint8_t reg);

/* Its value, or `otherwise` if it is not among them. */
uint8_t cds_span_value(const struct cds_span *span, uint8_t reg, uint8_t otherwise);

/* Is any of the registers `first` to `last` among them? */
bool cds_span_touches(const struct cds_span *span, uint8_t first, uint8_t last);

enum cds_mode { CDS_MODE_UNKNOWN, CDS_MODE_POSITION, CDS_MODE_TURN };

/* Returns enum cds_mode. */
static inline uint8_t cds_limits_mode(const struct cds_servo_state *servo)
{
    uint8_t cw = servo->cw_limit, ccw = servo->ccw_limit;

    if ((cw | ccw) & CDS_ANGLE_SET)
        return CDS_MODE_POSITION;
    return cw & ccw ? CDS_MODE_TURN : CDS_MODE_UNKNOWN;
}

/* Is there any limit of its goal, or of its speed? */
bool cds_limits_any(const struct cds_servo_state *servo);

/* May this be written? CDS_OK, or CDS_LIMIT: with it, or with what it holds already, the servo
 * would go beyond a soft limit, or nobody knows whether it would. */
enum cds_result cds_limits_check(const struct cds_servo_state *servo, const struct cds_span *span);

/* The same of goal and speed, `data` as of goal.h, by the short way: a cycle has 50 of them in
 * 4 ms. */
enum cds_result cds_limits_check_goal(const struct cds_servo_state *servo, const uint8_t *data);

/* The servo holds this: mode, goal and speed are known by that. */
void cds_limits_take(struct cds_servo_state *servo, const struct cds_span *span);

#endif
