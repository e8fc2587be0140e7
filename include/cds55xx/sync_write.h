/* SPDX-License-Identifier: MIT */
/* SYNC WRITE: the same registers of many servos (manual 2.4.7). One packet that the caller fills,
 * or as many packets as it takes. No servo replies: whether a packet was heard is not known.
 *
 *     cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
 *     cds_sync_write_add_goal(&request, 1, 512, 100);
 *     cds_sync_write_add_goal(&request, 2, 300, 100);
 *     cds_sync_write_send(&bus, &request);
 *
 * To know that each servo has taken its goal before any starts: registered_move.h. Main context.
 */
#ifndef CDS_SYNC_WRITE_H
#define CDS_SYNC_WRITE_H

#include <stdint.h>

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/steps.h"         // struct cds_steps

#ifdef __cplusplus
extern "C" {
#endif

/* ---- one packet ---- */

/* Begins the packet. Begin and add write into the request's packet buffer, which must be
 * CDS_SYNC_WRITE_SIZE(servos, length) bytes; send reports what does not fit. `length`: bytes for
 * each servo, 1 to 50, from `address` on. CDS_OK; CDS_BAD_ARGUMENT: address and length lie outside
 * the control table; CDS_BUSY: the request is on its way, and add changes nothing either. */
enum cds_result cds_sync_write_begin(struct cds_request *request, uint8_t address, uint8_t length);

/* Adds one servo: ID 0 to 253 and its `length` bytes of `data`; or, for a SYNC WRITE of
 * GOAL_POSITION and MOVING_SPEED (length 4), the goal `position` 0 to 1023 (0 to 300 degrees) and
 * `speed` 0 to 1023 (62/1023 RPM each, 0: as fast as it can; R8, R10). */
void cds_sync_write_add(struct cds_request *request, uint8_t id, const uint8_t *data);
void cds_sync_write_add_goal(struct cds_request *request, uint8_t id, uint16_t position,
                             uint16_t speed);

/* Sends the packet. Results as cds_servo_write(), plus CDS_NO_ROOM if a servo did not fit and
 * CDS_BAD_ARGUMENT if begin refused, a value was out of range, or a goal was added where `length`
 * is not 4. The same packet may be sent again. */
enum cds_result cds_sync_write_send(struct cds_bus *bus, struct cds_request *request);

/* ---- as many packets as it takes ---- */

/* The longest packet there is, in bytes: LENGTH 254. */
#define CDS_SYNC_WRITE_PACKET_MAX (CDS_LENGTH_MAX + 4u)

/* What to write. Bus, request and arrays stay in place until the operation has ended. */
struct cds_sync_write_many_config {
    struct cds_bus *bus;         // open
    struct cds_request *request; // packet capacity: CDS_SYNC_WRITE_SIZE(1, length) at least; the
                                 // larger, the fewer packets. All have its priority
    const uint8_t *ids;          // 0 to 253
    const uint8_t *data;         // those of servo i begin at data[i * length]
    uint8_t count;               // of servos, 1 to 254
    uint8_t address, length;     // of the registers; length: 1 to 50
    uint16_t packet_max;         // no packet is longer, in bytes; 0: CDS_SYNC_WRITE_PACKET_MAX. For
                                 // servos with a small receive buffer, of which 64 and 143 bytes
                                 // are known: each servo on the bus hears each packet
};

/* One operation: the caller reads the first two fields and steps.result. */
struct cds_sync_write_many {
    uint8_t next;    // servos before this one have been sent their data
    uint8_t packets; // sent so far
    uint8_t end;     // servos before this one are in the packet in flight
    // internal:
    struct cds_sync_write_many_config config;
    // to be read:
    struct cds_steps steps; // steps.result: enum cds_result of the whole
};

/* Prepares it; nothing is sent before the first poll. The packets take effect one after the other:
 * a packet is later than the one before it by its time on the wire (2.6 ms for the longest at
 * 1 Mbps), by the time to build it (0.9 ms for 50 servos of 4 bytes on an AVR of 16 MHz) and by
 * requests of a higher priority in between. CDS_OK; CDS_BAD_ARGUMENT: the bus is not open, there is
 * no servo, or an ID, the address or the length is out of range; CDS_NO_ROOM: the data of one servo
 * do not fit the buffer or packet_max; CDS_BUSY: the request is on its way. Unless it is CDS_OK,
 * nothing was changed. */
enum cds_result cds_sync_write_many_begin(struct cds_sync_write_many *write,
                                          const struct cds_sync_write_many_config *config);

/* Moves on by at most one packet; call it and cds_bus_poll() from the main loop. CDS_PENDING: under
 * way. CDS_OK: all packets are out. Else a packet was not sent, and `next` tells which servos have
 * their data: CDS_TIMEOUT, CDS_LINE_BUSY; CDS_CANCELLED: aborted, or the request was cancelled, or
 * the bus opened again; CDS_LIMIT, CDS_INHIBITED: the permit (servos.h) refuses a servo. */
enum cds_result cds_sync_write_many_poll(struct cds_sync_write_many *write);

/* Sends nothing more. Poll until the packet in flight is sent: the result is CDS_CANCELLED. */
void cds_sync_write_many_abort(struct cds_sync_write_many *write);

#ifdef __cplusplus
}
#endif

#endif
