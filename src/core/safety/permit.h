/* The one door: may this packet leave? docs/internals/permit.md states the rules; not installed.
 * Main context.
 *
 * For registered_move.c, which lies below and calls this through bus->hooks->set_move:
 *   - set_move(context, request) when the move begins: the request that carries its packets.
 *   - In that request only, REG WRITE of goal and speed (0x1E, 4 bytes) to a servo with limits is
 *     permitted if goal and speed are within its limits.
 *   - ACTION is permitted if every known servo of the move has answered its REG WRITE, each servo
 *     with limits that ACTION reaches is one of them, and none is inhibited.
 *   - After a change of any limit or inhibit, REG WRITE and ACTION of the move are refused
 *     (CDS_LIMIT or CDS_INHIBITED). The move then clears 0x2C of each servo, which always passes.
 *   - set_move(context, NULL) when no REG WRITE or ACTION of the move follows.
 * The permit learns by itself which REG WRITE was answered: nothing the move says is trusted.
 * Without hooks, or if set_move is NULL, the move sends without a check. */
#ifndef CDS_PERMIT_H
#define CDS_PERMIT_H

#include "cds55xx/servos.h" // struct cds_servos

/* The permit of the servos' hooks; `context` is a struct cds_servos. CDS_OK; CDS_PENDING: the check
 * of a long packet goes on; else why the packet must not leave. */
enum cds_result cds_servos_permit(void *context, struct cds_request *request);

/* The permit_goal of the servos' hooks. */
enum cds_result cds_servos_permit_goal(void *context, uint8_t id, uint8_t *index,
                                       const uint8_t *goal);

#endif
