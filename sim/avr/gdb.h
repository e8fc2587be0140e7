/* SPDX-License-Identifier: MIT */
/* A server for avr-gdb: `target remote 127.0.0.1:PORT`, breakpoints, watchpoints on writes, steps,
 * Ctrl-C.
 *
 * The server stops the run between two instructions. Simulated time then stops too, and with it the
 * wire and the servos: a run with stops gives the same results as a run without. simavr's own
 * server polls its socket before each instruction; this server reads one table entry instead.
 *
 * A step runs through interrupts that occur meanwhile, unless it reaches a breakpoint in them. */
#ifndef SIM_GDB_H
#define SIM_GDB_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

#include "avr/cpu.h"
#include "avr/eeprom_model.h"
#include "avr/gdb_memory.h"

#define GDB_SIZE         2048 // bytes of a packet
#define GDB_WATCHES      8
#define GDB_WATCHED_SIZE 8

enum gdb_state { GDB_STOPPED, GDB_STEPPING, GDB_RUNNING };

struct gdb_watch {
    uint16_t address, size; // size 0: unused
    uint8_t bytes[GDB_WATCHED_SIZE];
};

struct gdb {
    struct gdb_machine machine;
    const struct cpu *cpu;
    const volatile sig_atomic_t *stop; // the simulation shall end
    int listener, client;              // -1: none
    enum gdb_state state;
    bool killed;
    unsigned depth;    // cpu->depth when the step began
    bool *breakpoints; // one for each word of flash
    uint8_t signal;    // gdb's number of the reason for the stop
    unsigned runs;     // instructions since the latest poll of the socket
    const struct gdb_watch *hit;
    struct gdb_watch watches[GDB_WATCHES];
    unsigned watching;
    unsigned in_size;
    char in[GDB_SIZE];
    char out[GDB_SIZE + 4];
};

/* Listens on 127.0.0.1 and prints the port on stderr; port 0: any free port. Returns false, with
 * one line on stderr. */
bool gdb_open(struct gdb *gdb, uint16_t port);
void gdb_close(struct gdb *gdb);
void gdb_attach(struct gdb *gdb, avr_t *avr, const struct cpu *cpu,
                const struct eeprom_model *eeprom, const volatile sig_atomic_t *stop);

/* Call it before each instruction. It returns when the debugger lets the run continue. Returns
 * false if the debugger ends the run. */
bool gdb_may_run(struct gdb *gdb);

/* The run has ended. After a crash the debugger may inspect the machine. */
void gdb_ended(struct gdb *gdb, bool crashed);

#endif
