/* Soft limits of one servo, and what is known of its mode, goal and speed; not installed. Main
 * context. */
#ifndef CDS_LIMITS_H
#define CDS_LIMITS_H

#include "cds55xx/servos.h" // struct cds_servo_state
#include "safety/written.h" // struct cds_written

/* How what was written became known. */
enum cds_source {
    CDS_SOURCE_READ,     // the servo was read
    CDS_SOURCE_ANSWERED, // it has answered the packet that wrote it
    CDS_SOURCE_SENT,     // no reply was due
    CDS_SOURCE_LOST,     // the reply is missing: written or not
};

/* CDS_OK, or CDS_LIMIT: with this write, or with what it holds already, the servo would go beyond a
 * soft limit, or it is not known whether it would. A speed of 0 that is permitted is noted. */
enum cds_result cds_limits_check(struct cds_servo_state *servo, const struct cds_written *written);

/* As cds_limits_check() for goal and speed, `data` as in registers 0x1E to 0x21: shorter, because a
 * cycle sets 50 of them in 4 ms. */
enum cds_result cds_limits_check_goal(struct cds_servo_state *servo, const uint8_t *data);

/* Takes mode, goal and speed over: a READ makes them known; a write that was answered keeps known
 * what was known; else what differs is no longer known. True if an answer of the permit may have
 * changed. */
bool cds_limits_learn(struct cds_servo_state *servo, const struct cds_written *written,
                      enum cds_source source);

#endif
