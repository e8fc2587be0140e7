/* The bench: one board with its firmware, the servos on its bus, a PC, and the instruments. */
#ifndef SIM_BENCH_H
#define SIM_BENCH_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "board.h"
#include "host.h"
#include "machine.h"
#include "pty.h"
#include "rules.h"
#include "schedule.h"
#include "script.h"
#include "servos.h"
#include "trace.h"
#include "transcript.h"
#include "vcd.h"
#include "wire.h"

enum bench_host { BENCH_HOST_NONE, BENCH_HOST_SCRIPT, BENCH_HOST_PTY, BENCH_HOST_STDOUT };

struct bench_options {
    const char *elf;
    const char *boards; // folder
    const char *board;
    uint8_t ids[IDS_MAX];
    unsigned servos;
    const char *script; // files; 0: none
    const char *transcript;
    const char *vcd;
    const char *csv;
    enum bench_host host;
    double seconds; // 0: no limit
    bool exact;
    bool echo;
};

/* One bus and what hangs on it. */
struct bench_bus {
    struct bench *bench;
    struct wire wire;
    struct servos servos;
    struct transcript transcript;
    struct bus_trace trace;
};

struct bench {
    const struct bench_options *options;
    struct schedule schedule;
    struct board board;
    struct machine machine;
    struct rules rules;
    struct bench_bus bus[BOARD_BUSES_MAX];
    struct host host;
    struct script script;
    struct script_world world;
    struct pty pty;
    struct vcd vcd;
    unsigned handler; // the VCD's signal
    struct motion motion;
    FILE *transcript;
    struct event limit;
    uint64_t end;
    bool cpu_done;
};

/* False, with one line on stderr: a file is missing or bad. bench_free() is due all the same. */
bool bench_init(struct bench *bench, const struct bench_options *options);

/* False when a rule was broken. */
bool bench_run(struct bench *bench);
void bench_report(const struct bench *bench, FILE *out);

/* False when a file could not be written. */
bool bench_free(struct bench *bench);

#endif
