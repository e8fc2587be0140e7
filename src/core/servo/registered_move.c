/* SPDX-License-Identifier: MIT */
/* The registered move, step by step; see registered_move.h. */
#include "cds55xx/registered_move.h"

#include <string.h>

#include "bus/steps_internal.h"    // cds_steps_poll()
#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/servo.h"         // cds_servo_reg_write()
#include "compiler.h"              // NOINLINE
#include "servo/goal.h"            // cds_goal_put()

/* Steps. All but ACTION are done for one goal after the other; READ_BACK follows each CLEAR. */
enum phase {
    REGISTER,  // REG WRITE
    INSPECT,   // READ of 0x2C: 1?
    ACTION,    // to all
    CONFIRM,   // READ of goal to 0x2C
    CLEAR,     // 0x2C = 0, unless the servo has nothing registered
    READ_BACK, // READ of 0x2C: 0?
} __attribute__((packed));

static bool is_in_range(const struct cds_goal *goal)
{
    return goal->id <= CDS_ID_MAX && goal->position <= CDS_VALUE_MAX &&
           goal->speed <= CDS_VALUE_MAX;
}

/* Sets what became of each goal to `result`, or to CDS_BAD_ARGUMENT if it is out of range. */
static enum cds_result reset_goals(struct cds_goal *goals, uint8_t count)
{
    enum cds_result result = count ? CDS_OK : CDS_BAD_ARGUMENT;

    for (; count; count--, goals++) {
        goals->error = 0;
        goals->registered = CDS_REGISTERED_NO;
        goals->result = CDS_PENDING;
        if (!is_in_range(goals))
            goals->result = result = CDS_BAD_ARGUMENT;
    }
    return result;
}

/* Tells the permit of the bus which request carries a registered move; NULL: none any more. */
static void set_move(const struct cds_bus *bus, const struct cds_request *request)
{
    const struct cds_bus_hooks *hooks = bus->hooks;

    if (hooks && hooks->set_move)
        hooks->set_move(hooks->context, request);
}

enum cds_result cds_registered_move_begin(struct cds_registered_move *move,
                                          const struct cds_registered_move_config *config)
{
    uint8_t reply = config->verify ? CDS_REGISTERED_MOVE_VERIFY_REPLY : CDS_REGISTERED_MOVE_REPLY;
    enum cds_result result =
        cds_steps_check(config->bus, config->request, CDS_REGISTERED_MOVE_SIZE, reply);

    if (result == CDS_OK)
        result = reset_goals(config->goals, config->count);
    if (result != CDS_OK)
        return result;
    *move = (struct cds_registered_move){
        .goals = config->goals,
        .count = config->count,
        .verifies = config->verify,
        .phase = REGISTER,
    };
    cds_steps_begin(&move->steps, config->bus, config->request);
    set_move(config->bus, config->request);
    return CDS_OK;
}

/* The goal of the step. */
static struct cds_goal *current(const struct cds_registered_move *move)
{
    return &move->goals[move->next];
}

static NOINLINE void enter(struct cds_registered_move *move, uint8_t phase)
{
    move->phase = phase;
    move->next = 0;
    move->retries = 0;
    if (phase == CLEAR)
        set_move(move->steps.bus, NULL);
}

/* The first reason stays. */
static void note_reason(struct cds_registered_move *move, uint8_t reason)
{
    if (move->reason == CDS_OK)
        move->reason = reason;
}

/* Moves `next` to a goal that is to be cleared; after the last one the move ends. */
static void skip_cleared(struct cds_registered_move *move)
{
    while (move->next < move->count && current(move)->registered == CDS_REGISTERED_NO)
        move->next++;
    if (move->next == move->count)
        cds_steps_end(&move->steps, (enum cds_result)move->reason);
}

/* ---- a step is sent ---- */

static enum cds_result send_goal(struct cds_registered_move *move, struct cds_goal *goal)
{
    uint8_t data[CDS_GOAL_SIZE];
    enum cds_result result;

    cds_goal_put(data, goal->position, goal->speed);
    result = cds_servo_reg_write(move->steps.bus, move->steps.request, goal->id,
                                 CDS_REG_GOAL_POSITION, data, sizeof data);
    if (result == CDS_OK)
        goal->registered = CDS_REGISTERED_IN_DOUBT; // a servo that refuses keeps an earlier write
    return result;
}

static enum cds_result send(void *operation)
{
    struct cds_registered_move *move = (struct cds_registered_move *)operation;
    struct cds_bus *bus = move->steps.bus;
    struct cds_request *request = move->steps.request;
    struct cds_goal *goal = current(move);

    switch (move->phase) {
    case REGISTER: return send_goal(move, goal);
    case ACTION: return cds_servo_action(bus, request, CDS_BROADCAST_ID);
    case CONFIRM:
        return cds_servo_read(bus, request, goal->id, CDS_REG_GOAL_POSITION,
                              CDS_REGISTERED_MOVE_VERIFY_REPLY);
    case CLEAR:
        return cds_servo_write_byte(bus, request, goal->id, CDS_REG_REGISTERED_INSTRUCTION, 0);
    default: return cds_servo_read(bus, request, goal->id, CDS_REG_REGISTERED_INSTRUCTION, 1);
    }
}

/* ---- a step has ended ---- */

/* Takes 0x2C, the last byte of the reply. Returns `result`, or CDS_REFUSED if it is not as the step
 * wants it. */
static uint8_t take_registered(const struct cds_registered_move *move, uint8_t result)
{
    const struct cds_request *request = move->steps.request;
    struct cds_goal *goal = current(move);
    uint8_t registered = 0;

    if (result == CDS_OK)
        result = (uint8_t)cds_request_byte(request, (uint8_t)(request->length - 1u), &registered);
    goal->registered = registered ? CDS_REGISTERED_YES : CDS_REGISTERED_NO;
    if (result != CDS_OK)
        goal->registered = CDS_REGISTERED_IN_DOUBT;
    else if ((goal->registered == CDS_REGISTERED_YES) != (move->phase == INSPECT))
        result = CDS_REFUSED;
    return result;
}

/* True if the reply has the goal and the speed that were registered. */
static NOINLINE bool is_at_goal(const struct cds_registered_move *move, const struct cds_goal *goal)
{
    uint8_t data[CDS_GOAL_SIZE];

    cds_goal_put(data, goal->position, goal->speed);
    return memcmp(move->steps.request->reply, data, sizeof data) == 0;
}

/* A step other than ACTION, before the goals are cleared. */
static void on_goal(struct cds_registered_move *move, uint8_t result)
{
    struct cds_goal *goal = current(move);
    uint8_t phase = move->phase, next = ACTION;

    if (move->steps.request->result == CDS_OK)
        goal->error = move->steps.request->error;
    if (phase != REGISTER)
        result = take_registered(move, result);
    else if (result == CDS_OK)
        goal->registered = CDS_REGISTERED_YES;
    if (phase == CONFIRM && result == CDS_OK && !is_at_goal(move, goal))
        result = CDS_REFUSED;
    goal->result = result;
    note_reason(move, result);
    if (phase == CONFIRM)
        next = CLEAR;
    else if (phase == REGISTER && move->verifies)
        next = INSPECT;
    move->next++;
    if (result != CDS_OK && phase != CONFIRM)
        enter(move, CLEAR);
    else if (move->next == move->count)
        enter(move, next);
}

static void on_action(struct cds_registered_move *move, uint8_t result)
{
    struct cds_goal *goal = move->goals;

    move->acted = !cds_was_not_sent(result) && result != CDS_BAD_ARGUMENT;
    note_reason(move, result);
    for (uint8_t i = move->count; i; i--, goal++) {
        goal->result = result;
        if (result == CDS_OK && !move->verifies)
            goal->registered = CDS_REGISTERED_NO;
    }
    enter(move, result == CDS_OK && move->verifies ? CONFIRM : CLEAR);
}

/* Goal `next` was cleared and read: once more, or the next goal. */
static void on_read_back(struct cds_registered_move *move, uint8_t result)
{
    take_registered(move, result);
    move->phase = CLEAR;
    if (current(move)->registered != CDS_REGISTERED_NO &&
        move->retries < CDS_REGISTERED_MOVE_RETRIES) {
        move->retries++;
    } else {
        move->retries = 0;
        move->next++;
    }
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_registered_move *move = (struct cds_registered_move *)operation;

    switch (move->phase) {
    case ACTION: on_action(move, (uint8_t)result); break;
    case CLEAR: move->phase = READ_BACK; break; // whatever the answer was, it may be cleared
    case READ_BACK: on_read_back(move, (uint8_t)result); break;
    default: on_goal(move, (uint8_t)result); break;
    }
    if (move->is_called_off && move->phase < CLEAR)
        enter(move, CLEAR);
    if (move->phase == CLEAR)
        skip_cleared(move);
}

/* ---- */

enum cds_result cds_registered_move_poll(struct cds_registered_move *move)
{
    return cds_steps_poll(&move->steps, move, send, ended);
}

void cds_registered_move_abort(struct cds_registered_move *move)
{
    struct cds_steps *steps = &move->steps;

    if (steps->result != CDS_PENDING || move->phase >= CLEAR)
        return;
    note_reason(move, CDS_CANCELLED);
    if (steps->is_submitted) {
        if (cds_bus_cancel(steps->bus, steps->request) != CDS_OK) {
            move->is_called_off = true; // when the transaction has ended
            return;
        }
        steps->is_submitted = false;
    }
    enter(move, CLEAR);
    skip_cleared(move);
}
