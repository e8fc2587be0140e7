/* SPDX-License-Identifier: MIT */
/* Priority and retries; see queue.h. */
#include "cds55xx/queue.h"

#include <stddef.h>

#include "bus/line_internal.h"     // GATE_LINE
#include "cds55xx/control_table.h" // CDS_REG_*
#include "compiler.h"              // OPTIMIZER_BARRIER()

/* Puts the request before all of a lower priority than `priority`. */
static void insert(struct cds_queue *queue, struct cds_request *request, uint8_t priority)
{
    struct cds_request **place = &queue->first;

    while (*place && (*place)->priority >= priority)
        place = &(*place)->next;
    request->next = *place;
    *place = request;
}

/* True if `request` goes before the one that waits for the line. While the line is in use only
 * torque off does: goals that come more often than a wait may last would begin the other wait again
 * without end. */
static bool overtakes(const struct cds_bus *bus, const struct cds_request *request)
{
    uint8_t passed = bus->request->priority;

    if (bus->gate & GATE_LINE)
        passed |= CDS_PRIORITY_HIGH;
    return request->priority > passed;
}

static NOINLINE void start_first(struct cds_queue *queue)
{
    struct cds_request *first = queue->first;

    if (!first)
        return;
    queue->first = first->next;
    cds_bus_start(queue->bus, first);
}

static enum cds_result submit(void *context, struct cds_request *request)
{
    struct cds_queue *queue = (struct cds_queue *)context;
    bool goes_first = overtakes(queue->bus, request);
    struct cds_request *overtaken;

    request->result = CDS_PENDING;
    insert(queue, request, request->priority);
    overtaken = goes_first ? cds_bus_take_back(queue->bus) : NULL;
    if (overtaken) {
        insert(queue, overtaken, (uint8_t)(overtaken->priority + 1u));
        start_first(queue);
    }
    return CDS_OK;
}

static bool cancel(void *context, struct cds_request *request)
{
    struct cds_queue *queue = (struct cds_queue *)context;
    struct cds_request **place = &queue->first;

    while (*place && *place != request && request)
        place = &(*place)->next;
    if (!*place)
        return false;
    do {
        (*place)->result = CDS_CANCELLED;
        (*place)->retries = 0;
        *place = (*place)->next;
    } while (*place && !request);
    return true;
}

/* True if the registers `first` to `last` have one of `from` to `to` among them. */
static bool overlaps(uint8_t first, uint8_t last, uint8_t from, uint8_t to)
{
    return first <= to && from <= last;
}

/* True if the packet may be sent again although its servo may have carried it out. False if that
 * does something twice, if the servo may answer under another ID or at another rate by then, or if
 * it refuses the second packet: a lock is set once (R6). */
static bool is_idempotent(const uint8_t *bytes)
{
    uint8_t first = bytes[CDS_AT_PARAMETERS];
    uint8_t last = (uint8_t)(first + bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN - 2);

    switch (bytes[CDS_AT_INSTRUCTION]) {
    case CDS_PING:
    case CDS_READ: return true;
    case CDS_WRITE:
        return !overlaps(first, last, CDS_REG_ID, CDS_REG_BAUD_RATE) &&
               !overlaps(first, last, CDS_REG_LOCK, CDS_REG_LOCK);
    default: return false;
    }
}

/* True if the request waits again, before all of its own priority. */
static bool retry(struct cds_queue *queue, struct cds_request *request, enum cds_result result)
{
    if ((result != CDS_TIMEOUT && result != CDS_CORRUPT) || request->retries >= queue->retries ||
        request->no_retry || !is_idempotent(request->packet.bytes))
        return false;
    request->retries++;
    insert(queue, request, (uint8_t)(request->priority + 1u));
    return true;
}

static enum cds_result request_ended(void *context, struct cds_request *request,
                                     enum cds_result result)
{
    struct cds_queue *queue = (struct cds_queue *)context;
    bool is_kept = retry(queue, request, result);

    start_first(queue);
    if (is_kept)
        return CDS_PENDING;
    if (request->retries && result > CDS_CORRUPT) // the order of result.h
        result = CDS_TIMEOUT; // the retry was not sent, but the packet was before
    request->retries = 0;
    return result;
}

void cds_queue_begin(struct cds_queue *queue, struct cds_bus *bus)
{
    OPTIMIZER_BARRIER(queue);
    *queue = (struct cds_queue){
        .hooks = {.context = queue,
                  .submit = submit,
                  .cancel = cancel,
                  .request_ended = request_ended},
        .bus = bus,
    };
}

enum cds_result cds_queue_attach(struct cds_queue *queue, struct cds_bus *bus)
{
    enum cds_result result = cds_bus_attach(bus, &queue->hooks);

    if (result == CDS_OK)
        cds_queue_begin(queue, bus);
    return result;
}

void cds_queue_set_retries(struct cds_queue *queue, uint8_t retries)
{
    queue->retries = retries;
}
