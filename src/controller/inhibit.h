/* The copy of the drive inhibit that a reset does not clear: it stands in RAM that start-up leaves
 * alone (section .noinit). Whether a reset kept the copy whole is seen by its complement: a damaged
 * copy counts as inhibited. After power-on the content is random, and the caller sets
 * it.
 *
 * Main context. */
#ifndef CONTROLLER_INHIBIT_H
#define CONTROLLER_INHIBIT_H

#include <stdbool.h>
#include <stdint.h>

#define INHIBIT_FREE 0x5AC3u // `state` if driving is allowed; any other value inhibits

/* Volatile: a reset may come between two stores, and their order must be the one written here. */
struct inhibit_copy {
    volatile uint16_t state;
    volatile uint16_t check; // the complement of `state`
};

/* True: driving is inhibited, or the copy is damaged. */
static inline bool inhibit_stored(const struct inhibit_copy *copy)
{
    uint16_t state = copy->state, check = copy->check;

    return state != INHIBIT_FREE || (uint16_t)(state ^ check) != UINT16_MAX;
}

/* Stores `inhibited`. A reset between the stores leaves a damaged copy, which inhibits. */
static inline void inhibit_store(struct inhibit_copy *copy, bool inhibited)
{
    uint16_t state = inhibited ? 0 : INHIBIT_FREE;

    copy->check = 0; // no complement of either state: damaged until both words are written
    copy->state = state;
    copy->check = (uint16_t)~state;
}

#endif
