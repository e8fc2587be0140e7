/* SPDX-License-Identifier: MIT */
/* Runs a scenario (docs/scenario.md): sends its commands to the firmware's console or its bytes to
 * the wire, changes the environment, and checks what it expects. */
#ifndef SIM_SCRIPT_H
#define SIM_SCRIPT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "output/transcript.h"
#include "script/environment.h"
#include "script/recorder.h"
#include "script/scenario.h"
#include "servo/servos.h"
#include "wire/rules.h"
#include "wire/schedule.h"

#define SCRIPT_REPLY_SIZE 200 // longer lines of a reply are cut
#define SCRIPT_WHAT_SIZE  120 // a message with a number in it

enum script_outcome {
    SCRIPT_GOOD,
    SCRIPT_UNEXPECTED_ERROR,
    SCRIPT_UNEXPECTED_OK,
    SCRIPT_SILENCE,
    SCRIPT_UNMET, // an expectation; the scenario ends
};

/* What a scenario can do. A function that is 0 is not available. */
struct script_ops {
    void *context;
    /* The firmware's console: does it listen; send text to it. */
    bool (*console_ready)(void *context);
    void (*console_send)(void *context, uint64_t now, const char *bytes, size_t size);
    bool has_text; // script_receive() is called: @expect text can be met
    /* A serial adapter on the bus: `send` returns the end of the last stop bit. */
    uint64_t (*bus_send)(void *context, uint64_t now, const uint8_t *bytes, size_t size);
    void (*bus_baud)(void *context, uint32_t baud);
    struct servos *(*bus)(void *context, unsigned index); // 0: no further bus
    /* Replaces the servos of the first bus. */
    void (*servos)(void *context, uint64_t now, const uint8_t *ids, unsigned count);
    /* Injects a fault. Returns 0, or what is wrong. */
    const char *(*fault)(void *context, uint64_t now, const char *text);
    /* Resets the controller or hangs its main program. */
    void (*reset)(void *context, uint64_t now, const struct reset_order *order);
    void (*echo)(void *context, bool on);
    struct rules *rules; // may be 0
    /* A command has ended, or an expectation was not met. */
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
    uint32_t quiet_us;  // the time for which the firmware must listen before a command is sent
    bool ready;         // the firmware listens
    bool started;       // it has listened for quiet_us: commands may be sent
    bool command_waits; // a command waits for `started`
    bool awaits_reply;  // a command was sent, and the end of its reply has not come
    bool awaits_reset;  // `@reset` of this moment: the next line waits until it has happened
    bool expecting;     // the present line is an expectation that is still open
    bool echo;          // prints commands, replies and packets: @echo
    bool done;          // the scenario, or the latest order, has ended
    bool is_program;    // the console gives bare replies
    bool unmet;         // an @expect was not met
    bool enters;        // the reply to `mode program` is due
    char reply[SCRIPT_REPLY_SIZE];
    unsigned reply_size;
};

/* Parses the whole file. Returns false, with `file:line: what` on stderr. */
bool script_read(struct script *script, const char *path);
void script_free(struct script *script);

/* Starts the scenario. The servos of the start are on their buses. Returns false, with `file:line:
 * what` on stderr, if a line needs a servo or a function that does not exist. */
bool script_start(struct script *script, struct schedule *schedule, uint32_t clock_Hz,
                  const struct script_ops *ops, FILE *out);

/* Starts without a scenario: for script_order(). */
void script_start_empty(struct script *script, struct schedule *schedule, uint32_t clock_Hz,
                        const struct script_ops *ops, FILE *out);

/* Parses a line of a scenario that begins with @; the @ may be left out. Returns 0 and runs the
 * line: ops->finished follows, after ops->outcome if the line fails. Or returns what is wrong, for
 * which it may use `what`. Not before the last order has finished. */
const char *script_order(struct script *script, uint64_t now, const char *text,
                         char what[SCRIPT_WHAT_SIZE]);
/* Ends an order that waits. ops->finished does not follow. */
void script_cancel(struct script *script);

/* A byte from the firmware; a packet, or bytes that are no packet, on a bus. */
void script_receive(struct script *script, uint64_t now, uint8_t byte);
void script_record_packet(struct script *script, const struct transcript *transcript);

/* The controller was reset. A pending reply is not expected any more. The scenario continues when
 * the firmware listens again, and sends `mode program` again. */
void script_was_reset(struct script *script, uint64_t now);

/* Returns the number of the present line, for messages. */
unsigned script_line_number(const struct script *script);

#endif
