/* SPDX-License-Identifier: MIT */
/* What survives a reset: the drive inhibit and the baud rate of the bus. Servos go on through a
 * reset of the controller, and a stop reaches them only at their rate. The copy stands in RAM that
 * start-up does not clear (section .noinit). The complement beside each byte shows whether the
 * byte is whole; a damaged state counts as inhibited. After power-on the content is random.
 *
 * Main context. */
#ifndef CONTROLLER_RESET_COPY_H
#define CONTROLLER_RESET_COPY_H

#include <stdbool.h>
#include <stdint.h>

/* Values of `state`. Any other value inhibits driving, as INHIBIT_ON. */
#define INHIBIT_FREE     0xC3u // driving is allowed
#define INHIBIT_ON       0x3Cu // driving is inhibited
#define INHIBIT_STOPPING 0x69u // driving is inhibited, and torque off is not finished

/* A byte and its complement. Volatile: a reset may come between two stores, and their order must be
 * the one written here. */
struct kept_byte {
    volatile uint8_t value;
    volatile uint8_t check;
};

struct reset_copy {
    struct kept_byte state;
    struct kept_byte baud_reg; // as register 0x04: 0 to 254
};

static inline bool kept_is_whole(const struct kept_byte *byte)
{
    return (byte->value ^ byte->check) == UINT8_MAX;
}

/* Stores `value`. A reset between the stores leaves a damaged byte, unless the byte
 * had this value before. */
static inline void kept_store(struct kept_byte *byte, uint8_t value)
{
    byte->value = value;
    byte->check = (uint8_t)~value;
}

/* Returns the state that the copy holds; INHIBIT_ON if it is damaged. */
static inline uint8_t reset_copy_state(const struct reset_copy *copy)
{
    return kept_is_whole(&copy->state) ? copy->state.value : INHIBIT_ON;
}

/* True if the rate is whole. The state must be whole, too: random bytes are that once in 65 536
 * times. */
static inline bool reset_copy_has_rate(const struct reset_copy *copy)
{
    return kept_is_whole(&copy->state) && kept_is_whole(&copy->baud_reg);
}

#endif
