/* What must come of an exchange, given the bytes that the controller's receiver took in: outcome,
 * values and counters, as bus.h and parser.h describe them. Written anew, over whole arrays and
 * without the library's code; it is not told which fault was injected. */
#ifndef ORACLE_H
#define ORACLE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/result.h"

struct oracle_byte {
    uint8_t byte;
    bool bad; // damaged, or bytes were lost before it
};

/* What was asked. */
struct oracle_asked {
    uint8_t packet[64];
    unsigned size;
    int due; // parameters of the reply; -1: no reply is due
};

/* All that is heard from one packet of the controller's to the next. */
struct oracle_span {
    const struct oracle_asked *asked; // 0: nothing, it has just begun to listen
    const struct oracle_byte *bytes;
    unsigned count;
    unsigned in_time; // of them: until the attempt was over, unless by a reply
    uint8_t last_id;  // who was asked before and had to answer,
    bool last_ok;     // and whether it did
};

struct result {
    enum cds_result result;
    uint8_t id, error;
    unsigned length; // of the data
    uint8_t data[64];
    unsigned taken; // bytes heard up to the end of the reply
    unsigned refuted, stray, late, extra, foreign;
};

void oracle_judge(const struct oracle_span *span, struct result *result);

/* Of one attempt to get a reply, when all these bytes were in time and there was nothing before. */
void oracle_reply(const struct oracle_asked *asked, const struct oracle_byte *bytes, unsigned count,
                  struct result *result);

/* Is there a packet among these bytes, right by its checksum, that changes a servo and is not the
 * one asked for? */
bool oracle_commands(const struct oracle_asked *asked, const struct oracle_byte *bytes,
                     unsigned count);

/* What a UART makes of a line whose level in each bit time is `level` (idle before and after): the
 * number of bytes. `room` for bits / 10 + 1 of them. */
unsigned oracle_hear(const bool *level, unsigned bits, struct oracle_byte *bytes);

/* The line while these bytes are sent without a gap, ten bits each. */
void oracle_say(const uint8_t *bytes, unsigned size, bool *level);

/* Builds a packet; returns its size. */
unsigned oracle_packet(uint8_t *packet, uint8_t id, uint8_t instruction_or_error,
                       const uint8_t *parameters, unsigned count);

#endif
