/* SPDX-License-Identifier: MIT */
/* The steps of a start: all servos are checked, then get their first goals, then their torque; see
 * cds_robot_start() in robot.h. torque_on.h does this for one servo. Manual: 3.1, registers 0x05 to
 * 0x2E. */
#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/servo.h"         // cds_servo_write_byte()
#include "robot/robot_internal.h"
#include "wire/word_internal.h" // cds_word_at()

enum phase {
    CHECK = CDS_TORQUE_ON_CHECK,      // is the servo well?
    SET_GOAL = CDS_TORQUE_ON_GOAL,    // all servos are well
    TORQUE_ON = CDS_TORQUE_ON_SWITCH, // all servos have their goals
    SET_DELAY,                        // WRITE of the return delay, then CHECK again
    AWAIT_DELAY,                      // the WRITE is on its way
} __attribute__((packed));

static const uint8_t *reply_of(const struct cds_robot *robot, uint8_t reg)
{
    return robot->reply + (reg - CDS_TORQUE_ON_READ_FROM);
}

static struct cds_servo_state *servo_of(const struct cds_robot *robot)
{
    return &robot->servos.states[robot->joint];
}

static uint8_t delay_of(const struct cds_robot *robot)
{
    return (uint8_t)((robot->return_delay_us + 1u) / 2u);
}

/* Begins the phase of the joint. */
static void begin(struct cds_robot *robot, uint8_t phase)
{
    struct cds_request *request = &robot->request;

    robot->phase = phase;
    request->servo_index = robot->joint;
    // the stored state may belong to a servo that was replaced since
    request->ignores_servo_state = phase == CHECK;
    if (phase <= TORQUE_ON)
        cds_torque_on_begin(&robot->torque_on,
                            &(struct cds_torque_on_config){.bus = &robot->bus,
                                                           .request = request,
                                                           .id = servo_of(robot)->id,
                                                           .first = phase,
                                                           .last = phase,
                                                           .checks_condition = phase == CHECK,
                                                           .speed = servo_of(robot)->fastest});
}

static void begin_joint(struct cds_robot *robot, uint8_t joint, uint8_t phase)
{
    robot->joint = joint;
    robot->is_delay_written = false;
    robot->blind_delay_writes = 0;
    begin(robot, phase);
}

/* Goes on to the next joint, or to the next phase behind the last joint. Returns what the start
 * ends as, or CDS_PENDING. */
static enum cds_result go_on(struct cds_robot *robot)
{
    uint8_t phase = robot->phase, joint = (uint8_t)(robot->joint + 1);

    if (joint == robot->count) {
        if (robot->has_failed)
            return CDS_REFUSED;
        if (phase == TORQUE_ON)
            return CDS_OK;
        if (phase == CHECK) {
            cds_bus_set_return_delay(&robot->bus, (uint16_t)(2u * delay_of(robot)));
            cds_servos_release_all(&robot->servos);
        }
        joint = 0;
        phase++;
    }
    begin_joint(robot, joint, phase);
    return CDS_PENDING;
}

/* The joint is not well. In phase CHECK the start goes on with the next joint, so that the program
 * gets an event for each bad joint. Returns what the start ends as, or CDS_PENDING. */
static enum cds_result fail(struct cds_robot *robot, uint8_t why, enum cds_result result)
{
    uint8_t joint = robot->joint, error = robot->request.error;
    enum cds_result end = CDS_REFUSED;

    robot->has_failed = true;
    if (robot->phase == CHECK)
        end = go_on(robot);
    robot->event = (struct cds_robot_event){
        .kind = CDS_ROBOT_EVENT_START_FAILED,
        .joint = joint,
        .why = why,
        .result = (uint8_t)result,
        .alarms = result == CDS_OK ? error & CDS_ERRORS_OF_CONDITION : 0,
    };
    cds_robot_report(robot);
    return end;
}

/* No good reply: the servo starts up, or is absent, or replies sooner than the board can receive.
 * A servo that replies too soon still receives a WRITE of its return delay. The WRITE is sent at
 * first and once more at the end. It is not sent each time: a servo that starts up meanwhile would
 * write its EEPROM each time. */
static enum cds_result ask_again(struct cds_robot *robot, enum cds_result result)
{
    bool is_over = cds_port_now_us() - robot->begun_us >= CDS_ROBOT_START_TIMEOUT_US;

    if (robot->blind_delay_writes < (is_over ? 2 : 1)) {
        robot->blind_delay_writes++;
        begin(robot, SET_DELAY);
        return CDS_PENDING;
    }
    if (is_over)
        return fail(robot, CDS_REASON_NO_REPLY, result);
    begin(robot, CHECK);
    return CDS_PENDING;
}

/* Returns what is wrong with the servo that was read, enum cds_reason. */
static uint8_t reason_to_fail(const struct cds_robot *robot)
{
    const struct cds_servo_state *servo = servo_of(robot);
    const uint8_t *bytes = reply_of(robot, CDS_REG_PRESENT_POSITION);
    uint16_t position = cds_word_at(bytes);

    if (*reply_of(robot, CDS_REG_RETURN_DELAY) != delay_of(robot))
        return CDS_REASON_RETURN_DELAY;
    if (robot->torque_on.reason != CDS_REASON_NONE)
        return robot->torque_on.reason;
    return position < servo->lowest || position > servo->highest ? CDS_REASON_POSITION
                                                                 : CDS_REASON_NONE;
}

static enum cds_result check_ended(struct cds_robot *robot)
{
    uint8_t why = reason_to_fail(robot);

    if (why == CDS_REASON_RETURN_DELAY && !robot->is_delay_written) {
        robot->is_delay_written = true;
        begin(robot, SET_DELAY);
        return CDS_PENDING;
    }
    return why == CDS_REASON_NONE ? go_on(robot) : fail(robot, why, CDS_OK);
}

/* The first goal of the joint in the cycle is the goal that the servo has. */
static void note_goal(struct cds_robot *robot)
{
    const CDS_FLASH struct cds_robot_config *config = cds_robot_config_of(robot);
    struct cds_feedback *feedback = &config->feedback[robot->joint];

    cds_feedback_decode(feedback, reply_of(robot, CDS_REG_PRESENT_POSITION));
    feedback->time_us = cds_port_now_us();
    feedback->error = robot->request.error;
    feedback->result = CDS_OK;
    feedback->known = true;
    config->reported[robot->joint] = 0;
    cds_cycle_goal(&robot->cycle, robot->joint, robot->torque_on.goal, servo_of(robot)->fastest);
}

/* True if the reply has the registers of the servo, which is well or not. */
static bool is_read(const struct cds_torque_on *on, enum cds_result result)
{
    return result == CDS_OK || (result == CDS_REFUSED && on->reason != CDS_REASON_REFUSED);
}

static enum cds_result part_ended(struct cds_robot *robot, enum cds_result result)
{
    if (robot->phase == CHECK)
        return is_read(&robot->torque_on, result) ? check_ended(robot) : ask_again(robot, result);
    if (result != CDS_OK)
        return fail(robot, robot->torque_on.reason, result);
    if (robot->phase == SET_GOAL)
        note_goal(robot);
    return go_on(robot);
}

/* Writes the return delay. Whatever the servo replies, it is checked again. */
static void poll_delay(struct cds_robot *robot)
{
    if (robot->phase == SET_DELAY) {
        if (cds_servo_write_byte(&robot->bus, &robot->request, servo_of(robot)->id,
                                 CDS_REG_RETURN_DELAY, delay_of(robot)) != CDS_BUSY)
            robot->phase = AWAIT_DELAY;
    } else if (robot->request.result != CDS_PENDING) {
        begin(robot, CHECK);
    }
}

void cds_robot_begin_steps(struct cds_robot *robot)
{
    struct cds_request *request = &robot->request;

    request->packet.bytes = robot->packet;
    request->packet.capacity = sizeof robot->packet;
    request->reply = robot->reply;
    request->reply_capacity = sizeof robot->reply;
    cds_bus_set_return_delay(&robot->bus, CDS_RETURN_DELAY_MAX_US);
    robot->begun_us = cds_port_now_us();
    robot->has_failed = false;
    begin_joint(robot, 0, CHECK);
}

enum cds_result cds_robot_poll_steps(struct cds_robot *robot)
{
    enum cds_result result;

    if (robot->phase >= SET_DELAY) {
        poll_delay(robot);
        return CDS_PENDING;
    }
    result = cds_torque_on_poll(&robot->torque_on);
    return result == CDS_PENDING ? CDS_PENDING : part_ended(robot, result);
}
