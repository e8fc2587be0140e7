/* SPDX-License-Identifier: MIT */
/* Runs the simulator, $SIM, on the small firmwares in $FIRMWARE, and keeps its output. */
#ifndef SIMULATOR_H
#define SIMULATOR_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "unity.h"

struct run {
    int status; // exit status
    char output[8192];
};

static inline const char *environment(const char *name, const char *otherwise)
{
    const char *value = getenv(name);
    return value ? value : otherwise;
}

/* Runs the simulator with these arguments. The output contains standard error. */
static inline void simulate(struct run *run, const char *arguments)
{
    char command[1024];
    snprintf(command, sizeof(command), "%s %s 2>&1", environment("SIM", "build/host/cds55xx-sim"),
             arguments);
    FILE *pipe = popen(command, "r");
    TEST_ASSERT_NOT_NULL(pipe);
    size_t size = fread(run->output, 1, sizeof(run->output) - 1, pipe);
    run->output[size] = 0;
    char rest[256];
    while (fread(rest, 1, sizeof(rest), pipe) > 0) {
    }
    int status = pclose(pipe);
    TEST_ASSERT_TRUE_MESSAGE(WIFEXITED(status), run->output);
    run->status = WEXITSTATUS(status);
}

/* Runs a test firmware on its board with servo 1. */
static inline void simulate_firmware(struct run *run, const char *name, const char *options)
{
    char arguments[512];
    snprintf(arguments, sizeof(arguments),
             "firmware %s/%s.elf --board atmega128 --servos 1 --seconds 0.5 %s",
             environment("FIRMWARE", "build/firmware"), name, options);
    simulate(run, arguments);
}

/* Returns the number that the firmware printed in a line "name value". */
static inline int figure(const struct run *run, const char *name)
{
    char wanted[64];
    snprintf(wanted, sizeof(wanted), "%s ", name);
    const char *line = run->output;
    while (line && strncmp(line, wanted, strlen(wanted)) != 0) {
        line = strchr(line, '\n');
        line = line ? line + 1 : 0;
    }
    TEST_ASSERT_NOT_NULL_MESSAGE(line, run->output);
    return atoi(line + strlen(wanted));
}

static inline void assert_says(const struct run *run, const char *text)
{
    TEST_ASSERT_TRUE_MESSAGE(strstr(run->output, text), run->output);
}

#endif
