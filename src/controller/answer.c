/* A status packet for the host; see answer.h. */
#include "answer.h"

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

/* Here cycles count: this is done while the bus is at work. */
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
