/* What happens to the controller itself, as a scenario orders it: a reset, or a main program that
 * hangs. docs/scenario.md has the language. */
#ifndef SIM_RESET_INJECTION_H
#define SIM_RESET_INJECTION_H

#include <stdbool.h>
#include <stdint.h>

#include "avr/machine.h"
#include "wire/schedule.h"

/* An order, read. */
struct reset_order {
    bool hang; // else a reset
    enum machine_reset cause;
    uint32_t us;      // from now on
    uint32_t writes;  // or within so many-th write to the EEPROM from now on; 0: not so
    uint32_t percent; // ... of the time it takes
};

/* The one order there is; a new one takes the place of one that has not happened yet. */
struct reset_injection {
    struct machine *machine;
    struct event event;
    struct reset_order order;
};

/* Reads what follows @reset or @hang. Returns 0, or what is wrong. */
const char *reset_order_parse(struct reset_order *order, char *text);
const char *hang_order_parse(struct reset_order *order, char *text);

void reset_injection_init(struct reset_injection *injection, struct machine *machine);
void reset_injection_order(struct reset_injection *injection, uint64_t now,
                           const struct reset_order *order);

#endif
