/* SPDX-License-Identifier: MIT */
/* The testbench: servos on a bus, what drives the bus, the PC, and the instruments of a run.
 *
 * With a controller, a board's firmware drives up to three buses in a simulated AVR. Without one
 * (options->bus), a program behind a pty or a scenario drives one bus through a serial adapter.
 *
 *     static struct testbench bench; // about 10 MB: too big for the stack
 *     if (testbench_init(&bench, &options)) {
 *         good = testbench_run(&bench);
 *         testbench_report(&bench, stdout);
 *     }
 *     written = testbench_free(&bench); // also after a failed testbench_init()
 */
#ifndef SIM_TESTBENCH_H
#define SIM_TESTBENCH_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "avr/bus_circuit.h"
#include "avr/gdb.h"
#include "avr/machine.h"
#include "board.h"
#include "host/adapter.h"
#include "host/host_link.h"
#include "host/pc_program.h"
#include "host/poke_socket.h"
#include "host/pty.h"
#include "host/realtime.h"
#include "host/tcp.h"
#include "output/cycle_log.h"
#include "output/live_view.h"
#include "output/plot.h"
#include "output/trace.h"
#include "output/transcript.h"
#include "output/vcd.h"
#include "script/faults.h"
#include "script/reset_injection.h"
#include "script/script.h"
#include "servo/servo_eeprom.h"
#include "servo/servos.h"
#include "wire/rules.h"
#include "wire/schedule.h"

#define TESTBENCH_FAULTS_MAX 64
#define TESTBENCH_CLOCK_HZ   16000000 // unit of time without a controller
#define TESTBENCH_BAUD       1000000  // of the adapter, until a client or a scenario sets it

/* What the console's serial line is connected to. */
enum testbench_host {
    TESTBENCH_HOST_NONE,
    TESTBENCH_HOST_SCRIPT,
    TESTBENCH_HOST_PTY,
    TESTBENCH_HOST_TCP,
    TESTBENCH_HOST_STDOUT,
    TESTBENCH_HOST_PC,
};

/* The command line. A field has the name of its option; a path of 0 means: not given. */
struct testbench_options {
    const char *elf;
    const char *boards; // folder of the known boards
    const char *board;
    struct testbench_servos {
        uint8_t ids[IDS_MAX];
        unsigned count;
    } servos[BOARD_BUSES_MAX];
    const char *script;
    const char *pc; // the file of --host FILE
    const char *transcript;
    const char *vcd;
    const char *csv;
    const char *plot;
    struct plot_panes panes; // of the plot
    const char *eeprom;
    const char *state; // folder
    struct cycle_log_options cycles;
    bool gdb;
    uint16_t gdb_port; // 0: any
    bool rules_warn;
    bool client_baud; // the PC has the bit rate that the client of the pty sets, not the board's
    enum testbench_host host;
    bool prints_text;      // what the firmware says beside a scenario
    const char *poke;      // the socket of --poke
    const char *poke_hint; // the command that the banner names for orders, or NULL
    uint16_t tcp_port;     // of --host tcp:PORT; 0: any
    double seconds;        // 0: no limit
    const char *faults[TESTBENCH_FAULTS_MAX];
    unsigned fault_count;
    unsigned long slow; // simulated time runs so many times slower than real time; 0: as 1
    uint32_t seed;
    bool allow_duplicates;
    bool exact;
    bool echo;
    bool follow;
    bool bus; // no controller
    bool pty; // without a controller: a pty drives the bus
};

/* One bus and what is connected to it. */
struct testbench_bus {
    struct testbench *bench;
    unsigned index;
    struct net *wire;
    struct bus_circuit circuit; // with a controller
    struct net adapter_wire;    // without a controller
    struct adapter adapter;     // without a controller
    struct rules rules;
    char label[16]; // " bus1" on a board with several buses, else ""
    char where[24]; // "bus 1: " on a board with several buses, else ""
    struct servos servos;
    struct servo_eeprom eeprom;
    struct faults faults;
    struct transcript transcript;
    uint64_t latest_packet;    // of the controller: its begin; 0: none
    uint64_t longest_pause;    // from one of these begins to the next
    uint32_t unheard[IDS_MAX]; // packets of the controller for an ID that no servo has
    struct bus_trace trace;
};

/* The order that a client of --poke has given. */
struct testbench_poke {
    struct poke_socket socket;
    bool busy;    // the order is not answered yet
    char *output; // what the order has printed, for the client
    size_t output_size;
    char wrong[800]; // why the order has failed; "": it has not
};

/* A line of the firmware that has no end yet. */
struct testbench_line {
    uint8_t bytes[256];
    unsigned size;
};

struct testbench {
    const struct testbench_options *options;
    struct schedule schedule;
    uint32_t clock_Hz;
    struct board board; // with a controller
    struct machine machine;
    struct reset_injection reset;
    struct host_link host_link;
    struct testbench_line host_line; // with --host stdout and --echo
    struct pc_program pc_program;
    struct gdb gdb;
    struct cycle_log cycle_log;
    unsigned handler_signal; // in the VCD
    bool cpu_done;           // the firmware sleeps with interrupts off

    struct testbench_bus bus[BOARD_BUSES_MAX];
    unsigned bus_count;
    struct rules rules;
    struct script script;
    struct script_ops ops;
    struct pty pty;
    struct tcp tcp;
    struct testbench_poke poke;
    bool cannot_listen;       // testbench_init() has failed: TCP port or socket cannot be opened
    struct realtime realtime; // with a client: a pty or a TCP port
    struct event next_step;   // with a client and a controller
    uint64_t traffic;         // cycle of the latest byte from or to the client
    struct vcd vcd;
    struct motion motion;
    struct plot plot;
    char title[128]; // of the plot
    FILE *transcript;
    struct live_view live_view;
    struct event time_limit;
    bool ran; // there are results to save
    uint64_t end;
    volatile sig_atomic_t stop; // a signal handler may set it
};

/* Returns false, with one line on stderr, if a file is missing or wrong. */
bool testbench_init(struct testbench *bench, const struct testbench_options *options);

/* Runs until the scenario, the time or the firmware ends. Returns false if a rule was broken. */
bool testbench_run(struct testbench *bench);

/* Ends testbench_run() soon. A signal handler may call it. */
void testbench_stop(struct testbench *bench);

void testbench_report(struct testbench *bench, FILE *out);

/* Writes and closes the files. Returns false, with a line on stderr for each file that could not be
 * written. */
bool testbench_free(struct testbench *bench);

/* --- for the other files of the testbench: testbench_*.c --- */

/* Replaces the servos of a bus. Returns false, with one line on stderr, if an EEPROM file is wrong.
 */
bool testbench_put_servos(struct testbench_bus *bus, uint64_t now, const uint8_t *ids,
                          unsigned count);

/* Injects a fault on the bus that its text names. Returns 0, or what is wrong. */
const char *testbench_fault(void *context, uint64_t now, const char *text);
void testbench_reset(void *context, uint64_t now, const struct reset_order *order);
void testbench_echo(void *context, bool on);

/* Prints the line that the firmware has not ended, and ends it. */
void testbench_end_host_line(struct testbench *bench);

/* Returns false, with `file:line: what` on stderr. */
bool testbench_start_script(struct testbench *bench);

/* Sets what the lines of a scenario can do, but not what follows their end. */
void testbench_set_script_ops(struct testbench *bench);

/* Orders during a run in real time. Opening returns false, with one line on stderr. */
bool testbench_open_poke(struct testbench *bench);
void testbench_poll_poke(struct testbench *bench, uint64_t now);
void testbench_close_poke(struct testbench *bench);

/* Opens the pty or the TCP port. Returns false, with one line on stderr. */
bool testbench_open_client(struct testbench *bench);

/* Prints the name of the pty or TCP port, and how to open it. */
void testbench_print_client(const struct testbench *bench);

/* Passes a byte of the firmware, or of the bus, to the client. */
void testbench_send_to_client(struct testbench *bench, uint8_t byte);
void testbench_flush_client(struct testbench *bench);

/* Runs a bus without a controller at the speed of real time. */
void testbench_run_adapter_in_realtime(struct testbench *bench);

#endif
