/* SPDX-License-Identifier: MIT */
/* Torque off for all; see torque_off.h. */
#include "cds55xx/torque_off.h"

#include "bus/bus_internal.h"      // CDS_LINE_WAIT_US
#include "bus/steps_internal.h"    // cds_steps_poll()
#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/servo.h"         // cds_servo_read(), cds_servo_write_byte()
#include "compiler.h"              // OPTIMIZER_BARRIER(), NOINLINE

enum phase {
    TELL_ALL, // broadcasts
    READ,     // TORQUE_ENABLE of a servo
    TELL,     // a servo that is not known to be off; then READ
} __attribute__((packed));

/* Aborts an operation at another rate than the servos' own; it restores the rate now, or when its
 * transaction on the wire has ended. True if the bus has the servos' own rate. */
static bool claim_own_rate(const struct cds_bus *bus)
{
    const struct cds_bus_lock *lock = bus->lock;

    if (!lock || lock->baud_reg == bus->baud_reg)
        return true;
    lock->abort(lock->context);
    return lock->baud_reg == bus->baud_reg;
}

static void take_back(struct cds_torque_off *off)
{
    cds_bus_cancel(off->servos->bus, &off->requests[0]);
    cds_bus_cancel(off->servos->bus, &off->requests[1]);
}

/* ---- all servos ---- */

/* Submits the next broadcast in `request`, if one is due. */
static void tell_next(struct cds_torque_off *off, struct cds_request *request)
{
    struct cds_bus *bus = off->servos->bus;
    uint8_t reg = CDS_REG_TORQUE_ENABLE;
    enum cds_result result;

    if (off->submitted >= CDS_TORQUE_OFF_BROADCASTS)
        reg = CDS_REG_REGISTERED_INSTRUCTION;
    if (off->submitted == CDS_TORQUE_OFF_BROADCASTS + CDS_TORQUE_OFF_CLEARS || !claim_own_rate(bus))
        return;
    result = cds_servo_write_byte(bus, request, CDS_BROADCAST_ID, reg, 0);
    if (result == CDS_OK)
        off->submitted++;
    else if (result == CDS_BAD_ARGUMENT)
        cds_steps_end(&off->steps, result);
}

static bool is_torque_broadcast(const struct cds_request *request)
{
    const uint8_t *bytes = request->packet.bytes;

    return bytes[CDS_AT_ID] == CDS_BROADCAST_ID &&
           bytes[CDS_AT_PARAMETERS] == CDS_REG_TORQUE_ENABLE;
}

#define LINE_WAIT_UNIT_US 56 // of line_wait: then each byte time of the wait counts as one
_Static_assert(CDS_LINE_WAIT_BYTES == LINE_WAIT_UNIT_US, "on_end() adds one byte time");

/* A request has ended. If it was a broadcast, the next broadcast is submitted behind that of the
 * other request. */
static void on_end(struct cds_request *request)
{
    struct cds_torque_off *off = (struct cds_torque_off *)request->context;

    if (request->result == CDS_LINE_BUSY) {
        off->line_wait = (uint16_t)(off->line_wait + off->servos->bus->byte_time_us +
                                    (CDS_LINE_WAIT_US + LINE_WAIT_UNIT_US / 2) / LINE_WAIT_UNIT_US);
        return;
    }
    if (is_torque_broadcast(request))
        off->broadcasts++;
    if (off->steps.outcome == CDS_PENDING)
        tell_next(off, request);
}

/* Submits what was not sent. True if all broadcasts were sent. */
static bool tell_all(struct cds_torque_off *off)
{
    struct cds_bus *bus = off->servos->bus;
    bool is_done = true;

    if (off->requests[0].result == CDS_PENDING && off->requests[1].result == CDS_PENDING)
        return false;
    for (struct cds_request *request = off->requests; request < off->requests + 2; request++) {
        bool is_unsent = request->result == CDS_LINE_BUSY || request->result == CDS_CANCELLED;

        if (!is_unsent)
            tell_next(off, request);
        else if (claim_own_rate(bus))
            cds_bus_submit(bus, request);
        if (is_unsent || request->result == CDS_PENDING)
            is_done = false;
    }
    return is_done && off->submitted == CDS_TORQUE_OFF_BROADCASTS + CDS_TORQUE_OFF_CLEARS;
}

/* ---- one servo after the other ---- */

static struct cds_servo_state *servo_of(const struct cds_torque_off *off)
{
    return &off->servos->states[off->index];
}

/* By the worst outcome: from CDS_TORQUE_OFF_ON on a lower number is worse. */
static enum cds_result conclude(const struct cds_servos *servos)
{
    const struct cds_servo_state *servo = servos->states;
    uint8_t worst = UINT8_MAX;

    for (uint8_t i = servos->count; i; i--, servo++) {
        uint8_t outcome = servo->torque_off;

        if (outcome >= CDS_TORQUE_OFF_ON && outcome < worst)
            worst = outcome;
    }
    if (worst == CDS_TORQUE_OFF_ON) // no switch: its table would be in RAM
        return CDS_REFUSED;
    if (worst == CDS_TORQUE_OFF_SILENT)
        return CDS_TIMEOUT;
    return worst == CDS_TORQUE_OFF_MUTE ? CDS_NO_REPLY_DUE : CDS_OK;
}

/* Chooses the next servo to read, from `index` on, round after round: a silent servo does not hold
 * up the others. */
static void choose_from(struct cds_torque_off *off, uint8_t index)
{
    for (; off->round < CDS_TORQUE_OFF_ROUNDS; off->round++) {
        for (; index < off->servos->count; index++) {
            uint8_t outcome = off->servos->states[index].torque_off;

            if (outcome == CDS_TORQUE_OFF_OFF || outcome == CDS_TORQUE_OFF_MUTE)
                continue;
            off->index = index;
            off->phase = off->round == 0 ? READ : TELL;
            return;
        }
        index = 0;
    }
    cds_steps_end(&off->steps, conclude(off->servos));
}

static void settle(struct cds_torque_off *off, uint8_t outcome)
{
    servo_of(off)->torque_off = outcome & 7u;
    choose_from(off, (uint8_t)(off->index + 1u));
}

static enum cds_result send(void *operation)
{
    struct cds_torque_off *off = (struct cds_torque_off *)operation;
    struct cds_bus *bus = off->servos->bus;
    uint8_t id;

    if (off->line_wait >= CDS_TORQUE_OFF_LINE_WAIT) {
        take_back(off);
        cds_steps_end(&off->steps, CDS_LINE_BUSY);
        return CDS_BUSY;
    }
    if (off->phase == TELL_ALL && tell_all(off))
        choose_from(off, 0);
    if (off->phase == TELL_ALL || !claim_own_rate(bus))
        return CDS_BUSY;
    off->requests->servo_index = off->index;
    id = servo_of(off)->id;
    if (off->phase == TELL)
        return cds_servo_write_byte(bus, off->requests, id, CDS_REG_TORQUE_ENABLE, 0);
    return cds_servo_read(bus, off->requests, id, CDS_REG_TORQUE_ENABLE, 1);
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_torque_off *off = (struct cds_torque_off *)operation;
    uint8_t torque = 0;

    if (result == CDS_LINE_BUSY || result == CDS_CANCELLED)
        return; // the step is sent again
    if (result == CDS_BAD_ARGUMENT)
        cds_steps_end(&off->steps, result);
    else if (result == CDS_NO_REPLY_DUE)
        settle(off, CDS_TORQUE_OFF_MUTE);
    else if (off->phase == TELL)
        off->phase = READ; // whatever the servo answered
    else if (cds_request_byte(off->requests, 0, &torque) != CDS_OK)
        settle(off, CDS_TORQUE_OFF_SILENT);
    else
        settle(off, torque ? CDS_TORQUE_OFF_ON : CDS_TORQUE_OFF_OFF);
}

/* ---- */

/* Submits the first broadcast in `request`, unless its packet is on the wire since the last begin.
 * The other fields of the request are 0. NOINLINE: saves 40 bytes. */
static NOINLINE void take_up(struct cds_torque_off *off, struct cds_request *request,
                             uint8_t *packet)
{
    if (request->result == CDS_PENDING)
        return;
    request->packet.bytes = packet;
    request->packet.capacity = sizeof off->packets[0];
    request->reply = &off->reply;
    request->reply_capacity = 1;
    request->priority = CDS_PRIORITY_TORQUE_OFF;
    request->passes_lock = true;
    request->on_end = on_end;
    request->context = off;
    tell_next(off, request);
}

enum cds_result cds_torque_off_begin(struct cds_torque_off *off, struct cds_servos *servos)
{
    struct cds_servo_state *servo;

    OPTIMIZER_BARRIER(off);
    cds_servos_inhibit_all(servos);
    off->servos = servos;
    if (off->requests[0].result == CDS_PENDING || off->requests[1].result == CDS_PENDING)
        take_back(off); // of the last begin; what is on the wire stays
    off->line_wait = 0;
    off->broadcasts = off->submitted = off->round = 0;
    off->phase = TELL_ALL;
    take_up(off, &off->requests[0], off->packets[0]); // before all that can wait
    cds_steps_begin(&off->steps, servos->bus, off->requests);
    take_up(off, &off->requests[1], off->packets[1]);
    servo = servos->states; // not before: the loop is 20 us shorter
    for (uint8_t i = servos->count; i; i--, servo++)
        servo->torque_off = CDS_TORQUE_OFF_UNKNOWN;
    return off->steps.outcome == CDS_PENDING ? CDS_OK : CDS_BAD_ARGUMENT;
}

enum cds_result cds_torque_off_poll(struct cds_torque_off *off)
{
    return cds_steps_poll(&off->steps, off, send, ended);
}

void cds_torque_off_abort(struct cds_torque_off *off)
{
    if (off->steps.result != CDS_PENDING)
        return;
    take_back(off);
    cds_steps_abort(&off->steps);
}
