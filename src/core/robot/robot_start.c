/* The steps of a start: each servo is checked, then gets its first goal, then its torque; see
 * cds_robot_start() in robot.h. Manual: 3.1, registers 0x05 to 0x2E. */
#include "bus/steps_internal.h"    // cds_steps_poll()
#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/servo.h"         // cds_servo_read(), cds_servo_write()
#include "compiler.h"              // NOINLINE
#include "robot/robot_internal.h"
#include "servo/goal.h" // cds_goal_put(), CDS_GOAL_SIZE

#define FIRST_READ CDS_REG_RETURN_DELAY

enum phase {
    CHECK,     // READ: is the servo well?
    SET_DELAY, // WRITE, then CHECK again
    // all servos are well
    FIND,      // READ: where is the servo?
    SET_GOAL,  // WRITE: there
    READ_BACK, // READ: the permit needs mode, goal and speed before torque on
    // all servos have their goals
    TORQUE_ON, // WRITE
} __attribute__((packed));

static uint8_t byte_of(const struct cds_robot *robot, uint8_t reg)
{
    return robot->reply[reg - FIRST_READ];
}

static uint16_t word_of(const struct cds_robot *robot, uint8_t reg)
{
    return (uint16_t)(byte_of(robot, reg) | (uint16_t)byte_of(robot, (uint8_t)(reg + 1)) << 8);
}

static struct cds_servo_state *servo_of(const struct cds_robot *robot)
{
    return &robot->servos.states[robot->joint];
}

static uint8_t delay_of(const struct cds_robot *robot)
{
    return (uint8_t)((robot->return_delay_us + 1u) / 2u);
}

static enum cds_result send(void *operation)
{
    struct cds_robot *robot = (struct cds_robot *)operation;
    struct cds_bus *bus = &robot->bus;
    struct cds_request *request = &robot->request;
    uint8_t id = servo_of(robot)->id, goal[CDS_GOAL_SIZE];

    request->servo_index = robot->joint;
    request->ignores_servo_state = robot->phase == CHECK; // another servo may have its place
    switch (robot->phase) {
    case SET_DELAY:
        return cds_servo_write_byte(bus, request, id, CDS_REG_RETURN_DELAY, delay_of(robot));
    case SET_GOAL:
        cds_goal_put(goal, word_of(robot, CDS_REG_PRESENT_POSITION), servo_of(robot)->fastest);
        return cds_servo_write(bus, request, id, CDS_REG_GOAL_POSITION, goal, sizeof goal);
    case TORQUE_ON: return cds_servo_write_byte(bus, request, id, CDS_REG_TORQUE_ENABLE, 1);
    default: return cds_servo_read(bus, request, id, FIRST_READ, CDS_ROBOT_READ_SIZE);
    }
}

/* Returns what is wrong with the servo that was read, enum cds_robot_reason. */
static uint8_t reason_to_fail(const struct cds_robot *robot)
{
    const struct cds_servo_state *servo = servo_of(robot);
    uint16_t position = word_of(robot, CDS_REG_PRESENT_POSITION);
    uint8_t voltage = byte_of(robot, CDS_REG_PRESENT_VOLTAGE);

    if (byte_of(robot, CDS_REG_RETURN_DELAY) != delay_of(robot))
        return CDS_REASON_RETURN_DELAY;
    if (voltage < byte_of(robot, CDS_REG_MIN_VOLTAGE) ||
        voltage > byte_of(robot, CDS_REG_MAX_VOLTAGE))
        return CDS_REASON_VOLTAGE;
    if (robot->request.error & CDS_ERRORS_OF_CONDITION)
        return CDS_REASON_ALARM;
    if (!word_of(robot, CDS_REG_CW_ANGLE_LIMIT) && !word_of(robot, CDS_REG_CCW_ANGLE_LIMIT))
        return CDS_REASON_MODE;
    return position < servo->lowest || position > servo->highest ? CDS_REASON_POSITION
                                                                 : CDS_REASON_NONE;
}

/* Goes on to the next joint, or to the next phase behind the last joint. */
static void go_on(struct cds_robot *robot, uint8_t same_phase, uint8_t next_phase)
{
    robot->is_delay_written = false;
    robot->unread_writes = 0;
    robot->phase = same_phase;
    if (++robot->joint < robot->count)
        return;
    robot->joint = 0;
    robot->phase = next_phase;
    if (robot->has_failed)
        cds_steps_end(&robot->steps, CDS_REFUSED);
    else if (next_phase == FIND) {
        cds_bus_set_return_delay(&robot->bus, (uint16_t)(2u * delay_of(robot)));
        cds_servos_release_all(&robot->servos);
    } else if (next_phase == CHECK) {
        cds_steps_end(&robot->steps, CDS_OK);
    }
}

/* The joint is not well. While servos are checked, the others still are: the program learns of
 * all. */
static void fail(struct cds_robot *robot, uint8_t why, enum cds_result result)
{
    uint8_t joint = robot->joint, error = robot->request.error;

    robot->has_failed = true;
    if (robot->phase > SET_DELAY)
        cds_steps_end(&robot->steps, CDS_REFUSED);
    else
        go_on(robot, CHECK, CHECK);
    robot->event = (struct cds_robot_event){
        .kind = CDS_ROBOT_START_FAILED,
        .joint = joint,
        .why = why,
        .result = (uint8_t)result,
        .alarms = result == CDS_OK ? error & CDS_ERRORS_OF_CONDITION : 0,
    };
    cds_robot_report(robot);
}

/* No good reply: the servo starts up, or is absent, or replies sooner than the board can receive.
 * The latter hears a WRITE of its return delay nevertheless. The WRITE is sent at first, and once
 * more at the end. It is not sent each time: a servo that starts up meanwhile would write its
 * EEPROM each time. */
static void ask_again(struct cds_robot *robot, enum cds_result result)
{
    bool is_over = cds_port_now_us() - robot->begun_us >= CDS_ROBOT_PATIENCE_US;

    if (robot->unread_writes < (is_over ? 2 : 1)) {
        robot->unread_writes++;
        robot->phase = SET_DELAY;
    } else if (is_over) {
        fail(robot, CDS_REASON_NO_REPLY, result);
    }
}

static void check_ended(struct cds_robot *robot)
{
    uint8_t why = reason_to_fail(robot);

    if (why == CDS_REASON_RETURN_DELAY && !robot->is_delay_written) {
        robot->is_delay_written = true;
        robot->phase = SET_DELAY;
    } else if (why == CDS_REASON_NONE) {
        go_on(robot, CHECK, FIND);
    } else {
        fail(robot, why, CDS_OK);
    }
}

static void note_feedback(struct cds_robot *robot)
{
    struct cds_feedback *feedback = &cds_robot_config_of(robot)->feedback[robot->joint];

    cds_feedback_decode(feedback, robot->reply + (CDS_REG_PRESENT_POSITION - FIRST_READ));
    feedback->time_us = cds_port_now_us();
    feedback->error = robot->request.error;
    feedback->result = CDS_OK;
    feedback->known = true;
}

static uint8_t reason_of(enum cds_result result)
{
    switch (result) {
    case CDS_REFUSED: return CDS_REASON_REFUSED;
    case CDS_RESERVED:
    case CDS_INHIBITED: return CDS_REASON_INHIBITED;
    case CDS_LIMIT: return CDS_REASON_POSITION;
    default: return CDS_REASON_NO_REPLY;
    }
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_robot *robot = (struct cds_robot *)operation;

    if (robot->phase == SET_DELAY) {
        robot->phase = CHECK; // whatever the servo answered
        return;
    }
    if (result != CDS_OK) {
        if (robot->phase == CHECK && robot->steps.is_submitted)
            ask_again(robot, result);
        else
            fail(robot, reason_of(result), result);
        return;
    }
    switch (robot->phase) {
    case CHECK: check_ended(robot); break;
    case FIND:
        note_feedback(robot);
        robot->phase = SET_GOAL;
        break;
    case SET_GOAL: robot->phase = READ_BACK; break;
    case READ_BACK: go_on(robot, FIND, TORQUE_ON); break;
    default: go_on(robot, TORQUE_ON, CHECK); break;
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
    cds_steps_begin(&robot->steps, &robot->bus, request);
    robot->begun_us = cds_port_now_us();
    robot->phase = CHECK;
    robot->joint = 0;
    robot->is_delay_written = robot->has_failed = false;
    robot->unread_writes = 0;
}

enum cds_result cds_robot_poll_steps(struct cds_robot *robot)
{
    return cds_steps_poll(&robot->steps, robot, send, ended);
}
