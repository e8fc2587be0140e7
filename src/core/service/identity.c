/* ID, baud rate and factory reset as transactions; see identity.h. */
#include "cds55xx/identity.h"

#include <stdbool.h>

#include "cds55xx/servo.h"     // cds_servo_ping(), cds_servo_write_byte(), cds_servo_reset()
#include "compiler.h"          // OPTIMIZER_BARRIER()
#include "service/operation.h" // cds_operation_take()

#define LOOKS   3    // PINGs that must be silent before a place counts as empty
#define RESET   0xFE // in place of a register's address
#define ID_1    1    // where RESET leaves a servo
#define NOWHERE CDS_TIMEOUT

enum identity_phase {
    TARGET,  // look at the new place: free?
    SOURCE,  // look at the old one: is the servo there?
    CHANGE,  // write, once
    ARRIVAL, // look at the new place
    LEAVING, // look at the old one
    SETTLE,  // the bus to the rate where the servo is
    OVER,
};

static bool same_place(const struct cds_identity *identity)
{
    return identity->from.id == identity->to.id && identity->from.baud == identity->to.baud;
}

static bool every_servo(const struct cds_identity *identity)
{
    return identity->from.id == CDS_BROADCAST_ID;
}

/* Is the new place being looked at, not the old one? */
static bool looks_ahead(const struct cds_identity *identity)
{
    return identity->phase == TARGET || identity->phase == ARRIVAL;
}

static void enter(struct cds_identity *identity, uint8_t phase)
{
    identity->phase = phase;
    identity->looks = 0;
    if (looks_ahead(identity))
        identity->at_to = NOWHERE;
    else if (phase == SOURCE || phase == LEAVING)
        identity->at_from = NOWHERE;
}

/* At the first poll. The bus waits as long as can be: what may be at the new place is not known. */
static void start(struct cds_identity *identity)
{
    identity->started = 1;
    identity->return_delay_us = cds_operation_take(identity->bus);
}

static enum cds_result begin(struct cds_identity *identity, struct cds_bus *bus,
                             struct cds_request *request, uint8_t id, struct cds_identity_place to,
                             uint8_t address)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (bus->byte_time_us == 0 || to.id > CDS_ID_MAX || to.baud > CDS_BAUD_MAX)
        return CDS_BAD_ARGUMENT;
    if (request->packet.room < CDS_PACKET_SIZE(2))
        return CDS_NO_ROOM;
    *identity = (struct cds_identity){
        .bus = bus,
        .request = request,
        .from = {id, bus->baud},
        .to = to,
        .at_from = CDS_PENDING,
        .at_to = CDS_PENDING,
        .address = address,
        .result = CDS_PENDING,
    };
    enter(identity, TARGET);
    return CDS_OK;
}

enum cds_result cds_identity_change_id_begin(struct cds_identity *identity, struct cds_bus *bus,
                                             struct cds_request *request, uint8_t id,
                                             uint8_t new_id)
{
    struct cds_identity_place to = {new_id, bus->baud};

    if (id > CDS_ID_MAX || id == new_id)
        return CDS_BAD_ARGUMENT;
    return begin(identity, bus, request, id, to, CDS_REG_ID);
}

enum cds_result cds_identity_change_baud_begin(struct cds_identity *identity, struct cds_bus *bus,
                                               struct cds_request *request, uint8_t id,
                                               uint8_t new_baud)
{
    struct cds_identity_place to = {id, new_baud};

    if (id > CDS_ID_MAX || new_baud == bus->baud)
        return CDS_BAD_ARGUMENT;
    return begin(identity, bus, request, id, to, CDS_REG_BAUD_RATE);
}

static enum cds_result begin_reset(struct cds_identity *identity, struct cds_bus *bus,
                                   struct cds_request *request, uint8_t id)
{
    struct cds_identity_place to = {ID_1, CDS_BAUD_1M};

    return begin(identity, bus, request, id, to, RESET);
}

enum cds_result cds_identity_reset_begin(struct cds_identity *identity, struct cds_bus *bus,
                                         struct cds_request *request, uint8_t id)
{
    enum cds_result result = CDS_BAD_ARGUMENT;

    if (id <= CDS_ID_MAX)
        result = begin_reset(identity, bus, request, id);
    if (result == CDS_OK && same_place(identity)) {
        identity->at_to = CDS_PENDING; // there is no other place that could be taken
        enter(identity, SOURCE);
    }
    return result;
}

enum cds_result cds_identity_reset_all_begin(struct cds_identity *identity, struct cds_bus *bus,
                                             struct cds_request *request)
{
    enum cds_result result = begin_reset(identity, bus, request, CDS_BROADCAST_ID);

    if (result == CDS_OK) {
        identity->at_to = CDS_PENDING;
        enter(identity, CHANGE);
    }
    return result;
}

enum cds_result cds_identity_look_again(struct cds_identity *identity)
{
    if (identity->state != CDS_IDENTITY_LOST)
        return CDS_BAD_ARGUMENT;
    if (identity->request->result == CDS_PENDING)
        return CDS_BUSY;
    identity->started = 0;
    identity->result = CDS_PENDING;
    identity->state = CDS_IDENTITY_UNDECIDED;
    enter(identity, ARRIVAL);
    return CDS_OK;
}

static NOINLINE void settle(struct cds_identity *identity, enum cds_identity_state state,
                            enum cds_result reason)
{
    identity->state = (uint8_t)state;
    identity->reason = (uint8_t)reason;
    enter(identity, SETTLE);
}

/* Nothing has been written so far: go ahead? */
static void decide_before(struct cds_identity *identity)
{
    if (identity->at_to != CDS_PENDING && identity->at_to != NOWHERE)
        settle(identity, CDS_IDENTITY_TAKEN, CDS_REFUSED);
    else if (identity->at_from != CDS_OK)
        settle(identity, CDS_IDENTITY_LOST, (enum cds_result)identity->at_from);
    else
        enter(identity, CHANGE);
}

/* What became of the write: identity->reason, from its answer; and where the servo is, from what
 * answers. */
static void decide_after(struct cds_identity *identity)
{
    uint8_t here = identity->at_from, there = identity->at_to, reason = identity->reason;

    if (there == CDS_OK && here == NOWHERE)
        settle(identity, CDS_IDENTITY_CHANGED, CDS_OK);
    else if (there == CDS_OK)
        settle(identity, CDS_IDENTITY_BOTH, CDS_CORRUPT);
    else if (here == CDS_OK)
        settle(identity, CDS_IDENTITY_UNCHANGED,
               reason == CDS_OK ? CDS_TIMEOUT : (enum cds_result)reason);
    else
        settle(identity, CDS_IDENTITY_LOST,
               here == CDS_CORRUPT || there == CDS_CORRUPT ? CDS_CORRUPT : CDS_TIMEOUT);
}

/* There was one place to look at only. */
static void decide_alone(struct cds_identity *identity)
{
    enum cds_result there = (enum cds_result)identity->at_to;
    enum cds_result reason = (enum cds_result)identity->reason;

    if (there == CDS_TIMEOUT || (there == CDS_CORRUPT && !every_servo(identity)))
        settle(identity, CDS_IDENTITY_LOST, there);
    else if (reason != CDS_OK)
        settle(identity, CDS_IDENTITY_UNCHANGED, reason);
    else
        settle(identity, CDS_IDENTITY_CHANGED, there);
}

/* One PING of a look is over. True when the look is: a good answer, or none left to try. */
static bool looked(struct cds_identity *identity)
{
    uint8_t result = identity->request->result;

    identity->looks++;
    if (result == CDS_LINE_BUSY) // then silence is not to be had
        result = CDS_CORRUPT;
    if (result == CDS_OK || result == CDS_CORRUPT) {
        if (looks_ahead(identity))
            identity->at_to = result;
        else
            identity->at_from = result;
    }
    return result == CDS_OK || identity->looks == LOOKS;
}

static void changed(struct cds_identity *identity)
{
    const struct cds_request *request = identity->request;

    identity->reason = request->result;
    identity->written = !cds_was_not_sent(request->result);
    if (request->result == CDS_OK)
        identity->error = request->error;
    if (identity->error & CDS_ERRORS_OF_PACKET)
        identity->reason = CDS_REFUSED;
    enter(identity, ARRIVAL);
}

static void exchange_ended(struct cds_identity *identity)
{
    if (identity->phase == CHANGE)
        changed(identity);
    else if (!looked(identity))
        return;
    else if (identity->phase == TARGET)
        enter(identity, SOURCE);
    else if (identity->phase == SOURCE)
        decide_before(identity);
    else if (identity->phase == LEAVING)
        decide_after(identity);
    else if (same_place(identity) || every_servo(identity))
        decide_alone(identity);
    else
        enter(identity, LEAVING);
}

static const struct cds_identity_place *place(const struct cds_identity *identity)
{
    bool there = looks_ahead(identity);

    if (identity->phase == SETTLE)
        there = identity->state == CDS_IDENTITY_CHANGED || identity->state == CDS_IDENTITY_BOTH;
    return there ? &identity->to : &identity->from;
}

static enum cds_result change(struct cds_identity *identity)
{
    uint8_t id = identity->from.id, address = identity->address;

    if (address == RESET)
        return cds_servo_reset(identity->bus, identity->request, id);
    return cds_servo_write_byte(identity->bus, identity->request, id, address,
                                address == CDS_REG_ID ? identity->to.id : identity->to.baud);
}

static void finish(struct cds_identity *identity, uint8_t result)
{
    if (cds_operation_has(identity->bus)) // else it is somebody else's
        cds_bus_set_return_delay(identity->bus, identity->return_delay_us);
    identity->request->skips_rest = false;
    identity->result = result;
    identity->phase = OVER;
}

/* The bus's observer does not let it through, so nothing was sent. */
static void refused(struct cds_identity *identity, enum cds_result result)
{
    enum cds_identity_state state = CDS_IDENTITY_UNDECIDED;

    if (identity->phase == CHANGE && identity->at_from == CDS_OK)
        state = CDS_IDENTITY_UNCHANGED;
    settle(identity, state, result);
}

/* Does a stale reply do no harm? Behind another look at the same place it says the same as the
 * reply that is due. The first look at a place comes behind those at another one, whose replies
 * differ in ID or rate: but not behind the write, whose own reply may be late. */
static bool skips_rest(const struct cds_identity *identity)
{
    return identity->looks > 0 || (identity->phase < CHANGE && !same_place(identity));
}

static void go_on(struct cds_identity *identity)
{
    const struct cds_identity_place *at = place(identity);
    struct cds_bus *bus = identity->bus;
    enum cds_result submitted;

    if (!cds_operation_tune(bus, at->baud))
        return; // someone else's request: later
    if (identity->phase == SETTLE) {
        finish(identity, identity->reason);
        return;
    }
    identity->request->skips_rest = skips_rest(identity);
    submitted = identity->phase == CHANGE ? change(identity)
                                          : cds_servo_ping(bus, identity->request, at->id);
    identity->in_flight = submitted == CDS_OK;
    if (submitted != CDS_OK && submitted != CDS_BUSY)
        refused(identity, submitted);
    else if (submitted == CDS_OK && identity->phase == CHANGE)
        identity->written = 1;
}

/* Its request was, while it waited: what is on the wire is not cancelled. */
static void cancelled(struct cds_identity *identity)
{
    if (identity->phase == CHANGE)
        identity->written = 0;
    settle(identity, CDS_IDENTITY_UNDECIDED, CDS_CANCELLED);
}

enum cds_result cds_identity_poll(struct cds_identity *identity)
{
    OPTIMIZER_BARRIER(identity);
    if (identity->result != CDS_PENDING)
        return (enum cds_result)identity->result;
    if (identity->started && !cds_operation_has(identity->bus)) {
        finish(identity, CDS_CANCELLED);
        return CDS_CANCELLED;
    }
    if (identity->in_flight) {
        if (identity->request->result == CDS_PENDING)
            return CDS_PENDING;
        identity->in_flight = 0;
        if (identity->request->result == CDS_CANCELLED)
            cancelled(identity);
        else
            exchange_ended(identity);
    }
    if (!identity->started)
        start(identity);
    go_on(identity);
    return (enum cds_result)identity->result;
}
