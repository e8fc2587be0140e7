/* What happened when, to the cycle, for whoever measures firmware: each transmission of the
 * controller, each step of a pin that the firmware sets as a mark, and in the end how long handlers
 * took and interrupts were off. Lines of words; docs/simulator.md says which. */
#ifndef SIM_CYCLE_LOG_H
#define SIM_CYCLE_LOG_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "board.h"
#include "avr/cpu.h"
#include "avr/machine.h"
#include "avr/pins.h"
#include "avr/bus_circuit.h"

#define TIMES_VECTORS 64
#define TIMES_DEPTH   8 // handlers within handlers

struct times {
    const char *path;
    FILE *file; // 0: nothing is asked for
    struct machine *machine;
    const struct cpu *cpu;

    struct times_handler {
        uint32_t times;
        uint64_t cycles; // without other handlers within, as the next one
        uint64_t longest;
    } handler[TIMES_VECTORS];
    struct times_running {
        uint8_t vector;
        uint64_t entered;
        uint64_t nested; // cycles of handlers within
    } running[TIMES_DEPTH];
    unsigned depth;

    bool off; // interrupts are
    uint64_t off_since;
    uint64_t longest_off;
    uint64_t longest_off_at;

    uint64_t steps_from, steps_to; // instructions that begin from one cycle to before the other

    struct pin stamp; // any of its port
    bool stamps;
    uint8_t level; // of its pins

    struct times_sent {
        unsigned bytes; // of the transmission that goes on; 0: none does
        uint64_t first; // its first start bit
        uint64_t last;  // its latest stop bit's end
        uint64_t idle;  // cycles within it that had no frame
    } sent[BOARD_BUSES_MAX];
};

/* False, with one line on stderr: the file cannot be written. */
bool times_open(struct times *times, struct machine *machine, const char *path);
/* Steps of the pins of `port`, as in B, are told too. False, with one line on stderr, when the chip
 * has no such port. */
bool times_stamp(struct times *times, const char *port);

/* The file also gets each instruction that begins in the cycles of `span`: 1000-2000 is from cycle
 * 1000 to before cycle 2000. False, with one line on stderr, if `span` is not two cycles, the lower
 * one first. */
bool times_steps(struct times *times, const char *span);

/* To be called when a handler is entered or left. */
void times_handler(struct times *times, uint64_t now);
/* A byte of the controller begins on this wire. */
void times_byte(struct times *times, uint64_t now, unsigned bus, const struct bus_circuit *circuit);
/* An enable has changed, or the controller's transmitter or receiver. */
void times_wire(struct times *times, uint64_t now, unsigned bus, const struct bus_circuit *circuit);

/* Writes the sums of a run that ends now. False: the file could not be written. */
bool times_close(struct times *times, uint64_t now);

#endif
