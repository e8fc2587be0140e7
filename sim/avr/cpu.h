/* SPDX-License-Identifier: MIT */
/* Corrects and observes simavr's core: the cycles of an interrupt's entry, the one instruction
 * after SEI and RETI, the time in handlers and asleep. */
#ifndef SIM_CPU_H
#define SIM_CPU_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

struct cpu {
    avr_t *avr;
    bool exact;           // correct the cycles; false: leave simavr as it is
    uint64_t asleep;      // cycles
    uint64_t in_handlers; // cycles with entry and RETI
    unsigned depth;       // number of nested handlers
    uint8_t vectors[64];  // of the running handlers, outermost first
    uint64_t entered;     // cycle at which the outermost handler was entered
    uint64_t latest;      // cycle at which the latest handler was entered
    bool has_slept;       // the CPU has slept since the latest entry
    void *context;
    void (*on_handler)(void *context, uint64_t now,
                       uint8_t vector); // vector 0: no handler runs; may be 0
};

void cpu_init(struct cpu *cpu, avr_t *avr, bool exact);
void cpu_reset(struct cpu *cpu);

/* Call it after each avr_run() that leaves avr->interrupt_state negative. */
void cpu_stepped(struct cpu *cpu);

/* Stops the CPU for `cycles`, after the present instruction. */
void cpu_halt(avr_t *avr, avr_cycle_count_t cycles);

/* Sets the request of a level-triggered interrupt: pending exactly while `on`. simavr drops a
 * request when the handler is entered: call it again then. */
void cpu_set_level_interrupt(avr_t *avr, avr_int_vector_t *vector, bool on);

/* Call it from avr->sleep. */
void cpu_slept(struct cpu *cpu, uint64_t cycles);

#endif
