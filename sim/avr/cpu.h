/* What simavr's core leaves out or does not tell: the cycles of entering an interrupt, the one
 * instruction after SEI and RETI, and where the time goes. */
#ifndef SIM_CPU_H
#define SIM_CPU_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

struct cpu {
    avr_t *avr;
    bool exact;           // charge and mend; else leave simavr as it is
    uint64_t asleep;      // cycles
    uint64_t in_handlers; // cycles, entry and RETI included
    unsigned depth;       // of nested handlers
    uint8_t vectors[64];  // that run, outermost first
    uint64_t entered;     // when the outermost was
    uint64_t latest;      // when the latest was
    bool woken;           // slept since the latest entry
    void *context;
    void (*on_handler)(void *context, uint64_t now, uint8_t vector); // 0: none runs; may be 0
};

void cpu_init(struct cpu *cpu, avr_t *avr, bool exact);
void cpu_reset(struct cpu *cpu);

/* To be called after every step of avr_run that leaves avr->interrupt_state negative. */
void cpu_stepped(struct cpu *cpu);

/* The CPU stands still for so many cycles, from where the present instruction leaves it. */
void cpu_halt(avr_t *avr, avr_cycle_count_t cycles);

/* A level-triggered interrupt: pending as long as `on`, and no longer. simavr drops the request
 * when the handler is entered: call it again then. */
void cpu_set_level_interrupt(avr_t *avr, avr_int_vector_t *vector, bool on);

/* From avr->sleep. */
void cpu_slept(struct cpu *cpu, uint64_t cycles);

#endif
