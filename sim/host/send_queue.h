/* SPDX-License-Identifier: MIT */
/* Bytes for a client that may be slow to read them: a ring of fixed size. It never makes the
 * simulation wait: what does not fit is dropped. */
#ifndef SIM_SEND_QUEUE_H
#define SIM_SEND_QUEUE_H

#include <stddef.h>
#include <stdint.h>

#define SEND_QUEUE_SIZE 65536

struct send_queue {
    uint8_t bytes[SEND_QUEUE_SIZE];
    size_t head, waiting;
};

/* Returns how many of the bytes fit; the others are dropped. */
size_t send_queue_put(struct send_queue *queue, const uint8_t *bytes, size_t size);

/* Returns the oldest bytes that stand in one piece, and their number in `size`. 0 bytes: the queue
 * is empty. */
const uint8_t *send_queue_oldest(const struct send_queue *queue, size_t *size);
/* Removes the oldest `size` bytes. */
void send_queue_remove(struct send_queue *queue, size_t size);
void send_queue_clear(struct send_queue *queue);

#endif
