/* What has been seen since the scenario last let time pass: packets, the console's reply, silence
 * of the wires. */
#ifndef SIM_RECORDER_H
#define SIM_RECORDER_H

#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "servo/servos.h"
#include "output/transcript.h"

#define RECORDER_PACKETS    64   // later ones are not kept
#define RECORDER_REPLY_SIZE 4096 // likewise later lines

struct recorder_packet {
    bool in; // from the controller
    uint16_t size;
    uint8_t bytes[TRANSCRIPT_SIZE];
    bool bad[TRANSCRIPT_SIZE]; // framing errors
};

struct recorder {
    struct recorder_packet packet[RECORDER_PACKETS];
    unsigned packets;
    unsigned next[2]; // the first one that was not yet expected: from servos, from the controller
    char reply[RECORDER_REPLY_SIZE]; // lines, each with its \n
    unsigned reply_size;
    struct listener sig[BOARD_BUSES_MAX];
    const struct net *net[BOARD_BUSES_MAX];
    unsigned nets;
    uint64_t edges; // on all wires, so far
};

void recorder_init(struct recorder *recorder);
void recorder_watch(struct recorder *recorder, struct net *net);

/* Forgets packets and reply. */
void recorder_clear(struct recorder *recorder);
void recorder_add_packet(struct recorder *recorder, const struct transcript *transcript);
void recorder_add_line(struct recorder *recorder, const char *line);

/* The next packet in that direction, or 0; and it is done with. */
const struct recorder_packet *recorder_next_packet(const struct recorder *recorder, bool in);
void recorder_take_packet(struct recorder *recorder, bool in);

/* No edge since there were so many, and every wire is high. */
bool recorder_is_silent(const struct recorder *recorder, uint64_t edges);

#endif
