/* SPDX-License-Identifier: MIT */
/* The text of a fault order, as on the command line and in scenarios: docs/faults.md. */
#ifndef SIM_FAULT_ORDER_H
#define SIM_FAULT_ORDER_H

#include <stdbool.h>
#include <stdint.h>

#include "servo/ids.h"

#define FAULT_NUMBERS  3
#define FAULT_TEXT_MAX 1200 // characters; a list of all IDs has 1017

enum fault_verb {
    FAULT_FLIP,
    FAULT_LOSE,
    FAULT_INSERT,
    FAULT_CUT,
    FAULT_DELAY,
    FAULT_ID,
    FAULT_LENGTH,
    FAULT_ECHO,
    FAULT_BABBLE,
    FAULT_STUCK,
    FAULT_NOISE,
    FAULT_BROWNOUT,
    FAULT_UNPLUG,
    FAULT_TURNAROUND,
    FAULT_BAUD,
    FAULT_QUIRK,
    FAULT_CLEAR,
    FAULT_VERBS
};

enum fault_switch { FAULT_OFF, FAULT_ON };
enum fault_babble {
    FAULT_BABBLE_OFF,
    FAULT_BABBLE_HEADERS,
    FAULT_BABBLE_RANDOM,
    FAULT_BABBLE_BYTE
};
enum fault_stuck { FAULT_STUCK_OFF, FAULT_STUCK_LOW, FAULT_STUCK_HIGH };
enum fault_quirk {
    FAULT_QUIRK_SILENT,
    FAULT_QUIRK_SYNC_WRITE,
    FAULT_QUIRK_TURNAROUND,
    FAULT_QUIRK_JITTER,
    FAULT_QUIRKS
};

struct fault_order {
    enum fault_verb verb;
    bool from_servo; // `out`: packets from servos; `in`: packets from the controller
    bool every;      // every packet
    uint32_t packet; // 1: the next packet
    unsigned choice; // index of one of the verb's words, a value of the enums above
    uint32_t number[FAULT_NUMBERS];
    unsigned numbers;
    bool ids[IDS_MAX];
};

/* Returns 0, or what is wrong with the text. A prefix `1:` means bus 1. */
const char *fault_order_parse(struct fault_order *order, const char *text);
unsigned fault_order_bus(const char *text);
const char *fault_verb_name(enum fault_verb verb);

#endif
