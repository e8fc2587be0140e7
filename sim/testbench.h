/* The bench: one board with its firmware, the servos on its bus, a PC, and the instruments. */
#ifndef SIM_TESTBENCH_H
#define SIM_TESTBENCH_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "board.h"
#include "script/faults.h"
#include "output/live_view.h"
#include "avr/gdb.h"
#include "host/host_link.h"
#include "avr/machine.h"
#include "output/pin_timer.h"
#include "host/realtime.h"
#include "host/pc_program.h"
#include "output/plot.h"
#include "host/pty.h"
#include "wire/rules.h"
#include "wire/schedule.h"
#include "script/script.h"
#include "servo/servos.h"
#include "servo/servo_eeprom.h"
#include "output/cycle_log.h"
#include "output/trace.h"
#include "output/transcript.h"
#include "script/reset_injection.h"
#include "output/vcd.h"
#include "avr/bus_circuit.h"

#define BENCH_FAULTS_MAX 64

enum bench_host {
    BENCH_HOST_NONE,
    BENCH_HOST_SCRIPT,
    BENCH_HOST_PTY,
    BENCH_HOST_STDOUT,
    BENCH_HOST_PC,
};

struct bench_options {
    const char *elf;
    const char *boards; // folder
    const char *board;
    struct bench_servos {
        uint8_t ids[IDS_MAX];
        unsigned count;
    } servos[BOARD_BUSES_MAX]; // by bus
    const char *script;        // files; 0: none
    const char *pc;            // of BENCH_HOST_PC
    const char *transcript;
    const char *vcd;
    const char *csv;
    const char *plot;
    const char *eeprom; // of the AVR
    const char *mark;   // pin
    const char *times;
    const char *stamp; // port
    const char *steps; // cycles, as in 1000-2000
    bool gdb;
    uint16_t gdb_port; // 0: any
    bool rules_warn;
    bool client_baud; // the PC has the rate that the pty's client sets, not the board's
    enum bench_host host;
    double seconds;    // 0: no limit
    const char *state; // folder
    const char *faults[BENCH_FAULTS_MAX];
    unsigned fault_count;
    uint32_t seed;
    bool allow_duplicates;
    bool exact;
    bool echo;
    bool bus; // servos only, no AVR
    bool pty; // likewise
    bool live_view;
};

/* One bus and what hangs on it. */
struct bench_bus {
    struct bench *bench;
    unsigned index;
    struct rules rules;
    char label[16], where[24]; // of a board with several buses
    struct bus_circuit circuit;
    struct servos servos;
    struct faults faults;
    struct servo_eeprom state;
    struct transcript transcript;
    struct bus_trace trace;
};

struct bench {
    const struct bench_options *options;
    struct schedule schedule;
    struct board board;
    struct machine machine;
    struct reset_injection reset;
    struct rules rules;
    struct bench_bus bus[BOARD_BUSES_MAX];
    struct host_link host_link;
    struct script script;
    struct script_ops ops;
    struct pc_program pc_program;
    struct pty pty;
    struct realtime realtime; // with a pty
    struct event keep_pace;
    uint64_t traffic; // cycle of the latest byte of the client or for it
    struct vcd vcd;
    unsigned handler; // the VCD's signal
    struct motion motion;
    struct plot plot;
    char title[128]; // of the plot
    struct gdb gdb;
    struct mark mark;
    struct times times;
    FILE *transcript;
    struct live_view live_view;
    struct event limit;
    bool ran; // there are results to save, though the run may have ended before its first cycle
    uint64_t end;
    bool cpu_done;
};

/* False, with one line on stderr: a file is missing or bad. bench_free() is due all the same. */
bool bench_init(struct bench *bench, const struct bench_options *options);

/* The faults of the command line. False, with one line on stderr, when one cannot be had. */
bool bench_order_faults(const struct bench_options *options,
                        const char *(*order)(void *context, uint64_t now, const char *text),
                        void *context);

/* False when a rule was broken. */
bool bench_run(struct bench *bench);
void bench_report(struct bench *bench, FILE *out);

/* False when a file could not be written. */
bool bench_free(struct bench *bench);

#endif
