/* The AVR: simavr set up, the event queue driven by it, and the loop that runs it. */
#ifndef SIM_MACHINE_H
#define SIM_MACHINE_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

#include "cpu.h"
#include "image.h"
#include "schedule.h"

enum machine_end {
    MACHINE_STOPPED, // machine_stop
    MACHINE_DONE,    // the firmware sleeps with interrupts off
    MACHINE_CRASHED,
};

struct machine {
    avr_t *avr;
    struct schedule *schedule;
    struct cpu cpu;
    struct image image;
    avr_io_t reset_watch;       // simavr calls it when the chip is reset, after its own parts
    uint32_t pc;                // of the latest instruction, byte address
    bool fresh;                 // has been reset and not yet run
    bool driving;               // within schedule_run_until
    volatile sig_atomic_t stop; // may be set by a signal handler
    char crash[240];            // what went wrong; "": nothing
    void *owner;
    void (*on_reset)(void *owner, uint64_t now); // by the watchdog; may be 0
};

/* False, with one line on stderr, when there is no such chip or the ELF file is not for it. */
bool machine_init(struct machine *machine, struct schedule *schedule, const char *mcu,
                  uint32_t clock_Hz, const char *elf, bool exact);
void machine_free(struct machine *machine);

/* Ends machine_run after the present instruction. */
void machine_stop(struct machine *machine);
enum machine_end machine_run(struct machine *machine);

#endif
