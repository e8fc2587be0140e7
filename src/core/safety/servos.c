/* What is known of each servo of a bus; see servos.h. */
#include "cds55xx/servos.h"

#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "cds55xx/packet.h"        // CDS_AT_*
#include "compiler.h"              // NOINLINE
#include "safety/limits.h"         // cds_limits_learn()
#include "safety/permit.h"         // cds_servos_permit()
#include "safety/servos_internal.h"

#define FACTORY_RETURN_DELAY 1
#define ALL_LEARNT           UINT8_MAX // in `learnt`

/* ---- the list ---- */

NOINLINE struct cds_servo_state *cds_servos_search(struct cds_servos *servos, uint8_t id,
                                                   uint8_t *index)
{
    struct cds_servo_state *servo = servos->states;

    for (uint8_t i = 0; i < servos->count; i++, servo++) {
        if (servo->id == id) {
            *index = i;
            return servo;
        }
    }
    return NULL;
}

struct cds_servo_state *cds_servos_next(struct cds_servos *servos, uint8_t id, uint8_t *index,
                                        uint8_t *budget)
{
    uint8_t next = (uint8_t)(*index + 1u), cost = servos->count >> 4;

    if (next >= servos->count)
        next = 0;
    if (servos->count && servos->states[next].id == id) {
        *index = next;
        return &servos->states[next];
    }
    *budget = *budget > cost ? (uint8_t)(*budget - cost) : 0;
    return cds_servos_search(servos, id, index);
}

struct cds_servo_state *cds_servos_find(struct cds_servos *servos, uint8_t id)
{
    uint8_t index;

    return cds_servos_search(servos, id, &index);
}

NOINLINE void cds_servos_note_change(struct cds_servos *servos, uint8_t id)
{
    servos->epoch++;
    if (servos->epoch == 0)
        servos->epoch = 1;
    servos->changed_id = id;
}

static void note_error(struct cds_servos *servos, struct cds_servo_state *servo, uint8_t error)
{
    uint8_t before = servos->alarms, own = servo ? servo->alarms : 0;

    servos->alarms |= error;
    if (servo)
        servo->alarms |= error;
    if (servos->alarms != before || (servo && servo->alarms != own))
        servos->news++;
}

/* ---- which ID a servo has ---- */

bool cds_servos_may_become(struct cds_servos *servos, const struct cds_servo_state *servo,
                           uint8_t id, uint8_t to)
{
    uint8_t index;

    if (to == id)
        return true;
    if (to > CDS_ID_MAX)
        return !servo; // there is no such ID
    if (cds_servos_search(servos, to, &index))
        return servo && servo->second == index;
    return !servo || (servo->second == CDS_NO_ID && servos->count < servos->capacity);
}

static struct cds_servo_state *second_of(struct cds_servos *servos,
                                         const struct cds_servo_state *servo)
{
    return servo->second < servos->count ? &servos->states[servo->second] : NULL;
}

/* Returns the entry of the ID `id`, which `servo` may have now beside its own: a copy of `servo`,
 * on which the caller writes what has changed. NULL: it has `id` already. */
static struct cds_servo_state *doubt_id(struct cds_servos *servos, struct cds_servo_state *servo,
                                        uint8_t id)
{
    struct cds_servo_state *other = second_of(servos, servo);

    if (id == servo->id || id > CDS_ID_MAX)
        return NULL;
    if (!other) {
        if (servos->count == servos->capacity) { // the permit has seen to that
            servos->is_full = true;
            return NULL;
        }
        other = &servos->states[servos->count];
        servo->second = servos->count++;
        *other = *servo;
        other->counters = (struct cds_servo_counters){0};
        other->second = (uint8_t)(servo - servos->states);
        other->id = id;
    }
    servo->has_answered = other->has_answered = false;
    servo->misses = other->misses = 0;
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
    return other;
}

/* Moves the last entry to the place of entry `index`, which goes. */
static void remove_entry(struct cds_servos *servos, uint8_t index)
{
    struct cds_servo_state *place = &servos->states[index], *other;

    servos->count--;
    if (index == servos->count)
        return;
    *place = servos->states[servos->count];
    other = second_of(servos, place);
    if (other)
        other->second = index;
}

/* The ID of `servo` is certain as soon as one of its two entries has answered a READ and the other
 * has missed three, or both have answered: then there are two servos. The lower entry stays where
 * it is. Not while driving is inhibited: torque_off goes through the entries. */
static NOINLINE void settle_id(struct cds_servos *servos, struct cds_servo_state *servo)
{
    struct cds_servo_state *other = second_of(servos, servo), *lower, *higher;

    if (!other || servos->inhibited || !(servo->has_answered || other->has_answered))
        return;
    if (!(servo->has_answered && other->has_answered)) {
        if ((servo->has_answered ? other : servo)->misses < CDS_SERVOS_MISSES)
            return;
        lower = servo < other ? servo : other;
        higher = servo < other ? other : servo;
        if (higher->has_answered)
            *lower = *higher;
        lower->second = CDS_NO_ID;
        remove_entry(servos, (uint8_t)(higher - servos->states));
    } else {
        servo->second = other->second = CDS_NO_ID;
    }
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}

/* ---- what is learnt ---- */

/* Its RAM area may be at initial values, and its settings may have changed. */
static void forget(struct cds_servo_state *servo)
{
    servo->cw_limit = servo->ccw_limit = CDS_ANGLE_UNKNOWN;
    servo->goal_known = false;
    servo->speed_known = false;
    servo->return_delay = CDS_SERVOS_UNKNOWN;
    servo->status_return_level = CDS_LEVEL_UNKNOWN;
    servo->is_registered = false;
}

/* Returns the value of register `reg`, of which `known` was known; without an answer the larger
 * one: 255 and CDS_LEVEL_UNKNOWN are the largest. */
static uint8_t learn_byte(uint8_t known, const struct cds_written *written, uint8_t reg,
                          enum cds_source source)
{
    uint8_t value = cds_written_value(written, reg, known);

    return source == CDS_SOURCE_LOST && known > value ? known : value;
}

static bool learn_settings(struct cds_servo_state *servo, const struct cds_written *written,
                           enum cds_source source)
{
    uint8_t delay = servo->return_delay, level = servo->status_return_level;
    uint8_t baud_reg = cds_written_value(written, CDS_REG_BAUD_RATE, servo->baud_reg), next;

    if (source == CDS_SOURCE_LOST && baud_reg != servo->baud_reg)
        baud_reg = CDS_SERVOS_UNKNOWN;
    servo->baud_reg = baud_reg;
    servo->return_delay = learn_byte(delay, written, CDS_REG_RETURN_DELAY, source);
    next = cds_written_value(written, CDS_REG_STATUS_RETURN_LEVEL, level);
    if (next > CDS_LEVEL_ALL && cds_written_byte(written, CDS_REG_STATUS_RETURN_LEVEL))
        next = CDS_LEVEL_ALL; // as no servo should have
    if (source == CDS_SOURCE_LOST && level > next)
        next = level;
    servo->status_return_level = next & 3u;
    return servo->return_delay != delay || servo->status_return_level != level;
}

/* What was written or read, but for ID and torque. */
static void learn_span(struct cds_servos *servos, struct cds_servo_state *servo,
                       const struct cds_written *written, enum cds_source source)
{
    bool has_changed = false;

    if (written->sets & CDS_SETS_REPLY)
        has_changed = learn_settings(servo, written, source);
    if (written->sets & (CDS_SETS_MODE | CDS_SETS_GOAL | CDS_SETS_SPEED) &&
        cds_limits_learn(servo, written, source))
        has_changed = true;
    if (written->sets & CDS_SETS_REGISTERED) {
        if (source != CDS_SOURCE_READ ||
            !cds_written_value(written, CDS_REG_REGISTERED_INSTRUCTION, 0))
            servo->is_registered = false;
        if (source <= CDS_SOURCE_ANSWERED &&
            !cds_written_value(written, CDS_REG_REGISTERED_INSTRUCTION, 1))
            servo->registered_torque = false;
    }
    if (has_changed)
        cds_servos_note_change(servos, servo->id);
}

static void learn_written(struct cds_servos *servos, struct cds_servo_state *servo,
                          const struct cds_written *written, enum cds_source source)
{
    learn_span(servos, servo, written, source);
    if (written->sets & CDS_SETS_TORQUE) {
        bool is_on = cds_written_value(written, CDS_REG_TORQUE_ENABLE, 0);

        servo->torque = is_on || (source == CDS_SOURCE_LOST && servo->torque);
    }
}

static void learn_write(struct cds_servos *servos, struct cds_servo_state *servo,
                        const struct cds_written *written, enum cds_source source)
{
    uint8_t id = cds_written_value(written, CDS_REG_ID, servo->id);

    if (id == servo->id || id > CDS_ID_MAX) {
        learn_written(servos, servo, written, source);
    } else if (source == CDS_SOURCE_ANSWERED && servo->second == CDS_NO_ID) {
        learn_written(servos, servo, written, source);
        servo->id = id;
        cds_servos_note_change(servos, CDS_BROADCAST_ID);
    } else { // it was carried out under the new ID, or not at all
        struct cds_servo_state *other = doubt_id(servos, servo, id);

        if (other)
            learn_written(servos, other, written, CDS_SOURCE_SENT);
    }
}

static void take_factory_values(struct cds_servo_state *servo)
{
    forget(servo);
    servo->return_delay = FACTORY_RETURN_DELAY;
    servo->status_return_level = CDS_LEVEL_ALL;
    servo->baud_reg = CDS_BAUD_1M;
    servo->torque = false;
    servo->registered_torque = false;
}

static void learn_reset(struct cds_servos *servos, struct cds_servo_state *servo,
                        enum cds_source source)
{
    struct cds_servo_state *other;

    if (source == CDS_SOURCE_ANSWERED && servo->second == CDS_NO_ID) {
        take_factory_values(servo);
        servo->id = CDS_FACTORY_ID;
    } else if ((other = doubt_id(servos, servo, CDS_FACTORY_ID))) {
        take_factory_values(other);
    } else { // its ID stays
        forget(servo);
        if (servo->baud_reg != CDS_BAUD_1M)
            servo->baud_reg = CDS_SERVOS_UNKNOWN;
    }
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}

static void learn_registered(struct cds_servos *servos, struct cds_servo_state *servo,
                             const struct cds_request *request, enum cds_source source)
{
    struct cds_written written;

    if (!cds_written_by(request->packet.bytes, &written))
        return;
    if (cds_written_value(&written, CDS_REG_TORQUE_ENABLE, 0))
        servo->registered_torque = true;
    else if (source == CDS_SOURCE_ANSWERED)
        servo->registered_torque = false; // the last one counts
    servo->is_registered = false;
    if (request != servos->move_request)
        return;
    if (source == CDS_SOURCE_ANSWERED)
        servo->is_registered = servos->move_is_valid;
    else
        servos->move_is_answered = false;
}

static void learn_action(struct cds_servo_state *servo, enum cds_source source)
{
    if (servo->registered_torque)
        servo->torque = true;
    if (source == CDS_SOURCE_ANSWERED)
        servo->registered_torque = false;
    servo->is_registered = false;
}

/* The packet was carried out, as far as `source` tells. */
static void learn_packet(struct cds_servos *servos, struct cds_servo_state *servo,
                         const struct cds_request *request, enum cds_source source)
{
    const uint8_t *bytes = request->packet.bytes;
    struct cds_written written;

    switch (bytes[CDS_AT_INSTRUCTION]) {
    case CDS_WRITE:
        if (cds_written_by(bytes, &written))
            learn_write(servos, servo, &written, source);
        break;
    case CDS_REG_WRITE: learn_registered(servos, servo, request, source); break;
    case CDS_ACTION: learn_action(servo, source); break;
    case CDS_RESET: learn_reset(servos, servo, source); break;
    default: break;
    }
}

/* Torque that is off where it was on: the power was gone for a moment, or an alarm has shut it
 * down.
 */
static void learn_torque(struct cds_servos *servos, struct cds_servo_state *servo, bool is_on)
{
    if (servo->torque && !is_on) {
        servo->inhibited |= CDS_INHIBIT_STATE_LOST;
        servos->move_is_valid = false;
        forget(servo);
    } else if (servo->presence != CDS_PRESENCE_RETURNED) {
        servo->torque = is_on;
        return; // nothing that the permit uses
    }
    servo->torque = is_on;
    servo->presence = CDS_PRESENCE_ONLINE;
    servos->news++;
    cds_servos_note_change(servos, servo->id);
}

static void learn_read(struct cds_servos *servos, struct cds_servo_state *servo,
                       const struct cds_request *request)
{
    const uint8_t *bytes = request->packet.bytes;
    struct cds_written read = {
        .data = request->reply, .address = bytes[CDS_AT_PARAMETERS], .length = request->length};

    if (read.address > CDS_REG_MOVING_SPEED + 1 &&
        (read.address > CDS_REG_REGISTERED_INSTRUCTION ||
         read.address + read.length <= CDS_REG_REGISTERED_INSTRUCTION))
        return; // as feedback
    if (bytes[CDS_AT_LENGTH] != CDS_LENGTH_MIN + 2 ||
        bytes[CDS_AT_PARAMETERS + 1] != request->length)
        return; // not what was asked for
    read.sets = cds_written_sets(read.address, read.length);
    if (read.sets & CDS_SETS_TORQUE)
        learn_torque(servos, servo, *cds_written_byte(&read, CDS_REG_TORQUE_ENABLE));
    learn_span(servos, servo, &read, CDS_SOURCE_READ);
}

/* ---- replies and their absence ---- */

static void take_answer(struct cds_servos *servos, struct cds_servo_state *servo,
                        uint8_t instruction)
{
    uint8_t level = servo->status_return_level;

    servo->counters.ok++;
    servo->misses = 0;
    servo->baud_reg = servos->bus->baud_reg;
    if (servo->presence == CDS_PRESENCE_OFFLINE) {
        servo->presence = CDS_PRESENCE_RETURNED;
        forget(servo);
        servos->news++;
        cds_servos_note_change(servos, servo->id);
    } else if (servo->presence == CDS_PRESENCE_UNKNOWN) {
        servo->presence = CDS_PRESENCE_ONLINE;
        servos->news++;
    }
    if (instruction != CDS_PING && instruction != CDS_READ && level == CDS_LEVEL_UNKNOWN)
        servo->status_return_level = CDS_LEVEL_ALL;
    if (servo->second != CDS_NO_ID &&
        (instruction == CDS_READ || (instruction == CDS_PING && level == CDS_LEVEL_PING)))
        servo->has_answered = true;
}

/* True if the servo would have answered at any status return level that it may have. */
static bool had_to_answer(const struct cds_servo_state *servo, uint8_t instruction)
{
    if (servo->status_return_level != CDS_LEVEL_UNKNOWN || instruction == CDS_PING)
        return true;
    return instruction == CDS_READ && servo->presence != CDS_PRESENCE_RETURNED;
}

/* A miss tells something only at the rate of the servo. */
static void take_miss(struct cds_servos *servos, struct cds_servo_state *servo, uint8_t instruction)
{
    servo->counters.timeouts++;
    if (servo->baud_reg != servos->bus->baud_reg || !had_to_answer(servo, instruction))
        return;
    if (servo->misses < CDS_SERVOS_MISSES)
        servo->misses = (servo->misses + 1u) & 3u;
    if (servo->misses == CDS_SERVOS_MISSES && servo->presence != CDS_PRESENCE_OFFLINE) {
        servo->presence = CDS_PRESENCE_OFFLINE;
        servos->news++;
        cds_servos_note_change(servos, servo->id);
    }
}

/* Adds to a counter that stays at 255. */
static void add(uint8_t *counter, uint16_t more)
{
    *counter = more < UINT8_MAX - (uint16_t)*counter ? (uint8_t)(*counter + more) : UINT8_MAX;
}

static void count_echo_errors(struct cds_servos *servos, struct cds_servo_state *servo)
{
    uint16_t echo_errors = cds_link_count(&servos->bus->link.echo_errors);

    if (servo && echo_errors != servos->echo_errors)
        add(&servo->counters.echo_errors, (uint16_t)(echo_errors - servos->echo_errors));
    servos->echo_errors = echo_errors;
}

static struct cds_servo_state *met(struct cds_servos *servos, uint8_t id, bool joins)
{
    return joins && cds_servos_add(servos, id) == CDS_OK ? &servos->states[servos->count - 1]
                                                         : NULL;
}

/* A transaction with one servo, or a PING by broadcast, has ended. */
static void learn_end(struct cds_servos *servos, struct cds_request *request,
                      enum cds_result result)
{
    uint8_t id = request->packet.bytes[CDS_AT_ID];
    uint8_t instruction = request->packet.bytes[CDS_AT_INSTRUCTION];
    bool is_due = request->reply_parameters != CDS_REPLY_NONE && !request->is_muted;
    bool is_answered = is_due && result == CDS_OK;
    uint8_t error = is_answered ? request->error : 0;
    struct cds_servo_state *servo;
    enum cds_source source = CDS_SOURCE_LOST;

    if (id == CDS_BROADCAST_ID)
        id = is_answered ? request->id : CDS_NO_ID;
    servo = cds_servos_at(servos, id, &request->servo_index);
    if (!servo && servos->grows && is_answered && !servos->is_paused)
        servo = met(servos, id, error || servos->grows == CDS_GROWS_ALWAYS);
    count_echo_errors(servos, servo);
    if (error && !servos->is_paused)
        note_error(servos, servo, error);
    if (!servo)
        return;
    if (is_due && !servos->is_paused) {
        if (result == CDS_OK)
            take_answer(servos, servo, instruction);
        else if (result == CDS_TIMEOUT)
            take_miss(servos, servo, instruction);
        else
            servo->counters.corrupt++;
    }
    if (result == CDS_OK)
        source = is_due ? CDS_SOURCE_ANSWERED : CDS_SOURCE_SENT;
    if (!(error & CDS_ERRORS_OF_PACKET)) {
        if (instruction != CDS_READ)
            learn_packet(servos, servo, request, source);
        else if (is_answered && !servos->is_paused)
            learn_read(servos, servo, request);
        if (is_answered && instruction == CDS_READ &&
            servo->status_return_level == CDS_LEVEL_PING) // it may be of another make
            servo->status_return_level = CDS_LEVEL_READ;
    }
    if (servo->second != CDS_NO_ID)
        settle_id(servos, servo);
}

/* ---- what all servos hear, some each call ---- */

/* An entry after a RESET of all servos. */
static void expire(struct cds_servo_state *servo)
{
    forget(servo);
    servo->inhibited |= CDS_INHIBIT_STATE_LOST;
    servo->presence = CDS_PRESENCE_UNKNOWN;
    servo->misses = 0;
    servo->torque = false;
    servo->registered_torque = false;
    servo->baud_reg = CDS_SERVOS_UNKNOWN;
}

/* True while there is more. */
static bool learn_blocks(struct cds_servos *servos, const uint8_t *bytes)
{
    uint8_t budget = CDS_SERVOS_PER_CALL;
    struct cds_written written;
    struct cds_servo_state *servo;

    if (servos->learnt == 0)
        servos->learnt_index = UINT8_MAX;
    if (!cds_written_by(bytes, &written) ||
        !(written.sets & (CDS_SETS_REPLY | CDS_SETS_MODE | CDS_SETS_TORQUE)))
        return false; // goals make nothing known: cds_limits_check() has noted a speed of 0
    while (cds_written_block(bytes, servos->learnt, &written)) {
        if (budget == 0)
            return true;
        budget--;
        servo = cds_servos_next(servos, written.id, &servos->learnt_index, &budget);
        if (servo)
            learn_written(servos, servo, &written, CDS_SOURCE_SENT);
        servos->learnt++;
    }
    return false;
}

static bool is_torque_off(const uint8_t *bytes)
{
    return bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && bytes[CDS_AT_LENGTH] == CDS_LENGTH_MIN + 2 &&
           bytes[CDS_AT_PARAMETERS] == CDS_REG_TORQUE_ENABLE && bytes[CDS_AT_PARAMETERS + 1] == 0;
}

/* True while there is more. */
static bool learn_broadcast(struct cds_servos *servos, const struct cds_request *request)
{
    const uint8_t *bytes = request->packet.bytes;
    struct cds_servo_state *servo = servos->states;

    if (is_torque_off(bytes)) { // at once: the next packet of torque_off must not wait
        for (uint8_t i = servos->count; i; i--, servo++)
            servo->torque = false;
        return false;
    }
    for (uint8_t budget = CDS_SERVOS_PER_CALL; servos->learnt < servos->count; budget--) {
        if (budget == 0)
            return true;
        servo = &servos->states[servos->learnt++];
        if (bytes[CDS_AT_INSTRUCTION] == CDS_RESET)
            expire(servo);
        else
            learn_packet(servos, servo, request, CDS_SOURCE_SENT);
    }
    if (bytes[CDS_AT_INSTRUCTION] == CDS_RESET)
        cds_servos_note_change(servos, CDS_BROADCAST_ID);
    return false;
}

/* ---- hooks ---- */

static bool on_sending(void *context, struct cds_request *request)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    const uint8_t *bytes = request->packet.bytes;
    bool has_more = false;

    if (servos->learnt == ALL_LEARNT || servos->count == 0)
        return false;
    if (bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE)
        has_more = learn_blocks(servos, bytes);
    else if (bytes[CDS_AT_ID] == CDS_BROADCAST_ID)
        has_more = learn_broadcast(servos, request);
    if (!has_more)
        servos->learnt = ALL_LEARNT;
    return has_more;
}

static bool on_end(void *context, struct cds_request *request, enum cds_result result)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    struct cds_queue *queue = servos->queue;

    if (servos->checked_request == request)
        servos->checked_request = NULL;
    servos->learnt = 0;
    if (result == CDS_OK || result == CDS_TIMEOUT || result == CDS_CORRUPT)
        learn_end(servos, request, result);
    if (!queue)
        return false;
    if (queue->first && queue->first->priority == CDS_PRIORITY_TORQUE_OFF)
        result = CDS_CANCELLED; // torque off waits: no retry
    return queue->hooks.on_end(queue, request, result);
}

static void on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    struct cds_servo_state *servo;

    if (servos->is_paused)
        return;
    servo = cds_servos_find(servos, id);
    if (!servo && servos->grows)
        servo = met(servos, id, error || servos->grows == CDS_GROWS_ALWAYS);
    if (error)
        note_error(servos, servo, error);
    if (!servo)
        return;
    if (event == CDS_EVENT_STALE_REPLY) {
        add(&servo->counters.stale_replies, 1);
        return;
    }
    add(event == CDS_EVENT_DUPLICATE_REPLY ? &servo->counters.duplicate_replies
                                           : &servo->counters.unexpected_packets,
        1);
    if (servo->status_return_level < CDS_LEVEL_ALL) { // it says more than it was set to
        servo->status_return_level = CDS_LEVEL_UNKNOWN;
        cds_servos_note_change(servos, id);
    }
}

/* The permit is asked now, unless the bus has just asked it. */
static enum cds_result submit(void *context, struct cds_request *request)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    struct cds_bus *bus = servos->bus;
    enum cds_result result = CDS_PENDING;

    if (!servos->queue && bus->request)
        return CDS_BUSY;
    if (servos->checked_request != request)
        result = cds_servos_permit(servos, request);
    if (result != CDS_OK && result != CDS_PENDING)
        return result;
    if (servos->queue)
        return servos->queue->hooks.submit(servos->queue, request);
    request->result = CDS_PENDING;
    cds_bus_start(bus, request);
    return CDS_OK;
}

static bool cancel(void *context, struct cds_request *request)
{
    struct cds_servos *servos = (struct cds_servos *)context;

    if (!request || servos->checked_request == request)
        servos->checked_request = NULL;
    if (!request)
        servos->learnt = 0; // the bus is opened again, perhaps amid a packet
    return servos->queue && servos->queue->hooks.cancel(servos->queue, request);
}

static uint8_t changed_since(void *context, uint16_t *epoch)
{
    const struct cds_servos *servos = (const struct cds_servos *)context;
    uint16_t before = *epoch;

    *epoch = servos->epoch;
    if (before == servos->epoch)
        return CDS_NO_ID;
    return (uint16_t)(before + 1u) == servos->epoch ? servos->changed_id : CDS_BROADCAST_ID;
}

static void set_move(void *context, const struct cds_request *request)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    struct cds_servo_state *servo = servos->states;

    servos->move_request = request;
    servos->move_is_valid = servos->move_is_answered = true;
    for (uint8_t i = servos->count; i; i--, servo++)
        servo->is_registered = false;
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}

/* ---- what the caller asks for ---- */

/* A servo of which nothing is known. */
static void meet(struct cds_servo_state *servo, uint8_t id, uint8_t baud_reg)
{
    *servo = (struct cds_servo_state){
        .highest = CDS_VALUE_MAX,
        .fastest = CDS_VALUE_MAX,
        .id = id,
        .second = CDS_NO_ID,
        .baud_reg = baud_reg,
        .return_delay = CDS_SERVOS_UNKNOWN,
        .status_return_level = CDS_LEVEL_ALL,
    };
}

static bool are_distinct(const struct cds_servo_state *states, uint8_t count)
{
    const struct cds_servo_state *end = states + count, *other;

    for (; states < end; states++) {
        if (states->id > CDS_ID_MAX)
            return false;
        for (other = states + 1; other < end; other++)
            if (other->id == states->id)
                return false;
    }
    return true;
}

enum cds_result cds_servos_begin(struct cds_servos *servos, const struct cds_servos_config *config)
{
    struct cds_bus *bus = config->bus;
    uint16_t epoch = servos->epoch; // a cycle may hold it from before
    enum cds_result result;

    if (bus->state == CDS_BUS_CLOSED || config->count > config->capacity ||
        config->capacity > CDS_ID_MAX + 1 || !are_distinct(config->states, config->count))
        return CDS_BAD_ARGUMENT;
    result = cds_bus_attach(bus, &servos->hooks);
    if (result != CDS_OK)
        return result;
    *servos = (struct cds_servos){
        .hooks = {.context = servos,
                  .permit = cds_servos_permit,
                  .submit = submit,
                  .cancel = cancel,
                  .on_sending = on_sending,
                  .on_end = on_end,
                  .permit_goal = cds_servos_permit_goal,
                  .changed_since = changed_since,
                  .set_move = set_move,
                  .on_packet = on_packet},
        .bus = bus,
        .queue = config->queue,
        .states = config->states,
        .count = config->count,
        .capacity = config->capacity,
        .grows = config->grows,
        .shortest_delay = config->shortest_delay,
        .echo_errors = cds_link_count(&bus->link.echo_errors),
        .epoch = epoch,
    };
    for (uint8_t i = 0; i < config->count; i++)
        meet(&config->states[i], config->states[i].id, bus->baud_reg);
    if (config->queue)
        cds_queue_begin(config->queue, bus);
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
    servos->inhibit_epoch = servos->epoch;
    return CDS_OK;
}

void cds_servos_forget(struct cds_servos *servos)
{
    servos->count = 0;
    servos->is_full = false;
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}

/* True if the packet on the wire may take an entry: it changes an ID. */
static bool is_entry_reserved(const struct cds_servos *servos)
{
    const struct cds_request *request = servos->bus->request;
    const uint8_t *bytes;

    if (!request || servos->bus->state < CDS_BUS_SENDING)
        return false;
    bytes = request->packet.bytes;
    return bytes[CDS_AT_INSTRUCTION] == CDS_RESET ||
           (bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && bytes[CDS_AT_PARAMETERS] <= CDS_REG_ID);
}

enum cds_result cds_servos_add(struct cds_servos *servos, uint8_t id)
{
    if (id > CDS_ID_MAX || cds_servos_find(servos, id))
        return CDS_BAD_ARGUMENT;
    if (servos->count + is_entry_reserved(servos) >= servos->capacity) {
        servos->is_full = true;
        return CDS_NO_ROOM;
    }
    meet(&servos->states[servos->count++], id, servos->bus->baud_reg);
    cds_servos_note_change(servos, id);
    return CDS_OK;
}

/* Limits and inhibits are the same under both IDs that a servo may have. A registered move under
 * way was checked by others. */
static void note_guard(struct cds_servos *servos, const struct cds_servo_state *servo)
{
    servos->move_is_valid = false;
    cds_servos_note_change(servos,
                           servo && servo->second == CDS_NO_ID ? servo->id : CDS_BROADCAST_ID);
}

static void set_limits(struct cds_servo_state *servo, uint16_t lowest, uint16_t highest,
                       uint16_t fastest)
{
    if (fastest < servo->fastest)
        servo->speed_known = false;
    if (lowest > servo->lowest || highest < servo->highest)
        servo->goal_known = false;
    servo->lowest = lowest;
    servo->highest = highest;
    servo->fastest = fastest;
    servo->has_limits = lowest > 0 || highest < CDS_VALUE_MAX || fastest < CDS_VALUE_MAX;
}

enum cds_result cds_servos_set_limits(struct cds_servos *servos, struct cds_servo_state *servo,
                                      uint16_t lowest, uint16_t highest, uint16_t fastest)
{
    struct cds_servo_state *other = second_of(servos, servo);

    if (lowest > highest || highest > CDS_VALUE_MAX || fastest > CDS_VALUE_MAX)
        return CDS_BAD_ARGUMENT;
    set_limits(servo, lowest, highest, fastest);
    if (other)
        set_limits(other, lowest, highest, fastest);
    note_guard(servos, servo);
    return CDS_OK;
}

bool cds_servos_may_drive(struct cds_servos *servos, uint8_t id)
{
    const struct cds_servo_state *servo = servos->states;

    if (servos->inhibited)
        return false;
    if (id != CDS_BROADCAST_ID) {
        servo = cds_servos_find(servos, id);
        return !servo ||
               (!cds_servo_is_inhibited(servo) && servo->presence != CDS_PRESENCE_OFFLINE);
    }
    for (uint8_t i = servos->count; i; i--, servo++)
        if (cds_servo_is_inhibited(servo))
            return false;
    return true;
}

uint8_t cds_servos_acknowledge(struct cds_servos *servos, struct cds_servo_state *servo)
{
    uint8_t alarms = servo ? servo->alarms : servos->alarms;
    struct cds_servo_state *each = servos->states;

    servos->alarms = 0;
    for (uint8_t i = servos->count; i; i--, each++) {
        if (!servo || servo == each)
            each->alarms = 0;
        servos->alarms |= each->alarms;
    }
    if (alarms)
        servos->news++;
    return alarms;
}

void cds_servos_inhibit_all(struct cds_servos *servos)
{
    servos->inhibited = true;
    note_guard(servos, NULL);
    servos->inhibit_epoch = servos->epoch;
}

/* The bits `keep` of the inhibits of `servo` stay, and `why` is added. */
static void set_inhibited(struct cds_servos *servos, struct cds_servo_state *servo, uint8_t keep,
                          uint8_t why)
{
    struct cds_servo_state *other = second_of(servos, servo);

    servo->inhibited = (uint8_t)((servo->inhibited & keep) | why) & 3u;
    if (other)
        other->inhibited = (uint8_t)((other->inhibited & keep) | why) & 3u;
    note_guard(servos, servo);
}

void cds_servos_inhibit(struct cds_servos *servos, struct cds_servo_state *servo, uint8_t why)
{
    set_inhibited(servos, servo, UINT8_MAX, why);
}

void cds_servos_release(struct cds_servos *servos, struct cds_servo_state *servo)
{
    set_inhibited(servos, servo, 0, 0);
}

static NOINLINE void release_all(struct cds_servos *servos, uint8_t keep)
{
    struct cds_servo_state *servo = servos->states;

    servos->inhibited = false;
    for (uint8_t i = servos->count; i; i--, servo++)
        servo->inhibited = (uint8_t)(servo->inhibited & keep) & 3u;
    note_guard(servos, NULL);
}

void cds_servos_release_all(struct cds_servos *servos)
{
    release_all(servos, 0);
}

void cds_servos_allow(struct cds_servos *servos)
{
    release_all(servos, CDS_INHIBIT_STATE_LOST);
}

void cds_servos_allow_reset(struct cds_servos *servos, bool is_allowed)
{
    servos->may_reset_all = is_allowed;
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}
