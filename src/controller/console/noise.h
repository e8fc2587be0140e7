/* SPDX-License-Identifier: MIT */
/* Finds noise on the line of the bus while the console waits for input: bytes that come while no
 * reply is due, many more than other devices' good packets have. */
#ifndef CONTROLLER_NOISE_H
#define CONTROLLER_NOISE_H

#include "cds55xx/bus.h"

/* Zero it (static storage is). */
struct noise {
    bool is_there; // noise was found in this window, or in the one before
    // internal:
    uint8_t end;       // of the ring of the bus, at the last poll
    uint16_t sent;     // packets that the bus had sent by then
    uint16_t polls;    // of this window that found new bytes
    uint16_t packets;  // good packets that no request asked for, when the window began
    uint32_t begun_us; // when the window began
};

/* Call it in each turn while the console waits for input, and in the pauses of `monitor`. */
void noise_poll(struct noise *noise, const struct cds_bus *bus);

#endif
