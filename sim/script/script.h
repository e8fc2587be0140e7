/* Runs a scenario: says its commands to the firmware's console or its bytes to the wire, does what
 * it says to the world, and waits for what it expects. The language: docs/scenario.md. */
#ifndef SIM_SCRIPT_H
#define SIM_SCRIPT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "script/environment.h"
#include "wire/rules.h"
#include "script/scenario.h"
#include "wire/schedule.h"
#include "servo/servos.h"
#include "output/transcript.h"
#include "script/recorder.h"

#define SCRIPT_REPLY_SIZE      200 // longer lines of a reply are cut
#define SCRIPT_REPLY_TIMEOUT_S 10  // simulated, for one reply

enum script_outcome {
    SCRIPT_GOOD,
    SCRIPT_UNEXPECTED_ERROR,
    SCRIPT_UNEXPECTED_OK,
    SCRIPT_SILENCE,
    SCRIPT_UNMET, // an expectation; the scenario ends there
};

/* What a scenario works on. */
struct script_ops {
    void *context;
    /* The firmware's console: it listens on the host link; say something to it. 0: there is none.
     */
    bool (*ready)(void *context);
    void (*say)(void *context, uint64_t now, const char *bytes, size_t size);
    /* A serial adapter on the bus: returns the end of the last stop bit; its rate. 0: there is
     * none. */
    uint64_t (*send)(void *context, uint64_t now, const uint8_t *bytes, size_t size);
    void (*baud)(void *context, uint32_t baud);
    struct servos *(*bus)(void *context, unsigned index); // 0: no further bus
    /* Fresh servos on the first bus. */
    void (*servos)(void *context, uint64_t now, const uint8_t *ids, unsigned count);
    /* Orders a fault of the bus. Returns 0, or what is wrong. 0: there are no faults. */
    const char *(*fault)(void *context, uint64_t now, const char *text);
    /* Resets the controller or lets it hang. 0: there is none. */
    void (*reset)(void *context, uint64_t now, const struct reset_order *order);
    void (*echo)(void *context, bool on);
    struct rules *rules; // may be 0
    /* A command has had its reply, or none; an expectation was not met. */
    void (*outcome)(void *context, uint64_t now, enum script_outcome outcome, const char *what);
    void (*finished)(void *context, uint64_t now);
};

struct script {
    struct scenario scenario;
    unsigned next;
    uint32_t clock_Hz;
    struct schedule *schedule;
    const struct script_ops *ops;
    FILE *out;
    struct environment environment;
    struct recorder recorder;
    struct expect_sources sources;
    struct event step;
    struct event reply_timeout;
    struct event probe;
    uint32_t quiet_us; // until the firmware that listens is spoken to
    bool ready, started,
        command_waits; // the console listens; and a PC has noticed; a command waits for it
    bool awaits_reply, expecting, echo, done;
    char reply[SCRIPT_REPLY_SIZE];
    unsigned reply_size;
};

/* Reads and checks the whole file. False, with `file:line: what` on stderr. */
bool script_read(struct script *script, const char *path);
void script_free(struct script *script);

/* Begins; the servos there are at the start are on their buses. False, with `file:line: what` on
 * stderr: a line wants a servo or a way in that there is not. */
bool script_start(struct script *script, struct schedule *schedule, uint32_t clock_Hz,
                  const struct script_ops *ops, FILE *out);

/* A byte that the firmware said; a packet, or what was none, that has passed on a bus. */
void script_receive(struct script *script, uint64_t now, uint8_t byte);
void script_record_packet(struct script *script, const struct transcript *transcript);

/* The controller was reset: what it was asked will not be answered, and the scenario goes on when
 * it listens again. */
void script_was_reset(struct script *script, uint64_t now);

/* The line that is being worked on, for messages. */
unsigned script_line_number(const struct script *script);

#endif
