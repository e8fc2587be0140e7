/* Torque off for all; see torque_off.h. */
#include "cds55xx/torque_off.h"

#include <stddef.h>

#include "cds55xx/servo.h" // cds_servo_read(), cds_servo_write_byte()
#include "compiler.h"      // OPTIMIZER_BARRIER(), NOINLINE

enum stop_phase {
    TELLING_ALL,
    TELL, // one that is not known to be off
    TELLING,
    LOOK, // at its torque
    LOOKING,
};

static struct cds_servo_state *servo_of(const struct cds_torque_off *stop)
{
    return &stop->roster->servos[stop->index];
}

static bool is_settled(uint8_t outcome)
{
    return outcome == CDS_TORQUE_OFF_OFF || outcome == CDS_TORQUE_OFF_MUTE;
}

/* By the worst of them: from CDS_TORQUE_OFF_ON on, a lower number is worse. */
static enum cds_result conclude(const struct cds_torque_off *stop)
{
    const struct cds_servo_state *servo = stop->roster->servos;
    uint8_t worst = UINT8_MAX;

    for (uint8_t i = stop->roster->count; i; i--, servo++) {
        uint8_t outcome = servo->stopped;

        if (outcome >= CDS_TORQUE_OFF_ON && outcome < worst)
            worst = outcome;
    }
    if (worst == CDS_TORQUE_OFF_ON) // not by a switch: a table for it would stand in RAM
        return CDS_REFUSED;
    if (worst == CDS_TORQUE_OFF_SILENT)
        return CDS_TIMEOUT;
    return worst == CDS_TORQUE_OFF_MUTE ? CDS_NO_REPLY_DUE : CDS_OK;
}

/* The next one to look at, from `index` on: round after round, so that one that is dead does not
 * hold up the others. */
static void look_from(struct cds_torque_off *stop, uint8_t index)
{
    for (; stop->round < CDS_TORQUE_OFF_ROUNDS; stop->round++) {
        for (; index < stop->roster->count; index++) {
            if (!is_settled(stop->roster->servos[index].stopped)) {
                stop->index = index;
                stop->phase = stop->round == 0 ? LOOK : TELL;
                return;
            }
        }
        index = 0;
    }
    stop->result = (uint8_t)conclude(stop);
}

static void settle(struct cds_torque_off *stop, enum cds_torque_off_outcome outcome)
{
    servo_of(stop)->stopped = outcome & 7u;
    look_from(stop, (uint8_t)(stop->index + 1u));
}

static void give_up(struct cds_torque_off *stop, enum cds_result result)
{
    cds_bus_cancel(stop->roster->bus, &stop->requests[0]);
    cds_bus_cancel(stop->roster->bus, &stop->requests[1]);
    stop->result = (uint8_t)result;
}

/* Nothing went out, as the line was not quiet or somebody has opened the bus anew. May it be tried
 * once more? */
static NOINLINE bool may_try_again(struct cds_torque_off *stop)
{
    stop->tries++;
    if (stop->tries == CDS_TORQUE_OFF_TRIES)
        give_up(stop, CDS_LINE_BUSY);
    return stop->tries < CDS_TORQUE_OFF_TRIES;
}

/* ---- all ---- */

static bool is_broadcast(const struct cds_request *request, uint8_t reg)
{
    const uint8_t *bytes = request->packet.bytes;

    return bytes[CDS_AT_ID] == CDS_BROADCAST_ID && bytes[CDS_AT_PARAMETERS] == reg;
}

/* Are more broadcasts of this register due than went out (`count`) or are on their way? */
static NOINLINE bool is_due(const struct cds_torque_off *stop, uint8_t reg, uint8_t count,
                            uint8_t due)
{
    const struct cds_request *request = stop->requests;

    for (uint8_t i = 2; i; i--, request++)
        if (request->result == CDS_PENDING && is_broadcast(request, reg))
            count++;
    return count < due;
}

/* What all are to be told next: first torque off, then to forget registered writes; 0: nothing. */
static uint8_t due_register(const struct cds_torque_off *stop)
{
    if (is_due(stop, CDS_REG_TORQUE_ENABLE, stop->broadcasts, CDS_TORQUE_OFF_BROADCASTS))
        return CDS_REG_TORQUE_ENABLE;
    if (is_due(stop, CDS_REG_REGISTERED_INSTRUCTION, stop->clears, CDS_TORQUE_OFF_CLEARS))
        return CDS_REG_REGISTERED_INSTRUCTION;
    return 0;
}

static NOINLINE void tell_all(struct cds_torque_off *stop, struct cds_request *request)
{
    uint8_t reg = due_register(stop);
    enum cds_result result;

    if (!reg)
        return;
    result = cds_servo_write_byte(stop->roster->bus, request, CDS_BROADCAST_ID, reg, 0);
    if (result != CDS_OK && result != CDS_BUSY) // on its way since the stop was begun before
        stop->result = (uint8_t)result;
}

/* A broadcast has ended. The other request is on the wire or next, so this request, submitted
 * again, goes right behind it. cds_torque_off_poll() repeats a request that was not sent. */
static void on_end(struct cds_request *request)
{
    struct cds_torque_off *stop = (struct cds_torque_off *)request->owner;

    if (stop->result != CDS_PENDING || request->result == CDS_LINE_BUSY)
        return;
    if (is_broadcast(request, CDS_REG_TORQUE_ENABLE))
        stop->broadcasts++;
    if (is_broadcast(request, CDS_REG_REGISTERED_INSTRUCTION))
        stop->clears++;
    tell_all(stop, request);
}

static void telling_all(struct cds_torque_off *stop)
{
    struct cds_request *request = stop->requests;

    for (uint8_t i = 2; i && stop->result == CDS_PENDING; i--, request++)
        if (request->result != CDS_PENDING && due_register(stop) && may_try_again(stop))
            tell_all(stop, request);
    if (stop->broadcasts >= CDS_TORQUE_OFF_BROADCASTS && stop->clears >= CDS_TORQUE_OFF_CLEARS)
        look_from(stop, 0);
}

/* ---- one after the other ---- */

static void send(struct cds_torque_off *stop)
{
    struct cds_bus *bus = stop->roster->bus;
    uint8_t id = servo_of(stop)->id;
    enum cds_result result;

    if (stop->phase == TELL)
        result = cds_servo_write_byte(bus, stop->requests, id, CDS_REG_TORQUE_ENABLE, 0);
    else
        result = cds_servo_read(bus, stop->requests, id, CDS_REG_TORQUE_ENABLE, 1);
    if (result == CDS_OK)
        stop->phase++; // what it is, on its way
    else if (result == CDS_NO_REPLY_DUE)
        settle(stop, CDS_TORQUE_OFF_MUTE);
    else if (result != CDS_BUSY)
        stop->result = (uint8_t)result;
}

static void looked(struct cds_torque_off *stop)
{
    uint8_t torque = 0;

    if (cds_request_byte(stop->requests, 0, &torque) != CDS_OK)
        settle(stop, CDS_TORQUE_OFF_SILENT);
    else
        settle(stop, torque ? CDS_TORQUE_OFF_ON : CDS_TORQUE_OFF_OFF);
}

/* What was on its way to one has ended. */
static void ended(struct cds_torque_off *stop)
{
    uint8_t result = stop->requests[0].result;

    if (result == CDS_LINE_BUSY || result == CDS_CANCELLED) {
        if (may_try_again(stop))
            stop->phase--;
    } else if (stop->phase == TELLING) {
        stop->phase = LOOK; // whatever it says to that
    } else {
        looked(stop);
    }
}

static bool is_on_its_way(const struct cds_torque_off *stop)
{
    return stop->phase == TELLING || stop->phase == LOOKING;
}

/* Submits one of the two for the first time. A request that is still pending keeps its fields: they
 * are the same. */
static NOINLINE void take_up(struct cds_torque_off *stop, struct cds_request *request,
                             uint8_t *bytes)
{
    if (request->result != CDS_PENDING)
        *request = (struct cds_request){.packet = {.bytes = bytes, .room = CDS_PACKET_SIZE(2)},
                                        .on_end = on_end,
                                        .owner = stop,
                                        .urgent = CDS_URGENT_FIRST};
    tell_all(stop, request);
}

enum cds_result cds_torque_off_begin(struct cds_torque_off *stop, struct cds_servos *roster)
{
    struct cds_servo_state *servo = roster->servos;

    OPTIMIZER_BARRIER(stop);
    cds_servos_hold(roster, NULL, CDS_INHIBIT_STOPPED);
    cds_bus_set_queue(roster->bus, true);        // whatever is going on
    cds_bus_cancel(roster->bus, stop->requests); // a look, if it waits: all are to be told first
    stop->roster = roster;
    stop->tries = 0;
    stop->broadcasts = 0;
    stop->clears = 0;
    stop->round = 0;
    stop->phase = TELLING_ALL;
    stop->result = CDS_PENDING;
    for (uint8_t i = roster->count; i; i--, servo++)
        servo->stopped = CDS_TORQUE_OFF_UNKNOWN;
    take_up(stop, &stop->requests[0], stop->buffers[0]);
    take_up(stop, &stop->requests[1], stop->buffers[1]);
    return stop->result == CDS_PENDING ? CDS_OK : CDS_BAD_ARGUMENT;
}

enum cds_result cds_torque_off_poll(struct cds_torque_off *stop)
{
    OPTIMIZER_BARRIER(stop);
    if (stop->result != CDS_PENDING)
        return (enum cds_result)stop->result;
    if (stop->phase == TELLING_ALL)
        telling_all(stop);
    else if (is_on_its_way(stop) && stop->requests[0].result != CDS_PENDING)
        ended(stop);
    if (stop->result == CDS_PENDING && (stop->phase == TELL || stop->phase == LOOK))
        send(stop);
    return (enum cds_result)stop->result;
}
