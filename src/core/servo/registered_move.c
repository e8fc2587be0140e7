/* The registered move, step by step; see registered_move.h. */
#include "cds55xx/registered_move.h"

#include "cds55xx/servo.h" // cds_servo_reg_write(), cds_servo_read() ...
#include "servo/goal.h"    // cds_goal_put()
#include "compiler.h"      // OPTIMIZER_BARRIER(), NOINLINE

/* What is read after ACTION: the goal, and whether it is still registered. */
#define OUTCOME_SIZE (CDS_REG_REGISTERED_INSTRUCTION - CDS_REG_GOAL_POSITION + 1)

enum move_phase {
    CHECK,     // the arguments
    ARM,       // REG WRITE to each
    INSPECT,   // READ of 0x2C of each: 1?
    TRIGGER,   // ACTION to all
    CONFIRM,   // READ of goal to 0x2C of each
    DISARM,    // 0x2C = 0 to each that is, or may be, armed
    READ_BACK, // ... and READ of it
};

void cds_registered_move_begin(struct cds_registered_move *move, struct cds_bus *bus,
                               struct cds_request *request, struct cds_goal *goals, uint8_t count)
{
    *move = (struct cds_registered_move){
        .bus = bus,
        .request = request,
        .goals = goals,
        .count = count,
        .phase = CHECK,
        .result = CDS_PENDING,
    };
    for (; count; count--, goals++) {
        goals->result = CDS_PENDING;
        goals->error = 0;
        goals->armed = CDS_ARMED_NO;
    }
}

void cds_registered_move_set_verify(struct cds_registered_move *move)
{
    move->verified = true;
}

static void enter(struct cds_registered_move *move, enum move_phase phase)
{
    move->phase = (uint8_t)phase;
    move->next = 0;
    move->tries = 0;
}

static void check(struct cds_registered_move *move)
{
    uint8_t room = move->verified ? CDS_GROUP_VERIFY_SIZE : CDS_REGISTERED_MOVE_SIZE;

    enter(move, ARM);
    if (move->request->packet.capacity < room)
        move->result = CDS_NO_ROOM;
    if (move->count == 0)
        move->result = CDS_BAD_ARGUMENT;
    for (struct cds_goal *goal = move->goals; goal < move->goals + move->count; goal++) {
        if (goal->id > CDS_ID_MAX || goal->position > CDS_VALUE_MAX || goal->speed > CDS_VALUE_MAX)
            move->result = goal->result = CDS_BAD_ARGUMENT;
    }
}

/* Goal `next`, if there is one. */
static NOINLINE struct cds_goal *current(const struct cds_registered_move *move)
{
    return &move->goals[move->next];
}

/* Goal `next` has failed; the first reason stays. */
static void fail(struct cds_registered_move *move, uint8_t result)
{
    current(move)->result = result;
    if (move->reason == CDS_OK)
        move->reason = result;
}

/* Goal `next` is done with; behind the last of them comes `phase`. */
static NOINLINE void advance(struct cds_registered_move *move, enum move_phase phase)
{
    move->next++;
    if (move->next == move->count)
        enter(move, phase);
}

static enum cds_result arm(struct cds_registered_move *move, struct cds_goal *goal)
{
    uint8_t data[CDS_GOAL_SIZE];
    enum cds_result result;

    cds_goal_put(data, goal->position, goal->speed);
    result = cds_servo_reg_write(move->bus, move->request, goal->id, CDS_REG_GOAL_POSITION, data,
                                 sizeof data);
    if (result == CDS_OK)
        goal->armed = CDS_ARMED_IN_DOUBT; // until it answers; a refusal may leave an earlier one
    return result;
}

static void on_armed(struct cds_registered_move *move, uint8_t result)
{
    struct cds_goal *goal = current(move);

    if (result == CDS_OK && goal->error & CDS_ERRORS_OF_PACKET)
        result = CDS_REFUSED;
    if (result == CDS_OK) {
        goal->result = CDS_OK;
        goal->armed = CDS_ARMED_YES;
        advance(move, move->verified ? INSPECT : TRIGGER);
    } else {
        fail(move, result);
        enter(move, DISARM);
    }
}

/* 0x2C as it was read, at `index` of the reply, goes to goals[next].armed. */
static uint8_t take_armed(struct cds_registered_move *move, uint8_t result, uint8_t index)
{
    struct cds_goal *goal = current(move);
    uint8_t registered = 0;

    if (result == CDS_OK)
        result = (uint8_t)cds_request_byte(move->request, index, &registered);
    goal->armed = registered ? CDS_ARMED_YES : CDS_ARMED_NO;
    if (result != CDS_OK)
        goal->armed = CDS_ARMED_IN_DOUBT;
    return result;
}

static void on_inspected(struct cds_registered_move *move, uint8_t result)
{
    result = take_armed(move, result, 0);
    if (result == CDS_OK && current(move)->armed == CDS_ARMED_NO)
        result = CDS_REFUSED; // its power failed meanwhile
    if (result == CDS_OK) {
        advance(move, TRIGGER);
    } else {
        fail(move, result);
        enter(move, DISARM);
    }
}

static void on_triggered(struct cds_registered_move *move, uint8_t result)
{
    move->acted = result == CDS_OK || result == CDS_TIMEOUT || result == CDS_CORRUPT ||
                  result == CDS_CANCELLED;
    move->reason = result;
    for (struct cds_goal *goal = move->goals; goal < move->goals + move->count; goal++) {
        goal->result = result;
        if (result == CDS_OK && !move->verified)
            goal->armed = CDS_ARMED_NO;
    }
    enter(move, result == CDS_OK && move->verified ? CONFIRM : DISARM);
}

/* Has it the goal that was registered? */
static bool is_at_goal(const struct cds_registered_move *move)
{
    const struct cds_goal *goal = current(move);
    const uint8_t *bytes = move->request->packet.bytes;

    return bytes[0] == (uint8_t)goal->position && bytes[1] == goal->position >> 8 &&
           bytes[2] == (uint8_t)goal->speed && bytes[3] == goal->speed >> 8;
}

static void on_confirmed(struct cds_registered_move *move, uint8_t result)
{
    result = take_armed(move, result, OUTCOME_SIZE - 1);
    if (result == CDS_OK && (current(move)->armed != CDS_ARMED_NO || !is_at_goal(move)))
        result = CDS_REFUSED;
    if (result != CDS_OK)
        fail(move, result);
    advance(move, DISARM);
}

/* Goal `next` was told to forget its move, and read: again, or the next one. */
static void on_read_back(struct cds_registered_move *move, uint8_t result)
{
    take_armed(move, result, 0);
    move->phase = DISARM;
    if (current(move)->armed != CDS_ARMED_NO && move->tries < CDS_REGISTERED_MOVE_RETRIES) {
        move->tries++;
    } else {
        move->tries = 0;
        move->next++;
    }
}

/* Whoever is not armed needs no disarming. Behind the last one the move is over. */
static void skip_disarmed(struct cds_registered_move *move)
{
    while (move->next < move->count && current(move)->armed == CDS_ARMED_NO)
        move->next++;
    if (move->next == move->count)
        move->result = move->reason;
}

/* The exchange of this phase is over, or could not even begin. */
static void on_ended(struct cds_registered_move *move, uint8_t result)
{
    if (result == CDS_OK && move->phase <= CONFIRM && move->phase != TRIGGER)
        current(move)->error = move->request->error;
    switch (move->phase) {
    case ARM: on_armed(move, result); break;
    case INSPECT: on_inspected(move, result); break;
    case TRIGGER: on_triggered(move, result); break;
    case CONFIRM: on_confirmed(move, result); break;
    case DISARM: move->phase = READ_BACK; break; // it may have heard, whatever it answered
    default: on_read_back(move, result); break;
    }
    if (move->phase == DISARM)
        skip_disarmed(move);
}

static enum cds_result send(struct cds_registered_move *move)
{
    struct cds_bus *bus = move->bus;
    struct cds_request *request = move->request;
    struct cds_goal *goal = current(move);

    switch (move->phase) {
    case ARM: return arm(move, goal);
    case TRIGGER: return cds_servo_action(bus, request, CDS_BROADCAST_ID);
    case CONFIRM:
        return cds_servo_read(bus, request, goal->id, CDS_REG_GOAL_POSITION, OUTCOME_SIZE);
    case DISARM:
        return cds_servo_write_byte(bus, request, goal->id, CDS_REG_REGISTERED_INSTRUCTION, 0);
    default: return cds_servo_read(bus, request, goal->id, CDS_REG_REGISTERED_INSTRUCTION, 1);
    }
}

static void send_next(struct cds_registered_move *move)
{
    enum cds_result result = send(move);

    if (result == CDS_OK)
        move->sent = true;
    else if (result != CDS_BUSY)
        on_ended(move, (uint8_t)result);
}

enum cds_result cds_registered_move_poll(struct cds_registered_move *move)
{
    OPTIMIZER_BARRIER(move);
    if (move->phase == CHECK)
        check(move);
    if (move->sent && move->request->result != CDS_PENDING) {
        move->sent = false;
        on_ended(move, move->request->result);
    }
    if (move->result == CDS_PENDING && !move->sent)
        send_next(move);
    return (enum cds_result)move->result;
}
