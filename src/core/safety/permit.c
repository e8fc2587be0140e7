/* SPDX-License-Identifier: MIT */
/* The permit, which checks every packet before it leaves; see permit.h. Rows in the comments are
 * those of docs/internals/permit.md. Manual: 2.4; 3.1.
 */
#include "safety/permit.h"

#include <string.h>

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/packet.h"        // CDS_AT_*
#include "compiler.h"              // NOINLINE
#include "safety/limits.h"         // cds_limits_check()
#include "safety/servos_internal.h"
#include "servo/goal.h" // CDS_GOAL_SIZE

/* One packet under check. */
struct check {
    struct cds_walk walk; // The first member, as `written` is of struct cds_walk: struct check,
                          // `walk` and `walk.written` have the same address.
    const uint8_t *bytes;
    const struct cds_request *request;
    uint8_t refused_id;
    bool has_turn;        // The request leaves next. Only then does the permit check packets to
                          // many servos.
    bool is_goal;         // goal and speed are written, and no other register
    bool inhibit_applies; // driving of all servos is inhibited, or was since the last check of this
                          // packet
};

/* True if the request carries the registered move. */
static inline bool is_of_move(const struct check *check)
{
    return check->request == check->walk.servos->move_request;
}

/* ---- one servo ---- */

/* True if the write sets the goal, the speed (also to 0) or an angle limit, or switches torque on.
 * An angle limit changes the mode, and in endless turn the speed register makes the servo turn. */
static inline bool drives(const struct cds_written *written)
{
    return written->sets & (CDS_SETS_MODE | CDS_SETS_GOAL | CDS_SETS_SPEED) ||
           (written->sets & CDS_SETS_TORQUE &&
            cds_written_value(written, CDS_REG_TORQUE_ENABLE, 0));
}

/* Checks that hold for every ID, whether the servo is known or not: row 7, and row 3 except the
 * gains (see check_write()). */
static NOINLINE uint8_t check_any(const struct check *check)
{
    const struct cds_written *written = &check->walk.written;

    if (check->inhibit_applies && drives(written))
        return CDS_INHIBITED;
    if (written->sets & CDS_SETS_REPLY &&
        cds_written_value(written, CDS_REG_RETURN_DELAY, UINT8_MAX) <
            check->walk.servos->shortest_delay)
        return CDS_TOO_EARLY;
    return CDS_OK;
}

/* Rows 20 to 22. A servo may carry out a registered write at any later time, unnoticed. So the
 * write must not change ID, rate, return delay, status return level or mode. */
static uint8_t check_registered(const struct check *check, struct cds_servo_state *servo)
{
    const struct cds_written *written = &check->walk.written;

    if (written->sets & (CDS_SETS_ID | CDS_SETS_REPLY | CDS_SETS_MODE))
        return CDS_LIMIT;
    if (!servo->has_limits)
        return CDS_OK;
    if (!is_of_move(check) || !check->is_goal)
        return CDS_LIMIT;
    return (uint8_t)cds_limits_check_goal(check->walk.servos, servo, written->data);
}

/* Rows 23 to 25. */
static uint8_t check_action(const struct check *check, const struct cds_servo_state *servo)
{
    if (cds_servo_is_inhibited(servo))
        return CDS_INHIBITED;
    if (!servo->has_limits)
        return CDS_OK;
    return is_of_move(check) && servo->is_registered && check->walk.servos->move_is_answered
               ? CDS_OK
               : CDS_LIMIT;
}

/* Rows 10 to 13. A packet that drives is not sent to an OFFLINE servo alone. A packet to several
 * servos is sent even if one of them is OFFLINE. */
static NOINLINE uint8_t check_servo(const struct check *check, struct cds_servo_state *servo)
{
    const struct cds_written *written = &check->walk.written;
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
    if (check->is_goal)
        return (uint8_t)cds_limits_check_goal(check->walk.servos, servo, written->data);
    return cds_limits_check(check->walk.servos, servo, written);
}

/* Rows 40 and 41. */
static uint8_t check_id(const struct check *check, const struct cds_servo_state *servo, uint8_t to)
{
    uint8_t id = check->bytes[CDS_AT_ID];

    return cds_servos_may_become(check->walk.servos, servo, id, to) ? CDS_OK : CDS_LIMIT;
}

/* ---- many servos: each call checks some of them ---- */

ALWAYS_INLINE enum cds_result check_goal(struct cds_servos *servos, struct cds_servo_state *servo,
                                         const uint8_t *goal)
{
    return cds_servo_is_inhibited(servo) ? CDS_INHIBITED
                                         : cds_limits_check_goal(servos, servo, goal);
}

static uint8_t check_block(struct check *check)
{
    const struct cds_written *written = &check->walk.written;
    struct cds_servos *servos = check->walk.servos;
    uint8_t result = check_any(check);

    if (result != CDS_OK)
        return result;
    if (written->sets & CDS_SETS_ID && servos->count)
        return CDS_LIMIT;
    if (written->id > CDS_ID_MAX) // the block may reach every servo, or none
        return servos->count && drives(written) ? CDS_LIMIT : CDS_OK;
    if (check->walk.servo)
        return check_servo(check, check->walk.servo);
    cds_servos_meet(servos, written->id, 0);
    return CDS_OK;
}

static NOINLINE uint8_t check_many(struct check *check)
{
    struct cds_walk *walk = &check->walk;
    uint8_t result;

    if (!check->has_turn)
        return CDS_PENDING;
    while ((result = cds_walk_next(walk, 1)) == CDS_OK) {
        if (!walk->is_sync_write)
            result = check_servo(check, walk->servo);
        else if (check->is_goal && walk->servo)
            result = (uint8_t)check_goal(walk->servos, walk->servo, walk->written.data);
        else
            result = check_block(check);
        if (result != CDS_OK) {
            check->refused_id = walk->written.id;
            return result;
        }
        if (!check->is_goal && walk->servo && walk->servo->has_limits)
            walk->budget = (int8_t)(walk->budget - 2); // such a check takes twice as long
    }
    if (result == CDS_PENDING) {
        walk->servos->walk_epoch = walk->servos->epoch; // the servos checked so far stay good
        return result;
    }
    // it is not known how a servo takes a block that is cut
    return check->inhibit_applies && walk->written.left ? CDS_INHIBITED : CDS_OK;
}

/* ---- the packet ---- */

static uint8_t check_write(struct check *check, struct cds_servo_state *servo)
{
    struct cds_written *written = &check->walk.written;
    struct cds_servos *servos = check->walk.servos;
    const uint8_t *bytes = check->bytes;
    uint8_t result, sets;

    if (cds_written_is_torque_off(bytes))
        return CDS_OK;
    if (!cds_written_by(bytes, check->has_turn ? servos->walked : 0, written))
        return check->inhibit_applies ? CDS_INHIBITED : CDS_OK;
    sets = written->sets;
    check->is_goal = written->address == CDS_REG_GOAL_POSITION && written->length == CDS_GOAL_SIZE;
    if (check->inhibit_applies &&
        sets & (CDS_SETS_GAIN | CDS_SETS_MODE | CDS_SETS_GOAL | CDS_SETS_SPEED))
        return CDS_INHIBITED;
    if (bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE) {
        if (!check->inhibit_applies && servos->grows != CDS_GROWS_ALWAYS &&
            !(sets & (CDS_SETS_DRIVE | CDS_SETS_REPLY | CDS_SETS_ID)))
            return CDS_OK;
        return check_many(check);
    }
    result = check_any(check);
    if (result == CDS_OK && servo)
        result = check_servo(check, servo);
    if (result != CDS_OK)
        return result;
    if (written->id == CDS_BROADCAST_ID) {
        if (sets & CDS_SETS_ID && servos->count)
            return CDS_LIMIT;
        return bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && !(sets & CDS_SETS_DRIVE)
                   ? CDS_OK
                   : check_many(check);
    }
    if (sets & CDS_SETS_ID)
        return check_id(check, servo, cds_written_value(written, CDS_REG_ID, written->id));
    return CDS_OK;
}

static uint8_t check_action_or_reset(struct check *check, struct cds_servo_state *servo)
{
    struct cds_servos *servos = check->walk.servos;
    bool is_to_all = check->bytes[CDS_AT_ID] == CDS_BROADCAST_ID;

    if (check->inhibit_applies)
        return CDS_INHIBITED;
    if (check->bytes[CDS_AT_INSTRUCTION] == CDS_ACTION) {
        if (is_to_all)
            return check_many(check);
        return servo ? check_servo(check, servo) : CDS_OK;
    }
    if (is_to_all)
        return servos->count && !servos->may_reset_all ? CDS_LIMIT : CDS_OK;
    return check_id(check, servo, CDS_FACTORY_ID);
}

static inline uint8_t check_packet(struct check *check, struct cds_servo_state *servo)
{
    uint8_t instruction = check->bytes[CDS_AT_INSTRUCTION], longest = CDS_LENGTH_MIN;

    if ((instruction == CDS_REG_WRITE || instruction == CDS_ACTION) && is_of_move(check) &&
        !check->walk.servos->move_is_valid)
        return check->inhibit_applies ? CDS_INHIBITED : CDS_LIMIT;
    switch (instruction) {
    case CDS_READ: longest = CDS_LENGTH_MIN + 2; // fall through
    case CDS_PING:
        return check->inhibit_applies && check->bytes[CDS_AT_LENGTH] > longest ? CDS_INHIBITED
                                                                               : CDS_OK;
    case CDS_WRITE:
    case CDS_REG_WRITE:
    case CDS_SYNC_WRITE: return check_write(check, servo);
    case CDS_ACTION:
    case CDS_RESET: return check_action_or_reset(check, servo);
    default:
        return check->inhibit_applies ? CDS_INHIBITED
                                      : CDS_OK; // not in the manual: limits do not apply
    }
}

/* Registers of a reserved servo that only the request of the reservation may write: what moves the
 * servo, and its ID, baud rate, return delay and status return level. Goals and feedback would no
 * longer reach a servo with another ID or rate. */
#define RESERVED_REGISTERS                                                                         \
    (CDS_SETS_ID | CDS_SETS_REPLY | CDS_SETS_MODE | CDS_SETS_GOAL | CDS_SETS_SPEED)

/* Rows 14 and 15. */
static NOINLINE bool is_reserved(const struct cds_servos *servos, const struct cds_request *request)
{
    const uint8_t *bytes = request->packet.bytes;
    uint8_t id = bytes[CDS_AT_ID];
    struct cds_written written;

    if (request == servos->reserved_for)
        return false;
    switch (bytes[CDS_AT_INSTRUCTION]) {
    case CDS_SYNC_WRITE: id = CDS_BROADCAST_ID; // fall through
    case CDS_WRITE:
    case CDS_REG_WRITE:
        if (!cds_written_by(bytes, 0, &written) || !(written.sets & RESERVED_REGISTERS))
            return false;
        break;
    case CDS_ACTION:
    case CDS_RESET: break;
    default: return false;
    }
    return id > CDS_ID_MAX || memchr(servos->reserved_ids, id, servos->reserved_count);
}

static NOINLINE uint8_t check_anew(struct cds_servos *servos, struct cds_request *request,
                                   struct cds_servo_state *servo)
{
    const uint8_t *bytes = request->packet.bytes;
    struct check check;
    const struct cds_request *current = servos->bus->request;
    bool is_submitted = !current && request->permit_epoch == 0, has_turn = current == request;
    uint8_t result;

    if (servos->reserved_count && is_reserved(servos, request)) {
        servos->refused_id = bytes[CDS_AT_ID];
        return CDS_RESERVED;
    }
    if (!servo &&
        (bytes[CDS_AT_INSTRUCTION] == CDS_WRITE || bytes[CDS_AT_INSTRUCTION] == CDS_REG_WRITE))
        servo = cds_servos_meet(servos, bytes[CDS_AT_ID],
                                bytes[CDS_AT_PARAMETERS] <= CDS_REG_STATUS_RETURN_LEVEL);
    check.bytes = bytes;
    check.refused_id = bytes[CDS_AT_ID];
    check.walk.written.sets = check.walk.written.left = 0;
    check.walk.servos = servos;
    // False if another request is in flight, and if cds_bus_start() begins this one: then a later
    // poll checks a packet to many servos.
    check.has_turn = has_turn || is_submitted;
    check.is_goal = false;
    if (check.has_turn)
        cds_walk_begin(&check.walk, servos, request, servos->epoch);
    if (is_submitted)
        check.walk.budget--; // a submit takes longer than a poll
    check.request = request;
    check.inhibit_applies =
        servos->all_inhibited ||
        (request->permit_epoch && (int16_t)(servos->inhibit_epoch - request->permit_epoch) > 0);
    result = check_packet(&check, servo);
    if (result == CDS_PENDING) {
        if (request->permit_epoch == 0) // an inhibit from now on applies, even if it ends first
            request->permit_epoch = (uint16_t)(servos->epoch - 1u);
        return result;
    }
    if (servos->walk_request == request)
        servos->walk_request = NULL; // the next check of this request begins again
    if (result == CDS_OK)
        request->permit_epoch = servos->epoch;
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
    if (request->permit_epoch == servos->epoch ||
        (!servos->all_inhibited && (instruction == CDS_READ || instruction == CDS_PING)))
        return CDS_OK;
    return (enum cds_result)check_anew(servos, request, servo);
}

/* The entry is not at the index that the caller gave. */
static NOINLINE enum cds_result search_and_check_goal(struct cds_servos *servos, uint8_t id,
                                                      uint8_t *index, const uint8_t *goal)
{
    struct cds_servo_state *servo = cds_servos_search(servos, id, index);

    if (servo)
        return check_goal(servos, servo, goal);
    cds_servos_meet(servos, id, 0);
    return CDS_OK;
}

enum cds_result cds_servos_permit_goal(void *context, uint8_t id, uint8_t *index,
                                       const uint8_t *goal)
{
    struct cds_servos *servos = (struct cds_servos *)context;
    struct cds_servo_state *servo = &servos->states[*index];

    if (servos->all_inhibited)
        return CDS_INHIBITED;
    if (*index >= servos->count || servo->id != id)
        return search_and_check_goal(servos, id, index, goal);
    return check_goal(servos, servo, goal);
}
