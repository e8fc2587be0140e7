/* SPDX-License-Identifier: MIT */
/* The AVR: sets up simavr, drives the event queue by simavr's cycles, and runs the firmware. */
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
    MACHINE_STOPPED, // by machine_stop()
    MACHINE_DONE,    // the firmware sleeps with interrupts off
    MACHINE_CRASHED,
};

/* In the order of their flags in MCUSR (MCUCSR). */
enum machine_reset {
    MACHINE_POWER_ON, // clears RAM and stops an EEPROM write
    MACHINE_EXTERNAL,
    MACHINE_BROWN_OUT, // stops an EEPROM write
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
    avr_run_t run;      // simavr's run function; its watchdog replaces it to reset
    unsigned reset_due; // bits: 1 << enum machine_reset
    bool hang_due;
    bool hangs;
    avr_flashaddr_t hang_at; // address of the replaced instruction
    uint8_t hang_code[2];
    uint8_t flags;              // of MCUSR, kept over a reset
    avr_io_t reset_hook;        // simavr calls it at a reset, after its own parts
    uint32_t pc;                // byte address of the latest instruction
    bool just_reset;            // the chip was reset and has not run yet
    bool in_events;             // within schedule_run_until()
    volatile sig_atomic_t stop; // a signal handler may set it
    char crash[240];            // what happened; "": no crash
    bool interrupts;            // they were on after the latest instruction
    bool interrupts_were_on;    // at any time of the run
    void *log_context;
    void (*on_interrupts)(void *log_context, bool on); // interrupts were turned on or off; may be 0
    void (*on_step)(void *log_context, uint64_t now,
                    uint32_t pc); // an instruction begins; may be 0
    void *context;
    void (*on_reset)(void *context, uint64_t now); // may be 0
};

/* Returns false, with one line on stderr, if simavr does not know the chip or the ELF file is for
 * another chip. */
bool machine_init(struct machine *machine, struct schedule *schedule, const char *mcu,
                  const char *core, uint32_t clock_Hz, const char *elf, bool exact);
void machine_free(struct machine *machine);

/* Resets the chip after the present instruction: registers and pins, and the RAM with
 * MACHINE_POWER_ON. The start-up time is 0. */
void machine_reset(struct machine *machine, enum machine_reset cause);

/* Makes the main program loop in one place with interrupts on. Handlers run as before. A reset ends
 * the loop. */
void machine_hang(struct machine *machine);

/* Ends machine_run() after the present instruction. */
void machine_stop(struct machine *machine);
enum machine_end machine_run(struct machine *machine);

#endif
