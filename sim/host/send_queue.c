/* SPDX-License-Identifier: MIT */
#include "host/send_queue.h"

size_t send_queue_put(struct send_queue *queue, const uint8_t *bytes, size_t size)
{
    size_t put = 0;
    while (put < size && queue->waiting < SEND_QUEUE_SIZE) {
        queue->bytes[(queue->head + queue->waiting++) % SEND_QUEUE_SIZE] = bytes[put++];
    }
    return put;
}

const uint8_t *send_queue_oldest(const struct send_queue *queue, size_t *size)
{
    size_t to_the_end = SEND_QUEUE_SIZE - queue->head;
    *size = to_the_end < queue->waiting ? to_the_end : queue->waiting;
    return queue->bytes + queue->head;
}

void send_queue_remove(struct send_queue *queue, size_t size)
{
    queue->head = (queue->head + size) % SEND_QUEUE_SIZE;
    queue->waiting -= size;
}

void send_queue_clear(struct send_queue *queue)
{
    queue->waiting = 0;
}
