/* SPDX-License-Identifier: MIT */
/* Resets the controller or hangs its main program, as a scenario orders: docs/scenario.md. */
#ifndef SIM_RESET_INJECTION_H
#define SIM_RESET_INJECTION_H

#include <stdbool.h>
#include <stdint.h>

#include "avr/machine.h"
#include "wire/schedule.h"

struct reset_order {
    bool hang; // false: a reset
    enum machine_reset cause;
    uint32_t us;      // from now on
    uint32_t writes;  // the reset comes within this write to the EEPROM, counted from now on; 0:
                      // after `us`
    uint32_t percent; // share of the write's duration after which the reset comes
};

/* Holds one order. A new order replaces an order that has not been executed yet. */
struct reset_injection {
    struct machine *machine;
    struct event event;
    struct reset_order order;
};

/* Parse the text after @reset or @hang. Return 0, or what is wrong. */
const char *reset_order_parse(struct reset_order *order, char *text);
const char *hang_order_parse(struct reset_order *order, char *text);

void reset_injection_init(struct reset_injection *injection, struct machine *machine);
void reset_injection_order(struct reset_injection *injection, uint64_t now,
                           const struct reset_order *order);

#endif
