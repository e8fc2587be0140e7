/* Torque off for all; see stop.h. */
#include "cds55xx/stop.h"

#include <stddef.h>

#include "cds55xx/servo.h" // cds_servo_read(), cds_servo_write_byte()

enum stop_phase {
    TELL_ALL, // the next broadcast
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

static enum cds_result conclude(const struct cds_stop *stop)
{
    bool on = false, silent = false, mute = false;

    for (uint8_t i = 0; i < stop->roster->count; i++) {
        on = on || stop->outcomes[i] == CDS_STOP_ON;
        silent = silent || stop->outcomes[i] == CDS_STOP_SILENT;
        mute = mute || stop->outcomes[i] == CDS_STOP_MUTE;
    }
    return on ? CDS_REFUSED : silent ? CDS_TIMEOUT : mute ? CDS_NO_REPLY_DUE : CDS_OK;
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

/* What is to be sent in this phase, on its way. */
static enum cds_result submit(struct cds_stop *stop)
{
    struct cds_bus *bus = stop->roster->bus;
    struct cds_request *request = &stop->request;

    switch (stop->phase) {
    case TELL_ALL:
        return cds_servo_write_byte(bus, request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 0);
    case TELL:
        return cds_servo_write_byte(bus, request, servo_of(stop)->id, CDS_REG_TORQUE_ENABLE, 0);
    default: return cds_servo_read(bus, request, servo_of(stop)->id, CDS_REG_TORQUE_ENABLE, 1);
    }
}

static void send(struct cds_stop *stop)
{
    enum cds_result result = submit(stop);

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

    if (cds_request_byte(&stop->request, 0, &torque) != CDS_OK)
        settle(stop, CDS_STOP_SILENT);
    else
        settle(stop, torque ? CDS_STOP_ON : CDS_STOP_OFF);
}

/* Nothing went out, as the line was not quiet or somebody has opened the bus anew: once more. */
static void try_again(struct cds_stop *stop)
{
    stop->tries++;
    stop->phase--;
    if (stop->tries == CDS_STOP_TRIES)
        stop->result = CDS_LINE_BUSY;
}

static void told_all(struct cds_stop *stop)
{
    stop->broadcasts++;
    if (stop->broadcasts < CDS_STOP_BROADCASTS)
        stop->phase = TELL_ALL;
    else
        look_from(stop, 0);
}

/* What was on its way has ended. */
static void ended(struct cds_stop *stop)
{
    uint8_t result = stop->request.result;

    if (result == CDS_LINE_BUSY || result == CDS_CANCELLED ||
        (result != CDS_OK && stop->phase == TELLING_ALL))
        try_again(stop);
    else if (stop->phase == TELLING_ALL)
        told_all(stop);
    else if (stop->phase == TELLING)
        stop->phase = LOOK; // whatever it says to that
    else
        looked(stop);
}

static bool is_on_its_way(const struct cds_stop *stop)
{
    return stop->phase == TELLING_ALL || stop->phase == TELLING || stop->phase == LOOKING;
}

enum cds_result cds_stop_begin(struct cds_stop *stop, struct cds_roster *roster, uint8_t *outcomes)
{
    cds_roster_hold(roster, NULL, CDS_HOLD_STOPPED);
    if (stop->request.result == CDS_PENDING)
        return CDS_BUSY;
    *stop = (struct cds_stop){
        .roster = roster,
        .outcomes = outcomes,
        .request = {.urgent = true},
        .phase = TELL_ALL,
        .result = CDS_PENDING,
    };
    stop->request.packet.bytes = stop->buffer;
    stop->request.packet.room = sizeof stop->buffer;
    for (uint8_t i = 0; i < roster->count; i++)
        outcomes[i] = CDS_STOP_UNKNOWN;
    send(stop);
    return stop->result == CDS_PENDING ? CDS_OK : (enum cds_result)stop->result;
}

enum cds_result cds_stop_poll(struct cds_stop *stop)
{
    if (stop->result == CDS_PENDING && is_on_its_way(stop) && stop->request.result != CDS_PENDING)
        ended(stop);
    if (stop->result == CDS_PENDING && !is_on_its_way(stop))
        send(stop);
    return (enum cds_result)stop->result;
}
