/* SPDX-License-Identifier: MIT */
/* Another baud rate for several servos; see baud_change.h. */
#include "robot/baud_change.h"

#include <string.h>

#include "cds55xx/bus.h" // cds_bus_set_baud()

enum phase {
    BEGIN,  // the bus goes to the old rate, then the change of a servo begins
    CHANGE, // of a servo
    FINISH, // the bus goes to its new rate
} __attribute__((packed));

enum cds_result baud_change_begin(struct baud_change *change,
                                  const struct baud_change_config *config)
{
    if (config->count == 0 || config->count > BAUD_CHANGE_SERVOS)
        return CDS_BAD_ARGUMENT;
    memset(change, 0, sizeof *change);
    change->bus = config->bus;
    change->request = config->request;
    change->from_baud_reg = config->bus->baud_reg;
    change->to_baud_reg = config->baud_reg;
    change->count = config->count;
    memcpy(change->ids, config->ids, config->count);
    return CDS_OK;
}

/* The present servo is done. */
static void record(struct baud_change *change, uint8_t state, uint8_t result)
{
    change->states[change->index] = state;
    change->results[change->index++] = result;
    change->tries = 0;
    change->phase = BEGIN;
    if (state == CDS_IDENTITY_CHANGED)
        change->has_moved = true;
}

static void begin_servo(struct baud_change *change)
{
    const struct cds_identity_config config = {.bus = change->bus,
                                               .request = change->request,
                                               .change = CDS_IDENTITY_BAUD,
                                               .id = change->ids[change->index],
                                               .new_baud_reg = change->to_baud_reg};
    enum cds_result result;

    if (cds_bus_set_baud(change->bus, change->from_baud_reg) != CDS_OK)
        return; // a request of another caller is on its way
    result = cds_identity_begin(&change->identity, &config);
    if (result == CDS_OK)
        change->phase = CHANGE;
    else if (result != CDS_BUSY)
        record(change, CDS_IDENTITY_UNDECIDED, (uint8_t)result);
}

/* True if the servo answered at the new rate only, before anything was written. */
static bool was_there(const struct cds_identity *identity)
{
    return identity->state == CDS_IDENTITY_TAKEN && identity->at_to == CDS_OK &&
           identity->at_from == CDS_TIMEOUT;
}

/* Tries again if that may help: the write was lost, or the servo was not found. */
static bool try_again(struct baud_change *change, enum cds_result result)
{
    struct cds_identity *identity = &change->identity;

    if (result != CDS_TIMEOUT && result != CDS_CORRUPT)
        return false;
    if (++change->tries == BAUD_CHANGE_TRIES)
        return false;
    if (identity->state == CDS_IDENTITY_LOST && identity->is_written)
        return cds_identity_look_again(identity) == CDS_OK;
    change->phase = BEGIN;
    return identity->state == CDS_IDENTITY_LOST || identity->state == CDS_IDENTITY_UNCHANGED;
}

static void poll_servo(struct baud_change *change)
{
    struct cds_identity *identity = &change->identity;
    enum cds_result result = cds_identity_poll(identity);

    if (result == CDS_PENDING)
        return;
    if (result == CDS_CANCELLED) {
        record(change, CDS_IDENTITY_UNDECIDED, (uint8_t)result);
        change->outcome = CDS_CANCELLED;
        change->phase = FINISH;
    } else if (was_there(identity)) {
        record(change, CDS_IDENTITY_CHANGED, CDS_OK);
    } else if (!try_again(change, result)) {
        record(change, identity->state, (uint8_t)result);
    }
}

enum cds_result baud_change_poll(struct baud_change *change)
{
    uint8_t baud_reg = change->has_moved ? change->to_baud_reg : change->from_baud_reg;

    if (change->phase == BEGIN && change->index == change->count)
        change->phase = FINISH;
    switch (change->phase) {
    case BEGIN: begin_servo(change); return CDS_PENDING;
    case CHANGE: poll_servo(change); return CDS_PENDING;
    default:
        return cds_bus_set_baud(change->bus, baud_reg) == CDS_OK ? (enum cds_result)change->outcome
                                                                 : CDS_PENDING;
    }
}
