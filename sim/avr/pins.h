/* Port pins of the AVR, as they stand in its DDR and PORT registers. */
#ifndef SIM_PINS_H
#define SIM_PINS_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>
#include <simavr/avr_ioport.h>

#include "wire/net.h"

enum pin_state { PIN_FLOATS, PIN_PULLED_UP, PIN_LOW, PIN_HIGH };

struct pin {
    avr_ioport_t *port;
    uint8_t bit;
};

/* False when the chip has no such port. */
bool pin_find(struct pin *pin, avr_t *avr, char port, unsigned bit);

/* Calls `changed` after every write to the pin's DDR or PORT register, once per owner. simavr tells
 * of it with avr->cycle at the start of the writing instruction. */
void pin_watch(const struct pin *pin, avr_irq_notify_t changed, void *context);

enum pin_state pin_state(const struct pin *pin);

/* The firmware's view of a pin: the net that it hangs on. */
struct pin_input {
    struct pin pin;
    const struct net *net;
    avr_io_read_t read; // of PINx before: simavr's own, or that of another pin of this port
    void *context;
};

/* From now on a read of the pin's bit in PINx, by whatever instruction, gives the net's level as
 * the instruction begins: of that age is what the synchroniser behind a pin shows. While DDR makes
 * it an output, simavr's value stands. A change of level costs nothing, and it makes no INTn or
 * PCINT. */
void pin_connect_input(struct pin_input *input, const struct pin *pin, const struct net *net);

#endif
