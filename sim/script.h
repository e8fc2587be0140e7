/* A script: commands for the firmware's console, line by line, and what happens to the simulation.
 *
 *   # comment            (blank lines are ignored too)
 *   ping 1               said to the firmware; the next line waits for `ok` or `error N: text`
 *   ! ping 77            the same, and an error is what is expected
 *   @servos 0,1,5-7      fresh servos with these IDs; one ID may occur several times
 *   @power off|on        of all servos
 *   @wait MS             simulated time passes
 *   @print TEXT          on stdout
 *   @echo on|off         show commands, replies and packets on stdout from here on
 */
#ifndef SIM_SCRIPT_H
#define SIM_SCRIPT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "ids.h"
#include "schedule.h"

#define SCRIPT_REPLY_ROOM 200 // longer lines of a reply are cut
#define SCRIPT_PATIENCE_S 10  // simulated, for one reply
#define SCRIPT_WAIT_MAX   3600000

enum script_verb {
    SCRIPT_COMMAND,
    SCRIPT_SERVOS,
    SCRIPT_POWER,
    SCRIPT_WAIT,
    SCRIPT_PRINT,
    SCRIPT_ECHO,
};

struct script_line {
    enum script_verb verb;
    unsigned number; // in the file, from 1
    const char *text;
    bool flag;        // POWER, ECHO: on; COMMAND: an error is expected
    uint32_t wait_ms; // WAIT
};

enum script_outcome { SCRIPT_GOOD, SCRIPT_UNEXPECTED_ERROR, SCRIPT_UNEXPECTED_OK, SCRIPT_SILENCE };

/* What a script works on. */
struct script_world {
    void *owner;
    bool (*ready)(void *owner); // the firmware listens on the host link
    void (*say)(void *owner, uint64_t now, const char *bytes, size_t size);
    void (*servos)(void *owner, uint64_t now, const uint8_t *ids, unsigned count);
    void (*power)(void *owner, uint64_t now, bool on);
    void (*echo)(void *owner, bool on);
    /* A command has had its reply, or none. */
    void (*outcome)(void *owner, uint64_t now, enum script_outcome outcome, const char *what);
    void (*finished)(void *owner, uint64_t now);
};

struct script {
    const char *path;
    char *text;
    struct script_line *lines;
    unsigned count;
    unsigned next;
    uint32_t clock_Hz;
    struct schedule *schedule;
    const struct script_world *world;
    FILE *out;
    struct event step;
    struct event patience;
    bool started, waiting, echo, done;
    char reply[SCRIPT_REPLY_ROOM];
    unsigned reply_size;
};

/* Reads and checks the whole file. False, with `file:line: what` on stderr. */
bool script_read(struct script *script, const char *path);
void script_free(struct script *script);

void script_start(struct script *script, struct schedule *schedule, uint32_t clock_Hz,
                  const struct script_world *world, FILE *out);

/* A byte that the firmware said. */
void script_hear(struct script *script, uint64_t now, uint8_t byte);

/* The line that is being worked on, for messages. */
unsigned script_line_number(const struct script *script);

#endif
