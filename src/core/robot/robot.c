/* SPDX-License-Identifier: MIT */
/* The one object most programs need; see robot.h. robot_start.c has the steps of a start. */
#include "cds55xx/robot.h"

#include "cds55xx/motion.h" // CDS_POSE_NONE
#include "compiler.h"       // NOINLINE, OPTIMIZER_BARRIER()
#include "robot/robot_internal.h"

#define RETRIES        2
#define FULL_CDS55XX   62000  // mRPM at 1023
#define FULL_AX12      113553 // mRPM at 1023
#define WAS_OFFLINE    0x80   // in `reported`, beside the CDS_ERROR_* bits of conditions
#define WAS_STATE_LOST 0x40
#define WAS_OLD        0x10 // feedback
#define LATE_US        250 // if more time is between two calls of cds_robot_poll(), the main loop is late

static const CDS_FLASH struct cds_joint *row_of(const struct cds_robot *robot, uint8_t joint)
{
    return (const CDS_FLASH struct cds_joint *)cds_robot_config_of(robot)->joints + joint;
}

/* ---- units ---- */

/* Returns the angle of the servo where the joint is at `mdeg`: 0 to CDS_MDEG_MAX, or more if it is
 * out of range. */
static NOINLINE uint32_t servo_mdeg(const CDS_FLASH struct cds_joint *row, int32_t mdeg)
{
    uint32_t turned = (uint32_t)mdeg;

    return (uint32_t)row->offset_mdeg + (row->direction < 0 ? 0 - turned : turned);
}

/* Returns the position of a servo at `mdeg`, 0 to CDS_MDEG_MAX, as cds_units_to_register(): mdeg x
 * 341 / 100000, rounded. A product of 16 bits takes the place of the division by 3125 = 100000 /
 * 32; the quotient is at most one too low: 600 cycles less. */
static NOINLINE uint16_t to_position(uint32_t mdeg)
{
    uint32_t dividend = (mdeg * 341u + 50000u) / 32u;
    uint16_t quotient = (uint16_t)((uint32_t)(uint16_t)(dividend / 64u) * 1342u >> 16);
    uint16_t rest = (uint16_t)(dividend - (uint16_t)(quotient * 3125u));

    return rest < 3125 ? quotient : (uint16_t)(quotient + 1u);
}

/* Returns the angle of a servo at `position`, 0 to 1023, as cds_units_from_register(): position x
 * 300000 / 1023 = position x (293 + 261 / 1023), rounded. Shifts take the place of the division by
 * 1023 = 1024 - 1, which no dividend here is a multiple of: 600 cycles less. */
static uint32_t to_mdeg(uint16_t position)
{
    uint32_t wide = position, dividend = wide * 261u + 511u;

    return wide * 293u + ((dividend + (dividend >> 10)) >> 10);
}

static uint16_t to_speed(uint32_t mrpm, uint32_t full_mrpm)
{
    uint16_t speed = (uint16_t)((mrpm * CDS_VALUE_MAX + full_mrpm / 2u) / full_mrpm);

    return speed ? speed : 1; // 0 would be as fast as the servo can
}

/* ---- open ---- */

/* Sets the limits of `joint`. CDS_BAD_ARGUMENT: a value of its row is out of range. */
static enum cds_result set_limits(struct cds_robot *robot, uint8_t joint)
{
    const CDS_FLASH struct cds_joint *row = row_of(robot, joint);
    uint32_t full_mrpm = row->profile == CDS_JOINT_AX12 ? FULL_AX12 : FULL_CDS55XX;
    int32_t low_mdeg = row->lowest_mdeg, high_mdeg = row->highest_mdeg;
    uint32_t lowest, highest;

    if ((row->direction != CDS_FORWARD && row->direction != CDS_REVERSED) ||
        row->profile > CDS_JOINT_AX12 || (uint32_t)row->offset_mdeg > CDS_MDEG_MAX)
        return CDS_BAD_ARGUMENT;
    if (low_mdeg > high_mdeg || row->fastest_mrpm == 0 || row->fastest_mrpm > full_mrpm)
        return CDS_BAD_ARGUMENT;
    lowest = servo_mdeg(row, row->direction < 0 ? high_mdeg : low_mdeg);
    highest = servo_mdeg(row, row->direction < 0 ? low_mdeg : high_mdeg);
    if (lowest > CDS_MDEG_MAX || highest > CDS_MDEG_MAX)
        return CDS_BAD_ARGUMENT;
    return cds_servos_set_limits(&robot->servos, &robot->servos.states[joint], to_position(lowest),
                                 to_position(highest), to_speed(row->fastest_mrpm, full_mrpm));
}

static bool is_at_rest(const struct cds_robot *robot)
{
    return robot->state <= CDS_ROBOT_OPEN || robot->state == CDS_ROBOT_STOPPED;
}

static enum cds_result begin_servos(struct cds_robot *robot)
{
    const CDS_FLASH struct cds_robot_config *config = cds_robot_config_of(robot);
    uint8_t count = robot->count;
    enum cds_result result;

    result = cds_servos_begin(&robot->servos, &(struct cds_servos_config){.bus = &robot->bus,
                                                                          .queue = &robot->queue,
                                                                          .states = config->states,
                                                                          .capacity = count});
    cds_servos_inhibit_all(&robot->servos);
    cds_queue_set_retries(&robot->queue, RETRIES);
    for (uint8_t i = 0; i < count && result == CDS_OK; i++) {
        robot->event.joint = i;
        config->ids[i] = row_of(robot, i)->id;
        result = cds_servos_add(&robot->servos, config->ids[i]);
        if (result == CDS_OK)
            result = set_limits(robot, i);
    }
    return result;
}

enum cds_result cds_robot_open(struct cds_robot *robot, const struct cds_robot_config *config,
                               uint8_t port, uint8_t baud_reg)
{
    enum cds_result result;

    OPTIMIZER_BARRIER(robot);
    if (!is_at_rest(robot))
        return CDS_BUSY;
    robot->state = CDS_ROBOT_CLOSED;
    robot->config = config;
    robot->count = cds_robot_config_of(robot)->count;
    cds_bus_open(&robot->bus, port, baud_reg);
    result = begin_servos(robot);
    if (result != CDS_OK) {
        robot->count = 0; // until it is opened well, the robot cannot start
        robot->state = CDS_ROBOT_STOPPED;
        return result;
    }
    robot->tolerates = 0;
    robot->return_delay_us = CDS_ROBOT_RETURN_DELAY_US;
    robot->period_us = CDS_CYCLE_PERIOD_US;
    robot->on_event = NULL;
    robot->on_poll = NULL;
    robot->state = CDS_ROBOT_OPEN;
    return CDS_OK;
}

/* ---- start ---- */

void cds_robot_report(struct cds_robot *robot)
{
    if (robot->on_event)
        robot->on_event(robot);
}

/* Reports an event without a reason. */
static void report(struct cds_robot *robot, uint8_t kind, uint8_t joint, uint8_t result,
                   uint8_t alarms)
{
    robot->event =
        (struct cds_robot_event){.kind = kind, .joint = joint, .result = result, .alarms = alarms};
    cds_robot_report(robot);
}

/* Returns the age from which on feedback is too old. */
static uint32_t old_us(const struct cds_robot *robot)
{
    uint32_t us = (uint32_t)robot->period_us * (uint8_t)(CDS_SERVOS_MISSES * robot->count);

    return us > CDS_ROBOT_FEEDBACK_US ? us : CDS_ROBOT_FEEDBACK_US;
}

static enum cds_result begin_cycle(struct cds_robot *robot)
{
    const CDS_FLASH struct cds_robot_config *config = cds_robot_config_of(robot);

    return cds_cycle_begin(&robot->cycle, &(struct cds_cycle_config){
                                              .bus = &robot->bus,
                                              .ids = config->ids,
                                              .packets = config->packets,
                                              .feedback = config->feedback,
                                              .count = robot->count,
                                              .period_us = robot->period_us,
                                          });
}

enum cds_result cds_robot_start(struct cds_robot *robot)
{
    enum cds_result result = CDS_BAD_ARGUMENT;

    OPTIMIZER_BARRIER(robot);
    if (!is_at_rest(robot))
        return CDS_BUSY;
    robot->state = CDS_ROBOT_STOPPED;
    if (robot->count && robot->return_delay_us <= CDS_RETURN_DELAY_MAX_US)
        result = begin_cycle(robot); // checks period_us
    if (result != CDS_OK)
        return result;
    cds_servos_inhibit_all(&robot->servos);
    cds_servos_acknowledge(&robot->servos, NULL);
    robot->old_us = old_us(robot);
    cds_robot_begin_steps(robot);
    robot->state = CDS_ROBOT_STARTING;
    return CDS_OK;
}

/* Torque is on, and the cycle has its first goals. */
static void run(struct cds_robot *robot)
{
    uint32_t now_us = cds_port_now_us();

    for (uint8_t i = 0; i < robot->count; i++) // each joint has held the position since it was read
        cds_robot_config_of(robot)->feedback[i].time_us = now_us;
    cds_cycle_commit(&robot->cycle);
    robot->has_goals = false;
    robot->next_checked_joint = 0;
    cds_health_begin(
        &robot->health,
        &(struct cds_health_config){.servos = &robot->servos, .period_us = CDS_HEALTH_PERIOD_US});
    cds_health_set_cycle(&robot->health, &robot->cycle);
    robot->state = CDS_ROBOT_RUNNING;
    report(robot, CDS_ROBOT_EVENT_STARTED, 0, CDS_OK, 0);
}

static void poll_start(struct cds_robot *robot)
{
    enum cds_result result = cds_robot_poll_steps(robot);

    if (result == CDS_OK)
        run(robot);
    else if (result != CDS_PENDING)
        cds_robot_stop(robot);
}

/* ---- run ---- */

/* Reports an event, and stops the robot if the program does not tolerate it. */
static void report_trouble(struct cds_robot *robot, uint8_t kind, uint8_t joint, uint8_t alarms)
{
    report(robot, kind, joint, CDS_OK, alarms);
    if (!(robot->tolerates & 1u << kind))
        cds_robot_stop(robot);
}

/* Reports what of `found` was not reported for `joint` before. */
static void report_new(struct cds_robot *robot, uint8_t joint, uint8_t found)
{
    uint8_t *reported = &cds_robot_config_of(robot)->reported[joint];
    uint8_t fresh = (uint8_t)(found & ~*reported), alarms = fresh & CDS_ERRORS_OF_CONDITION;

    *reported = found;
    if (alarms)
        report_trouble(robot, CDS_ROBOT_EVENT_ALARM, joint, alarms);
    if (fresh & WAS_OFFLINE)
        report_trouble(robot, CDS_ROBOT_EVENT_OFFLINE, joint, 0);
    if (fresh & WAS_STATE_LOST)
        report_trouble(robot, CDS_ROBOT_EVENT_STATE_LOST, joint, 0);
    if (fresh & WAS_OLD)
        report_trouble(robot, CDS_ROBOT_EVENT_FEEDBACK_OLD, joint, 0);
}

static bool is_old(const struct cds_robot *robot, uint8_t joint)
{
    return cds_feedback_age_us(&cds_robot_config_of(robot)->feedback[joint]) > robot->old_us;
}

/* Reports what is new of one joint. While the line is blocked, no feedback can come. A joint that
 * was OFFLINE counts as OFFLINE until it is read again. */
static void check_joint(struct cds_robot *robot)
{
    uint8_t joint = robot->next_checked_joint++;
    const struct cds_servo_state *servo = &robot->servos.states[joint];
    uint8_t found = servo->alarms & CDS_ERRORS_OF_CONDITION;
    bool was_offline = cds_robot_config_of(robot)->reported[joint] & WAS_OFFLINE;
    bool has_grown_old = !robot->is_line_blocked && is_old(robot, joint);

    if (servo->presence >= CDS_PRESENCE_OFFLINE || (has_grown_old && was_offline))
        found |= WAS_OFFLINE;
    else if (has_grown_old)
        found |= WAS_OLD;
    if (servo->inhibits & CDS_INHIBIT_STATE_LOST)
        found |= WAS_STATE_LOST;
    report_new(robot, joint, found);
}

/* True if nothing could be sent for too long: the line is low, or never quiet. No servo counts as
 * OFFLINE then, since no servo was asked. */
static bool is_line_lost(struct cds_robot *robot)
{
    uint16_t sent = robot->bus.stats.sent;

    if (cds_bus_line(&robot->bus) == CDS_BUS_LINE_QUIET || sent != robot->sent) {
        robot->sent = sent;
        robot->is_line_blocked = false;
        return false;
    }
    if (robot->is_line_blocked)
        return cds_port_now_us() - robot->blocked_us > CDS_ROBOT_LINE_US;
    robot->is_line_blocked = true;
    robot->blocked_us = cds_port_now_us();
    return false;
}

/* Goals are committed while no packet of goals is on its way. Otherwise the next goals would find
 * their packet in use (CDS_BUSY). */
static void poll_run(struct cds_robot *robot)
{
    if (robot->has_goals && robot->cycle.goals.result != CDS_PENDING) {
        robot->has_goals = false;
        cds_cycle_commit(&robot->cycle);
    }
    cds_cycle_poll(&robot->cycle);
    cds_health_poll(&robot->health);
    if (is_line_lost(robot)) {
        report(robot, CDS_ROBOT_EVENT_LINE_BUSY, 0, CDS_LINE_BUSY, 0);
        cds_robot_stop(robot);
        return;
    }
    if (robot->next_checked_joint < robot->count) {
        check_joint(robot);
    } else if (robot->last_event_count != robot->servos.event_count) {
        robot->last_event_count = robot->servos.event_count;
        robot->next_checked_joint = 0;
    }
}

/* ---- stop ---- */

void cds_robot_stop(struct cds_robot *robot)
{
    OPTIMIZER_BARRIER(robot);
    if (robot->count == 0 || robot->state == CDS_ROBOT_STOPPING)
        return;
    cds_cycle_abort(&robot->cycle);
    cds_torque_off_begin(&robot->torque_off, &robot->servos);
    robot->state = CDS_ROBOT_STOPPING;
}

static void poll_stop(struct cds_robot *robot)
{
    enum cds_result result = cds_torque_off_poll(&robot->torque_off);

    if (cds_cycle_poll(&robot->cycle) == CDS_PENDING || result == CDS_PENDING ||
        robot->request.result == CDS_PENDING || robot->health.request.result == CDS_PENDING)
        return;
    if (result == CDS_LINE_BUSY) { // servos have torque still
        cds_torque_off_begin(&robot->torque_off, &robot->servos);
        return;
    }
    robot->on_poll = NULL;
    robot->state = CDS_ROBOT_STOPPED;
    report(robot, CDS_ROBOT_EVENT_STOPPED, 0, (uint8_t)result, 0);
}

/* ---- */

/* Polls the bus. A transaction takes four polls: the packet has left, head, parameters, the next
 * packet. After a long turn of the main loop one call makes them all, so that the next packet can
 * leave. */
static void poll_bus(struct cds_robot *robot, bool is_late)
{
    struct cds_bus *bus = &robot->bus;

    if (is_late && cds_bus_poll(bus) && cds_bus_poll(bus))
        cds_bus_poll(bus);
    cds_bus_poll(bus);
}

/* Every 65 ms lets poll_run() check all joints, as after an event of the servos: feedback grows old
 * without an event. */
static void schedule_checks(struct cds_robot *robot, uint32_t now_us)
{
    if ((now_us ^ robot->polled_us) >> 16)
        robot->last_event_count = (uint8_t)(robot->servos.event_count - 1u);
}

enum cds_robot_state cds_robot_poll(struct cds_robot *robot)
{
    uint32_t now_us = cds_port_now_us();

    OPTIMIZER_BARRIER(robot);
    schedule_checks(robot, now_us);
    poll_bus(robot, now_us - robot->polled_us > LATE_US);
    robot->polled_us = now_us;
    if (robot->on_poll)
        robot->on_poll(robot);
    if (robot->state == CDS_ROBOT_RUNNING)
        poll_run(robot);
    else if (robot->state == CDS_ROBOT_STARTING)
        poll_start(robot);
    else if (robot->state == CDS_ROBOT_STOPPING)
        poll_stop(robot);
    return (enum cds_robot_state)robot->state;
}

enum cds_result cds_robot_to_position(const struct cds_robot *robot, uint8_t joint, int32_t mdeg,
                                      uint16_t *position)
{
    const CDS_FLASH struct cds_joint *row;

    *position = CDS_POSE_NONE;
    if (joint >= robot->count)
        return CDS_BAD_ARGUMENT;
    row = row_of(robot, joint);
    if (mdeg < row->lowest_mdeg || mdeg > row->highest_mdeg)
        return CDS_LIMIT;
    *position = to_position(servo_mdeg(row, mdeg));
    return CDS_OK;
}

enum cds_result cds_robot_set_goal_mdeg(struct cds_robot *robot, uint8_t joint, int32_t mdeg)
{
    uint16_t position;
    enum cds_result result = cds_robot_to_position(robot, joint, mdeg, &position);

    if (result != CDS_OK)
        return result;
    if (robot->state != CDS_ROBOT_RUNNING)
        return CDS_INHIBITED;
    robot->has_goals = true;
    return cds_cycle_goal(&robot->cycle, joint, position, robot->servos.states[joint].fastest);
}

enum cds_result cds_robot_position_mdeg(const struct cds_robot *robot, uint8_t joint, int32_t *mdeg)
{
    const CDS_FLASH struct cds_joint *row;
    const struct cds_feedback *feedback;
    int32_t turned;

    if (joint >= robot->count)
        return CDS_BAD_ARGUMENT;
    row = row_of(robot, joint);
    feedback = &cds_robot_config_of(robot)->feedback[joint];
    if (is_old(robot, joint))
        return CDS_TIMEOUT;
    turned = (int32_t)to_mdeg(feedback->position) - row->offset_mdeg;
    *mdeg = row->direction < 0 ? -turned : turned;
    return CDS_OK;
}

enum cds_result cds_robot_joint(const struct cds_robot *robot, uint8_t joint, struct cds_joint *row)
{
    if (joint >= robot->count)
        return CDS_BAD_ARGUMENT;
    *row = *row_of(robot, joint);
    return CDS_OK;
}
