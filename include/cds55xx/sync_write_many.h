/* SYNC WRITE of any registers to any number of servos (manual 2.4.7), in as few packets as it
 * takes: as many servos in each as LENGTH (R23), the request's buffer and the servos can hold.
 *
 * The packets go out in order, one behind the other, and so the parts do not take effect together:
 * the servos of the second packet are later by its time on the wire (2.6 ms for the longest at
 * 1 Mbps), by the time to build it (0.9 ms for 50 servos of 4 bytes, on an AVR of 16 MHz) and by
 * whatever urgent slipped in between. If all must start at the same moment:
 * registered_move.h. For a few servos again and again, sync_write.h has the packet at hand already.
 *
 * All functions: main context.
 */
#ifndef CDS_SYNC_WRITE_MANY_H
#define CDS_SYNC_WRITE_MANY_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"           // struct cds_request
#include "cds55xx/control_table.h" // CDS_REG_*

#ifdef __cplusplus
extern "C" {
#endif

/* The longest packet there is, in bytes: LENGTH 254. */
#define CDS_SYNC_WRITE_MANY_LONGEST (CDS_LENGTH_MAX + 4u)

/* A group write. All of it is the operation's own; arrays and request stay in place until it is
 * over. */
struct cds_sync_write_many {
    struct cds_bus *bus;
    struct cds_request *request;
    const uint8_t *ids;
    const uint8_t *data;
    uint16_t longest; // packet that every servo can take, in bytes
    uint8_t count;
    uint8_t address;
    uint8_t length;
    uint8_t next;    // servos before this one have been sent theirs
    uint8_t end;     // ... and up to here are in the packet under way
    uint8_t packets; // sent so far
    bool checked;    // the arguments are good
    bool sent;       // a packet is on its way
    uint8_t result;
};

/* Prepares a SYNC WRITE of `length` bytes (1 to 50) from `address` on to each of the `count` (1 or
 * more) servos `ids` (0 to 253); nothing is sent before the first poll. `data` is `count` times
 * `length` bytes: those of servo i begin at data[i * length]. The request's buffer must hold one
 * servo's, CDS_SYNC_WRITE_SIZE(1, length) bytes; the larger it is, up to
 * CDS_SYNC_WRITE_MANY_LONGEST, the fewer packets. All of them are as urgent as `request->urgent`
 * says. */
void cds_sync_write_many_begin(struct cds_sync_write_many *write, struct cds_bus *bus,
                               struct cds_request *request, const uint8_t *ids, uint8_t count,
                               uint8_t address, uint8_t length, const uint8_t *data);

/* Before the first poll, as wanted: no packet is longer than `bytes`, for servos whose own buffer
 * ends there, of which 64 and 143 bytes are known. CDS_SYNC_WRITE_SIZE(1, length) to
 * CDS_SYNC_WRITE_MANY_LONGEST, which it is from begin on; every servo on the bus hears every
 * packet, so what counts is the smallest buffer of those that are written to. */
void cds_sync_write_many_set_longest(struct cds_sync_write_many *write, uint16_t bytes);

/* Moves on by at most one packet; call it and cds_bus_poll() from the main loop.
 * CDS_PENDING: not over yet. CDS_OK: all packets are out; none is answered (2.4.7), so whether they
 * were heard is not known. CDS_BAD_ARGUMENT: no bus is open, there is no servo, or an ID, the
 * address or the length is out of range; CDS_NO_ROOM: one servo's data do not fit the buffer or the
 * longest packet; in both nothing was sent. CDS_TIMEOUT, CDS_LINE_BUSY, CDS_CANCELLED: a packet
 * could not be sent; CDS_LIMIT, CDS_INHIBITED: a servo of it must not be driven so (servos.h; its
 * refused_id says which). Servos before write->next have been sent theirs, the others not. */
enum cds_result cds_sync_write_many_poll(struct cds_sync_write_many *write);

#ifdef __cplusplus
}
#endif

#endif
