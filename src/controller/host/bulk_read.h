/* SPDX-License-Identifier: MIT */
/* SYNC READ (0x84, as USB2AX and ArbotiX define it) and BULK READ (0x92, as Robotis protocol 1.0
 * defines it) for servos that know single READ only (manual 2.4.2): one READ for each servo, by
 * read_pipeline.h.
 *
 *   SYNC READ  to the device or to all: FF FF FE LENGTH 84 ADDRESS N ID... CHECKSUM. The device
 *              sends one status packet with N bytes for each ID, in order. The bytes of a servo
 *              that failed are 0xFF, and then error bit 7 is set. More than 252 bytes in all, or
 *              none: range error
 *   BULK READ  to all: FF FF FE LENGTH 92 00 (N ID ADDRESS)... CHECKSUM. The status packets of the
 *              servos in order. Nothing follows a servo that does not answer: servos that know
 *              BULK READ wait for the status packet of the servo before them
 *
 * Device registers FAILED and FAILED_IDS tell which servos failed last time. Main context.
 */
#ifndef CONTROLLER_BULK_READ_H
#define CONTROLLER_BULK_READ_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/read_pipeline.h" // struct cds_read_pipeline
#include "cds55xx/ring.h"          // struct cds_ring
#include "host/device.h"           // struct device

#define INSTRUCTION_SYNC_READ  0x84
#define INSTRUCTION_BULK_READ  0x92
#define BULK_READ_ERROR_FAILED 0x80 // error bit of a SYNC READ: at least one servo failed

/* What bulk_read_poll() tells. */
enum bulk_read_progress {
    BULK_READ_MORE,    // call again
    BULK_READ_ANSWER,  // ended: a status packet of the device is due
    BULK_READ_DONE,    // ended: nothing more is due
    BULK_READ_DROPPED, // ended by bulk_read_abort(): nothing more is due
} __attribute__((packed));

/* All state of it. The buffers stand last: an AVR reaches the first 64 bytes with less code. */
struct bulk_read {
    struct cds_read_pipeline pipeline;
    struct cds_bus *bus;
    struct device *device;
    struct cds_ring *output;
    const uint8_t *next; // the part of the packet that tells the next READ
    uint8_t *to;         // SYNC READ: where the next data of the status packet go
    bool is_bulk;        // a BULK READ, else a SYNC READ
    uint8_t servos;      // that the packet names
    uint8_t address;     // SYNC READ: of the first register
    uint8_t length;      // SYNC READ: bytes of each servo
    uint8_t device_id;
    uint8_t error, data_length;     // of the status packet that BULK_READ_ANSWER tells
    struct cds_request requests[2]; // of the pipeline
    uint8_t packets[2][CDS_PACKET_SIZE(2)];
    uint8_t replies[2][CDS_REPLY_MAX]; // the device finds its packet there, too
};

/* Opens it; it must be zero. Call once. */
void bulk_read_open(struct bulk_read *bulk, struct cds_bus *bus, struct device *device,
                    struct cds_ring *output);

/* True if a packet with this ID and instruction is a SYNC READ or a BULK READ. `device_id`: of the
 * device. */
bool bulk_read_handles(uint8_t device_id, uint8_t id, uint8_t instruction);

/* Begins with a whole packet in a buffer of 258 bytes; the data of a SYNC READ replace it. False: a
 * BULK READ that names no servos; a servo would not answer such a packet. */
bool bulk_read_begin(struct bulk_read *bulk, uint8_t device_id, uint8_t *packet);

/* Moves on; call it after cds_bus_poll(). */
enum bulk_read_progress bulk_read_poll(struct bulk_read *bulk);

/* Sends no further READ. Poll it until it has ended. */
void bulk_read_abort(struct bulk_read *bulk);

/* True while a status packet waits for room in the ring. */
static inline bool bulk_read_talks(const struct bulk_read *bulk)
{
    return bulk->pipeline.state == CDS_READ_ENDED;
}

/* True while only cds_bus_poll() can move it on. */
static inline bool bulk_read_is_awaiting(const struct bulk_read *bulk)
{
    return cds_read_pipeline_is_awaiting(&bulk->pipeline);
}

/* Returns how many parameters the reply to `packet` may have: CDS_REPLY_NONE if no reply is due,
 * else 0 to CDS_REPLY_MAX. Manual 2.4; ruling R1. */
uint8_t status_packet_due(const uint8_t *packet);

#endif
