/* SPDX-License-Identifier: MIT */
/* READs one behind the other; see read_pipeline.h. */
#include "cds55xx/read_pipeline.h"

#include <stddef.h>

#include "bus/steps_internal.h"   // cds_steps_check()
#include "compiler.h"             // OPTIMIZER_BARRIER(), NOINLINE
#include "wire/packet_internal.h" // cds_packet_start()

#define UNSENT CDS_BUSY // result of a READ that is built; a submit that has to wait leaves it so

/* Builds the READ of the next item in `request`. */
NOINLINE static void build(struct cds_read_pipeline *pipeline, struct cds_request *request)
{
    struct cds_read_item item;
    bool is_sent = pipeline->config.next(pipeline->config.context, &item);
    const uint8_t parameters[2] = {item.address, item.length};

    cds_packet_start(&request->packet, parameters, sizeof parameters, item.id, CDS_READ);
    cds_packet_end(&request->packet);
    request->id = item.id;
    request->reply_parameters = item.length <= CDS_REPLY_MAX ? item.length : 0;
    request->any_length = false;
    request->error = 0;
    request->length = 0;
    request->result = is_sent ? UNSENT : CDS_OK;
    if (is_sent && request->reply_parameters > request->reply_capacity)
        request->result = CDS_NO_ROOM;
}

/* True once the request that has ended is taken over. */
static void hand_over(struct cds_read_pipeline *pipeline)
{
    if (pipeline->config.take(pipeline->config.context, pipeline->other))
        pipeline->state = CDS_READ_SPENT;
}

/* The current item has ended: sends the next one first, then hands over what has come. The fields
 * are stored before the submit: to keep them in registers meanwhile costs 10 cycles. */
static void go_on(struct cds_read_pipeline *pipeline)
{
    struct cds_request *ended = pipeline->current, *next = pipeline->other;

    pipeline->current = next;
    pipeline->other = ended;
    pipeline->state = CDS_READ_ENDED;
    pipeline->remaining--;
    if (pipeline->config.stops_on_failure && ended->result != CDS_OK)
        pipeline->remaining = 0;
    if (pipeline->remaining && next->result == UNSENT)
        cds_bus_submit_valid(pipeline->config.bus, next); // next->result tells if it is refused
    hand_over(pipeline);
}

/* If the item before this one was not taken over yet, cds_read_pipeline_poll() goes on. */
static void on_end(struct cds_request *ended)
{
    struct cds_read_pipeline *pipeline = (struct cds_read_pipeline *)ended->context;

    if (pipeline->state == CDS_READ_AWAITING)
        go_on(pipeline);
}

enum cds_result cds_read_pipeline_begin(struct cds_read_pipeline *pipeline,
                                        const struct cds_read_pipeline_config *config)
{
    struct cds_request *requests = config->requests;

    if (config->count == 0)
        return CDS_BAD_ARGUMENT;
    for (uint8_t i = 0; i < 2; i++) {
        enum cds_result result =
            cds_steps_check(config->bus, &requests[i], CDS_PACKET_SIZE(2), config->longest);

        if (result != CDS_OK)
            return result;
    }
    for (uint8_t i = 0; i < 2; i++) {
        requests[i].on_end = on_end;
        requests[i].context = pipeline;
    }
    *pipeline = (struct cds_read_pipeline){.state = CDS_READ_BEGUN,
                                           .remaining = config->count,
                                           .result = CDS_PENDING,
                                           .outcome = CDS_OK,
                                           .current = &requests[0],
                                           .other = &requests[1],
                                           .config = *config};
    return CDS_OK;
}

void cds_read_pipeline_abort(struct cds_read_pipeline *pipeline)
{
    struct cds_request *current = pipeline->current;

    if (pipeline->result != CDS_PENDING)
        return;
    pipeline->outcome = CDS_CANCELLED;
    if (current->result == CDS_PENDING &&
        cds_bus_cancel(pipeline->config.bus, current) == CDS_BUSY) {
        pipeline->remaining = 1; // its packet has left: it ends by its deadline
        return;
    }
    pipeline->remaining = 0;
    if (pipeline->state == CDS_READ_AWAITING)
        pipeline->state = CDS_READ_SPENT;
}

/* `other` was taken over. Sends `current` if it is not sent yet, and builds the READ after it. */
static void prepare(struct cds_read_pipeline *pipeline)
{
    struct cds_request *current = pipeline->current;

    if (current->result == UNSENT)
        cds_bus_submit(pipeline->config.bus, current);
    if (pipeline->state == CDS_READ_SPENT && pipeline->remaining > 1)
        build(pipeline, pipeline->other);
    pipeline->state = CDS_READ_PREPARED;
    if (current->result == CDS_PENDING)
        pipeline->state = CDS_READ_AWAITING;
    else if (current->result != UNSENT) // it ended before `other` was taken over, or was not sent
        go_on(pipeline);
}

/* The READ was cancelled, by cds_bus_cancel() or because the bus was opened again: neither calls
 * on_end. */
NOINLINE static void end_cancelled(struct cds_read_pipeline *pipeline)
{
    pipeline->outcome = CDS_CANCELLED;
    pipeline->remaining = 0;
    pipeline->state = CDS_READ_SPENT;
}

enum cds_result cds_read_pipeline_poll(struct cds_read_pipeline *pipeline)
{
    struct cds_request *requests;

    OPTIMIZER_BARRIER(pipeline);
    if (pipeline->state == CDS_READ_AWAITING) {
        if (pipeline->current->result == CDS_PENDING)
            return CDS_PENDING;
        end_cancelled(pipeline);
    } else if (pipeline->result != CDS_PENDING) {
        return (enum cds_result)pipeline->result;
    }
    if (pipeline->state == CDS_READ_BEGUN) {
        build(pipeline, pipeline->current);
        pipeline->state = CDS_READ_SPENT;
    }
    if (pipeline->state == CDS_READ_ENDED)
        hand_over(pipeline);
    else if (pipeline->remaining)
        prepare(pipeline);
    if (pipeline->remaining == 0 && pipeline->state != CDS_READ_ENDED) {
        requests = pipeline->config.requests;
        requests[0].on_end = requests[1].on_end = NULL;
        pipeline->result = pipeline->outcome;
    }
    return (enum cds_result)pipeline->result;
}
