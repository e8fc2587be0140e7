/* A server for avr-gdb: `target remote 127.0.0.1:PORT`, breakpoints, watchpoints on writes, steps,
 * Ctrl-C.
 *
 * It holds the run up between two instructions, so simulated time stands, and with it the wire and
 * the servos: a run with stops is the same as one without. simavr's own server looks at its socket
 * before every instruction and answers one packet a look; this one costs a table look-up.
 *
 * A step runs through interrupts that come up meanwhile, unless a breakpoint in them is met.
 */
#ifndef SIM_GDB_H
#define SIM_GDB_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

#include "avr/cpu.h"
#include "avr/eeprom_model.h"

#define GDB_SIZE         2048 // bytes of a packet
#define GDB_WATCHES      8
#define GDB_WATCHED_SIZE 8

enum gdb_state { GDB_STOPPED, GDB_STEPPING, GDB_RUNNING };

struct gdb_watch {
    uint16_t address, size; // size 0: free
    uint8_t bytes[GDB_WATCHED_SIZE];
};

struct gdb {
    avr_t *avr;
    const struct cpu *cpu;
    const struct eeprom_model *eeprom;
    const volatile sig_atomic_t *stop; // the simulation is to end
    int listener, client;              // -1: none
    enum gdb_state state;
    bool killed;
    unsigned depth;    // of handlers, when the step began
    bool *breakpoints; // one for each word of flash
    uint8_t signal;    // why it stopped, as gdb numbers it
    unsigned runs;     // instructions since the last look at the socket
    const struct gdb_watch *hit;
    struct gdb_watch watches[GDB_WATCHES];
    unsigned watching;
    unsigned in_size;
    char in[GDB_SIZE];
    char out[GDB_SIZE + 4];
};

/* Listens on 127.0.0.1 and says so on stderr; port 0: any. False, with one line on stderr. */
bool gdb_open(struct gdb *gdb, uint16_t port);
void gdb_close(struct gdb *gdb);
void gdb_attach(struct gdb *gdb, avr_t *avr, const struct cpu *cpu,
                const struct eeprom_model *eeprom, const volatile sig_atomic_t *stop);

/* Before every instruction; does not return while the debugger holds the run. False: it ends it. */
bool gdb_may_run(struct gdb *gdb);

/* The run is over. After a crash the debugger may look at what is left. */
void gdb_ended(struct gdb *gdb, bool crashed);

#endif
