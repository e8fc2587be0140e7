/* A status packet on its way to the host, into a ring that empties at its own pace. Manual: 2.3. */
#ifndef CONTROLLER_ANSWER_H
#define CONTROLLER_ANSWER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring

struct answer {
    const uint8_t *parameters; // stay in place until it is out
    uint16_t at;               // next byte of the packet
    uint8_t id, error, length; // length: parameters
    uint8_t sum;
};

/* `length`: 0 to 252. */
void answer_begin(struct answer *answer, uint8_t id, uint8_t error, const uint8_t *parameters,
                  uint8_t length);

/* Puts what there is room for; true when all of it is in the ring. */
bool answer_put(struct answer *answer, struct cds_ring *ring);

#endif
