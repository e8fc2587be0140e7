/* Torque off for all; see stop.h. */
#include "cds55xx/stop.h"

#include <stddef.h>

#include "cds55xx/servo.h" // cds_servo_read(), cds_servo_write_byte()
#include "opaque.h"        // CDS_APART

enum stop_phase {
    TELLING_ALL,
    TELL, // one that is not known to be off
    TELLING,
    LOOK, // at its torque
    LOOKING,
};

static const struct cds_roster_servo *servo_of(const struct cds_stop *stop)
{
    return &stop->roster->servos[stop->index];
}

static bool is_settled(uint8_t outcome)
{
    return outcome == CDS_STOP_OFF || outcome == CDS_STOP_MUTE;
}

/* By the worst of them: from CDS_STOP_ON on, the less the worse. */
static enum cds_result conclude(const struct cds_stop *stop)
{
    uint8_t worst = UINT8_MAX;

    for (uint8_t i = 0; i < stop->roster->count; i++) {
        uint8_t outcome = stop->outcomes[i];

        if (outcome >= CDS_STOP_ON && outcome < worst)
            worst = outcome;
    }
    switch (worst) {
    case CDS_STOP_ON: return CDS_REFUSED;
    case CDS_STOP_SILENT: return CDS_TIMEOUT;
    case CDS_STOP_MUTE: return CDS_NO_REPLY_DUE;
    default: return CDS_OK;
    }
}

/* The next one to look at, from `index` on: round after round, so that one that is dead does not
 * hold up the others. */
static void look_from(struct cds_stop *stop, uint8_t index)
{
    for (; stop->round < CDS_STOP_ROUNDS; stop->round++) {
        for (; index < stop->roster->count; index++) {
            if (!is_settled(stop->outcomes[index])) {
                stop->index = index;
                stop->phase = stop->round == 0 ? LOOK : TELL;
                return;
            }
        }
        index = 0;
    }
    stop->result = (uint8_t)conclude(stop);
}

static void settle(struct cds_stop *stop, enum cds_stop_outcome outcome)
{
    stop->outcomes[stop->index] = (uint8_t)outcome;
    look_from(stop, (uint8_t)(stop->index + 1u));
}

static void give_up(struct cds_stop *stop, enum cds_result result)
{
    for (struct cds_request *each = stop->all; each < stop->all + CDS_STOP_BROADCASTS; each++)
        cds_bus_cancel(stop->roster->bus, each);
    stop->result = (uint8_t)result;
}

/* Nothing went out, as the line was not quiet or somebody has opened the bus anew. May it be tried
 * once more? */
static bool may_try_again(struct cds_stop *stop)
{
    stop->tries++;
    if (stop->tries == CDS_STOP_TRIES)
        give_up(stop, CDS_LINE_BUSY);
    return stop->tries < CDS_STOP_TRIES;
}

/* ---- all ---- */

static void tell_all(struct cds_stop *stop, struct cds_request *request)
{
    enum cds_result result = cds_servo_write_byte(stop->roster->bus, request, CDS_BROADCAST_ID,
                                                  CDS_REG_TORQUE_ENABLE, 0);

    if (result != CDS_OK && result != CDS_BUSY) // on its way since the stop was begun before
        stop->result = (uint8_t)result;
}

static void telling_all(struct cds_stop *stop)
{
    struct cds_request *request = stop->all, *end = request + CDS_STOP_BROADCASTS;

    stop->broadcasts = 0;
    for (; request < end && stop->result == CDS_PENDING; request++) {
        if (request->result == CDS_OK)
            stop->broadcasts++;
        else if (request->result != CDS_PENDING && may_try_again(stop))
            tell_all(stop, request);
    }
    if (stop->broadcasts == CDS_STOP_BROADCASTS)
        look_from(stop, 0);
}

/* ---- one after the other ---- */

static void send(struct cds_stop *stop)
{
    struct cds_bus *bus = stop->roster->bus;
    uint8_t id = servo_of(stop)->id;
    enum cds_result result;

    if (stop->phase == TELL)
        result = cds_servo_write_byte(bus, &stop->one, id, CDS_REG_TORQUE_ENABLE, 0);
    else
        result = cds_servo_read(bus, &stop->one, id, CDS_REG_TORQUE_ENABLE, 1);
    if (result == CDS_OK)
        stop->phase++; // what it is, on its way
    else if (result == CDS_NO_REPLY_DUE)
        settle(stop, CDS_STOP_MUTE);
    else if (result != CDS_BUSY)
        stop->result = (uint8_t)result;
}

static void looked(struct cds_stop *stop)
{
    uint8_t torque = 0;

    if (cds_request_byte(&stop->one, 0, &torque) != CDS_OK)
        settle(stop, CDS_STOP_SILENT);
    else
        settle(stop, torque ? CDS_STOP_ON : CDS_STOP_OFF);
}

/* What was on its way to one has ended. */
static void ended(struct cds_stop *stop)
{
    uint8_t result = stop->one.result;

    if (result == CDS_LINE_BUSY || result == CDS_CANCELLED) {
        if (may_try_again(stop))
            stop->phase--;
    } else if (stop->phase == TELLING) {
        stop->phase = LOOK; // whatever it says to that
    } else {
        looked(stop);
    }
}

static bool is_on_its_way(const struct cds_stop *stop)
{
    return stop->phase == TELLING || stop->phase == LOOKING;
}

/* One that is on its way still is what it is to be already. */
static CDS_APART void prepare(struct cds_request *request, uint8_t bytes[CDS_PACKET_SIZE(2)])
{
    if (request->result != CDS_PENDING)
        *request = (struct cds_request){.packet = {.bytes = bytes, .room = CDS_PACKET_SIZE(2)},
                                        .urgent = CDS_URGENT_FIRST};
}

enum cds_result cds_stop_begin(struct cds_stop *stop, struct cds_roster *roster, uint8_t *outcomes)
{
    cds_roster_hold(roster, NULL, CDS_HOLD_STOPPED);
    cds_bus_cancel(roster->bus, &stop->one); // of a stop under way, if it waits: to be told first
    stop->roster = roster;
    stop->outcomes = outcomes;
    stop->tries = 0;
    stop->broadcasts = 0;
    stop->round = 0;
    stop->phase = TELLING_ALL;
    stop->result = CDS_PENDING;
    for (uint8_t i = 0; i < roster->count; i++)
        outcomes[i] = CDS_STOP_UNKNOWN;
    prepare(&stop->one, stop->buffers[CDS_STOP_BROADCASTS]);
    for (uint8_t i = 0; i < CDS_STOP_BROADCASTS; i++) {
        prepare(&stop->all[i], stop->buffers[i]);
        tell_all(stop, &stop->all[i]);
    }
    return stop->result == CDS_PENDING ? CDS_OK : CDS_BAD_ARGUMENT;
}

enum cds_result cds_stop_poll(struct cds_stop *stop)
{
    if (stop->result != CDS_PENDING)
        return (enum cds_result)stop->result;
    if (stop->phase == TELLING_ALL)
        telling_all(stop);
    else if (is_on_its_way(stop) && stop->one.result != CDS_PENDING)
        ended(stop);
    if (stop->result == CDS_PENDING && (stop->phase == TELL || stop->phase == LOOK))
        send(stop);
    return (enum cds_result)stop->result;
}
