/* What a scenario expects: read from its line, and judged by what a witness has seen and by the
 * servos themselves. */
#ifndef SIM_EXPECT_H
#define SIM_EXPECT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "servo/ids.h"
#include "wire/rules.h"
#include "servo/servos.h"
#include "script/recorder.h"

#define EXPECT_WITHIN_MS 1000 // when the line does not say

enum expect_kind { EXPECT_PACKET, EXPECT_SILENCE, EXPECT_SERVO, EXPECT_TEXT, EXPECT_RULE };
enum expect_subject { EXPECT_REGISTER, EXPECT_TORQUE, EXPECT_LED, EXPECT_ERROR };
enum expect_result { EXPECT_MET, EXPECT_PENDING, EXPECT_FAILED };

struct expectation {
    enum expect_kind kind;
    uint32_t ms;      // within; EXPECT_SILENCE: how long
    const char *text; // bytes of the packet; what the reply contains; what is shown
    bool in;          // packet from the controller
    bool ids[IDS_MAX];
    enum expect_subject subject;
    uint8_t address, width;
    int32_t lowest, highest;
    enum rule rule;
};

/* Where an expectation is looked for. */
struct expect_sources {
    struct recorder *recorder;
    struct rules *rules; // may be 0
    struct servos *(*bus)(void *context, unsigned index);
    void *context;
    uint64_t end;   // of waiting for it
    uint64_t edges; // of the wires when that began
};

/* Of the words behind `@expect`; cuts them in place. Returns 0, or what is wrong. */
const char *expect_parse(struct expectation *expectation, char *words);

/* When it is not met, `seen` says what there is instead. */
enum expect_result expect_check(const struct expectation *expectation,
                                const struct expect_sources *sources, uint64_t now, char *seen,
                                size_t capacity);

/* `servo IDS WHAT`: what is there, a line for each servo. */
const char *expect_parse_show(struct expectation *expectation, char *words);
void expect_show(const struct expectation *expectation, const struct expect_sources *sources,
                 FILE *out);

#endif
