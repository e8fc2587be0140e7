/* A pin that firmware holds high while it does what is to be measured: how much of the time that
 * takes, interrupt handlers within it not counted. */
#ifndef SIM_PIN_TIMER_H
#define SIM_PIN_TIMER_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "avr/cpu.h"
#include "avr/pins.h"

struct mark {
    const char *name; // of the pin, as in B0; 0: there is no mark
    struct pin pin;
    const struct cpu *cpu;
    bool high;
    uint64_t since;       // cycles; when it rose
    uint64_t in_handlers; // the CPU's, then
    uint64_t cycles;      // that it was high in all
    uint64_t longest;     // at one time
    uint32_t times;
};

/* `name` is a port and a bit, as in B0. False, with one line on stderr, when the chip has none. */
bool mark_open(struct mark *mark, const struct cpu *cpu, const char *name);
/* One line, if there is a mark; of a run that ends now. */
void mark_report(struct mark *mark, uint64_t now, FILE *out);

#endif
