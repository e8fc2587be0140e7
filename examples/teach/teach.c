/* SPDX-License-Identifier: MIT */
/* Three joints, servos 1 to 3, learn poses from your hands and play them in a loop.
 *
 * 1. Torque is off. Turn the joints, then hold them still for a second: the LEDs of the servos
 *    light up for half a second, and the pose is learnt. A pose with a joint beyond its limits is
 *    not learnt.
 * 2. After three poses the LEDs light up for two seconds. Take your hands away: the robot switches
 *    torque on and plays the poses until you switch its power off.
 * 3. If a servo fails, reports an alarm or is blocked, the robot switches torque off for all servos
 *    and begins with 1. again.
 *
 * The poses are in RAM. */
#include <cds55xx/avr.h>
#include <cds55xx/blocking.h>
#include <cds55xx/motion.h>
#include <cds55xx/robot.h>
#include <cds55xx/sequence.h>
#include <stdlib.h>
#include <string.h>

#define POSES       3
#define STEP_MS     1500      // from pose to pose
#define DWELL_MS    500       // at each pose
#define STILL_US    1000000ul // a pose that is held for so long is learnt
#define STILL_STEPS 3         // 1 degree: a joint that turns less is still
#define MOVED_STEPS 17        // 5 degrees: one joint at least has turned so far from the last pose
#define LEARNT_US   500000ul  // LEDs after each pose
#define READY_US    2000000ul // LEDs before the robot moves

#define JOINT(id, name)                                                                            \
    CDS_JOINT(id, CDS_FORWARD, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, name)

CDS_JOINTS(joints) = {JOINT(1, "base"), JOINT(2, "elbow"), JOINT(3, "wrist")};
#define JOINTS CDS_JOINT_COUNT(joints)
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

static uint16_t poses[POSES][JOINTS]; // positions of the servos, 0 to 1023

/* ---- learn ---- */

static uint8_t packet[CDS_PACKET_SIZE(2)], reply[2];
static struct cds_request request = CDS_REQUEST(packet, reply);

/* Reads where the servos are. False: a servo does not answer, or a joint is beyond its limits. */
static bool read_pose(uint16_t *pose)
{
    for (uint8_t i = 0; i < JOINTS; i++) {
        const struct cds_servo_state *servo = &robot.servos.states[i];

        if (cds_blocking_read_word(&robot.bus, &request, servo->id, CDS_REG_PRESENT_POSITION,
                                   &pose[i]) != CDS_OK ||
            pose[i] < servo->lowest || pose[i] > servo->highest)
            return false;
    }
    return true;
}

/* Returns the way of the joint that has the longest way from pose `a` to pose `b`. */
static uint16_t distance(const uint16_t *a, const uint16_t *b)
{
    uint16_t longest = 0;

    for (uint8_t i = 0; i < JOINTS; i++) {
        uint16_t way = (uint16_t)abs((int16_t)(a[i] - b[i]));

        if (way > longest)
            longest = way;
    }
    return longest;
}

/* Switches all LEDs on, waits, and switches them off. */
static void show(uint32_t time_us)
{
    uint32_t begun_us = cds_port_now_us();

    cds_blocking_write_byte(&robot.bus, &request, CDS_BROADCAST_ID, CDS_REG_LED, 1);
    while (cds_port_now_us() - begun_us < time_us)
        cds_bus_poll(&robot.bus);
    cds_blocking_write_byte(&robot.bus, &request, CDS_BROADCAST_ID, CDS_REG_LED, 0);
}

/* Waits until hands have turned the joints away from pose `last`, and held them still. */
static void learn(uint16_t *pose, const uint16_t *last)
{
    uint16_t held[JOINTS] = {0}; // where the joints were at still_since_us
    uint32_t still_since_us = cds_port_now_us();

    do {
        if (!read_pose(pose) || distance(pose, last) < MOVED_STEPS ||
            distance(pose, held) > STILL_STEPS) {
            memcpy(held, pose, sizeof held);
            still_since_us = cds_port_now_us();
        }
    } while (cds_port_now_us() - still_since_us < STILL_US);
}

static void learn_all(void)
{
    uint16_t last[JOINTS];

    while (!read_pose(last)) {
    }
    for (uint8_t i = 0; i < POSES; i++) {
        learn(poses[i], last);
        memcpy(last, poses[i], sizeof last);
        show(i + 1 < POSES ? LEARNT_US : READY_US);
    }
}

/* ---- play ---- */

static struct cds_motion motion;
static struct cds_motion_joint motion_joints[JOINTS];
static struct cds_sequence sequence;
static uint16_t sequence_poses[2 * JOINTS];

static bool read_step(void *context, uint8_t index, struct cds_sequence_step *step, uint16_t *pose)
{
    (void)context;
    if (index >= POSES)
        return false;
    *step = (struct cds_sequence_step){
        .time_ms = STEP_MS, .dwell_ms = DWELL_MS, .may_take_longer = true};
    memcpy(pose, poses[index], sizeof poses[index]);
    return true;
}

static void poll_sequence(struct cds_robot *self)
{
    if (cds_sequence_poll(&sequence) != CDS_PENDING)
        cds_robot_stop(self);
}

static void on_event(struct cds_robot *self)
{
    if (self->event.kind != CDS_ROBOT_EVENT_STARTED)
        return;
    cds_robot_begin_motion(self, &motion, motion_joints, NULL);
    cds_sequence_begin(&sequence, &(struct cds_sequence_config){.motion = &motion,
                                                                .poses = sequence_poses,
                                                                .read = read_step});
    self->on_poll = poll_sequence; // in place of the poll of the motion
}

int main(void)
{
    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    robot.on_event = on_event;
    for (;;) {
        cds_robot_stop(&robot);
        while (cds_robot_poll(&robot) != CDS_ROBOT_STOPPED) {
        }
        learn_all();
        cds_robot_start(&robot);
        while (cds_robot_poll(&robot) != CDS_ROBOT_STOPPED) {
        }
    }
}
