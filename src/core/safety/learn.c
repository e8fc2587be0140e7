/* SPDX-License-Identifier: MIT */
/* Learns the state of the servos from the packets that pass; see servos.h and
 * docs/internals/permit.md. Manual: 3.1, registers 0x03 to 0x10, 0x18, 0x1E to 0x21, 0x2C; 2.3
 * (error bits). */
#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/packet.h"        // CDS_AT_*
#include "compiler.h"              // NOINLINE
#include "safety/limits.h"         // cds_limits_learn()
#include "safety/servos_internal.h"

#define FACTORY_RETURN_DELAY 1
#define ALL_LEARNT           UINT8_MAX // in `walked`

/* ---- registers ---- */

/* The RAM area of the servo may be at initial values, and its settings may have changed. */
static NOINLINE void forget(struct cds_servo_state *servo)
{
    servo->held &= CDS_HELD_SPEED_0;
    servo->return_delay = CDS_SERVOS_UNKNOWN;
    servo->status_return_level = CDS_LEVEL_UNKNOWN;
    servo->is_registered = false;
}

/* After a write that was not answered the more careful value is assumed: an unknown rate, the
 * longer delay, the level at which the servo answers more. */
static bool learn_settings(struct cds_servo_state *servo, const struct cds_written *written,
                           uint8_t source)
{
    uint8_t delay = servo->return_delay, level = servo->status_return_level;
    uint8_t baud_reg = cds_written_value(written, CDS_REG_BAUD_RATE, servo->baud_reg);
    uint8_t next_delay = cds_written_value(written, CDS_REG_RETURN_DELAY, delay);
    uint8_t next_level = cds_written_value(written, CDS_REG_STATUS_RETURN_LEVEL, level);

    if (next_level != level && next_level > CDS_LEVEL_ALL)
        next_level = CDS_LEVEL_ALL; // levels above 2 do not exist
    if (source == CDS_SOURCE_LOST) {
        if (baud_reg != servo->baud_reg)
            baud_reg = CDS_SERVOS_UNKNOWN;
        if (next_delay < delay)
            next_delay = delay;
        if (next_level < level)
            next_level = level;
    }
    servo->baud_reg = baud_reg;
    servo->return_delay = next_delay;
    servo->status_return_level = next_level & 3u;
    return next_delay != delay || next_level != level;
}

/* Learns all registers that were written or read, except the ID. */
static NOINLINE void learn_registers(struct cds_servos *servos, struct cds_servo_state *servo,
                                     const struct cds_written *written, uint8_t source)
{
    bool has_changed = false;

    if (written->sets & CDS_SETS_TORQUE && source != CDS_SOURCE_READ) {
        bool is_on = cds_written_value(written, CDS_REG_TORQUE_ENABLE, 0);

        if (is_on || source != CDS_SOURCE_LOST)
            servo->torque = is_on;
    }
    if (written->sets & CDS_SETS_REPLY)
        has_changed = learn_settings(servo, written, source);
    if (written->sets & (CDS_SETS_MODE | CDS_SETS_GOAL | CDS_SETS_SPEED) &&
        cds_limits_learn(servo, written, source))
        has_changed = true;
    if (written->sets & CDS_SETS_REGISTERED) {
        const uint8_t *byte = cds_written_byte(written, CDS_REG_REGISTERED_INSTRUCTION);

        if (source != CDS_SOURCE_READ || !byte || !*byte)
            servo->is_registered = false;
        if (source <= CDS_SOURCE_ANSWERED && byte && !*byte)
            servo->registered_torque = false;
    }
    if (has_changed)
        cds_servos_note_change(servos, servo->id);
}

static void learn_write(struct cds_servos *servos, struct cds_servo_state *servo,
                        const uint8_t *bytes, uint8_t source)
{
    struct cds_servo_state *other;
    struct cds_written written;
    uint8_t id = servo->id;

    if (!cds_written_by(bytes, 0, &written))
        return;
    if (written.sets & CDS_SETS_ID)
        id = cds_written_value(&written, CDS_REG_ID, id);
    if (id == servo->id || (source == CDS_SOURCE_ANSWERED && servo->second == CDS_NO_ID)) {
        learn_registers(servos, servo, &written, source);
        if (id != servo->id)
            cds_servos_note_change(servos, CDS_BROADCAST_ID);
        servo->id = id;
    } else if ((other = cds_servos_doubt_id(servos, servo,
                                            id))) { // the write was carried out, or was not
        learn_registers(servos, other, &written, CDS_SOURCE_SENT);
    }
}

static void learn_reset(struct cds_servos *servos, struct cds_servo_state *servo, uint8_t source)
{
    struct cds_servo_state *next = servo;

    if (source != CDS_SOURCE_ANSWERED || servo->second != CDS_NO_ID)
        next = cds_servos_doubt_id(servos, servo, CDS_FACTORY_ID);
    if (next) {
        forget(next);
        next->id = CDS_FACTORY_ID;
        next->return_delay = FACTORY_RETURN_DELAY;
        next->status_return_level = CDS_LEVEL_ALL;
        next->baud_reg = CDS_BAUD_1M;
        next->torque = next->registered_torque = false;
    } else { // its ID stays
        forget(servo);
        if (servo->baud_reg != CDS_BAUD_1M)
            servo->baud_reg = CDS_SERVOS_UNKNOWN;
    }
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}

static void learn_registered(struct cds_servos *servos, struct cds_servo_state *servo,
                             const struct cds_request *request, uint8_t source)
{
    struct cds_written written;

    if (!cds_written_by(request->packet.bytes, 0, &written))
        return;
    if (cds_written_value(&written, CDS_REG_TORQUE_ENABLE, 0))
        servo->registered_torque = true;
    else if (source == CDS_SOURCE_ANSWERED)
        servo->registered_torque = false; // a REG WRITE replaces the one before
    if (request != servos->move_request)
        return; // the permit sends a servo with limits no other REG WRITE
    if (source == CDS_SOURCE_ANSWERED)
        servo->is_registered = servos->move_is_valid;
    else
        servos->move_is_answered = false;
}

/* The packet was carried out, as far as `source` tells. */
static void learn_packet(struct cds_servos *servos, struct cds_servo_state *servo,
                         const struct cds_request *request, uint8_t source)
{
    switch (request->packet.bytes[CDS_AT_INSTRUCTION]) {
    case CDS_WRITE: learn_write(servos, servo, request->packet.bytes, source); break;
    case CDS_REG_WRITE: learn_registered(servos, servo, request, source); break;
    case CDS_ACTION:
        if (servo->registered_torque)
            servo->torque = true;
        if (source == CDS_SOURCE_ANSWERED)
            servo->registered_torque = false;
        if (servo->is_registered) { // the speed of the move may be 0
            servo->is_registered = false;
            servo->held |= CDS_HELD_SPEED_0;
            cds_servos_note_change(servos, servo->id);
        }
        break;
    case CDS_RESET: learn_reset(servos, servo, source); break;
    default: break;
    }
}

/* If torque was on and is read as off, the servo has lost its power for a moment, or an alarm has
 * switched torque off. */
static void learn_torque(struct cds_servos *servos, struct cds_servo_state *servo, uint8_t is_on)
{
    uint8_t was_on = servo->torque;

    servo->torque = is_on != 0;
    if (is_on || !was_on) {
        if (servo->presence != CDS_PRESENCE_RETURNED)
            return; // no event: the permit uses neither torque nor this presence
    } else {
        servo->inhibits |= CDS_INHIBIT_STATE_LOST;
        servos->move_is_valid = false;
        forget(servo);
    }
    servo->presence = CDS_PRESENCE_ONLINE;
    servos->event_count++;
    cds_servos_note_change(servos, servo->id);
}

static NOINLINE void learn_read(struct cds_servos *servos, struct cds_servo_state *servo,
                                const struct cds_request *request)
{
    const uint8_t *bytes = request->packet.bytes;
    struct cds_written read;

    if (bytes[CDS_AT_LENGTH] != CDS_LENGTH_MIN + 2 ||
        bytes[CDS_AT_PARAMETERS + 1] != request->length)
        return; // the reply has another length than was asked for
    read.data = request->reply;
    read.address = bytes[CDS_AT_PARAMETERS];
    read.length = request->length;
    read.sets = cds_written_sets(read.address, read.length);
    if (read.sets & CDS_SETS_TORQUE)
        learn_torque(servos, servo, *cds_written_byte(&read, CDS_REG_TORQUE_ENABLE));
    learn_registers(servos, servo, &read, CDS_SOURCE_READ);
    if (servo->status_return_level == CDS_LEVEL_PING) { // untrue: it has answered a READ
        servo->status_return_level = CDS_LEVEL_UNKNOWN;
        if (read.sets & CDS_SETS_TORQUE && servo->torque) // only its replies were lost: health.h
            servo->inhibits = servo->inhibits & (uint8_t)~CDS_INHIBIT_STATE_LOST & 3u;
    }
}

/* ---- replies and their absence ---- */

static NOINLINE void note_error(struct cds_servos *servos, struct cds_servo_state *servo,
                                uint8_t error)
{
    uint8_t known = servos->alarms;

    servos->alarms |= error;
    if (servo) {
        known &= servo->alarms;
        servo->alarms |= error;
    }
    if (error & (uint8_t)~known)
        servos->event_count++;
}

static NOINLINE void set_presence(struct cds_servos *servos, struct cds_servo_state *servo,
                                  enum cds_presence presence)
{
    servo->presence = presence & 3u;
    servos->event_count++;
    if (presence != CDS_PRESENCE_ONLINE) // else the permit's answers stay the same
        cds_servos_note_change(servos, servo->id);
}

static void take_answer(struct cds_servos *servos, struct cds_servo_state *servo,
                        uint8_t instruction)
{
    uint8_t level = servo->status_return_level;
    bool is_ping = instruction == CDS_PING, is_read = instruction == CDS_READ;

    servo->counters.ok++;
    servo->misses = 0;
    servo->baud_reg = servos->bus->baud_reg;
    if (servo->presence == CDS_PRESENCE_OFFLINE) {
        forget(servo);
        set_presence(servos, servo, CDS_PRESENCE_RETURNED);
    } else if (servo->presence == CDS_PRESENCE_UNKNOWN) {
        set_presence(servos, servo, CDS_PRESENCE_ONLINE);
    }
    if (!is_ping && !is_read && level == CDS_LEVEL_UNKNOWN)
        servo->status_return_level = CDS_LEVEL_ALL;
    if (is_read || (is_ping && level == CDS_LEVEL_PING))
        servo->has_answered = true;
}

/* The transaction has ended without a good reply. This counts as a miss only at the rate of the
 * servo, and only if the servo answers this packet at every status return level that it may have. A
 * damaged reply is a miss only after a READ of TORQUE_ENABLE, as in a state check: a cycle that
 * reads all the time would meet three in a row too often. */
static void take_failure(struct cds_servos *servos, struct cds_servo_state *servo,
                         const uint8_t *bytes, uint8_t instruction, uint8_t result)
{
    uint8_t misses;

    if (result == CDS_TIMEOUT) {
        servo->counters.timeouts++;
    } else {
        servo->counters.corrupt++;
        if (instruction != CDS_READ || bytes[CDS_AT_PARAMETERS] != CDS_REG_TORQUE_ENABLE)
            return;
    }
    if (servo->baud_reg != servos->bus->baud_reg)
        return;
    if (servo->status_return_level == CDS_LEVEL_UNKNOWN && instruction != CDS_PING &&
        (instruction != CDS_READ || servo->presence == CDS_PRESENCE_RETURNED))
        return;
    misses = servo->misses;
    if (misses < CDS_SERVOS_MISSES)
        misses++;
    servo->misses = misses & 3u;
    if (misses == CDS_SERVOS_MISSES && servo->presence != CDS_PRESENCE_OFFLINE)
        set_presence(servos, servo, CDS_PRESENCE_OFFLINE);
}

/* Adds to a counter that stays at 255. */
static NOINLINE void add(uint8_t *counter, uint16_t more)
{
    *counter = more < UINT8_MAX - (uint16_t)*counter ? (uint8_t)(*counter + more) : UINT8_MAX;
}

static void count_echo_errors(struct cds_servos *servos, struct cds_servo_state *servo)
{
    uint16_t echo_errors = cds_link_count(&servos->bus->link.echo_errors);

    if (servo)
        add(&servo->counters.echo_errors, (uint16_t)(echo_errors - servos->echo_errors));
    servos->echo_errors = echo_errors;
}

bool cds_servos_take_routine(const struct cds_servos *servos, const struct cds_request *request,
                             uint8_t result)
{
    const uint8_t *bytes = request->packet.bytes;
    uint8_t index = request->servo_index;
    struct cds_servo_state *servo;

    if (result != CDS_OK || bytes[CDS_AT_INSTRUCTION] != CDS_READ ||
        bytes[CDS_AT_PARAMETERS] <= CDS_REG_MOVING_SPEED + 1 || request->error ||
        (uint8_t)servos->echo_errors != (uint8_t)servos->bus->link.echo_errors)
        return false;
    servo = &servos->states[index];
    if (index >= servos->count || servo->id != bytes[CDS_AT_ID]) // the permit has searched for it
        return servos->grows != CDS_GROWS_ALWAYS;
    if (servo->presence != CDS_PRESENCE_ONLINE || servo->misses || servo->second != CDS_NO_ID ||
        servo->is_registered || servo->registered_torque ||
        servo->baud_reg != servos->bus->baud_reg || servos->is_paused)
        return false;
    servo->counters.ok++;
    return true;
}

NOINLINE void cds_servos_learn_end(struct cds_servos *servos, struct cds_request *request,
                                   uint8_t result)
{
    uint8_t id = request->packet.bytes[CDS_AT_ID];
    uint8_t instruction = request->packet.bytes[CDS_AT_INSTRUCTION], error = 0;
    uint8_t is_reply_due = 0, source = CDS_SOURCE_LOST;
    struct cds_servo_state *servo = NULL;

    if (request->reply_parameters != CDS_REPLY_NONE)
        is_reply_due = !request->is_muted;
    if (id == CDS_BROADCAST_ID)
        id =
            result == CDS_OK ? request->id : CDS_NO_ID; // after a PING: the servo that has answered
    if (id <= CDS_ID_MAX)
        servo = cds_servos_at(servos, id, &request->servo_index);
    if (result == CDS_OK) {
        source = CDS_SOURCE_SENT;
        if (is_reply_due) {
            source = CDS_SOURCE_ANSWERED;
            error = request->error;
            if (!servo && !servos->is_paused)
                servo = cds_servos_meet(servos, request->id, error);
        }
    }
    count_echo_errors(servos, servo);
    if (error && !servos->is_paused)
        note_error(servos, servo, error);
    if (!servo)
        return;
    if (is_reply_due && !servos->is_paused) {
        if (result == CDS_OK)
            take_answer(servos, servo, instruction);
        else
            take_failure(servos, servo, request->packet.bytes, instruction, result);
    }
    if (!(error & CDS_ERRORS_OF_PACKET)) {
        if (instruction != CDS_READ)
            learn_packet(servos, servo, request, source);
        else if (result == CDS_OK && !servos->is_paused)
            learn_read(servos, servo, request);
    }
    cds_servos_settle_id(servos, servo);
}

void cds_servos_on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    struct cds_servo_state *servo;
    uint8_t *counter;

    if (servos->is_paused)
        return;
    servo = cds_servos_find(servos, id);
    if (!servo)
        servo = cds_servos_meet(servos, id, error);
    note_error(servos, servo, error);
    if (!servo)
        return;
    counter = &servo->counters.unexpected_packets;
    if (event == CDS_EVENT_STALE_REPLY)
        counter = &servo->counters.stale_replies;
    else if (event == CDS_EVENT_DUPLICATE_REPLY)
        counter = &servo->counters.duplicate_replies;
    add(counter, 1);
    if (event != CDS_EVENT_STALE_REPLY &&
        servo->status_return_level < CDS_LEVEL_ALL) { // it answers more than its level allows
        servo->status_return_level = CDS_LEVEL_UNKNOWN;
        cds_servos_note_change(servos, id);
    }
}

/* ---- packets to many servos: each call learns from some ---- */

/* A broadcast RESET was sent: nothing is known of `servo` any more. */
static void expire(struct cds_servo_state *servo)
{
    forget(servo);
    servo->inhibits |= CDS_INHIBIT_STATE_LOST;
    servo->presence = CDS_PRESENCE_UNKNOWN;
    servo->misses = 0;
    servo->torque = servo->registered_torque = false;
    servo->baud_reg = CDS_SERVOS_UNKNOWN;
}

/* For all servos in one call: the next packet of torque_off must not wait. */
static void learn_torque_off(struct cds_servos *servos)
{
    struct cds_servo_state *servo = servos->states;

    for (uint8_t i = servos->count; i; i--, servo++)
        servo->torque = false;
}

static void learn_one(struct cds_walk *walk, const struct cds_request *request)
{
    struct cds_servo_state *servo = walk->servo;
    uint8_t instruction = request->packet.bytes[CDS_AT_INSTRUCTION];

    if (!servo)
        return;
    if (instruction == CDS_WRITE ||
        instruction == CDS_SYNC_WRITE) // not of ID: the permit refuses such a packet
        learn_registers(walk->servos, servo, &walk->written, CDS_SOURCE_SENT);
    else if (instruction == CDS_RESET)
        expire(servo);
    else
        learn_packet(walk->servos, servo, request, CDS_SOURCE_SENT);
}

/* True if the broadcast of torque off is the next packet. */
static bool torque_off_is_next(const struct cds_servos *servos)
{
    const struct cds_queue *queue = servos->queue;
    const uint8_t *bytes;

    if (!queue || !queue->first)
        return false;
    bytes = queue->first->packet.bytes;
    return bytes[CDS_AT_ID] == CDS_BROADCAST_ID && cds_written_is_torque_off(bytes);
}

/* Returns true if servos learn from a packet that writes `sets`. Goals make nothing known:
 * cds_limits_check() has noted a speed of 0. Torque is not learnt before torque off: to learn 50
 * servos takes 1 ms longer than the packet, and torque off waits for it. */
static bool is_learnt(const struct cds_servos *servos, uint8_t sets)
{
    if (sets == CDS_SETS_TORQUE)
        return !torque_off_is_next(servos);
    return sets & (CDS_SETS_REPLY | CDS_SETS_MODE | CDS_SETS_TORQUE);
}

bool cds_servos_on_sending(void *context, struct cds_request *request)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    const uint8_t *bytes = request->packet.bytes;
    bool is_sync_write = bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE;
    struct cds_walk walk;
    uint8_t result;

    if (servos->count == 0 || (bytes[CDS_AT_ID] != CDS_BROADCAST_ID && !is_sync_write))
        return false;
    if (is_sync_write &&
        (bytes[CDS_AT_LENGTH] < CDS_LENGTH_MIN + 2 ||
         !is_learnt(servos, cds_written_sets(bytes[CDS_AT_PARAMETERS], bytes[CDS_AT_SYNC_LENGTH]))))
        return false; // else goals of a cycle would end the check of a request that waits
    cds_walk_begin(&walk, servos, request, 0);
    if (servos->walked == ALL_LEARNT)
        return false;
    walk.written.sets = 0;
    cds_written_by(bytes, servos->walked, &walk.written);
    if (cds_written_is_torque_off(bytes)) {
        learn_torque_off(servos);
    } else {
        while ((result = cds_walk_next(&walk, 2)) == CDS_OK)
            learn_one(&walk, request);
        if (result == CDS_WALK_ENDS) {
            servos->walked = ALL_LEARNT;
            if (bytes[CDS_AT_INSTRUCTION] == CDS_RESET)
                cds_servos_note_change(servos, CDS_BROADCAST_ID);
        }
        return walk.budget <= 0 || result != CDS_WALK_ENDS; // else the next call finds the end
    }
    servos->walked = ALL_LEARNT;
    return false;
}
