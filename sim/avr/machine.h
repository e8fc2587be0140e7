/* The AVR: simavr set up, the event queue driven by it, and the loop that runs it. */
#ifndef SIM_MACHINE_H
#define SIM_MACHINE_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

#include "avr/cpu.h"
#include "avr/eeprom_model.h"
#include "avr/gdb.h"
#include "avr/image.h"
#include "wire/schedule.h"

enum machine_end {
    MACHINE_STOPPED, // machine_stop
    MACHINE_DONE,    // the firmware sleeps with interrupts off
    MACHINE_CRASHED,
};

/* In the order of the flags in MCUSR (MCUCSR), which tell them apart. */
enum machine_reset {
    MACHINE_POWER_ON, // RAM and an unfinished EEPROM write are lost
    MACHINE_EXTERNAL,
    MACHINE_BROWN_OUT, // an unfinished EEPROM write is lost
    MACHINE_WATCHDOG,
    MACHINE_RESETS
};

struct machine {
    avr_t *avr;
    struct schedule *schedule;
    struct cpu cpu;
    struct eeprom_model eeprom;
    struct image image;
    struct gdb *gdb;    // 0: none
    avr_run_t run;      // simavr's own way to run; its watchdog puts another one there to reset
    unsigned reset_due; // bits of enum machine_reset
    bool hang_due;
    bool hangs;
    avr_flashaddr_t hang_at; // the instruction that was put aside
    uint8_t hang_code[2];
    uint8_t flags;              // of MCUSR, over a reset
    avr_io_t reset_hook;        // simavr calls it when the chip is reset, after its own parts
    uint32_t pc;                // of the latest instruction, byte address
    bool just_reset;            // has been reset and not yet run
    bool in_events;             // within schedule_run_until
    volatile sig_atomic_t stop; // may be set by a signal handler
    char crash[240];            // what went wrong; "": nothing
    bool interrupts;            // on, after the latest instruction
    void *log_context;
    void (*on_interrupts)(void *log_context, bool on); // they were turned on or off; may be 0
    void (*on_step)(void *log_context, uint64_t now,
                    uint32_t pc); // an instruction begins; may be 0
    void *context;
    void (*on_reset)(void *context, uint64_t now); // may be 0
};

/* False, with one line on stderr, when there is no such chip or the ELF file is not for it. */
bool machine_init(struct machine *machine, struct schedule *schedule, const char *mcu,
                  const char *core, uint32_t clock_Hz, const char *elf, bool exact);
void machine_free(struct machine *machine);

/* Resets the chip after the present instruction: registers and pins, not the RAM but for
 * MACHINE_POWER_ON. No start-up time is charged. */
void machine_reset(struct machine *machine, enum machine_reset cause);

/* The main program goes round in one place from now on, with interrupts on: handlers run as before.
 * A reset ends it. */
void machine_hang(struct machine *machine);

/* Ends machine_run after the present instruction. */
void machine_stop(struct machine *machine);
enum machine_end machine_run(struct machine *machine);

#endif
