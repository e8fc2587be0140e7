/* SPDX-License-Identifier: MIT */
/* Status packets to the host; see status_packet.h. */
#include "host/status_packet.h"

#include "compiler.h" // NOINLINE

void status_packet_begin(struct status_packet *status, uint8_t id, uint8_t error,
                         uint8_t *parameters, uint8_t length)
{
    uint8_t *packet = parameters - STATUS_PACKET_HEAD;

    packet[0] = packet[1] = CDS_HEADER;
    packet[CDS_AT_ID] = id;
    packet[CDS_AT_LENGTH] = (uint8_t)(length + CDS_LENGTH_MIN);
    packet[CDS_AT_ERROR] = error;
    parameters[length] = cds_packet_checksum(packet);
    status->from = packet;
    status->left = (uint16_t)CDS_PACKET_SIZE(length);
}

bool status_packet_put(struct status_packet *status, struct cds_ring *ring)
{
    const uint8_t *from = status->from;
    uint8_t head = ring->head;
    uint8_t room = (uint8_t)(CDS_RING_SIZE - (uint8_t)(head - ring->tail));
    uint8_t count = room;

    if (count > status->left)
        count = (uint8_t)status->left;
    for (uint8_t left = count; left; left--)
        ring->bytes[head++ & (CDS_RING_SIZE - 1)] = *from++;
    ring->head = head; // only when the bytes are there
    status->from = from;
    status->left = (uint16_t)(status->left - count);
    return status->left == 0;
}

/* Copies bytes into the ring and returns `sum` plus their sum. Without volatile the loop takes half
 * the cycles; the barrier keeps the bytes before the store of the ring's head. */
NOINLINE static uint8_t copy(volatile uint8_t *ring, const uint8_t *from, uint8_t count,
                             uint8_t sum)
{
    uint8_t *to = (uint8_t *)ring;

    if (!count)
        return sum;
    do {
        uint8_t byte = *from++;

        *to++ = byte;
        sum = (uint8_t)(sum + byte);
    } while (--count);
    __asm__ volatile("" ::: "memory");
    return sum;
}

#define PUT(byte) bytes[head++ & (CDS_RING_SIZE - 1)] = (byte)

bool status_packet_put_whole(struct cds_ring *ring, uint8_t id, uint8_t error,
                             const uint8_t *parameters, uint8_t length)
{
    uint8_t head = ring->head, sum = (uint8_t)(id + length + CDS_LENGTH_MIN + error);
    volatile uint8_t *bytes = ring->bytes;
    uint8_t at, first;

    if ((uint8_t)(ring->tail + CDS_RING_SIZE - head) < (uint8_t)CDS_PACKET_SIZE(length))
        return false;
    PUT(CDS_HEADER);
    PUT(CDS_HEADER);
    PUT(id);
    PUT((uint8_t)(length + CDS_LENGTH_MIN));
    PUT(error);
    at = head & (CDS_RING_SIZE - 1);
    head = (uint8_t)(head + length);
    first = (uint8_t)(CDS_RING_SIZE - at);
    if (first < length) { // the parameters wrap around the end of the ring
        sum = copy(bytes + at, parameters, first, sum);
        parameters += first;
        length = (uint8_t)(length - first);
        at = 0;
    }
    sum = copy(bytes + at, parameters, length, sum);
    PUT((uint8_t)~sum);
    ring->head = head; // only when the bytes are there
    return true;
}
