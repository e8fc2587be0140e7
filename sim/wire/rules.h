/* SPDX-License-Identifier: MIT */
/* The rules of the wire and of a run: what must never happen, and how often it has happened. */
#ifndef SIM_RULES_H
#define SIM_RULES_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

enum rule {
    RULE_EARLY_RELEASE,
    RULE_TWO_DRIVERS,
    RULE_COLLISION,
    RULE_BOTH_ENABLES,
    RULE_DRIVER_OFF,
    RULE_TRANSMITTER_OFF,
    RULE_REPLY_LOST,
    RULE_OVERRUN,
    RULE_FLOATING_RXD,
    RULE_FLOATING_TXD,
    RULE_TXD_OUTPUT,
    RULE_LOST_WRITE,
    RULE_FRAME_FORMAT,
    RULE_CRASH,
    RULE_BAD_ADDRESS,
    RULE_REPLY_WAS_ERROR,
    RULE_REPLY_WAS_OK,
    RULE_EXPECTATION,
    RULE_SCRIPT_UNFINISHED,
    RULE_COUNT
};

struct rules {
    uint32_t breaches[RULE_COUNT];
    uint32_t clock_Hz;
    FILE *out;               // prints the first breaches of each rule; 0: prints nothing
    bool line_is_open;       // set it while a line on `out` has no end yet: the message ends it
    bool warn;               // a breach of a rule of the wire does not fail the run
    struct rules *aggregate; // of all buses: counts and prints the breaches; 0: this struct does
    const char *where;       // printed before the message; 0: nothing
    void *context;
    void (*on_breach)(void *context, enum rule rule, uint64_t now); // may be 0
};

void rules_init(struct rules *rules, uint32_t clock_Hz, FILE *out);

/* Prepares the rules of one bus. `aggregate` counts and prints its breaches, after `where`. */
void rules_init_bus(struct rules *rules, struct rules *aggregate, const char *where);

/* Records a breach at `now` and prints the message, as printf() does. */
void rules_record_breach(struct rules *rules, enum rule rule, uint64_t now, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

uint32_t rules_broken(const struct rules *rules); // number of all breaches
bool rules_failed(const struct rules *rules);     // true if a breach fails the run
const char *rule_name(enum rule rule);

/* Prints one line for each broken rule, or one line if no rule was broken. */
void rules_report(const struct rules *rules, FILE *out);

#endif
