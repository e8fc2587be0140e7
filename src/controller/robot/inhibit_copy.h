/* SPDX-License-Identifier: MIT */
/* A copy of the drive inhibit that survives a reset. It stands in RAM that start-up does not clear
 * (section .noinit). The complement beside it shows whether the copy is whole; a damaged copy
 * counts as inhibited. After power-on the content is random, and the caller sets it.
 *
 * Main context. */
#ifndef CONTROLLER_INHIBIT_COPY_H
#define CONTROLLER_INHIBIT_COPY_H

#include <stdbool.h>
#include <stdint.h>

/* Values of `state`; every other one counts as INHIBIT_ON. */
#define INHIBIT_FREE     0x5AC3u // driving is allowed
#define INHIBIT_ON       0x3C96u // driving is inhibited
#define INHIBIT_STOPPING 0xA569u // driving is inhibited, and torque off is not finished

/* Volatile: a reset may come between two stores, and their order must be the one written here. */
struct inhibit_copy {
    volatile uint16_t state;
    volatile uint16_t check; // the complement of `state`
};

/* Returns the state that the copy holds; INHIBIT_ON if the copy is damaged. */
static inline uint16_t inhibit_stored(const struct inhibit_copy *copy)
{
    uint16_t state = copy->state, check = copy->check;

    if ((uint16_t)(state ^ check) != UINT16_MAX ||
        (state != INHIBIT_FREE && state != INHIBIT_STOPPING))
        return INHIBIT_ON;
    return state;
}

/* Stores `state`. A reset between the stores leaves a damaged copy, which inhibits. */
static inline void inhibit_store(struct inhibit_copy *copy, uint16_t state)
{
    copy->check = 0; // no complement of any state: damaged until both words are written
    copy->state = state;
    copy->check = (uint16_t)~state;
}

#endif
