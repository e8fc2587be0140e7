/* SPDX-License-Identifier: MIT */
/* Records packets, the console's reply and edges on the wires since the scenario last let time
 * pass. */
#ifndef SIM_RECORDER_H
#define SIM_RECORDER_H

#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "output/transcript.h"
#include "servo/servos.h"

#define RECORDER_PACKETS    64   // later packets are dropped
#define RECORDER_REPLY_SIZE 4096 // characters; later lines are dropped

struct recorder_packet {
    bool in; // from the controller
    uint16_t size;
    uint8_t bytes[TRANSCRIPT_SIZE];
    bool bad[TRANSCRIPT_SIZE]; // framing errors
};

struct recorder {
    struct recorder_packet packet[RECORDER_PACKETS];
    unsigned packets;
    unsigned next[2]; // index of the first packet that was not expected yet: [0] from servos, [1]
                      // from the controller
    char reply[RECORDER_REPLY_SIZE]; // each line ends with \n
    unsigned reply_size;
    struct listener sig[BOARD_BUSES_MAX];
    const struct net *net[BOARD_BUSES_MAX];
    unsigned nets;
    uint64_t edges; // on all wires since the start
};

void recorder_init(struct recorder *recorder);
void recorder_watch(struct recorder *recorder, struct net *net);

/* Drops packets and reply. */
void recorder_clear(struct recorder *recorder);
void recorder_add_packet(struct recorder *recorder, const struct transcript *transcript);
void recorder_add_line(struct recorder *recorder, const char *line);

/* Return and drop the next packet in that direction. No packet: returns 0. */
const struct recorder_packet *recorder_next_packet(const struct recorder *recorder, bool in);
void recorder_take_packet(struct recorder *recorder, bool in);

/* Returns true if there was no edge since there were `edges`, and every wire is high. */
bool recorder_is_silent(const struct recorder *recorder, uint64_t edges);

#endif
