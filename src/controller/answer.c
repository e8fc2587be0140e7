/* A status packet for the host; see answer.h. */
#include "answer.h"

void answer_begin(struct answer *answer, uint8_t id, uint8_t error, const uint8_t *parameters,
                  uint8_t length)
{
    uint8_t size = (uint8_t)(length + CDS_LENGTH_MIN);

    *answer = (struct answer){.head = {CDS_HEADER, CDS_HEADER, id, size, error},
                              .parameters = parameters,
                              .left = length,
                              .sum = 2}; // the header does not count: 2 + 2 * 0xFF is 0
}

/* Puts as many of the bytes as there is room for and returns how many; here cycles count: this is
 * done while the bus is at work. */
static uint8_t put(struct answer *answer, struct cds_ring *ring, const uint8_t *from, uint8_t count)
{
    uint8_t head = ring->head, sum = answer->sum;
    uint8_t room = (uint8_t)(CDS_RING_SIZE - (uint8_t)(head - ring->tail));

    if (count > room)
        count = room;
    for (uint8_t left = count; left; left--) {
        uint8_t byte = *from++;

        ring->bytes[head++ & (CDS_RING_SIZE - 1)] = byte;
        sum = (uint8_t)(sum + byte);
    }
    ring->head = head; // behind the bytes it vouches for
    answer->sum = sum;
    return count;
}

bool answer_put(struct answer *answer, struct cds_ring *ring)
{
    uint8_t count, left = (uint8_t)(sizeof answer->head - answer->at);

    if (left) {
        count = put(answer, ring, &answer->head[answer->at], left);
        answer->at = (uint8_t)(answer->at + count);
        if (count < left)
            return false;
    }
    count = put(answer, ring, answer->parameters, answer->left);
    answer->parameters += count;
    answer->left = (uint8_t)(answer->left - count);
    return answer->left == 0 && cds_ring_put(ring, (uint8_t)~answer->sum);
}
