/* A status packet on its way to the host, into a ring that empties at its own pace. Manual: 2.3. */
#ifndef CONTROLLER_STATUS_PACKET_H
#define CONTROLLER_STATUS_PACKET_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_AT_PARAMETERS
#include "cds55xx/ring.h"   // struct cds_ring

#define STATUS_PACKET_HEAD                                                                         \
    CDS_AT_PARAMETERS // bytes before its parameters that are the packet's, too

struct status_packet {
    const uint8_t *from; // what is to come; it stays in place until it is out
    uint16_t left;       // bytes
};

/* Makes a packet of the parameters where they stand. `length`: 0 to 252. */
void status_packet_begin(struct status_packet *status, uint8_t id, uint8_t error,
                         uint8_t *parameters, uint8_t length);

/* Puts what there is room for; true when all of it is in the ring. */
bool status_packet_put(struct status_packet *status, struct cds_ring *ring);

/* Puts a whole one, of at most CDS_RING_SIZE bytes, from parameters that stay as they are. Here
 * cycles count: the bus is at work meanwhile. False: there is no room for it yet. */
bool status_packet_put_whole(struct cds_ring *ring, uint8_t id, uint8_t error,
                             const uint8_t *parameters, uint8_t length);

#endif
