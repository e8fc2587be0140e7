/* What happens to the controller itself, as a scenario orders it: a reset, or a main program that
 * hangs. docs/scenario.md has the language. */
#ifndef SIM_RESET_INJECTION_H
#define SIM_RESET_INJECTION_H

#include <stdbool.h>
#include <stdint.h>

#include "avr/machine.h"
#include "wire/schedule.h"

/* An order, read. */
struct upset_order {
    bool hang; // else a reset
    enum machine_reset cause;
    uint32_t us;      // from now on
    uint32_t writes;  // or within so many-th write to the EEPROM from now on; 0: not so
    uint32_t percent; // ... of the time it takes
};

/* The one order there is; a new one takes the place of one that has not happened yet. */
struct upset {
    struct machine *machine;
    struct event event;
    struct upset_order order;
};

/* Reads what follows @reset or @hang. Returns 0, or what is wrong. */
const char *upset_parse_reset(struct upset_order *order, char *text);
const char *upset_parse_hang(struct upset_order *order, char *text);

void upset_init(struct upset *upset, struct machine *machine);
void upset_order(struct upset *upset, uint64_t now, const struct upset_order *order);

#endif
