/* SPDX-License-Identifier: MIT */
/* Port pins of the AVR, as its DDR and PORT registers set them. */
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

/* Returns false if the chip has no such port. */
bool pin_find(struct pin *pin, avr_t *avr, char port, unsigned bit);

/* Calls `changed` after each write to the pin's DDR or PORT register. simavr calls with avr->cycle
 * at the start of the writing instruction. */
void pin_watch(const struct pin *pin, avr_irq_notify_t changed, void *context);

enum pin_state pin_state(const struct pin *pin);

/* A pin as the firmware reads it: it follows a net. */
struct pin_input {
    struct pin pin;
    const struct net *net;
    avr_io_read_t read; // of PINx before: simavr's own, or that of another pin of the port
    void *context;
};

/* From now on a read of the pin's bit in PINx returns the level of the net at the start of the
 * reading instruction, which has the age that a pin's synchroniser shows. While the pin is an
 * output, simavr's value applies. A change of level costs no time and raises no INTn or PCINT. */
void pin_connect_input(struct pin_input *input, const struct pin *pin, const struct net *net);

#endif
