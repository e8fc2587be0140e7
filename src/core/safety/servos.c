/* SPDX-License-Identifier: MIT */
/* The servos of a bus: the list, and what the caller asks for; see servos.h. */
#include "cds55xx/servos.h"

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "cds55xx/packet.h"        // CDS_AT_*
#include "compiler.h"              // NOINLINE, OPTIMIZER_BARRIER()
#include "safety/permit.h"         // cds_servos_permit()
#include "safety/servos_internal.h"

/* The greatest distance of `inhibit_epoch` behind `epoch`. */
#define OLDEST 0x4000u

/* ---- the list ---- */

NOINLINE struct cds_servo_state *cds_servos_search(const struct cds_servos *servos, uint8_t id,
                                                   uint8_t *index)
{
    struct cds_servo_state *servo = servos->states;
    uint8_t count = servos->count;

    for (uint8_t i = 0; i < count; i++, servo++) {
        if (servo->id == id) {
            *index = i;
            return servo;
        }
    }
    return NULL;
}

NOINLINE struct cds_servo_state *cds_servos_find(struct cds_servos *servos, uint8_t id)
{
    uint8_t index;

    return cds_servos_search(servos, id, &index);
}

NOINLINE void cds_servos_note_change(struct cds_servos *servos, uint8_t id)
{
    servos->epoch++;
    if (servos->epoch < 2) // an answer has epoch 0 if none was asked for, epoch - 1 during a check
        servos->epoch = 2;
    if ((uint16_t)(servos->epoch - servos->inhibit_epoch) > OLDEST)
        servos->inhibit_epoch =
            (uint16_t)(servos->epoch - OLDEST); // a greater difference would change its sign
    servos->changed_id = id;
}

/* Returns 1 if the packet on the wire may take an entry, since it changes an ID; else 0. */
static uint8_t is_entry_reserved(const struct cds_servos *servos)
{
    const struct cds_request *request = servos->bus->request;
    const uint8_t *bytes;

    if (!request || servos->bus->state < CDS_BUS_SENDING)
        return 0;
    bytes = request->packet.bytes;
    if (bytes[CDS_AT_INSTRUCTION] == CDS_WRITE)
        return bytes[CDS_AT_PARAMETERS] <= CDS_REG_ID;
    return bytes[CDS_AT_INSTRUCTION] == CDS_RESET;
}

enum cds_result cds_servos_add(struct cds_servos *servos, uint8_t id)
{
    if (id > CDS_ID_MAX || cds_servos_find(servos, id))
        return CDS_BAD_ARGUMENT;
    if ((uint8_t)(servos->capacity - servos->count) <= is_entry_reserved(servos)) {
        servos->is_full = true;
        return CDS_NO_ROOM;
    }
    servos->states[servos->count++] = (struct cds_servo_state){
        .highest = CDS_VALUE_MAX,
        .fastest = CDS_VALUE_MAX,
        .id = id,
        .second = CDS_NO_ID,
        .baud_reg = servos->bus->baud_reg,
        .return_delay = CDS_SERVOS_UNKNOWN,
        .status_return_level = CDS_LEVEL_ALL,
    };
    cds_servos_note_change(servos, id);
    return CDS_OK;
}

struct cds_servo_state *cds_servos_meet(struct cds_servos *servos, uint8_t id, uint8_t is_told)
{
    if (servos->grows == CDS_GROWS_NEVER ||
        (servos->grows == CDS_GROWS_ON_ALARM_OR_SETTING && !is_told) ||
        cds_servos_add(servos, id) != CDS_OK)
        return NULL;
    return &servos->states[servos->count - 1];
}

void cds_servos_forget_from(struct cds_servos *servos, uint8_t count)
{
    if (count >= servos->count)
        return;
    servos->count = count;
    servos->is_full = false;
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}

void cds_servos_forget(struct cds_servos *servos)
{
    servos->count = 0;
    servos->is_full = false;
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}

enum cds_result cds_servos_forget_one(struct cds_servos *servos, struct cds_servo_state *servo)
{
    const struct cds_servo_state *last = &servos->states[servos->count - 1];
    struct cds_servo_state *other = cds_servos_second(servos, last);
    uint8_t index;

    if (servo->second != CDS_NO_ID)
        return CDS_BAD_ARGUMENT;
    if (servos->bus->request || (servos->queue && servos->queue->first))
        return CDS_BUSY;
    cds_servos_search(servos, servo->id, &index);
    if (other)
        other->second = index;
    *servo = *last;
    cds_servos_forget_from(servos, (uint8_t)(servos->count - 1u));
    return CDS_OK;
}

/* ---- the servos of a packet ---- */

#define WALK_BUDGET 3

NOINLINE void cds_walk_begin(struct cds_walk *walk, struct cds_servos *servos,
                             const struct cds_request *request, uint16_t epoch)
{
    if (servos->walk_request != request || servos->walk_epoch != epoch) {
        servos->walk_request = request;
        servos->walk_epoch = epoch;
        servos->walked = servos->walk_index = 0;
    }
    walk->servos = servos;
    walk->is_sync_write = request->packet.bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE;
    walk->budget = WALK_BUDGET;
}

NOINLINE uint8_t cds_walk_next(struct cds_walk *walk, uint8_t cost)
{
    struct cds_servos *servos = walk->servos;
    uint8_t index = servos->walk_index, id;
    struct cds_servo_state *servo = &servos->states[index];

    if (walk->is_sync_write ? walk->written.left <= walk->written.length : index >= servos->count)
        return CDS_WALK_ENDS;
    if (walk->budget <= 0)
        return CDS_PENDING;
    if (walk->is_sync_write)
        cds_written_next(&walk->written);
    else
        walk->written.id = servo->id;
    id = walk->written.id;
    if (index >= servos->count || servo->id != id) {
        if (walk->budget != WALK_BUDGET)
            return CDS_PENDING;
        if (cds_servos_search(servos, id, &servos->walk_index))
            return CDS_PENDING; // the next call finds it at once
        servo = NULL;
        cost = WALK_BUDGET;
    } else {
        servos->walk_index = (uint8_t)(index + 1u);
    }
    servos->walked++;
    walk->servo = servo;
    walk->budget = (int8_t)(walk->budget - cost);
    return CDS_OK;
}

/* ---- hooks ---- */

static enum cds_result request_ended(void *context, struct cds_request *request,
                                     enum cds_result result)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    struct cds_queue *queue = servos->queue;

    if (!cds_servos_take_routine(servos, request, (uint8_t)result)) {
        if (servos->walk_request == request) // the check of another request goes on
            servos->walk_request = NULL;
        if (result <= CDS_CORRUPT) // the packet was sent: see the order of result.h
            cds_servos_learn_end(servos, request, (uint8_t)result);
    }
    if (!queue)
        return result;
    // Nothing is retried while torque off waits. A retry leaves before all others of its priority:
    // the retry of a READ of torque off would leave before the broadcasts of the next torque off.
    if (result <= CDS_CORRUPT && queue->first && queue->first->priority == CDS_PRIORITY_TORQUE_OFF)
        request->retries = queue->retries;
    return queue->hooks.request_ended(queue, request, result);
}

static enum cds_result submit(void *context, struct cds_request *request)
{
    struct cds_queue *queue = ((struct cds_servos *)context)->queue;

    return queue ? queue->hooks.submit(queue, request) : CDS_BUSY;
}

/* The bus is opened again, and its counts begin again. A packet on the wire may be carried out. */
static void learn_reopening(struct cds_servos *servos)
{
    struct cds_request *request = servos->bus->request;

    if (request && servos->bus->state >= CDS_BUS_SENDING) {
        while (cds_servos_on_sending(servos, request)) {
        }
        cds_servos_learn_end(servos, request, CDS_CORRUPT);
    }
    servos->echo_errors = 0;
}

static bool cancel(void *context, struct cds_request *request)
{
    struct cds_servos *servos = (struct cds_servos *)context;

    if (!request)
        learn_reopening(servos);
    if (!request || servos->walk_request == request)
        servos->walk_request = NULL;
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

enum cds_result cds_servos_begin(struct cds_servos *servos, const struct cds_servos_config *config)
{
    uint16_t epoch = servos->epoch; // a cycle may hold it from before
    enum cds_result result;
    uint8_t i = 0;

    OPTIMIZER_BARRIER(servos);
    if (config->bus->state == CDS_BUS_CLOSED || config->capacity > CDS_ID_MAX + 1 ||
        config->count > config->capacity)
        return CDS_BAD_ARGUMENT;
    servos->hooks.permit = cds_servos_permit; // the bus looks whether there is one
    result = cds_bus_attach(config->bus, &servos->hooks);
    if (result != CDS_OK)
        return result;
    *servos = (struct cds_servos){
        .hooks = {.context = servos,
                  .permit = cds_servos_permit,
                  .submit = submit,
                  .cancel = cancel,
                  .on_sending = cds_servos_on_sending,
                  .request_ended = request_ended,
                  .permit_goal = cds_servos_permit_goal,
                  .changed_since = changed_since,
                  .set_move = set_move,
                  .on_packet = cds_servos_on_packet},
        .bus = config->bus,
        .queue = config->queue,
        .states = config->states,
        .capacity = config->capacity,
        .grows = config->grows,
        .shortest_delay = config->shortest_delay,
        .echo_errors = cds_link_count(&config->bus->link.echo_errors),
        .epoch = epoch,
    };
    if (config->queue)
        cds_queue_begin(config->queue, config->bus);
    while (i < config->count && cds_servos_add(servos, config->states[i].id) == CDS_OK)
        i++;
    if (i < config->count)
        servos->count = 0;
    servos->inhibit_epoch = servos->epoch;
    cds_servos_note_change(servos, CDS_BROADCAST_ID); // later than `inhibit_epoch`
    return i == config->count ? CDS_OK : CDS_BAD_ARGUMENT;
}

/* A limit or an inhibit has changed, under both IDs that a servo may have. A registered move under
 * way was checked against the old one. */
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
        servo->held &= (uint8_t)~CDS_HELD_SPEED;
    if (lowest > servo->lowest || highest < servo->highest)
        servo->held &= (uint8_t)~CDS_HELD_GOAL;
    servo->lowest = lowest;
    servo->highest = highest;
    servo->fastest = fastest;
    servo->has_limits = lowest > 0 || highest < CDS_VALUE_MAX || fastest < CDS_VALUE_MAX;
}

enum cds_result cds_servos_set_limits(struct cds_servos *servos, struct cds_servo_state *servo,
                                      uint16_t lowest, uint16_t highest, uint16_t fastest)
{
    struct cds_servo_state *other = cds_servos_second(servos, servo);

    if (lowest > highest || highest > CDS_VALUE_MAX || fastest > CDS_VALUE_MAX)
        return CDS_BAD_ARGUMENT;
    for (struct cds_servo_state *each = servo; each; each = each == servo ? other : NULL)
        set_limits(each, lowest, highest, fastest);
    note_guard(servos, servo);
    return CDS_OK;
}

bool cds_servos_may_drive(struct cds_servos *servos, uint8_t id)
{
    const struct cds_servo_state *servo = servos->states;

    if (servos->all_inhibited)
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
        servos->event_count++;
    return alarms;
}

NOINLINE void cds_servos_inhibit_all(struct cds_servos *servos)
{
    if (!servos->all_inhibited) { // else nothing changes, and a check under way goes on
        servos->all_inhibited = true;
        note_guard(servos, NULL);
    }
    servos->inhibit_epoch = servos->epoch;
}

/* The bits `keep` of the inhibits of `servo` stay, and `why` is added. */
static void set_inhibited(struct cds_servos *servos, struct cds_servo_state *servo, uint8_t keep,
                          uint8_t why)
{
    struct cds_servo_state *other = cds_servos_second(servos, servo);
    uint8_t inhibits = (uint8_t)((servo->inhibits & keep) | why) & 3u;

    if (servo->inhibits == inhibits)
        return;
    servo->inhibits = inhibits & 3u;
    if (other)
        other->inhibits = inhibits & 3u;
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
    uint8_t released = servos->all_inhibited;

    servos->all_inhibited = false;
    for (uint8_t i = servos->count; i; i--, servo++) {
        released = (uint8_t)(released | (servo->inhibits & ~keep));
        servo->inhibits = (uint8_t)(servo->inhibits & keep) & 3u;
    }
    if (released)
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

void cds_servos_reserve(struct cds_servos *servos, const struct cds_request *request,
                        const uint8_t *ids, uint8_t count)
{
    servos->reserved_for = request;
    servos->reserved_ids = ids;
    servos->reserved_count = count;
    cds_servos_note_change(servos, CDS_BROADCAST_ID); // packets that wait are checked again
}
