/* SPDX-License-Identifier: MIT */
/* A change of ID or baud rate, and a RESET; see identity.h. */
#include "cds55xx/identity.h"

#include "bus/steps_internal.h" // cds_steps_poll()
#include "cds55xx/servo.h"      // cds_servo_ping(), cds_servo_write_byte(), cds_servo_reset()
#include "compiler.h"           // NOINLINE

#define LOOKS       3 // PINGs that must be silent before a place counts as empty
#define ID_OF_RESET 1 // a RESET leaves every servo there

enum identity_phase {
    LOOK_AT_TO,   // is the new place free?
    LOOK_AT_FROM, // is the servo at the old one?
    CHANGE,       // write, once
    LOOK_FOR_ARRIVAL,
    LOOK_FOR_LEAVING,
} __attribute__((packed));

static bool is_same_place(const struct cds_identity *identity)
{
    return identity->from.id == identity->to.id && identity->from.baud_reg == identity->to.baud_reg;
}

static bool looks_at_to(const struct cds_identity *identity)
{
    return identity->phase == LOOK_AT_TO || identity->phase == LOOK_FOR_ARRIVAL;
}

/* What a look sees is silence until a reply comes. */
static NOINLINE void enter(struct cds_identity *identity, enum identity_phase phase)
{
    identity->phase = (uint8_t)phase;
    identity->looks = 0;
    if (looks_at_to(identity))
        identity->at_to = CDS_TIMEOUT;
    else if (phase != CHANGE)
        identity->at_from = CDS_TIMEOUT;
}

static void begin_steps(struct cds_identity *identity, struct cds_bus *bus,
                        struct cds_request *request, enum identity_phase phase)
{
    cds_steps_begin_exclusive(&identity->steps, bus, request);
    identity->steps.lock.baud_reg = identity->from.baud_reg; // until the servo has left it
    identity->state = CDS_IDENTITY_UNDECIDED;
    enter(identity, phase);
}

/* CDS_OK, or CDS_BAD_ARGUMENT. Sets both places. */
static enum cds_result set_places(struct cds_identity *identity,
                                  const struct cds_identity_config *config)
{
    struct cds_identity_place *to = &identity->to;

    identity->from = *to = (struct cds_identity_place){config->id, config->bus->baud_reg};
    if (config->change == CDS_IDENTITY_ID)
        to->id = config->new_id;
    else if (config->change == CDS_IDENTITY_BAUD)
        to->baud_reg = config->new_baud_reg;
    else
        *to = (struct cds_identity_place){ID_OF_RESET, CDS_BAUD_1M};
    if (config->change == CDS_IDENTITY_RESET_ALL)
        identity->from.id = CDS_BROADCAST_ID;
    else if (identity->from.id > CDS_ID_MAX)
        return CDS_BAD_ARGUMENT;
    return to->id > CDS_ID_MAX || to->baud_reg > CDS_BAUD_MAX ||
                   config->change > CDS_IDENTITY_RESET_ALL
               ? CDS_BAD_ARGUMENT
               : CDS_OK;
}

/* A servo that is at its new place already is only looked for; a RESET is sent all the same. */
static enum identity_phase first_phase(const struct cds_identity *identity)
{
    if (identity->change == CDS_IDENTITY_RESET_ALL)
        return CHANGE;
    if (is_same_place(identity))
        return LOOK_AT_FROM;
    return LOOK_AT_TO;
}

enum cds_result cds_identity_begin(struct cds_identity *identity,
                                   const struct cds_identity_config *config)
{
    struct cds_identity begun = {
        .at_from = CDS_PENDING, .at_to = CDS_PENDING, .change = config->change};
    enum cds_result result = set_places(&begun, config);

    if (result == CDS_OK)
        result = cds_steps_check_exclusive(config->bus, config->request, CDS_PACKET_SIZE(2), 0);
    if (result != CDS_OK)
        return result;
    *identity = begun;
    begin_steps(identity, config->bus, config->request, first_phase(identity));
    return CDS_OK;
}

enum cds_result cds_identity_look_again(struct cds_identity *identity)
{
    struct cds_steps *steps = &identity->steps;
    enum cds_result result = CDS_BAD_ARGUMENT;

    if (identity->state == CDS_IDENTITY_LOST)
        result = cds_steps_check_exclusive(steps->bus, steps->request, 0, 0);
    if (result == CDS_OK)
        begin_steps(identity, steps->bus, steps->request, LOOK_FOR_ARRIVAL);
    return result;
}

void cds_identity_abort(struct cds_identity *identity)
{
    cds_steps_abort(&identity->steps);
}

/* The operation ends with the servo in this state. */
static NOINLINE void settle(struct cds_identity *identity, enum cds_identity_state state,
                            uint8_t reason)
{
    if (identity->steps.outcome != CDS_PENDING)
        return; // it was aborted
    identity->state = (uint8_t)state;
    if (state == CDS_IDENTITY_CHANGED || state == CDS_IDENTITY_BOTH)
        identity->steps.lock.baud_reg = identity->to.baud_reg;
    cds_steps_end(&identity->steps, (enum cds_result)reason);
}

/* Both places were looked at before the write. */
static void decide_before(struct cds_identity *identity)
{
    if (identity->at_to == CDS_OK || identity->at_to == CDS_CORRUPT)
        settle(identity, CDS_IDENTITY_TAKEN, CDS_REFUSED);
    else if (identity->at_from != CDS_OK)
        settle(identity, CDS_IDENTITY_LOST, identity->at_from);
    else if (identity->change < CDS_IDENTITY_RESET && is_same_place(identity))
        settle(identity, CDS_IDENTITY_CHANGED, CDS_OK); // it is there already
    else
        enter(identity, CHANGE);
}

/* Both places were looked at after the write, which has ended as identity->reason. */
static void decide_after(struct cds_identity *identity)
{
    uint8_t from = identity->at_from, to = identity->at_to, reason = identity->reason;

    if (to == CDS_OK && from == CDS_TIMEOUT)
        settle(identity, CDS_IDENTITY_CHANGED, CDS_OK);
    else if (to == CDS_OK)
        settle(identity, CDS_IDENTITY_BOTH, CDS_CORRUPT);
    else if (from == CDS_OK)
        settle(identity, CDS_IDENTITY_UNCHANGED, reason == CDS_OK ? CDS_TIMEOUT : reason);
    else
        settle(identity, CDS_IDENTITY_LOST,
               from == CDS_CORRUPT || to == CDS_CORRUPT ? CDS_CORRUPT : CDS_TIMEOUT);
}

/* Only the new place could be looked at after the write. */
static void decide_by_arrival(struct cds_identity *identity)
{
    uint8_t to = identity->at_to;

    if (to == CDS_TIMEOUT || (to == CDS_CORRUPT && identity->change != CDS_IDENTITY_RESET_ALL))
        settle(identity, CDS_IDENTITY_LOST, to);
    else if (identity->reason != CDS_OK)
        settle(identity, CDS_IDENTITY_UNCHANGED, identity->reason);
    else
        settle(identity, CDS_IDENTITY_CHANGED, to);
}

/* A PING has ended. Returns true if the look has: a good reply, or no PING left. */
static bool look_ended(struct cds_identity *identity, enum cds_result result)
{
    uint8_t *seen = looks_at_to(identity) ? &identity->at_to : &identity->at_from;

    identity->looks++;
    if (result == CDS_REFUSED) // the servo has replied
        result = CDS_OK;
    if (result == CDS_LINE_BUSY) // no silence was heard
        result = CDS_CORRUPT;
    if (result == CDS_OK || result == CDS_CORRUPT)
        *seen = (uint8_t)result;
    return result == CDS_OK || identity->looks == LOOKS;
}

static void write_ended(struct cds_identity *identity, enum cds_result result)
{
    const struct cds_request *request = identity->steps.request;

    identity->reason = (uint8_t)result;
    identity->is_written = !cds_was_not_sent((uint8_t)result);
    if (request->result == CDS_OK)
        identity->error = request->error;
    enter(identity, LOOK_FOR_ARRIVAL);
}

/* A packet was not sent: the submit was refused, or the line was never quiet for a PING before the
 * write. */
static void refused(struct cds_identity *identity, enum cds_result result)
{
    bool is_there = identity->phase == CHANGE && identity->at_from == CDS_OK;

    settle(identity, is_there ? CDS_IDENTITY_UNCHANGED : CDS_IDENTITY_UNDECIDED, (uint8_t)result);
}

/* The request was cancelled. If the bus was opened again, the packet may have left before. */
static void cancelled(struct cds_identity *identity)
{
    const struct cds_steps *steps = &identity->steps;

    identity->is_written |= identity->phase == CHANGE && steps->bus->lock != &steps->lock;
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_identity *identity = (struct cds_identity *)operation;

    if (result == CDS_CANCELLED) {
        cancelled(identity);
        return;
    }
    if (!identity->steps.is_submitted || (result == CDS_LINE_BUSY && identity->phase < CHANGE)) {
        refused(identity, result);
        return;
    }
    if (identity->phase == CHANGE) {
        write_ended(identity, result);
        return;
    }
    if (!look_ended(identity, result))
        return;
    switch (identity->phase) {
    case LOOK_AT_TO: enter(identity, LOOK_AT_FROM); break;
    case LOOK_AT_FROM: decide_before(identity); break;
    case LOOK_FOR_LEAVING: decide_after(identity); break;
    default:
        if (is_same_place(identity) || identity->change == CDS_IDENTITY_RESET_ALL)
            decide_by_arrival(identity);
        else
            enter(identity, LOOK_FOR_LEAVING);
    }
}

static enum cds_result send_write(struct cds_identity *identity)
{
    struct cds_bus *bus = identity->steps.bus;
    struct cds_request *request = identity->steps.request;
    uint8_t id = identity->from.id;

    if (identity->change == CDS_IDENTITY_ID)
        return cds_servo_write_byte(bus, request, id, CDS_REG_ID, identity->to.id);
    if (identity->change == CDS_IDENTITY_BAUD)
        return cds_servo_write_byte(bus, request, id, CDS_REG_BAUD_RATE, identity->to.baud_reg);
    return cds_servo_reset(bus, request, id);
}

/* True if a stale reply does no harm. Behind a PING of the same look, the stale reply tells the
 * same as the reply that is due. Behind PINGs of the other place, it has another ID or rate. Behind
 * the write, it may be the reply to the write: it would be taken for the reply to the PING. */
static bool ignores_stale(const struct cds_identity *identity)
{
    return identity->looks > 0 || (identity->phase < CHANGE && !is_same_place(identity));
}

static enum cds_result send(void *operation)
{
    struct cds_identity *identity = (struct cds_identity *)operation;
    struct cds_steps *steps = &identity->steps;
    const struct cds_identity_place *at = looks_at_to(identity) ? &identity->to : &identity->from;

    if (!cds_steps_set_baud(steps, at->baud_reg))
        return CDS_BUSY;
    steps->request->ignores_stale = ignores_stale(identity);
    if (identity->phase == CHANGE)
        return send_write(identity);
    return cds_servo_ping(steps->bus, steps->request, at->id);
}

enum cds_result cds_identity_poll(struct cds_identity *identity)
{
    return cds_steps_poll(&identity->steps, identity, send, ended);
}
