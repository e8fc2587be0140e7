/* SPDX-License-Identifier: MIT */
/* Reads the same registers of many servos: READs back to back (manual 2.4.2), each with its own
 * result and time. One READ is in flight or in the queue at a time, so requests of a higher
 * priority get their turn between two of them. For items that differ: read_pipeline.h. Main
 * context.
 */
#ifndef CDS_GROUP_READ_H
#define CDS_GROUP_READ_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/read_pipeline.h" // struct cds_read_pipeline

#ifdef __cplusplus
extern "C" {
#endif

/* The age of data that were never read. */
#define CDS_GROUP_READ_NEVER UINT32_MAX

/* The outcome of one servo's READ. Zero it (static storage is) before the first group read. Kept
 * from one group read to the next, it keeps the time of its data. */
struct cds_group_answer {
    uint32_t time_us; // when the reply that brought the data was taken
    uint8_t result;   // enum cds_result of the latest READ; CDS_PENDING: not asked or not over yet
    uint8_t error;    // CDS_ERROR_* bits of the latest reply
    bool known;       // there are data; false: they mean nothing
};

/* What to read. Bus, request and arrays stay in place until the operation has ended. */
struct cds_group_read_config {
    struct cds_bus *bus;              // open
    struct cds_request *requests;     // two of them, used in turn; capacities of each: packet
                                      // CDS_PACKET_SIZE(2), reply `length`
    const uint8_t *ids;               // 0 to 253
    uint8_t *data;                    // count * length bytes; those of servo i begin at
                                      // data[i * length]
    struct cds_group_answer *answers; // `count` of them
    uint8_t count;                    // of servos, 1 or more
    uint8_t address, length;          // of the registers; length: 1 to 50
};

/* A group read. The fields are internal. */
struct cds_group_read {
    uint8_t built;        // READs built so far
    uint8_t taken;        // READs whose outcome was noted
    uint8_t first_result; // of the first servo that failed, or CDS_OK
    struct cds_group_read_config config;
    struct cds_read_pipeline pipeline;
};

/* Prepares a group read; nothing is sent before the first poll. CDS_OK; CDS_BAD_ARGUMENT: the bus
 * is not open, or there is no servo; CDS_NO_ROOM: a buffer of a request is too small; CDS_BUSY: a
 * request is on its way. Unless it is CDS_OK, nothing was changed. */
enum cds_result cds_group_read_begin(struct cds_group_read *read,
                                     const struct cds_group_read_config *config);

/* Moves on by at most one transaction; call it and cds_bus_poll() from the main loop. A servo that
 * fails does not stop the others: answers[i].result tells how it failed, and its data stay as they
 * were, with their old time.
 *   CDS_PENDING  under way
 *   CDS_OK       all data are new
 * else the result of the first servo that failed: CDS_TIMEOUT, CDS_CORRUPT, CDS_LINE_BUSY;
 * CDS_REFUSED, see answers[i].error; CDS_NO_REPLY_DUE: it is set not to answer; CDS_BAD_ARGUMENT:
 * its ID, or address and length; CDS_CANCELLED: that, or the operation was aborted. */
enum cds_result cds_group_read_poll(struct cds_group_read *read);

/* Sends nothing more. Poll until the transaction in flight is over: the result is CDS_CANCELLED. */
void cds_group_read_abort(struct cds_group_read *read);

/* How old the data of this answer are, in microseconds, or CDS_GROUP_READ_NEVER. Counted from the
 * poll that took the reply: if the main loop is late, they are older by as much. Right up to
 * 71.6 min. */
uint32_t cds_group_read_age_us(const struct cds_group_answer *answer);

#ifdef __cplusplus
}
#endif

#endif
