/* A status packet on its way to the host, into a ring that empties at its own pace. Manual: 2.3. */
#ifndef CONTROLLER_ANSWER_H
#define CONTROLLER_ANSWER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_AT_PARAMETERS
#include "cds55xx/ring.h"   // struct cds_ring

#define ANSWER_BEFORE CDS_AT_PARAMETERS // bytes before its parameters that are the packet's, too

struct answer {
    const uint8_t *from; // what is to come; it stays in place until it is out
    uint16_t left;       // bytes
};

/* Makes a packet of the parameters where they stand. `length`: 0 to 252. */
void answer_begin(struct answer *answer, uint8_t id, uint8_t error, uint8_t *parameters,
                  uint8_t length);

/* Puts what there is room for; true when all of it is in the ring. */
bool answer_put(struct answer *answer, struct cds_ring *ring);

/* Puts a whole one, of at most CDS_RING_SIZE bytes, from parameters that stay as they are. Here
 * cycles count: the bus is at work meanwhile. False: there is no room for it yet. */
bool answer_at_once(struct cds_ring *ring, uint8_t id, uint8_t error, const uint8_t *parameters,
                    uint8_t length);

#endif
