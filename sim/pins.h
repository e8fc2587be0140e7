/* Port pins of the AVR, as they stand in its DDR and PORT registers. */
#ifndef SIM_PINS_H
#define SIM_PINS_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>
#include <simavr/avr_ioport.h>

enum pin_state { PIN_FLOATS, PIN_PULLED_UP, PIN_LOW, PIN_HIGH };

struct pin {
    avr_ioport_t *port;
    uint8_t bit;
};

/* False when the chip has no such port. */
bool pin_find(struct pin *pin, avr_t *avr, char port, unsigned bit);

/* Calls `changed` after every write to the pin's DDR or PORT register, once per owner. simavr tells
 * of it with avr->cycle at the start of the writing instruction. */
void pin_watch(const struct pin *pin, avr_irq_notify_t changed, void *owner);

enum pin_state pin_state(const struct pin *pin);

/* What the outside puts on the pin, for the firmware to read in PINx (no INTn, no PCINT). */
void pin_input(const struct pin *pin, bool level);

#endif
