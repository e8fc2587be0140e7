/* Reading the same registers of many servos: READs back to back (manual 2.4.2), each with its own
 * outcome and time. One is in flight or in the bus's queue at a time, so whatever else is
 * submitted, urgent requests above all, gets its turn between two of them.
 *
 * All functions: main context.
 */
#ifndef CDS_GROUP_READ_H
#define CDS_GROUP_READ_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"           // struct cds_request
#include "cds55xx/control_table.h" // CDS_REG_*

#ifdef __cplusplus
extern "C" {
#endif

/* The age of data that were never read. */
#define CDS_GROUP_READ_NEVER UINT32_MAX

/* What became of one servo's READ. Zero it (static storage is) before the first group read; one
 * that is kept from one group read to the next keeps the time of its data. */
struct cds_group_answer {
    uint32_t time_us; // when the reply that brought the data was taken
    uint8_t result;   // enum cds_result of the latest READ; CDS_PENDING: not asked or not over yet
    uint8_t error;    // CDS_ERROR_* bits of the latest reply
    bool known;       // there are data; false: they mean nothing
};

/* A group read. All of it is the operation's own; arrays and request stay in place until it is
 * over.
 */
struct cds_group_read {
    struct cds_bus *bus;
    struct cds_request *request;
    const uint8_t *ids;
    uint8_t *data;
    struct cds_group_answer *answers;
    uint8_t count;
    uint8_t address;
    uint8_t length;
    uint8_t next; // servo being read
    bool is_sent; // its READ is on its way
    uint8_t result;
};

/* Prepares a READ of `length` bytes (1 to 50) from `address` on of each of the `count` (1 or more)
 * servos `ids` (0 to 253); nothing is sent before the first poll. `data` is `count` times `length`
 * bytes: those of servo i begin at data[i * length]. `answers`: `count` of them. The
 * request's packet must have a capacity of CDS_PACKET_SIZE(2), its reply one of `length`. */
void cds_group_read_begin(struct cds_group_read *read, struct cds_bus *bus,
                          struct cds_request *request, const uint8_t *ids, uint8_t count,
                          uint8_t address, uint8_t length, uint8_t *data,
                          struct cds_group_answer *answers);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop. One servo that
 * fails does not stop the others: answers[i].result tells who and how, and its data stay as they
 * were, with their old time.
 * CDS_PENDING: not over yet. CDS_OK: all data are new. Else the result of the first servo that
 * failed: CDS_TIMEOUT, CDS_CORRUPT, CDS_LINE_BUSY, CDS_CANCELLED; CDS_REFUSED, see
 * answers[i].error; CDS_NO_REPLY_DUE: it is set not to answer (servos.h); CDS_BAD_ARGUMENT: its ID,
 * or address and length; CDS_NO_ROOM: the request's buffer is too small.
 */
enum cds_result cds_group_read_poll(struct cds_group_read *read);

/* How old the data of this answer are, in microseconds, or CDS_GROUP_READ_NEVER. Counted from the
 * poll that took the reply: a main loop that is late sees them younger by as much. Right up to
 * 71.6 min. */
uint32_t cds_group_read_age_us(const struct cds_group_answer *answer);

#ifdef __cplusplus
}
#endif

#endif
