/* SPDX-License-Identifier: MIT */
/* Finds noise on the line of the bus while the console waits for input: bytes that come while no
 * reply is due, many more than other devices' good packets have. If they follow each other without
 * a pause, a servo sends without end: it babbles. */
#ifndef CONTROLLER_NOISE_H
#define CONTROLLER_NOISE_H

#include "cds55xx/bus.h"

/* What sends the bytes: named within 250 ms, and kept as long as it lasts. */
enum noise_name {
    NOISE_UNNAMED, // not found yet
    NOISE_RANDOM,  // the line is quiet at times
    NOISE_BABBLE,  // it is not, and no packet leaves
} __attribute__((packed));

/* Zero it (static storage is). */
struct noise {
    bool is_there; // noise was found in this window, or in the one before
    uint8_t name;  // enum noise_name
    // internal:
    uint8_t end;         // of the ring of the bus, at the last poll
    uint16_t sent;       // packets that the bus had sent by then
    uint16_t polls;      // of this window that found new bytes
    uint16_t packets;    // good packets that no request asked for, when the window began
    uint16_t bytes;      // that came in `counted_us` of this window
    uint32_t counted_us; // between polls that were close to each other
    uint32_t polled_us;  // when the last poll was
    uint32_t begun_us;   // when the window began
};

/* Call it in each turn while the console waits for input, and in the pauses of `monitor`. */
void noise_poll(struct noise *noise, const struct cds_bus *bus);

#endif
