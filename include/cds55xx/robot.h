/* SPDX-License-Identifier: MIT */
/* The one object most programs need: a bus, the servos of a robot with their limits, goals and
 * feedback at 250 Hz, the state check, and torque off. A table in flash describes the joints.
 * Example: examples/two_joints.c. Manual: 2.4, 3.1.
 *
 *     CDS_JOINTS(joints) = {CDS_JOINT(1, CDS_FORWARD, 150000, -90000, 90000, 30000,
 *                                     CDS_JOINT_CDS55XX, "hip")};
 *     CDS_ROBOT(robot, joints);
 *
 *     cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
 *     cds_robot_start(&robot);
 *     for (;; cds_robot_poll(&robot)) // stops by itself when something is wrong
 *         cds_robot_set_goal_mdeg(&robot, 0, 45000); // refused until the robot runs
 *
 * A program that needs more uses the parts: robot.bus, robot.cycle. All functions: main context. */
#ifndef CDS_ROBOT_H
#define CDS_ROBOT_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/cycle.h"      // struct cds_cycle
#include "cds55xx/health.h"     // struct cds_health
#include "cds55xx/motion.h"     // struct cds_motion
#include "cds55xx/servos.h"     // struct cds_servos
#include "cds55xx/torque_off.h" // struct cds_torque_off
#include "cds55xx/torque_on.h"  // struct cds_torque_on, enum cds_reason

#ifdef __cplusplus
extern "C" {
#endif

/* A constant that stands in flash, in C and in C++. On an AVR a program cannot read it through a
 * pointer: cds_robot_joint() copies a row of the table. */
#ifdef __AVR__
#define CDS_IN_FLASH __attribute__((__progmem__))
#else
#define CDS_IN_FLASH
#endif

/* `direction` of a joint. */
#define CDS_FORWARD  1    // the angle of the joint increases with the position of the servo
#define CDS_REVERSED (-1) // the angle of the joint decreases with the position of the servo

/* `profile` of a joint. */
enum cds_joint_profile { CDS_JOINT_CDS55XX, CDS_JOINT_AX12 } __attribute__((packed));

#define CDS_JOINT_NAME_SIZE 9 // 8 characters and a 0

/* Expands to 0. A `name` of more than 8 characters does not compile: an array of negative size. */
#define CDS_JOINT_NAME_CHECK(name) (0 * sizeof(char[sizeof(name) <= CDS_JOINT_NAME_SIZE ? 1 : -1]))

/* One joint. Its angle is 0 where its servo is at offset_mdeg. */
struct cds_joint {
    uint8_t id;            // of the servo, 0 to 253
    int8_t direction;      // CDS_FORWARD or CDS_REVERSED
    uint8_t profile;       // enum cds_joint_profile
    int32_t offset_mdeg;   // 0 to 300000
    int32_t lowest_mdeg;   // limits of the angle; the servo stays within 0 to 300000
    int32_t highest_mdeg;  // lowest_mdeg or more
    uint32_t fastest_mrpm; // limit of the speed, 1 to 62000 (AX-12: 113553); goals have this speed
    char name[CDS_JOINT_NAME_SIZE]; // 0 to 8 characters and a 0
};

/* A row of the table, in C99 and C++11. `name`: a string of at most 8 characters. */
#define CDS_JOINT(id, direction, offset_mdeg, lowest_mdeg, highest_mdeg, fastest_mrpm, profile,    \
                  name)                                                                            \
    {                                                                                              \
        (id), (direction), (profile) + CDS_JOINT_NAME_CHECK(name), (offset_mdeg), (lowest_mdeg),   \
            (highest_mdeg), (fastest_mrpm), name                                                   \
    }

/* Begins the definition of a table: CDS_JOINTS(name) = {CDS_JOINT(...), ...}; at file scope. */
#define CDS_JOINTS(name) static const struct cds_joint name[] CDS_IN_FLASH

/* A table and the storage for its joints. CDS_ROBOT() defines one. */
struct cds_robot_config {
    const struct cds_joint *joints; // in flash
    struct cds_servo_state *states; // one for each joint
    struct cds_feedback *feedback;  // one for each joint
    uint8_t *ids;                   // one for each joint
    uint8_t *reported;              // one for each joint: events that on_event has learnt of
    uint8_t *packets;               // CDS_CYCLE_PACKETS_SIZE(count) bytes
    uint8_t count;                  // of joints, 1 to CDS_CYCLE_SERVOS_MAX
};

/* Joints of the table `joints`, a constant. */
#define CDS_JOINT_COUNT(joints) (sizeof(joints) / sizeof((joints)[0]))

/* Defines struct cds_robot `name`, its storage, and name_config, all with static storage. `joints`:
 * a table of CDS_JOINTS(). */
#define CDS_ROBOT(name, joints)                                                                    \
    static struct cds_robot name;                                                                  \
    static struct cds_servo_state name##_states[CDS_JOINT_COUNT(joints)];                          \
    static struct cds_feedback name##_feedback[CDS_JOINT_COUNT(joints)];                           \
    static uint8_t name##_ids[CDS_JOINT_COUNT(joints)];                                            \
    static uint8_t name##_reported[CDS_JOINT_COUNT(joints)];                                       \
    static uint8_t name##_packets[CDS_CYCLE_PACKETS_SIZE(CDS_JOINT_COUNT(joints))];                \
    static const struct cds_robot_config name##_config CDS_IN_FLASH = {                            \
        joints,                                                                                    \
        name##_states,                                                                             \
        name##_feedback,                                                                           \
        name##_ids,                                                                                \
        name##_reported,                                                                           \
        name##_packets,                                                                            \
        (uint8_t)CDS_JOINT_COUNT(joints)}

/* What a robot does now. */
enum cds_robot_state {
    CDS_ROBOT_CLOSED,   // cds_robot_open() was not called
    CDS_ROBOT_OPEN,     // driving is inhibited
    CDS_ROBOT_STARTING, // servos are checked and get their first goals
    CDS_ROBOT_RUNNING,  // torque is on, and goals are sent
    CDS_ROBOT_STOPPING, // driving is inhibited; torque is switched off
    CDS_ROBOT_STOPPED,  // driving is inhibited; also if open or start has failed
} __attribute__((packed));

/* What has happened to a robot. */
enum cds_robot_event_kind {
    CDS_ROBOT_EVENT_STARTED,      // torque is on
    CDS_ROBOT_EVENT_START_FAILED, // `joint` has failed the check (one event for each such joint),
                                  // or did not take its goal or torque (one event): `why`,
                                  // `result`, `alarms`
    CDS_ROBOT_EVENT_ALARM,        // `joint` reports CDS_ERROR_* bits of a condition: `alarms`
    CDS_ROBOT_EVENT_OFFLINE,      // `joint` gives no good answer any more
    CDS_ROBOT_EVENT_STATE_LOST,   // `joint` had torque on and has it off: power failed, or an alarm
    CDS_ROBOT_EVENT_STOPPED,      // the stop is over: `result` of cds_torque_off_poll()
    CDS_ROBOT_EVENT_LINE_BUSY, // the line was low or disturbed for CDS_ROBOT_LINE_US, and nothing
                               // could be sent: the robot stops. `result` is CDS_LINE_BUSY
    CDS_ROBOT_EVENT_FEEDBACK_OLD, // feedback of `joint` is too old: CDS_ROBOT_FEEDBACK_US. The main
                                  // loop is too slow (cds_robot_poll()), period_us leaves no time
                                  // for a READ, or other requests or a lock keep the bus in use
} __attribute__((packed));

/* An event; a field that its kind does not name is 0. */
struct cds_robot_event {
    uint8_t kind;   // enum cds_robot_event_kind
    uint8_t joint;  // index in the table
    uint8_t why;    // enum cds_reason, of torque_on.h
    uint8_t result; // enum cds_result
    uint8_t alarms; // CDS_ERROR_* bits
};

/* The return delay that every servo gets, unless the program sets another one. */
#define CDS_ROBOT_RETURN_DELAY_US 10

/* Time after cds_robot_start() in which a servo may be silent while it starts up. */
#define CDS_ROBOT_START_TIMEOUT_US 2000000ul

/* The longest time for which a running robot cannot send because the line is low or disturbed. */
#define CDS_ROBOT_LINE_US 500000ul

/* Feedback of a joint is too old if its age is more than this, or more than 3 x joints x period_us
 * if that is longer: 600 ms for 50 joints at 4 ms. Checked within another 65 ms and one poll for
 * each joint. */
#define CDS_ROBOT_FEEDBACK_US 500000ul

/* A robot; CDS_ROBOT() defines one. The program reads `state` and `event`, sets the fields from
 * `tolerates` to `context` after cds_robot_open(), and uses the parts from `servos` to `bus` by
 * their own headers. */
struct cds_robot {
    uint8_t state;                // enum cds_robot_state
    struct cds_robot_event event; // the last one
    // the program may set:
    uint8_t tolerates; // bits 1 << CDS_ROBOT_EVENT_ALARM, _OFFLINE, _STATE_LOST, _FEEDBACK_OLD:
                       // after these events the robot keeps running. After each of the four whose
                       // bit is 0 it stops. At first 0
    uint16_t return_delay_us; // of all servos, 0 to 508, 2 or more if the board has enables:
                              // register 0x05. At first 10
    uint16_t period_us;       // of the cycle. At first CDS_CYCLE_PERIOD_US
    void (*on_event)(struct cds_robot *robot); // from cds_robot_poll(): robot->event is new. NULL:
                                               // none. May call any function of this header
    // cds_robot_begin_motion() sets on_poll and context, to poll the motion. A program with a
    // sequence sets on_poll behind that call, and polls the sequence instead.
    void (*on_poll)(struct cds_robot *robot); // from each cds_robot_poll() until the robot has
                                              // stopped, which makes it NULL. NULL: none
    void *context;                            // of on_poll
    // internal:
    const struct cds_robot_config *config; // in flash
    uint8_t count;                         // of joints
    uint8_t joint;                         // of the step of the start
    uint8_t phase;                         // of the start
    uint8_t next_checked_joint;            // its state is checked for events next
    uint8_t last_event_count;              // servos.event_count when the last round of checks began
    uint8_t blind_delay_writes;            // WRITEs of the return delay of `joint` without a reply
    bool is_delay_written;                 // return delay of `joint`, after it was read
    bool has_failed;                       // a joint has failed the check
    bool has_goals;                        // goals were set and not committed
    uint32_t old_us;                       // feedback is too old from this age on
    uint32_t polled_us;                    // when cds_robot_poll() was called last
    uint32_t begun_us;                     // when the start began
    uint32_t blocked_us;                   // since when the line is not quiet and nothing was sent
    uint16_t sent;                         // packets of the bus before that
    bool is_line_blocked;                  // blocked_us is set
    struct cds_torque_on torque_on;        // of `joint`
    struct cds_request request;            // of the start
    uint8_t packet[CDS_TORQUE_ON_PACKET_SIZE];
    uint8_t reply[CDS_TORQUE_ON_READ_SIZE];
    // the parts:
    struct cds_servos servos;         // what is known of each servo
    struct cds_cycle cycle;           // goals and feedback; begins with CDS_ROBOT_EVENT_STARTED
    struct cds_health health;         // the state check
    struct cds_torque_off torque_off; // the stop
    struct cds_queue queue;           // requests that wait
    struct cds_bus bus;               // of the servos
};

/* Opens the bus on `port` at `baud_reg` (see cds_bus_open()) and sets the limits of all joints.
 * Sends nothing. Driving is inhibited until a start has checked all servos. `config`: name_config
 * of CDS_ROBOT(). CDS_OK; CDS_BUSY: the robot is starting, running or stopping; CDS_BAD_ARGUMENT:
 * an earlier row has the ID of joint event.joint, or a value of its row is out of range: the
 * state is CDS_ROBOT_STOPPED, and the robot does not start until it is opened well. */
enum cds_result cds_robot_open(struct cds_robot *robot, const struct cds_robot_config *config,
                               uint8_t port, uint8_t baud_reg);

/* Begins to start the robot; cds_robot_poll() goes on with it, until CDS_ROBOT_EVENT_STARTED or
 * CDS_ROBOT_EVENT_START_FAILED:
 *
 *   1. Each servo is read: it is there, has no alarm, is in position mode, and its voltage and its
 *      position are within their limits. Its return delay is set if it differs (EEPROM).
 *   2. If all pass, driving is allowed again, and the goal of each servo becomes its present
 *      position.
 *   3. Torque is switched on, servo by servo, and the cycle begins.
 *
 * If a servo fails the check, the robot stops as by cds_robot_stop(). A silent servo is asked
 * again until CDS_ROBOT_START_TIMEOUT_US after cds_robot_start(). The start also writes its return
 * delay without reading it first: a servo with a short delay may reply before the board can
 * receive. CDS_OK; CDS_BUSY: the robot is starting, running or stopping; CDS_BAD_ARGUMENT: it was
 * not opened well, return_delay_us is out of range, or goals of all joints do not fit period_us;
 * the state is CDS_ROBOT_STOPPED. So a program may ignore the results of open and start: such a
 * robot refuses goals. */
enum cds_result cds_robot_start(struct cds_robot *robot);

/* Moves all of the robot on: bus, start, cycle, state check, stop. Call it from the main loop, as
 * often as possible; it is the only poll. Returns robot->state. A turn of the main loop may take
 * half of period_us, 2 ms: then goals leave in each period, and each joint is read within 0.2 s (18
 * joints at 1 Mbps; 2 joints within 35 ms). In a slower loop goals go on, but less feedback is
 * read. If it is too old, the robot stops with CDS_ROBOT_EVENT_FEEDBACK_OLD: with 18 joints in
 * turns of 2.6 ms and more, with 2 joints of 3.4 ms, and each robot after a single turn of 0.5 s.
 */
enum cds_robot_state cds_robot_poll(struct cds_robot *robot);

/* Stops the robot: inhibits driving, ends start and cycle, and switches torque off for all servos
 * on the bus (torque_off.h), before any other request. Begins again if the robot has stopped. Does
 * nothing while it is stopping, or if it was not opened well. On a line that is never quiet the
 * robot is stopping until torque off could be sent. */
void cds_robot_stop(struct cds_robot *robot);

/* Sets the goal of `joint` (index in the table) to the angle `mdeg`, at the speed of its limit. All
 * goals set between two polls leave together in the next period.
 *
 *   CDS_OK
 *   CDS_BAD_ARGUMENT  there is no such joint
 *   CDS_LIMIT         outside of the limits of the joint; it keeps its goal
 *   CDS_INHIBITED     the robot is not running, or the servo may not be driven */
enum cds_result cds_robot_set_goal_mdeg(struct cds_robot *robot, uint8_t joint, int32_t mdeg);

/* Sets *mdeg to the angle of `joint` that its servo has reported last. CDS_OK; CDS_BAD_ARGUMENT:
 * there is no such joint; CDS_TIMEOUT: it was not read yet, or is too old: CDS_ROBOT_FEEDBACK_US.
 * For a robot that CDS_ROBOT() has named `robot`, cds_feedback_age_us(&robot_feedback[joint]) is
 * its age, and robot_feedback[joint] has load, voltage and temperature, too (feedback.h). */
enum cds_result cds_robot_position_mdeg(const struct cds_robot *robot, uint8_t joint,
                                        int32_t *mdeg);

/* Sets *position to the position of the servo, 0 to 1023, where `joint` has the angle `mdeg`: for
 * poses (motion.h) and for cds_cycle_goal(). CDS_OK; CDS_BAD_ARGUMENT: there is no such joint;
 * CDS_LIMIT: outside of its limits. If it fails, *position is CDS_POSE_NONE: the joint takes no
 * part in a move. */
enum cds_result cds_robot_to_position(const struct cds_robot *robot, uint8_t joint, int32_t mdeg,
                                      uint16_t *position);

/* Copies the row of `joint` from the table to *row: its ID, its name. CDS_OK; CDS_BAD_ARGUMENT:
 * there is no such joint. */
enum cds_result cds_robot_joint(const struct cds_robot *robot, uint8_t joint,
                                struct cds_joint *row);

/* Prepares timed moves; call it after each CDS_ROBOT_EVENT_STARTED. The program then calls
 * cds_motion_move(). cds_robot_poll() polls `motion`, too; after a stop a move under way ends as
 * CDS_INHIBITED. `joints`: one for each joint. `profiles`: as in struct cds_motion_config; required
 * if a joint is CDS_JOINT_AX12. Accelerations are not checked: config.acceleration is 0. A program
 * that does not call it does not link motion.c. CDS_OK;
 * CDS_INHIBITED: the robot is not running; else as cds_motion_begin(). */
enum cds_result cds_robot_begin_motion(struct cds_robot *robot, struct cds_motion *motion,
                                       struct cds_motion_joint *joints,
                                       const struct cds_register_profile *const *profiles);

#ifdef __cplusplus
}
#endif

#endif
