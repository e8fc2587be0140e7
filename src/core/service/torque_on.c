/* SPDX-License-Identifier: MIT */
/* Torque on without a movement; see torque_on.h. */
#include "cds55xx/torque_on.h"

#include "bus/steps_internal.h" // cds_steps_poll()
#include "cds55xx/servo.h"      // cds_servo_read(), cds_servo_write()
#include "servo/goal.h"         // cds_goal_put(), CDS_GOAL_SIZE
#include "wire/word_internal.h" // cds_word_at()

_Static_assert(CDS_TORQUE_ON_READ_FROM + CDS_TORQUE_ON_READ_SIZE == CDS_REG_MOVING + 1,
               "bytes read");

enum phase {
    READ,
    SET_GOAL,
    READ_BACK,
    SWITCH_ON,
} __attribute__((packed));

enum cds_result cds_torque_on_begin(struct cds_torque_on *on,
                                    const struct cds_torque_on_config *config)
{
    enum cds_result result = cds_steps_check(config->bus, config->request,
                                             CDS_TORQUE_ON_PACKET_SIZE, CDS_TORQUE_ON_READ_SIZE);

    if (config->id > CDS_ID_MAX || config->first > config->last ||
        config->last > CDS_TORQUE_ON_SWITCH || config->speed > CDS_VALUE_MAX)
        return CDS_BAD_ARGUMENT;
    if (result != CDS_OK)
        return result;
    *on = (struct cds_torque_on){
        .id = config->id,
        .phase = config->first == CDS_TORQUE_ON_SWITCH ? SWITCH_ON : READ,
        .last = config->last,
        .checks_condition = config->checks_condition,
        .speed = config->speed,
    };
    cds_steps_begin(&on->steps, config->bus, config->request);
    return CDS_OK;
}

/* Index of register `reg` in the reply to a READ. */
#define AT(reg) ((reg)-CDS_TORQUE_ON_READ_FROM)

static uint16_t position_of(const struct cds_torque_on *on)
{
    return cds_word_at(on->steps.request->reply + AT(CDS_REG_PRESENT_POSITION));
}

static enum cds_result send(void *operation)
{
    struct cds_torque_on *on = (struct cds_torque_on *)operation;
    struct cds_bus *bus = on->steps.bus;
    struct cds_request *request = on->steps.request;
    uint8_t goal[CDS_GOAL_SIZE];

    switch (on->phase) {
    case SET_GOAL:
        cds_goal_put(goal, on->goal, on->speed);
        return cds_servo_write(bus, request, on->id, CDS_REG_GOAL_POSITION, goal,
                               on->speed ? CDS_GOAL_SIZE : CDS_GOAL_SIZE / 2);
    case SWITCH_ON: return cds_servo_write_byte(bus, request, on->id, CDS_REG_TORQUE_ENABLE, 1);
    default:
        return cds_servo_read(bus, request, on->id, CDS_TORQUE_ON_READ_FROM,
                              CDS_TORQUE_ON_READ_SIZE);
    }
}

/* Returns why a step that has ended as `result`, not CDS_OK, has failed. No switch: gcc would make
 * a table in RAM. */
static uint8_t reason_of(enum cds_result result)
{
    if (result == CDS_REFUSED)
        return CDS_REASON_REFUSED;
    if (result == CDS_LIMIT)
        return CDS_REASON_POSITION;
    return result == CDS_INHIBITED || result == CDS_RESERVED ? CDS_REASON_INHIBITED
                                                             : CDS_REASON_NO_REPLY;
}

static void fail(struct cds_torque_on *on, uint8_t reason, enum cds_result result)
{
    on->reason = reason;
    cds_steps_end(&on->steps, result);
}

/* Returns what is wrong with the servo that was read, enum cds_reason. */
static uint8_t check(const struct cds_torque_on *on)
{
    const uint8_t *reply = on->steps.request->reply;
    uint8_t voltage = reply[AT(CDS_REG_PRESENT_VOLTAGE)];

    if (on->checks_condition) {
        if (voltage < reply[AT(CDS_REG_MIN_VOLTAGE)] || voltage > reply[AT(CDS_REG_MAX_VOLTAGE)])
            return CDS_REASON_VOLTAGE;
        if (on->steps.request->error & CDS_ERRORS_OF_CONDITION)
            return CDS_REASON_ALARM;
    }
    return cds_word_at(reply + AT(CDS_REG_CW_ANGLE_LIMIT)) ||
                   cds_word_at(reply + AT(CDS_REG_CCW_ANGLE_LIMIT))
               ? CDS_REASON_NONE
               : CDS_REASON_MODE;
}

/* The position that was read becomes the goal. The MOVING_SPEED that was read goes in the same
 * packet, unless it is 0: the permit refuses a goal without a speed if the speed is limited. */
static void set_goal(struct cds_torque_on *on)
{
    on->goal = position_of(on);
    if (on->speed == 0)
        on->speed =
            cds_word_at(on->steps.request->reply + AT(CDS_REG_MOVING_SPEED)) & CDS_VALUE_MAX;
    on->phase = SET_GOAL;
    if (++on->goals > CDS_TORQUE_ON_GOALS) // the servo is being turned
        fail(on, CDS_REASON_REFUSED, CDS_REFUSED);
}

static void read_ended(struct cds_torque_on *on)
{
    uint8_t reason = check(on);

    if (reason != CDS_REASON_NONE)
        fail(on, reason, CDS_REFUSED);
    else if (on->last == CDS_TORQUE_ON_CHECK ||
             (on->last == CDS_TORQUE_ON_SWITCH &&
              on->steps.request->reply[AT(CDS_REG_TORQUE_ENABLE)]))
        cds_steps_end(&on->steps, CDS_OK);
    else
        set_goal(on);
}

/* True if torque would not move the servo. */
static bool is_at_goal(const struct cds_torque_on *on)
{
    return (uint16_t)(on->goal - position_of(on) + CDS_TORQUE_ON_NEAR_STEPS) <=
           2 * CDS_TORQUE_ON_NEAR_STEPS;
}

/* The position counts only if torque is the next step. */
static void read_back_ended(struct cds_torque_on *on)
{
    if (cds_word_at(on->steps.request->reply + AT(CDS_REG_GOAL_POSITION)) != on->goal)
        fail(on, CDS_REASON_REFUSED, CDS_REFUSED);
    else if (on->last == CDS_TORQUE_ON_GOAL)
        cds_steps_end(&on->steps, CDS_OK);
    else if (is_at_goal(on))
        on->phase = SWITCH_ON;
    else
        set_goal(on);
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_torque_on *on = (struct cds_torque_on *)operation;

    if (result != CDS_OK) {
        fail(on, reason_of(result), result);
        return;
    }
    switch (on->phase) {
    case READ: read_ended(on); break;
    case SET_GOAL: on->phase = READ_BACK; break;
    case READ_BACK: read_back_ended(on); break;
    default: cds_steps_end(&on->steps, CDS_OK); break;
    }
}

enum cds_result cds_torque_on_poll(struct cds_torque_on *on)
{
    return cds_steps_poll(&on->steps, on, send, ended);
}

void cds_torque_on_abort(struct cds_torque_on *on)
{
    cds_steps_abort(&on->steps);
}
