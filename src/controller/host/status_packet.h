/* SPDX-License-Identifier: MIT */
/* Puts a status packet into the ring to the host, which empties at the rate of the host link.
 * Manual: 2.3. Main context. */
#ifndef CONTROLLER_STATUS_PACKET_H
#define CONTROLLER_STATUS_PACKET_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_AT_PARAMETERS
#include "cds55xx/ring.h"   // struct cds_ring

#define STATUS_PACKET_HEAD CDS_AT_PARAMETERS // bytes of a packet before its parameters

/* A status packet that goes into the ring in parts. */
struct status_packet {
    const uint8_t *from; // the next byte; it stays in place until it is in the ring
    uint16_t left;       // bytes
};

/* Makes a packet around `length` parameters, 0 to 252, where they stand: STATUS_PACKET_HEAD bytes
 * before them and one byte after them are overwritten. */
void status_packet_begin(struct status_packet *status, uint8_t id, uint8_t error,
                         uint8_t *parameters, uint8_t length);

/* Puts as many bytes into the ring as it has room for. Returns true when the packet is whole there.
 */
bool status_packet_put(struct status_packet *status, struct cds_ring *ring);

/* Puts a whole packet of at most CDS_RING_SIZE bytes into the ring; the parameters stay as they
 * are. The bus works meanwhile, so it is written for few cycles. Returns false, and puts nothing,
 * if the ring has no room for it. */
bool status_packet_put_whole(struct cds_ring *ring, uint8_t id, uint8_t error,
                             const uint8_t *parameters, uint8_t length);

#endif
