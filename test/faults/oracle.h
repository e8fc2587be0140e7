/* SPDX-License-Identifier: MIT */
/* Predicts a transaction from the bytes that the controller's receiver got: outcome, values and
 * counters, as bus.h and parser.h describe them. It shares no code with the library, works on whole
 * arrays and does not know which fault was injected. */
#ifndef ORACLE_H
#define ORACLE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/result.h"

struct oracle_byte {
    uint8_t byte;
    bool bad; // damaged, or bytes were lost before it
};

/* A packet of the controller and the reply that is due. */
struct oracle_asked {
    uint8_t packet[64];
    unsigned size;
    int due; // parameters of the reply; -1: no reply is due
};

/* The bytes received from the start of a packet to the start of the next packet. */
struct oracle_span {
    const struct oracle_asked *asked; // 0: no packet yet, the controller has just begun to listen
    const struct oracle_byte *bytes;
    unsigned count;
    unsigned in_time; // bytes that a reply must lie within
    uint8_t last_id;  // servo that the latest packet with a reply before this one was sent to
    bool last_ok;     // its reply was taken
};

struct oracle_result {
    enum cds_result result;
    uint8_t id, error;
    unsigned length; // of the data
    uint8_t data[64];
    unsigned taken; // bytes received up to the end of the reply
    unsigned malformed, noise_bytes, stale_replies, duplicate_replies, unexpected_packets;
};

void oracle_predict(const struct oracle_span *span, struct oracle_result *result);

/* Predicts an attempt whose bytes were all in time, with no packet before it. */
void oracle_reply(const struct oracle_asked *asked, const struct oracle_byte *bytes, unsigned count,
                  struct oracle_result *result);

/* Returns true if the bytes contain a packet with a right checksum that changes a servo and differs
 * from `asked`. */
bool oracle_commands(const struct oracle_asked *asked, const struct oracle_byte *bytes,
                     unsigned count);

/* Decodes a line as a UART does. `level`: the level in each bit time; the line is idle before and
 * after. `bytes` needs a capacity of bits / 10 + 1. Returns the number of bytes. */
unsigned oracle_receive(const bool *level, unsigned bits, struct oracle_byte *bytes);

/* Encodes bytes that follow each other without a gap, ten bit times each. */
void oracle_send(const uint8_t *bytes, unsigned size, bool *level);

/* Builds a packet; returns its size. */
unsigned oracle_packet(uint8_t *packet, uint8_t id, uint8_t instruction_or_error,
                       const uint8_t *parameters, unsigned count);

#endif
