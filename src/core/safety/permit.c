/* The one door; see permit.h. Its rules, by number: docs/permit.md. Manual: 2.4; 3.1. */
#include "safety/permit.h"

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/packet.h"        // CDS_AT_*
#include "compiler.h"              // NOINLINE
#include "safety/limits.h"         // cds_limits_check()
#include "safety/servos_internal.h"
#include "servo/goal.h" // CDS_GOAL_SIZE

/* Registers that inhibits and limits concern. */
#define SETS_DRIVE (CDS_SETS_MODE | CDS_SETS_TORQUE | CDS_SETS_GOAL | CDS_SETS_SPEED)

/* One packet under check. */
struct check {
    struct cds_servos *servos;
    struct cds_request *request;
    const uint8_t *bytes;
    struct cds_written written;
    uint8_t refused_id;
    bool is_inhibited; // driving is, or was since this packet was checked last
};

/* ---- one servo ---- */

/* Goal, speed (0 too), angle limit, or torque on. An angle limit changes the mode, and in endless
 * turn the speed register makes the servo turn. */
static bool drives(const struct cds_written *written)
{
    return written->sets & (CDS_SETS_MODE | CDS_SETS_GOAL | CDS_SETS_SPEED) ||
           (written->sets & CDS_SETS_TORQUE &&
            cds_written_value(written, CDS_REG_TORQUE_ENABLE, 0));
}

/* For servos of any ID, known or not. Margins, proportions and punch decide how far from its goal a
 * servo stands still whose torque is on. */
static enum cds_result check_any(const struct check *check)
{
    const struct cds_written *written = &check->written;

    if (check->is_inhibited && (written->sets & CDS_SETS_GAIN || drives(written)))
        return CDS_INHIBITED;
    if (written->sets & CDS_SETS_REPLY &&
        cds_written_value(written, CDS_REG_RETURN_DELAY, UINT8_MAX) < check->servos->shortest_delay)
        return CDS_TOO_EARLY;
    return CDS_OK;
}

static bool is_of_move(const struct check *check)
{
    return check->request == check->servos->move_request;
}

/* What an ACTION that is not heard leaves behind must not change where and how a servo answers. */
static enum cds_result check_registered(const struct check *check, struct cds_servo_state *servo)
{
    const struct cds_written *written = &check->written;

    if (written->sets & (CDS_SETS_ID | CDS_SETS_REPLY | CDS_SETS_MODE))
        return CDS_LIMIT;
    if (!servo->has_limits)
        return CDS_OK;
    if (!is_of_move(check) || written->address != CDS_REG_GOAL_POSITION ||
        written->length != CDS_GOAL_SIZE)
        return CDS_LIMIT;
    return cds_limits_check_goal(servo, written->data);
}

static enum cds_result check_action(const struct check *check, const struct cds_servo_state *servo)
{
    if (cds_servo_is_inhibited(servo))
        return CDS_INHIBITED;
    if (!servo->has_limits)
        return CDS_OK;
    return is_of_move(check) && servo->is_registered && check->servos->move_is_answered ? CDS_OK
                                                                                        : CDS_LIMIT;
}

/* A servo that is OFFLINE refuses what is sent to it alone; it stops no packet to others. */
static NOINLINE enum cds_result check_servo(const struct check *check,
                                            struct cds_servo_state *servo)
{
    uint8_t id = check->bytes[CDS_AT_ID], instruction = check->bytes[CDS_AT_INSTRUCTION];
    const struct cds_written *written = &check->written;
    bool is_inhibited = cds_servo_is_inhibited(servo);

    if (instruction == CDS_ACTION)
        return check_action(check, servo);
    if (servo->presence == CDS_PRESENCE_OFFLINE && id != CDS_BROADCAST_ID &&
        instruction != CDS_SYNC_WRITE)
        is_inhibited = true;
    if (is_inhibited && drives(written))
        return CDS_INHIBITED;
    if (instruction == CDS_REG_WRITE)
        return check_registered(check, servo);
    return cds_limits_check(servo, written);
}

static enum cds_result check_id(const struct check *check, const struct cds_servo_state *servo,
                                uint8_t to)
{
    uint8_t id = check->bytes[CDS_AT_ID];

    return cds_servos_may_become(check->servos, servo, id, to) ? CDS_OK : CDS_LIMIT;
}

/* ---- many servos, some each call ---- */

/* The check of this request begins, unless it goes on: nothing has changed since the last call.
 * When a request ends, `checked_request` is cleared. */
static void begin_many(const struct check *check)
{
    struct cds_servos *servos = check->servos;

    if (servos->checked_request == check->request && servos->checked_epoch == servos->epoch)
        return;
    servos->checked_request = check->request;
    servos->checked_epoch = servos->epoch;
    servos->checked = 0;
    servos->checked_index = UINT8_MAX;
}

static NOINLINE enum cds_result check_all(struct check *check)
{
    struct cds_servos *servos = check->servos;
    enum cds_result result;

    if (check->bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && !(check->written.sets & SETS_DRIVE))
        return CDS_OK;
    begin_many(check);
    for (uint8_t budget = CDS_SERVOS_PER_CALL; servos->checked < servos->count; budget--) {
        struct cds_servo_state *servo = &servos->states[servos->checked];

        if (budget == 0)
            return CDS_PENDING;
        result = check_servo(check, servo);
        if (result != CDS_OK) {
            check->refused_id = servo->id;
            return result;
        }
        servos->checked++;
    }
    return CDS_OK;
}

static enum cds_result check_block(struct check *check, uint8_t *budget)
{
    const struct cds_written *written = &check->written;
    struct cds_servos *servos = check->servos;
    enum cds_result result = check_any(check);
    struct cds_servo_state *servo;

    if (result != CDS_OK)
        return result;
    if (written->sets & CDS_SETS_ID && servos->count)
        return CDS_LIMIT;
    if (written->id > CDS_ID_MAX) // it may reach every servo, or none
        return servos->count && drives(written) ? CDS_LIMIT : CDS_OK;
    servo = cds_servos_next(servos, written->id, &servos->checked_index, budget);
    if (!servo) {
        if (servos->grows == CDS_GROWS_ALWAYS && cds_servos_add(servos, written->id) == CDS_OK)
            servos->checked_epoch = servos->epoch; // what was found good is so still
        return CDS_OK;
    }
    if (written->sets == (CDS_SETS_GOAL | CDS_SETS_SPEED) && written->length == CDS_GOAL_SIZE)
        return cds_servo_is_inhibited(servo) ? CDS_INHIBITED
                                             : cds_limits_check_goal(servo, written->data);
    return check_servo(check, servo);
}

static NOINLINE enum cds_result check_sync_write(struct check *check)
{
    uint8_t budget = CDS_SERVOS_PER_CALL;
    struct cds_servos *servos = check->servos;
    const uint8_t *bytes = check->bytes;
    uint16_t end;

    if (!check->is_inhibited && servos->grows != CDS_GROWS_ALWAYS &&
        !(check->written.sets & (SETS_DRIVE | CDS_SETS_REPLY | CDS_SETS_ID)))
        return CDS_OK;
    begin_many(check);
    while (cds_written_block(bytes, servos->checked, &check->written)) {
        enum cds_result result;

        if (budget == 0)
            return CDS_PENDING;
        budget--;
        result = check_block(check, &budget);
        if (result != CDS_OK) {
            check->refused_id = check->written.id;
            return result;
        }
        servos->checked++;
    }
    end = (uint16_t)(servos->checked * (check->written.length + 1u) + CDS_LENGTH_MIN + 2u);
    if (check->is_inhibited && end != bytes[CDS_AT_LENGTH])
        return CDS_INHIBITED; // the last block is cut: what a servo makes of it is not known
    return CDS_OK;
}

/* ---- the packet ---- */

static bool is_torque_off(const uint8_t *bytes)
{
    return bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && bytes[CDS_AT_LENGTH] == CDS_LENGTH_MIN + 2 &&
           bytes[CDS_AT_PARAMETERS] == CDS_REG_TORQUE_ENABLE && bytes[CDS_AT_PARAMETERS + 1] == 0;
}

static enum cds_result check_write(struct check *check, struct cds_servo_state *servo)
{
    struct cds_written *written = &check->written;
    const uint8_t *bytes = check->bytes;
    enum cds_result result;

    if (is_torque_off(bytes))
        return CDS_OK;
    if (!cds_written_by(bytes, written))
        return check->is_inhibited ? CDS_INHIBITED : CDS_OK;
    if (bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE)
        return check_sync_write(check);
    result = check_any(check);
    if (result != CDS_OK)
        return result;
    if (written->id != CDS_BROADCAST_ID) {
        if (servo && (result = check_servo(check, servo)) != CDS_OK)
            return result;
        return check_id(check, servo, cds_written_value(written, CDS_REG_ID, written->id));
    }
    if (written->sets & CDS_SETS_ID && check->servos->count)
        return CDS_LIMIT;
    return check_all(check);
}

static enum cds_result check_action_or_reset(struct check *check, struct cds_servo_state *servo)
{
    struct cds_servos *servos = check->servos;
    uint8_t id = check->bytes[CDS_AT_ID];

    if (check->is_inhibited)
        return CDS_INHIBITED;
    if (check->bytes[CDS_AT_INSTRUCTION] == CDS_ACTION) {
        if (id == CDS_BROADCAST_ID)
            return check_all(check);
        return servo ? check_action(check, servo) : CDS_OK;
    }
    if (id == CDS_BROADCAST_ID)
        return servos->count && !servos->may_reset_all ? CDS_LIMIT : CDS_OK;
    return check_id(check, servo, CDS_FACTORY_ID);
}

/* A registered move is over when a limit or an inhibit has changed. */
static bool is_of_aborted_move(const struct check *check)
{
    uint8_t instruction = check->bytes[CDS_AT_INSTRUCTION];

    return is_of_move(check) && !check->servos->move_is_valid &&
           (instruction == CDS_REG_WRITE || instruction == CDS_ACTION);
}

static NOINLINE enum cds_result check_packet(struct check *check, struct cds_servo_state *servo)
{
    uint8_t longest = CDS_LENGTH_MIN;

    switch (check->bytes[CDS_AT_INSTRUCTION]) {
    case CDS_READ: longest = CDS_LENGTH_MIN + 2; // fall through
    case CDS_PING:
        if (check->is_inhibited && check->bytes[CDS_AT_LENGTH] > longest)
            return CDS_INHIBITED;
        return CDS_OK;
    case CDS_WRITE:
    case CDS_REG_WRITE:
    case CDS_SYNC_WRITE:
        if (is_of_aborted_move(check))
            return check->is_inhibited ? CDS_INHIBITED : CDS_LIMIT;
        return check_write(check, servo);
    case CDS_ACTION:
    case CDS_RESET:
        if (is_of_aborted_move(check))
            return check->is_inhibited ? CDS_INHIBITED : CDS_LIMIT;
        return check_action_or_reset(check, servo);
    default: return check->is_inhibited ? CDS_INHIBITED : CDS_OK;
    }
}

/* The servo that a packet writes to joins the list, if the list grows by it. */
static struct cds_servo_state *meet(struct cds_servos *servos, const uint8_t *bytes)
{
    uint8_t instruction = bytes[CDS_AT_INSTRUCTION];

    if (instruction != CDS_WRITE && instruction != CDS_REG_WRITE)
        return NULL;
    if (servos->grows == CDS_GROWS_ON_ALARM_OR_SETTING &&
        (instruction != CDS_WRITE || bytes[CDS_AT_PARAMETERS] > CDS_REG_STATUS_RETURN_LEVEL))
        return NULL;
    return cds_servos_add(servos, bytes[CDS_AT_ID]) == CDS_OK ? &servos->states[servos->count - 1]
                                                              : NULL;
}

static NOINLINE enum cds_result check_anew(struct cds_servos *servos, struct cds_request *request,
                                           struct cds_servo_state *servo)
{
    const uint8_t *bytes = request->packet.bytes;
    struct check check = {
        .servos = servos, .request = request, .bytes = bytes, .refused_id = bytes[CDS_AT_ID]};
    enum cds_result result;

    if (!servo && servos->grows && bytes[CDS_AT_ID] <= CDS_ID_MAX)
        servo = meet(servos, bytes);
    check.is_inhibited = servos->inhibited ||
                         (request->check && (int16_t)(servos->inhibit_epoch - request->check) > 0);
    result = check_packet(&check, servo);
    if (result == CDS_PENDING)
        return result;
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
        if (instruction == CDS_READ) {
            if (level == CDS_LEVEL_PING) {
                servos->refused_id = servo->id;
                return CDS_NO_REPLY_DUE;
            }
        } else if (level <= CDS_LEVEL_READ && instruction != CDS_PING) {
            request->is_muted = true;
        }
    }
    if (request->check == servos->epoch ||
        (!servos->inhibited && (instruction == CDS_READ || instruction == CDS_PING)))
        return CDS_OK;
    return check_anew(servos, request, servo);
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
        if (servos->grows == CDS_GROWS_ALWAYS)
            cds_servos_add(servos, id);
        return CDS_OK;
    }
    return cds_servo_is_inhibited(servo) ? CDS_INHIBITED : cds_limits_check_goal(servo, goal);
}
