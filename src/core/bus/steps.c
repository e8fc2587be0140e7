/* SPDX-License-Identifier: MIT */
/* One request after another; see steps_internal.h. */
#include "bus/steps_internal.h"

#include <stddef.h>

#include "compiler.h" // OPTIMIZER_BARRIER(), NOINLINE

NOINLINE enum cds_result cds_steps_check(const struct cds_bus *bus,
                                         const struct cds_request *request,
                                         uint16_t packet_capacity, uint8_t reply_capacity)
{
    if (bus->state == CDS_BUS_CLOSED)
        return CDS_BAD_ARGUMENT;
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (request->packet.capacity < packet_capacity || request->reply_capacity < reply_capacity)
        return CDS_NO_ROOM;
    return CDS_OK;
}

NOINLINE enum cds_result cds_steps_check_exclusive(const struct cds_bus *bus,
                                                   const struct cds_request *request,
                                                   uint16_t packet_capacity, uint8_t reply_capacity)
{
    return bus->lock ? CDS_BUSY : cds_steps_check(bus, request, packet_capacity, reply_capacity);
}

NOINLINE void cds_steps_begin(struct cds_steps *steps, struct cds_bus *bus,
                              struct cds_request *request)
{
    *steps = (struct cds_steps){
        .bus = bus,
        .request = request,
        .result = CDS_PENDING,
        .outcome = CDS_PENDING,
        .return_delay_us = bus->return_delay_us,
    };
}

/* Restores and unlocks the bus. Does nothing if the bus was opened again since, or if another
 * request is in flight at the operation's rate. */
static void restore(struct cds_steps *steps)
{
    struct cds_bus *bus = steps->bus;

    if (bus->lock != &steps->lock || !cds_steps_set_baud(steps, steps->lock.baud_reg))
        return;
    if (bus->return_delay_us == CDS_RETURN_DELAY_MAX_US) // else the program has set another one
        cds_bus_set_return_delay(bus, steps->return_delay_us);
    cds_bus_unlock(bus, &steps->lock);
}

/* The transaction of an exclusive operation has ended. After an abort the bus is restored here: a
 * program may not poll the operation again. */
static void on_end(struct cds_request *request)
{
    struct cds_steps *steps = (struct cds_steps *)request->context;

    if (steps->outcome != CDS_PENDING)
        restore(steps);
}

static void abort_steps(void *context)
{
    cds_steps_abort((struct cds_steps *)context);
}

void cds_steps_begin_exclusive(struct cds_steps *steps, struct cds_bus *bus,
                               struct cds_request *request)
{
    cds_steps_begin(steps, bus, request);
    steps->is_exclusive = true;
    steps->lock = (struct cds_bus_lock){abort_steps, steps, bus->baud_reg};
    request->passes_lock = true;
    request->priority = CDS_PRIORITY_NORMAL; // behind all that was accepted before the lock
    request->on_end = on_end;
    request->context = steps;
    cds_bus_lock(bus, &steps->lock);
    cds_bus_set_return_delay(bus, CDS_RETURN_DELAY_MAX_US);
}

NOINLINE void cds_steps_end(struct cds_steps *steps, enum cds_result result)
{
    if (steps->outcome == CDS_PENDING)
        steps->outcome = (uint8_t)result;
}

void cds_steps_abort(struct cds_steps *steps)
{
    enum cds_result taken_back = CDS_BAD_ARGUMENT;

    if (steps->result != CDS_PENDING)
        return;
    cds_steps_end(steps, CDS_CANCELLED);
    if (steps->is_submitted)
        taken_back = cds_bus_cancel(steps->bus, steps->request);
    if (taken_back == CDS_OK)
        steps->is_submitted = false; // so ended() is not called
    if (taken_back != CDS_BUSY)
        restore(steps);
}

/* The outcome is decided. The operation ends now, or as soon as the bus can be restored. */
static void finish(struct cds_steps *steps)
{
    struct cds_request *request = steps->request;

    if (steps->is_exclusive) {
        restore(steps);
        if (steps->bus->lock == &steps->lock)
            return;
        request->passes_lock = request->no_retry = false;
        request->ignores_stale = request->ignores_servo_state = false;
        request->on_end = NULL;
        request->context = NULL;
    }
    steps->result = steps->outcome;
}

static enum cds_result result_of(const struct cds_request *request)
{
    if (request->result == CDS_OK && request->error & CDS_ERRORS_OF_PACKET)
        return CDS_REFUSED;
    return (enum cds_result)request->result;
}

enum cds_result cds_steps_poll(struct cds_steps *steps, void *operation,
                               enum cds_result (*send)(void *operation),
                               void (*ended)(void *operation, enum cds_result result))
{
    enum cds_result result;

    if (steps->result != CDS_PENDING)
        return (enum cds_result)steps->result;
    if (steps->is_submitted) {
        result = result_of(steps->request);
        if (result == CDS_PENDING)
            return CDS_PENDING;
        if (steps->is_exclusive && result == CDS_CANCELLED)
            steps->outcome = CDS_CANCELLED;
        ended(operation, result);
        steps->is_submitted = false;
    }
    if (steps->is_exclusive && steps->bus->lock != &steps->lock)
        cds_steps_end(steps, CDS_CANCELLED); // aborted, or the bus was opened again
    if (steps->outcome == CDS_PENDING) {
        result = send(operation);
        if (result == CDS_OK)
            steps->is_submitted = true;
        else if (result != CDS_BUSY)
            ended(operation, result);
    }
    if (steps->outcome != CDS_PENDING)
        finish(steps);
    return (enum cds_result)steps->result;
}
