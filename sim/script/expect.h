/* SPDX-License-Identifier: MIT */
/* What a scenario expects: parses a line, and checks it against the recorder and the servos. */
#ifndef SIM_EXPECT_H
#define SIM_EXPECT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "script/recorder.h"
#include "servo/ids.h"
#include "servo/servos.h"
#include "wire/rules.h"

#define EXPECT_WITHIN_MS 1000 // if the line does not say

enum expect_kind { EXPECT_PACKET, EXPECT_SILENCE, EXPECT_SERVO, EXPECT_TEXT, EXPECT_RULE };
enum expect_subject { EXPECT_REGISTER, EXPECT_TORQUE, EXPECT_LED, EXPECT_ERROR };
enum expect_result { EXPECT_MET, EXPECT_PENDING, EXPECT_FAILED };

struct expectation {
    enum expect_kind kind;
    uint32_t ms;      // time limit; EXPECT_SILENCE: duration
    const char *text; // bytes of the packet, text in the reply, or what to show
    bool in;          // a packet from the controller
    bool ids[IDS_MAX];
    enum expect_subject subject;
    uint8_t address, width;
    int32_t lowest, highest;
    enum rule rule;
};

/* Where an expectation is checked. */
struct expect_sources {
    struct recorder *recorder;
    struct rules *rules; // may be 0
    struct servos *(*bus)(void *context, unsigned index);
    void *context;
    uint64_t end;   // end of the time limit
    uint64_t edges; // edges on the wires when the wait began
};

/* Parses the words after `@expect` and cuts them in place. Returns 0, or what is wrong. */
const char *expect_parse(struct expectation *expectation, char *words);

/* Writes what there is instead to `seen` if the expectation is not met. */
enum expect_result expect_check(const struct expectation *expectation,
                                const struct expect_sources *sources, uint64_t now, char *seen,
                                size_t capacity);

/* `servo IDS WHAT`: prints a line for each servo. */
const char *expect_parse_show(struct expectation *expectation, char *words);
void expect_show(const struct expectation *expectation, const struct expect_sources *sources,
                 FILE *out);

#endif
