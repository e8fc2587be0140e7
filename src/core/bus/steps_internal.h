/* SPDX-License-Identifier: MIT */
/* The skeleton of an operation: it submits a request, waits for its end, decides on the next one.
 * Not installed; see cds55xx/steps.h. Main context.
 *
 *     enum cds_result cds_x_begin(struct cds_x *x, const struct cds_x_config *config)
 *         check the arguments and cds_steps_check(); set *x; cds_steps_begin()
 *     enum cds_result cds_x_poll(struct cds_x *x)
 *         return cds_steps_poll(&x->steps, x, send, ended);
 *     void cds_x_abort(struct cds_x *x)
 *         cds_steps_abort(&x->steps);
 */
#ifndef CDS_STEPS_INTERNAL_H
#define CDS_STEPS_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "bus/bus_internal.h" // cds_was_not_sent()
#include "cds55xx/steps.h"    // struct cds_steps

/* May an operation begin with these? CDS_OK; CDS_BAD_ARGUMENT: the bus is not open; CDS_BUSY: the
 * request is on its way; CDS_NO_ROOM: its packet or its reply has a lower capacity. */
enum cds_result cds_steps_check(const struct cds_bus *bus, const struct cds_request *request,
                                uint16_t packet_capacity, uint8_t reply_capacity);

/* The same question for an operation that needs the bus to itself. CDS_BUSY also if an operation,
 * this one or another one, holds the bus. */
enum cds_result cds_steps_check_exclusive(const struct cds_bus *bus,
                                          const struct cds_request *request,
                                          uint16_t packet_capacity, uint8_t reply_capacity);

/* Begins an operation after cds_steps_check(); nothing is sent. */
void cds_steps_begin(struct cds_steps *steps, struct cds_bus *bus, struct cds_request *request);

/* Begins an operation after cds_steps_check_exclusive(): takes the lock, and lets the bus wait for
 * the longest return delay. Sets the priority of the request to CDS_PRIORITY_NORMAL:
 * cds_bus_lock(). The operation uses on_end, context and passes_lock of the request, and may set
 * ignores_stale, ignores_servo_state and no_retry; it clears all of these when it ends. */
void cds_steps_begin_exclusive(struct cds_steps *steps, struct cds_bus *bus,
                               struct cds_request *request);

/* Moves `operation` on by at most one transaction. Returns steps->result.
 *
 * send(): submits the request of the step and returns what the submit returned. After CDS_BUSY,
 * which is also the answer if the step has to wait, it is called again at the next poll.
 *
 * ended(): the step has ended as `result`: request->result, or CDS_REFUSED if the servo answered
 * with an error of the packet. If steps->is_submitted is false, the submit was refused and nothing
 * was sent. ended() chooses the next step, or calls cds_steps_end(). It is called once for each
 * request that was submitted, also after an abort, unless the abort has taken the request back
 * unsent. */
enum cds_result cds_steps_poll(struct cds_steps *steps, void *operation,
                               enum cds_result (*send)(void *operation),
                               void (*ended)(void *operation, enum cds_result result));

/* Ends the operation as `result`, unless its outcome is decided already. The poll that calls send()
 * or ended() then restores the bus and returns the result. */
void cds_steps_end(struct cds_steps *steps, enum cds_result result);

/* Decides that the operation ends as CDS_CANCELLED; the next poll returns that. A request that
 * waits is taken back. The bus is restored and unlocked at once; if a packet of the operation is on
 * the wire, when its transaction ends, from within cds_bus_poll(). */
void cds_steps_abort(struct cds_steps *steps);

/* Sets the rate of the bus for the next step. False: a request is in flight, try again later. */
static inline bool cds_steps_set_baud(const struct cds_steps *steps, uint8_t baud_reg)
{
    return steps->bus->baud_reg == baud_reg || cds_bus_set_baud(steps->bus, baud_reg) == CDS_OK;
}

#endif
