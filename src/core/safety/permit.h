/* SPDX-License-Identifier: MIT */
/* The permit: decides whether a packet may leave. docs/internals/permit.md states the rules. Not
 * installed. Main context.
 *
 * bus.c calls cds_servos_permit() through bus->hooks->permit: at the submit of a request, and at
 * each later attempt to send its packet. The cycle calls cds_servos_permit_goal() through
 * bus->hooks->permit_goal: when a goal is set, and again after a change. */
#ifndef CDS_PERMIT_H
#define CDS_PERMIT_H

#include "cds55xx/servos.h" // struct cds_servos

/* The permit of the servos' hooks; `context` is a struct cds_servos. CDS_OK; CDS_PENDING: the check
 * of a long packet goes on; else why the packet must not leave.
 *
 * A registered move (registered_move.c) has rules of its own:
 *   - The move calls bus->hooks->set_move with its request when it begins, and with NULL when no
 *     REG WRITE or ACTION of the move follows.
 *   - In that request only, REG WRITE of goal and speed (0x1E, 4 bytes) to a servo with limits is
 *     permitted if goal and speed are within its limits.
 *   - ACTION is permitted if every known servo of the move has answered its REG WRITE, each servo
 *     with limits that ACTION reaches is one of them, and none is inhibited.
 *   - After a change of any limit or inhibit, REG WRITE and ACTION of the move are refused
 *     (CDS_LIMIT or CDS_INHIBITED). The move then clears 0x2C of each servo, which always passes.
 * The permit learns from the replies which REG WRITE was answered; the move does not report it. */
enum cds_result cds_servos_permit(void *context, struct cds_request *request);

/* The permit_goal of the servos' hooks. */
enum cds_result cds_servos_permit_goal(void *context, uint8_t id, uint8_t *index,
                                       const uint8_t *goal);

#endif
