/* The one door; see permit.h. Its rules, by number: docs/permit.md. Manual: 2.4; 3.1. */
#include "safety/permit.h"

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/packet.h"        // CDS_AT_*
#include "compiler.h"              // NOINLINE
#include "safety/limits.h"         // cds_limits_check()
#include "safety/servos_internal.h"
#include "servo/goal.h" // CDS_GOAL_SIZE

/* One packet under check. */
struct check {
    struct cds_written written; // first: one address is that of both
    struct cds_servos *servos;
    struct cds_request *request;
    const uint8_t *bytes;
    uint8_t refused_id;
    bool is_of_move;   // `request` carries the registered move
    bool is_inhibited; // driving is, or was since this packet was checked last
};

/* ---- one servo ---- */

/* Goal, speed (0 too), angle limit, or torque on. An angle limit changes the mode, and in endless
 * turn the speed register makes the servo turn. */
static inline bool drives(const struct cds_written *written)
{
    return written->sets & (CDS_SETS_MODE | CDS_SETS_GOAL | CDS_SETS_SPEED) ||
           (written->sets & CDS_SETS_TORQUE &&
            cds_written_value(written, CDS_REG_TORQUE_ENABLE, 0));
}

static NOINLINE bool is_goal_and_speed(const struct cds_written *written)
{
    return written->address == CDS_REG_GOAL_POSITION && written->length == CDS_GOAL_SIZE;
}

/* For servos of any ID, known or not. Margins, proportions and punch decide how far from its goal a
 * servo stands still whose torque is on. */
static NOINLINE uint8_t check_any(const struct check *check)
{
    const struct cds_written *written = &check->written;

    if (check->is_inhibited && (written->sets & CDS_SETS_GAIN || drives(written)))
        return CDS_INHIBITED;
    if (written->sets & CDS_SETS_REPLY &&
        cds_written_value(written, CDS_REG_RETURN_DELAY, UINT8_MAX) < check->servos->shortest_delay)
        return CDS_TOO_EARLY;
    return CDS_OK;
}

/* What an ACTION that is not heard leaves behind must not change where and how a servo answers. */
static uint8_t check_registered(const struct check *check, struct cds_servo_state *servo)
{
    const struct cds_written *written = &check->written;

    if (written->sets & (CDS_SETS_ID | CDS_SETS_REPLY | CDS_SETS_MODE))
        return CDS_LIMIT;
    if (!servo->has_limits)
        return CDS_OK;
    if (!check->is_of_move || !is_goal_and_speed(written))
        return CDS_LIMIT;
    return cds_limits_check_goal(servo, written->data);
}

static uint8_t check_action(const struct check *check, const struct cds_servo_state *servo)
{
    if (cds_servo_is_inhibited(servo))
        return CDS_INHIBITED;
    if (!servo->has_limits)
        return CDS_OK;
    return check->is_of_move && servo->is_registered && check->servos->move_is_answered ? CDS_OK
                                                                                        : CDS_LIMIT;
}

/* A servo that is OFFLINE refuses what is sent to it alone; it stops no packet to others. */
static NOINLINE uint8_t check_servo(const struct check *check, struct cds_servo_state *servo)
{
    const struct cds_written *written = &check->written;
    uint8_t instruction = check->bytes[CDS_AT_INSTRUCTION];
    uint8_t is_inhibited = cds_servo_is_inhibited(servo);

    if (instruction == CDS_ACTION)
        return check_action(check, servo);
    if (servo->presence == CDS_PRESENCE_OFFLINE && check->bytes[CDS_AT_ID] != CDS_BROADCAST_ID &&
        instruction != CDS_SYNC_WRITE)
        is_inhibited = 1;
    if (is_inhibited && drives(written))
        return CDS_INHIBITED;
    if (instruction == CDS_REG_WRITE)
        return check_registered(check, servo);
    if (is_goal_and_speed(written))
        return cds_limits_check_goal(servo, written->data);
    return cds_limits_check(servo, written);
}

static uint8_t check_id(const struct check *check, const struct cds_servo_state *servo, uint8_t to)
{
    uint8_t id = check->bytes[CDS_AT_ID];

    return cds_servos_may_become(check->servos, servo, id, to) ? CDS_OK : CDS_LIMIT;
}

/* ---- many servos, some each call ---- */

/* The check begins, unless it goes on: nothing has changed since the last call. When a request
 * ends, `checked_request` is cleared. */
static NOINLINE void begin_many(const struct check *check)
{
    struct cds_servos *servos = check->servos;

    if (servos->checked_request != check->request || servos->checked_epoch != servos->epoch) {
        servos->checked_request = check->request;
        servos->checked_epoch = servos->epoch;
        servos->checked = 0;
        servos->checked_index = 0;
    }
}

static NOINLINE uint8_t check_all(struct check *check)
{
    uint8_t cost = check->written.sets == CDS_SETS_TORQUE ? 1 : 3;
    struct cds_servos *servos = check->servos;
    uint8_t result;
    struct cds_walk walk;

    if (check->bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && !(check->written.sets & CDS_SETS_DRIVE))
        return CDS_OK;
    begin_many(check);
    cds_walk_begin(&walk, servos, servos->checked_index);
    for (; walk.index < servos->count; walk.index++, walk.servo++) {
        if (walk.budget <= 0) {
            servos->checked_index = walk.index;
            return CDS_PENDING;
        }
        result = check_servo(check, walk.servo);
        if (result != CDS_OK) {
            check->refused_id = walk.servo->id;
            return result;
        }
        cds_walk_pay(&walk, cost);
    }
    return CDS_OK;
}

static inline uint8_t check_block(struct check *check, struct cds_walk *walk)
{
    const struct cds_written *written = &check->written;
    struct cds_servos *servos = check->servos;
    uint8_t result = check_any(check);
    struct cds_servo_state *servo;

    if (result != CDS_OK)
        return result;
    if (written->sets & CDS_SETS_ID && servos->count)
        return CDS_LIMIT;
    if (written->id > CDS_ID_MAX) // it may reach every servo, or none
        return servos->count && drives(written) ? CDS_LIMIT : CDS_OK;
    if (!(written->sets & CDS_SETS_DRIVE) && servos->grows != CDS_GROWS_ALWAYS)
        return CDS_OK;
    servo = cds_walk_to(walk, servos, written->id);
    if (!servo) {
        if (cds_servos_meet(servos, written->id, 0))
            servos->checked_epoch = servos->epoch; // what was found good still is
        return CDS_OK;
    }
    return check_servo(check, servo);
}

static NOINLINE uint8_t check_sync_write(struct check *check)
{
    uint8_t sets = check->written.sets;
    uint8_t cost = sets & CDS_SETS_DRIVE ? (sets == CDS_SETS_TORQUE ? 2 : 4) : 1;
    struct cds_servos *servos = check->servos;
    uint8_t result;
    struct cds_walk walk;

    if (!check->is_inhibited && servos->grows != CDS_GROWS_ALWAYS &&
        !(sets & (CDS_SETS_DRIVE | CDS_SETS_REPLY | CDS_SETS_ID)))
        return CDS_OK;
    if (is_goal_and_speed(&check->written))
        cost = 1;
    begin_many(check);
    cds_walk_begin(&walk, servos, servos->checked_index);
    cds_written_by(check->bytes, servos->checked, &check->written);
    while (cds_written_next(&check->written)) {
        if (walk.budget <= 0) {
            servos->checked_index = walk.index;
            return CDS_PENDING;
        }
        result = check_block(check, &walk);
        if (result != CDS_OK) {
            check->refused_id = check->written.id;
            return result;
        }
        servos->checked++;
        cds_walk_pay(&walk, cost);
    }
    // what a servo makes of a block that is cut is not known
    return check->is_inhibited && check->written.left ? CDS_INHIBITED : CDS_OK;
}

/* ---- the packet ---- */

static uint8_t check_write(struct check *check, struct cds_servo_state *servo)
{
    struct cds_written *written = &check->written;
    const uint8_t *bytes = check->bytes;
    uint8_t result;

    if (cds_written_is_torque_off(bytes))
        return CDS_OK;
    if (!cds_written_by(bytes, 0, written))
        return check->is_inhibited ? CDS_INHIBITED : CDS_OK;
    if (bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE)
        return check_sync_write(check);
    result = check_any(check);
    if (result == CDS_OK && servo)
        result = check_servo(check, servo);
    if (result != CDS_OK)
        return result;
    if (written->id == CDS_BROADCAST_ID)
        return written->sets & CDS_SETS_ID && check->servos->count ? CDS_LIMIT : check_all(check);
    if (written->sets & CDS_SETS_ID)
        return check_id(check, servo, cds_written_value(written, CDS_REG_ID, written->id));
    return CDS_OK;
}

static uint8_t check_action_or_reset(struct check *check, struct cds_servo_state *servo)
{
    struct cds_servos *servos = check->servos;
    bool is_to_all = check->bytes[CDS_AT_ID] == CDS_BROADCAST_ID;

    if (check->is_inhibited)
        return CDS_INHIBITED;
    if (check->bytes[CDS_AT_INSTRUCTION] == CDS_ACTION) {
        if (is_to_all)
            return check_all(check);
        return servo ? check_action(check, servo) : CDS_OK;
    }
    if (is_to_all)
        return servos->count && !servos->may_reset_all ? CDS_LIMIT : CDS_OK;
    return check_id(check, servo, CDS_FACTORY_ID);
}

static inline uint8_t check_packet(struct check *check, struct cds_servo_state *servo)
{
    uint8_t instruction = check->bytes[CDS_AT_INSTRUCTION], longest = CDS_LENGTH_MIN;

    if (check->is_of_move && !check->servos->move_is_valid &&
        (instruction == CDS_REG_WRITE || instruction == CDS_ACTION))
        return check->is_inhibited ? CDS_INHIBITED : CDS_LIMIT;
    switch (instruction) {
    case CDS_READ: longest = CDS_LENGTH_MIN + 2; // fall through
    case CDS_PING:
        return check->is_inhibited && check->bytes[CDS_AT_LENGTH] > longest ? CDS_INHIBITED
                                                                            : CDS_OK;
    case CDS_WRITE:
    case CDS_REG_WRITE:
    case CDS_SYNC_WRITE: return check_write(check, servo);
    case CDS_ACTION:
    case CDS_RESET: return check_action_or_reset(check, servo);
    default: return check->is_inhibited ? CDS_INHIBITED : CDS_OK;
    }
}

static NOINLINE uint8_t check_anew(struct cds_servos *servos, struct cds_request *request,
                                   struct cds_servo_state *servo)
{
    const uint8_t *bytes = request->packet.bytes;
    struct check check;
    uint8_t result;

    if (servos->was_asked && servos->checked_request == request) {
        servos->was_asked = false; // by the bus, in this very call of cds_bus_submit()
        return CDS_PENDING;
    }
    if (!servo &&
        (bytes[CDS_AT_INSTRUCTION] == CDS_WRITE || bytes[CDS_AT_INSTRUCTION] == CDS_REG_WRITE))
        servo = cds_servos_meet(servos, bytes[CDS_AT_ID],
                                bytes[CDS_AT_PARAMETERS] <= CDS_REG_STATUS_RETURN_LEVEL);
    check.servos = servos;
    check.request = request;
    check.bytes = bytes;
    check.refused_id = bytes[CDS_AT_ID];
    check.written.sets = 0;
    check.is_of_move = request == servos->move_request;
    check.is_inhibited = servos->inhibited ||
                         (request->check && (int16_t)(servos->inhibit_epoch - request->check) > 0);
    result = check_packet(&check, servo);
    if (result == CDS_PENDING) {
        if (request->check == 0) // an inhibit from now on refuses it, also if it ends before
            request->check = (uint16_t)(servos->epoch - 1u);
        return result;
    }
    if (servos->checked_request == request)
        servos->checked_request = NULL;
    if (result == CDS_OK)
        request->check = servos->epoch;
    else
        servos->refused_id = check.refused_id;
    if (result == CDS_TOO_EARLY)
        servos->too_early++;
    return result;
}

enum cds_result cds_servos_permit(void *context, struct cds_request *request)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    const uint8_t *bytes = request->packet.bytes;
    struct cds_servo_state *servo = NULL;
    uint8_t instruction = bytes[CDS_AT_INSTRUCTION];

    request->return_delay_us = servos->bus->return_delay_us;
    request->is_muted = false;
    if (bytes[CDS_AT_ID] <= CDS_ID_MAX)
        servo = cds_servos_at(servos, bytes[CDS_AT_ID], &request->servo_index);
    if (servo && !servos->is_paused && !request->ignores_servo_state) {
        uint8_t level = servo->status_return_level;

        if (servo->return_delay != CDS_SERVOS_UNKNOWN)
            request->return_delay_us = (uint16_t)(2u * servo->return_delay);
        if (level <= CDS_LEVEL_READ && instruction != CDS_PING) {
            if (instruction != CDS_READ) {
                request->is_muted = true;
            } else if (level == CDS_LEVEL_PING) {
                servos->refused_id = servo->id;
                return CDS_NO_REPLY_DUE;
            }
        }
    }
    if (request->check == servos->epoch ||
        (!servos->inhibited && (instruction == CDS_READ || instruction == CDS_PING)))
        return CDS_OK;
    return (enum cds_result)check_anew(servos, request, servo);
}

enum cds_result cds_servos_permit_goal(void *context, uint8_t id, uint8_t *index,
                                       const uint8_t *goal)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    struct cds_servo_state *servo;

    if (servos->inhibited)
        return CDS_INHIBITED;
    servo = cds_servos_at(servos, id, index);
    if (!servo) {
        cds_servos_meet(servos, id, 0);
        return CDS_OK;
    }
    if (cds_servo_is_inhibited(servo))
        return CDS_INHIBITED;
    return (enum cds_result)cds_limits_check_goal(servo, goal);
}
