/* A status packet for the host; see answer.h. */
#include "answer.h"

#include "opaque.h" // CDS_OPAQUE()

void answer_begin(struct answer *answer, uint8_t id, uint8_t error, uint8_t *parameters,
                  uint8_t length)
{
    uint8_t *packet = parameters - ANSWER_BEFORE;

    packet[0] = packet[1] = CDS_HEADER;
    packet[CDS_AT_ID] = id;
    packet[CDS_AT_LENGTH] = (uint8_t)(length + CDS_LENGTH_MIN);
    packet[CDS_AT_ERROR] = error;
    parameters[length] = cds_packet_checksum(packet);
    answer->from = packet;
    answer->left = (uint16_t)CDS_PACKET_SIZE(length);
}

bool answer_put(struct answer *answer, struct cds_ring *ring)
{
    const uint8_t *from = answer->from;
    uint8_t head = ring->head;
    uint8_t room = (uint8_t)(CDS_RING_SIZE - (uint8_t)(head - ring->tail));
    uint8_t count = room;

    if (count > answer->left)
        count = (uint8_t)answer->left;
    for (uint8_t left = count; left; left--)
        ring->bytes[head++ & (CDS_RING_SIZE - 1)] = *from++;
    ring->head = head; // behind the bytes it vouches for
    answer->from = from;
    answer->left = (uint16_t)(answer->left - count);
    return answer->left == 0;
}

/* Copies at least one byte; returns their sum. The ring's bytes are written here as any others:
 * that is half as long, and the barrier keeps them before the index that vouches for them. */
CDS_APART static uint8_t copy(volatile uint8_t *ring, const uint8_t *from, uint8_t count,
                              uint8_t sum)
{
    uint8_t *to = (uint8_t *)ring;

    do {
        uint8_t byte = *from++;

        *to++ = byte;
        sum = (uint8_t)(sum + byte);
    } while (--count);
    __asm__ volatile("" ::: "memory");
    return sum;
}

bool answer_at_once(struct cds_ring *ring, uint8_t id, uint8_t error, uint8_t *parameters,
                    uint8_t length)
{
    uint8_t head = ring->head, at = head & (CDS_RING_SIZE - 1);
    uint8_t first = (uint8_t)(CDS_RING_SIZE - at), left = (uint8_t)(length + ANSWER_BEFORE);
    uint8_t *from = parameters - ANSWER_BEFORE;
    uint8_t sum;

    if ((uint8_t)(ring->tail + CDS_RING_SIZE - head) <= left)
        return false;
    CDS_OPAQUE(from); // or each byte of the header is reached anew
    from[0] = from[1] = CDS_HEADER;
    from[CDS_AT_ID] = id;
    from[CDS_AT_LENGTH] = (uint8_t)(length + CDS_LENGTH_MIN);
    from[CDS_AT_ERROR] = error;
    head = (uint8_t)(head + left);
    if (first > left)
        first = left;
    left = (uint8_t)(left - first);
    sum = copy(&ring->bytes[at], from, first, 2); // with both of the header it is 0
    if (left)
        sum = copy(ring->bytes, from + first, left, sum);
    ring->bytes[head & (CDS_RING_SIZE - 1)] = (uint8_t)~sum;
    ring->head = (uint8_t)(head + 1u); // behind the bytes it vouches for
    return true;
}
