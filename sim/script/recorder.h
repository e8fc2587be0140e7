/* What has been seen since the scenario last let time pass: packets, the console's reply, silence
 * of the wires. */
#ifndef SIM_RECORDER_H
#define SIM_RECORDER_H

#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "servo/servos.h"
#include "output/transcript.h"

#define WITNESS_PACKETS    64   // later ones are not kept
#define WITNESS_REPLY_ROOM 4096 // likewise later lines

struct witness_packet {
    bool in; // from the controller
    uint16_t size;
    uint8_t bytes[TRANSCRIPT_ROOM];
    bool bad[TRANSCRIPT_ROOM]; // framing errors
};

struct witness {
    struct witness_packet packet[WITNESS_PACKETS];
    unsigned packets;
    unsigned next[2]; // the first one that was not yet expected: from servos, from the controller
    char reply[WITNESS_REPLY_ROOM]; // lines, each with its \n
    unsigned reply_size;
    struct listener sig[BOARD_BUSES_MAX];
    const struct net *net[BOARD_BUSES_MAX];
    unsigned nets;
    uint64_t edges; // on all wires, so far
};

void witness_init(struct witness *witness);
void witness_watch(struct witness *witness, struct net *net);

/* Forgets packets and reply. */
void witness_forget(struct witness *witness);
void witness_packet(struct witness *witness, const struct transcript *transcript);
void witness_reply(struct witness *witness, const char *line);

/* The next packet in that direction, or 0; and it is done with. */
const struct witness_packet *witness_next(const struct witness *witness, bool in);
void witness_take(struct witness *witness, bool in);

/* No edge since there were so many, and every wire is high. */
bool witness_silence(const struct witness *witness, uint64_t edges);

#endif
