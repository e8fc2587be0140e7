/* A scenario file, read: one line, one command, in plain text. What the lines mean:
 * docs/scenario.md. */
#ifndef SIM_SCENARIO_H
#define SIM_SCENARIO_H

#include <stdbool.h>
#include <stdint.h>

#include "script/environment.h"
#include "script/expect.h"
#include "servo/ids.h"
#include "script/reset_injection.h"

#define SCENARIO_MS_MAX 3600000

#define SCENARIO_SEND_MAX 1024 // bytes of one @send

enum scenario_verb {
    SCENARIO_COMMAND, // said to the firmware's console
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
    const char *source; // the line as it is written
    const char *text;   // what follows the @ word; COMMAND: what is said
    bool flag;          // ECHO: on; COMMAND: an error is expected
    uint32_t ms;        // WAIT, AT; CAUSE: how long it takes
    bool all;           // CAUSE: every servo
    bool ids[IDS_MAX];  // CAUSE: these; SERVOS: which there will be
    enum environment_property property;
    int32_t value; // CAUSE, BAUD
    struct reset_order reset;
    struct expectation expectation;
};

struct scenario {
    const char *path;
    char *source;
    char *text; // the same, cut to words
    struct scenario_line *line;
    unsigned count;
};

/* Reads and checks the whole file. False, with `file:line: what` on stderr. */
bool scenario_read(struct scenario *scenario, const char *path);
void scenario_free(struct scenario *scenario);

/* `file:line: what` on stderr; returns false. */
bool scenario_complain(const struct scenario *scenario, unsigned line, const char *what);

/* The servo with this ID that no line before it has put there, in a line that names servos; 0 to
 * 253, or -1 when it names none. `there` holds the IDs at the start, and follows @servos. */
int scenario_absent(const struct scenario_line *line, bool there[IDS_MAX]);

#endif
