/* SPDX-License-Identifier: MIT */
/* Parses a scenario file, one command in each line: docs/scenario.md. */
#ifndef SIM_SCENARIO_H
#define SIM_SCENARIO_H

#include <stdbool.h>
#include <stdint.h>

#include "script/environment.h"
#include "script/expect.h"
#include "script/reset_injection.h"
#include "servo/ids.h"

#define SCENARIO_MS_MAX   3600000
#define SCENARIO_REPLY_MS 10000 // for the reply to a command, unless the line ends in `within MS`

#define SCENARIO_SEND_MAX 1024 // bytes of one @send

enum scenario_verb {
    SCENARIO_COMMAND, // text for the firmware's console
    SCENARIO_SERVOS,
    SCENARIO_WAIT,
    SCENARIO_AT,
    SCENARIO_PRINT,
    SCENARIO_ECHO,
    SCENARIO_BAUD,
    SCENARIO_SEND,
    SCENARIO_FAULT,
    SCENARIO_ENVIRONMENT,
    SCENARIO_RESET,
    SCENARIO_EXPECT,
    SCENARIO_SHOW,
};

struct scenario_line {
    enum scenario_verb verb;
    unsigned number;    // in the file, from 1
    const char *source; // the line as it was written
    const char *text;   // the text after the @ word; COMMAND: the command
    bool flag;          // ECHO: on; COMMAND: an error is expected
    uint32_t ms;        // WAIT, AT; ENVIRONMENT: duration of the change; COMMAND: until the reply
    bool all;           // ENVIRONMENT: every servo
    unsigned place;     // ENVIRONMENT: this servo of those there, from 1; 0: those in `ids`
    bool ids[IDS_MAX];  // ENVIRONMENT: these servos; SERVOS: the new servos
    enum environment_property property;
    int32_t value; // ENVIRONMENT, BAUD
    struct reset_order reset;
    struct expectation expectation;
};

struct scenario {
    const char *path;
    char *source;
    char *text; // a copy of the source, cut into words
    struct scenario_line *line;
    unsigned count;
};

/* Parses the whole file. Returns false, with `file:line: what` on stderr. */
bool scenario_read(struct scenario *scenario, const char *path);
/* Parses one line into a scenario of its own. Returns 0, or what is wrong. */
const char *scenario_read_line(struct scenario *scenario, const char *text);
void scenario_free(struct scenario *scenario);

/* Prints `file:line: what` on stderr. Returns false. */
bool scenario_complain(const struct scenario *scenario, unsigned line, const char *what);

/* Returns the ID of a servo that `line` names and that is not in `there`, or -1. Updates `there`
 * for @servos. */
int scenario_absent(const struct scenario_line *line, bool there[IDS_MAX]);

#endif
