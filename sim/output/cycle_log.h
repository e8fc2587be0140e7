/* SPDX-License-Identifier: MIT */
/* Records CPU cycles for measurements of firmware, from one place and with one clock:
 *
 *     --times FILE     handlers, time with interrupts off, transmissions of the controller
 *     --stamp PORT     and each change of the port's pins          (into FILE)
 *     --steps FROM-TO  and each instruction that begins in a span  (into FILE)
 *     --mark PIN       how long the firmware holds a pin high      (one line of the report)
 *
 * docs/simulator.md describes the lines of the file.
 */
#ifndef SIM_CYCLE_LOG_H
#define SIM_CYCLE_LOG_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "avr/bus_circuit.h"
#include "avr/cpu.h"
#include "avr/machine.h"
#include "avr/pins.h"
#include "board.h"

#define CYCLE_LOG_VECTORS 64
#define CYCLE_LOG_DEPTH   64 // nested handlers: simavr ends a run that nests deeper

/* The values of the options; 0: not given. */
struct cycle_log_options {
    const char *times;
    const char *stamp;
    const char *steps;
    const char *mark;
};

struct handler_cycles {
    uint32_t count;
    uint64_t cycles; // in all, without nested handlers
    uint64_t longest;
};

struct running_handler {
    uint8_t vector;
    uint64_t entered;
    uint64_t nested; // cycles of handlers that interrupted this one
};

/* A transmission of the controller that has not ended. */
struct transmission {
    unsigned bytes; // 0: there is none
    uint64_t start; // of the first start bit
    uint64_t end;   // of the latest stop bit
    uint64_t idle;  // cycles between frames
};

/* The time for which the firmware holds one pin high, without interrupt handlers. */
struct pin_timer {
    const char *name; // as in B0; 0: --mark was not given
    struct pin pin;
    bool high;
    uint64_t rose;        // cycle
    uint64_t in_handlers; // cpu->in_handlers when the pin rose
    uint64_t cycles;      // in all
    uint64_t longest;
    uint32_t count;
};

struct cycle_log {
    struct machine *machine;
    const struct cpu *cpu;
    const char *path;
    FILE *file; // 0: --times was not given

    struct handler_cycles handler[CYCLE_LOG_VECTORS];
    struct running_handler running[CYCLE_LOG_DEPTH];
    unsigned depth;

    bool interrupts_off;
    uint64_t off_since;
    uint64_t longest_off;
    uint64_t longest_off_since;

    uint64_t steps_from, steps_to; // a span of cycles, without its end

    struct pin stamp; // any pin of the port
    uint8_t stamp_level;

    struct transmission transmission[BOARD_BUSES_MAX];
    struct pin_timer timer;
};

/* Opens the file and watches what the options name. Returns false, with one line on stderr, if an
 * option's value is wrong. */
bool cycle_log_open(struct cycle_log *log, struct machine *machine,
                    const struct cycle_log_options *options);

/* The caller reports three events: a handler is entered or left; a byte of the controller begins on
 * a bus; an enable, the transmitter or the receiver of a bus has changed. */
void cycle_log_handler(struct cycle_log *log, uint64_t now);
void cycle_log_byte(struct cycle_log *log, uint64_t now, unsigned bus,
                    const struct bus_circuit *circuit);
void cycle_log_circuit(struct cycle_log *log, uint64_t now, unsigned bus,
                       const struct bus_circuit *circuit);

/* Writes the line of --mark for a run that ends at `now`. */
void cycle_log_report(struct cycle_log *log, uint64_t now, FILE *out);

/* Writes the sums of a run that ends at `now`. Returns false, with one line on stderr, if the file
 * could not be written. */
bool cycle_log_close(struct cycle_log *log, uint64_t now);

#endif
