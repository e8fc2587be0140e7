/* SPDX-License-Identifier: MIT */
/* Requests that wait behind the one in flight, in the order of their priority, and retries of
 * requests that got no good reply. A bus without a queue refuses a second request as CDS_BUSY.
 *
 *     static struct cds_queue queue;
 *     cds_queue_attach(&queue, &bus);
 *     cds_queue_set_retries(&queue, 1);
 *
 * Main context.
 */
#ifndef CDS_QUEUE_H
#define CDS_QUEUE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus_hooks

#ifdef __cplusplus
extern "C" {
#endif

/* Zero it (static storage is), then cds_queue_attach(), or cds_queue_begin() for an upper layer
 * that attaches hooks of its own and passes them on. The fields are internal. */
struct cds_queue {
    struct cds_bus_hooks hooks;
    struct cds_bus *bus;
    struct cds_request *first; // waiting requests, in their order
    uint8_t retries;           // how many times an idempotent request may be sent again
};

/* Attaches the queue to `bus`, and stays in place. CDS_OK; CDS_BUSY: other hooks are attached, or a
 * request is in flight. */
enum cds_result cds_queue_attach(struct cds_queue *queue, struct cds_bus *bus);

/* Prepares a queue of `bus` for an upper layer with hooks of its own. The upper layer calls submit,
 * cancel and request_ended of queue->hooks, with the queue as their context. */
void cds_queue_begin(struct cds_queue *queue, struct cds_bus *bus);

/* Sets how often a request is sent again when no good reply has come: `retries`, 0 to 2; 0 at
 * first. Only what does the same when done twice is retried: PING, READ, and WRITE but of ID, baud
 * rate and LOCK. What a servo has refused is never retried, nor a request with `no_retry`. Requests
 * of a higher priority go before a retry. */
void cds_queue_set_retries(struct cds_queue *queue, uint8_t retries);

#ifdef __cplusplus
}
#endif

#endif
