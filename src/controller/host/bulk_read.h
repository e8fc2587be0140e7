/* SYNC READ (0x84, as USB2AX and ArbotiX define it) and BULK READ (0x92, as Robotis protocol 1.0
 * does) for servos that know single READ only (manual 2.4.2): a READ of each, one behind the other;
 * a reply leaves for the host while the next servo is asked.
 *
 *   SYNC READ  to the device or to all: FF FF FE LENGTH 84 ADDRESS N ID... CHECKSUM. One status
 *              packet of the device with N bytes for each ID in order; those of a servo that failed
 *              are 0xFF, and then error bit 7 is set. More than 252 bytes, or none: range error
 *   BULK READ  to all: FF FF FE LENGTH 92 00 (N ID ADDRESS)... CHECKSUM. The status packets of the
 *              servos in order. Each waits for the one before, so behind one that does not answer
 *              none follows, as if the servos did it themselves
 *
 * Which servos failed last time stands in device registers, a bit for each ID. Main context.
 */
#ifndef CONTROLLER_BULK_READ_H
#define CONTROLLER_BULK_READ_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"  // struct cds_request
#include "cds55xx/ring.h" // struct cds_ring
#include "host/device.h"  // struct device

#define INSTRUCTION_SYNC_READ  0x84
#define INSTRUCTION_BULK_READ  0x92
#define BULK_READ_ERROR_FAILED 0x80 // of a SYNC READ: at least one servo failed

enum bulk_read_turn {
    BULK_READ_MORE,
    BULK_READ_ANSWER, // over: a status packet of the device is due
    BULK_READ_DONE,   // over
} __attribute__((packed));

enum bulk_read_other {
    BULK_READ_ENDED, // its reply is there, or none
    BULK_READ_SPENT, // ... and was handed over
    BULK_READ_READY, // to be sent to the next servo, if there is one
    BULK_READ_WAITS, // likewise, and a servo is asked: the bus sees to its end
} __attribute__((packed));

/* All state of it. Fields without a word are its own. */
struct bulk_read { // the buffers last: what is near costs less to reach
    struct cds_bus *bus;
    struct device *device;
    struct cds_ring *output;
    struct cds_request *asked; // what was asked last;
    struct cds_request *spare; // the other one, and how far it is:
    uint8_t other;             // enum bulk_read_other
    bool is_bulk;              // else a SYNC READ
    uint8_t left;              // servos that have not answered
    uint8_t address, each;
    uint8_t device_id;
    uint8_t error, length;      // of BULK_READ_ANSWER
    uint8_t *to;                // of a SYNC READ: where the next data of the status packet go
    const uint8_t *next;        // what is asked of whom, from the READ built next on
    struct cds_request read[2]; // in turn
    uint8_t packets[2][CDS_PACKET_SIZE(2)];
    uint8_t replies[2][CDS_REPLY_MAX]; // of the device too, which finds its packet there
};

/* Once. */
void bulk_read_open(struct bulk_read *bulk, struct cds_bus *bus, struct device *device,
                    struct cds_ring *output);

/* Is it one of the two? `device_id`: the device's own. */
bool bulk_read_handles(uint8_t device_id, uint8_t id, uint8_t instruction);

/* Begins, with a whole packet in a buffer of 258 bytes, which becomes the data. False: it makes no
 * sense, and no servo would answer it. */
bool bulk_read_begin(struct bulk_read *bulk, uint8_t device_id, uint8_t *packet);

/* Moves on; behind cds_bus_poll(). */
enum bulk_read_turn bulk_read_poll(struct bulk_read *bulk);

/* Does a status packet wait for room in the ring? */
static inline bool bulk_read_talks(const struct bulk_read *bulk)
{
    return bulk->other == BULK_READ_ENDED;
}

/* Is there nothing to do before the servo asked has answered? */
static inline bool bulk_read_waits(const struct bulk_read *bulk)
{
    return bulk->other >= BULK_READ_WAITS;
}

/* How many parameters the reply to a packet may have: CDS_REPLY_NONE if none is due, else 0 to
 * CDS_REPLY_MAX. Manual: 2.4, R1. */
uint8_t status_packet_due(const uint8_t *packet);

#endif
