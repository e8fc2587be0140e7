/* A status packet on its way to the host, into a ring that empties at its own pace. Manual: 2.3. */
#ifndef CONTROLLER_ANSWER_H
#define CONTROLLER_ANSWER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_AT_PARAMETERS
#include "cds55xx/ring.h"   // struct cds_ring

struct answer {
    uint8_t head[CDS_AT_PARAMETERS]; // header, ID, LENGTH, ERROR
    const uint8_t *parameters;       // those to come; they stay in place until they are out
    uint8_t at;                      // bytes of `head` that are out
    uint8_t left;                    // parameters to come
    uint8_t sum;                     // of what is out; the two of the header cancel out
};

/* `length`: 0 to 252. */
void answer_begin(struct answer *answer, uint8_t id, uint8_t error, const uint8_t *parameters,
                  uint8_t length);

/* Puts what there is room for; true when all of it is in the ring. */
bool answer_put(struct answer *answer, struct cds_ring *ring);

#endif
