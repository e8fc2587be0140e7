/* SPDX-License-Identifier: MIT */
/* READs of many servos one behind the other (manual 2.4.2), each of its own registers: the READ of
 * the next servo is built while a reply is awaited, and sent from the end of that transaction.
 *
 * Use group_read.h to read the same registers of all servos into one array. Use this header if the
 * items differ, or if each reply is to be handed on as it comes, as the controller does for BULK
 * READ. One READ is in flight or in the queue at a time, so requests of a higher priority get their
 * turn between two of them. Main context.
 */
#ifndef CDS_READ_PIPELINE_H
#define CDS_READ_PIPELINE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_request

#ifdef __cplusplus
extern "C" {
#endif

/* One READ: `length` bytes from register `address` on. Neither is checked: a servo refuses what
 * lies outside its control table. A reply to more than CDS_REPLY_MAX bytes is not expected. */
struct cds_read_item {
    uint8_t id;              // 0 to 253
    uint8_t address, length; // of the registers, in bytes
};

/* What to read. Bus, requests and context stay in place until the operation has ended. */
struct cds_read_pipeline_config {
    struct cds_bus *bus;          // open
    struct cds_request *requests; // two of them, used in turn; the operation uses on_end and
                                  // context of both. Packet capacity: CDS_PACKET_SIZE(2)
    uint8_t count;                // of items, 1 or more
    uint8_t longest;              // item, in bytes: the capacity that both replies must have
    bool stops_on_failure;        // no READ follows a READ that ended without a reply
    void *context;                // for next and take

    /* Fills in the next item; called once for each. False: no READ is sent for this item; it ends
     * in its turn as CDS_OK without data. */
    bool (*next)(void *context, struct cds_read_item *item);

    /* Takes over the outcome of an item, in the order of the items: result, id, error, reply and
     * length of `ended`. Called from cds_bus_poll() or from the poll below, as a rule while the
     * next READ is on its way. False: not now; the next poll calls it again. */
    bool (*take)(void *context, struct cds_request *ended);
};

/* How far the two requests are. */
enum cds_read_pipeline_state {
    CDS_READ_BEGUN,    // no READ is built
    CDS_READ_ENDED,    // `other` has ended and waits for take()
    CDS_READ_SPENT,    // `other` was taken over; its next item is not built yet
    CDS_READ_PREPARED, // `other` is built if there is another item; `current` is not in flight
    CDS_READ_AWAITING, // the same, and `current` is in flight: its end sends `other`
} __attribute__((packed));

/* The operation: the caller reads `result`. */
struct cds_read_pipeline {
    // internal:
    uint8_t state;     // enum cds_read_pipeline_state
    uint8_t remaining; // items that have not ended
    // to be read:
    uint8_t result; // enum cds_result: CDS_PENDING until the operation has ended
    // internal:
    uint8_t outcome;             // what it will end as
    struct cds_request *current; // the item that is read, or that has ended last
    struct cds_request *other;   // the item before `current`, then the one after it
    struct cds_read_pipeline_config config;
};

/* Prepares the operation; nothing is sent before the first poll. CDS_OK; CDS_BAD_ARGUMENT: the bus
 * is not open, or there is no item; CDS_NO_ROOM: a buffer is too small; CDS_BUSY: a request is on
 * its way. Unless it is CDS_OK, nothing was changed. */
enum cds_result cds_read_pipeline_begin(struct cds_read_pipeline *pipeline,
                                        const struct cds_read_pipeline_config *config);

/* Moves on; call it beside cds_bus_poll() from the main loop. CDS_PENDING; CDS_OK: every item, or
 * every item up to a failure, was taken over; CDS_CANCELLED: it was aborted, its
 * READ was cancelled, or the bus was opened again. */
enum cds_result cds_read_pipeline_poll(struct cds_read_pipeline *pipeline);

/* Sends nothing more. Poll until the transaction in flight is over: the result is CDS_CANCELLED. */
void cds_read_pipeline_abort(struct cds_read_pipeline *pipeline);

/* True while only cds_bus_poll() can move the operation on, unless its READ was cancelled. */
static inline bool cds_read_pipeline_is_awaiting(const struct cds_read_pipeline *pipeline)
{
    return pipeline->state == CDS_READ_AWAITING;
}

#ifdef __cplusplus
}
#endif

#endif
