/* SPDX-License-Identifier: MIT */
/* The robot on the bus: its servos, the stop, the state check, and one long operation at a time. An
 * operation is a cycle, a scan, a diagnosis, a change of ID or rate, or a registered move.
 * robot_poll() moves all of these on. None of them waits for the console's output.
 *
 * Main context. */
#ifndef CONTROLLER_ROBOT_H
#define CONTROLLER_ROBOT_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"             // struct cds_bus, struct cds_request
#include "cds55xx/cycle.h"           // struct cds_cycle
#include "cds55xx/diagnose.h"        // struct cds_diagnose
#include "cds55xx/registered_move.h" // struct cds_registered_move
#include "cds55xx/identity.h"        // struct cds_identity
#include "cds55xx/queue.h"           // struct cds_queue
#include "cds55xx/scan.h"            // struct cds_scan
#include "cds55xx/servos.h"          // struct cds_servos
#include "cds55xx/torque_off.h"      // struct cds_torque_off
#include "cds55xx/torque_on.h"       // struct cds_torque_on
#include "cds55xx/health.h"          // struct cds_health
#include "flash.h"                   // CDS_FLASH
#include "robot/baud_change.h"       // struct baud_change
#include "robot/new_servo.h"         // struct new_servo
#include "robot/reset_copy.h"        // struct reset_copy

/* Servos that the controller knows, 1 to 50. Each costs 50 bytes of RAM. */
#ifndef ROBOT_SERVOS
#define ROBOT_SERVOS 18
#endif

/* The state check waits for this time after a packet of the PC. */
#define ROBOT_HEALTH_DELAY_US 1000000ul

struct robot;
struct moves; // moves.h

/* A long operation. It stands in flash beside the command that begins it by robot_start(). So a
 * profile without the command does not link the operation. */
struct robot_operation {
    enum cds_result (*begin)(struct robot *robot, const void *config); // in robot->work
    enum cds_result (*poll)(struct robot *robot);                      // CDS_PENDING: goes on
    void (*abort)(struct robot *robot); // ends it soon; NULL: it always goes on to its end
    bool changes_rate; // it changes the rate of the bus: a servo that is silent is not OFFLINE then
};

/* Angle limits that a servo keeps itself, 0 to 1023 (angle_limits.h). */
struct angle_limits {
    uint16_t lowest, highest;
};

/* What the autostart needs until its cycle begins. */
struct autostart_servos {
    struct cds_torque_on torque_on; // of servo `index` of the group
    uint8_t index;
    uint8_t tries; // READs of this servo without a good reply; WRITEs when torque is switched off
    struct cds_request request;
    uint8_t packet[CDS_TORQUE_ON_PACKET_SIZE];
    uint8_t reply[CDS_TORQUE_ON_READ_SIZE];
    struct angle_limits limits[ROBOT_SERVOS]; // of each servo of the group
};

/* Storage of the operation. */
union robot_work {
    struct {
        struct cds_cycle cycle;
        struct cds_feedback feedback[ROBOT_SERVOS];
        uint8_t packets[CDS_CYCLE_PACKETS_SIZE(ROBOT_SERVOS)];
    } cycle;
    struct {
        struct cds_scan scan;
        struct cds_scan_found found[ROBOT_SERVOS];
    } scan;
    struct cds_diagnose diagnose;
    struct cds_identity identity;
    struct baud_change baud;
    struct new_servo new_servo;
    struct {
        struct cds_registered_move move;
        struct cds_goal goals[ROBOT_SERVOS];
    } move;
    struct autostart_servos autostart;
};

/* In `unlisted`: no scan has ended since the robot was begun or forgotten, or the rate changed. */
#define ROBOT_NOT_SCANNED UINT8_MAX

/* The robot. Other modules only read the fields, but for these: the operation writes `work`; the
 * scan and failsafe.c write `unlisted`; main.c writes `moves`; `group` writes `group_acts`, and the
 * autostart writes the group; failsafe.c writes servos.grows, and motions write servos.refused_id;
 * failsafe.c and unasked.c write CDS_HELD_LOSS_TOLD. */
struct robot {
    struct cds_bus *bus;
    struct reset_copy *reset_copy;                     // survives a reset; NULL: there is no copy
    const CDS_FLASH struct robot_operation *operation; // under way, or NULL
    struct cds_cycle
        *cycle;          // cycle of an operation that shares the bus with other requests, or NULL
    struct moves *moves; // storage of timed moves; NULL: this firmware has none
    uint8_t result;      // enum cds_result of the operation: CDS_PENDING while it goes on
    uint8_t baud_reg;    // rate of the bus when the operation began, as register 0x04
    bool stop_waits : 1; // a stop begins, or begins again, when the operation ends
    bool stop_begun : 1; // the torque off of the last stop has begun; robot_allow() clears it
    bool stopping : 1;   // a stop is under way
    bool health_pauses : 1; // the cycle leaves no time for the state check
    bool group_acts : 1;    // the group is moved by REG WRITE and ACTION, else by SYNC WRITE
    bool chosen : 1;        // a user has named the servos: the state check reads them
    uint8_t group_count;
    uint8_t health_servos; // number of servos when the state check began
    uint8_t unlisted;      // servos that the last whole scan found and the robot does not know, or
                           // ROBOT_NOT_SCANNED
    struct cds_servos servos;
    union robot_work work;
    struct cds_queue queue;
    uint8_t group[ROBOT_SERVOS]; // IDs of the servos of pose and cycle
    struct cds_torque_off stop;
    struct cds_health health;
    struct cds_servo_state states[ROBOT_SERVOS];
};

/* Begins with no servos on `bus`, which must be open. `shortest_delay`: the smallest value of
 * register 0x05 that the board can receive. Zero *robot first (static storage is). */
void robot_begin(struct robot *robot, struct cds_bus *bus, uint8_t shortest_delay);

/* Moves operation, stop and state check on. Call it once in each turn of the main loop, after
 * cds_bus_poll(). */
void robot_poll(struct robot *robot);

/* Restores the drive inhibit after a reset. Driving is inhibited if `copy` says so or is damaged,
 * and a stop that was not finished begins again. `copy` must stay in place. `powered_on`: `copy` is
 * random, and driving is allowed. Call it once, after robot_begin(). */
void robot_resume(struct robot *robot, struct reset_copy *copy, bool powered_on);

/* Inhibits driving, also after a reset: no packet that can drive a servo is sent to any ID. */
void robot_inhibit(struct robot *robot);

/* Ends the inhibit of the robot. Servos that lost their state stay inhibited. Sends nothing. False:
 * torque off is under way, and nothing was done. */
bool robot_allow(struct robot *robot);

/* Ends the inhibit of the robot and of all servos, also of those that lost their state. Sends
 * nothing. False: torque off is under way, and nothing was done. */
bool robot_release(struct robot *robot);

/* True if driving is inhibited. */
static inline bool robot_is_inhibited(const struct robot *robot)
{
    return robot->servos.all_inhibited;
}

/* Returns how many servos may be on the bus that the robot does not know: 0 to 254. After a whole
 * scan: the number of servos found for which the robot has no room, at least 1 if another servo has
 * answered since. Before a scan: the number of IDs that the robot does not know. */
uint8_t robot_unlisted(const struct robot *robot);

/* Stops the robot: ends the operation under way, inhibits driving, and switches the torque of all
 * servos off, before any other request. When robot_is_stopping() is false, robot->stop has the
 * result. */
void robot_stop(struct robot *robot);

/* True while a stop is under way. */
static inline bool robot_is_stopping(const struct robot *robot)
{
    return robot->stopping || robot->stop_waits;
}

/* True while an operation is under way that needs the bus for itself. */
bool robot_is_exclusive(const struct robot *robot);

/* True if there is nothing to do but the state check, which may wait for the next interrupt. */
bool robot_idle(const struct robot *robot);

/* True if a running cycle sets the goal of servo `id`, 0 to 253; CDS_BROADCAST_ID: of any servo. */
bool robot_cycle_drives(const struct robot *robot, uint8_t id);

/* True while a motion starts, moves the group or is paused: the servos of the group are reserved
 * for the goals of the motion. */
static inline bool robot_is_in_motion(const struct robot *robot)
{
    return robot->servos.reserved_count;
}

/* What functions of the robot return beside enum cds_result: numbers of errors in docs/errors.md.
 */
enum robot_refusal {
    ROBOT_TOO_MANY = 40,  // there is no room for all these servos
    ROBOT_BUSY = 43,      // another operation is under way
    ROBOT_STOPPED = 54,   // a stop is under way
    ROBOT_IN_MOTION = 58, // a motion is under way
};

/* Returns 0 if an operation may begin; else enum robot_refusal. */
uint8_t robot_busy(const struct robot *robot);

/* Begins `operation` with `config`. Returns 0: robot_poll() goes on with it; enum robot_refusal;
 * else the enum cds_result of the begin function of `operation`. */
uint8_t robot_start(struct robot *robot, const CDS_FLASH struct robot_operation *operation,
                    const void *config);

/* Called from the begin function of an operation that shares the bus with other requests; `cycle`:
 * the cycle that it runs. */
void robot_share_bus(struct robot *robot, struct cds_cycle *cycle);

/* Ends the operation as soon as possible; a change of ID or rate goes on to its end. */
void robot_abort(struct robot *robot);

/* Returns true if the robot has room for all servos of the list that it does not know. */
bool robot_has_room(struct robot *robot, const uint8_t *ids, uint8_t count);

/* Adds servo `id`, 0 to 253, and lets the state check read the robot's servos. False: there is no
 * room.
 *
 * Servos also join by themselves, so that inhibit and stop cover them. If link_loss_ms is 0, a
 * servo joins when it reports error bits or when its registers 0x00 to 0x10 are written; else also
 * when it answers or is written to (failsafe.h). Until robot_add() is called, the state check reads
 * a servo only if it has returned. */
bool robot_add(struct robot *robot, uint8_t id);

/* Chooses `count` servos, 1 to ROBOT_SERVOS, as the group, moved by SYNC WRITE. Returns 0; or an
 * enum robot_refusal, and the group stays as it was. */
uint8_t robot_choose_group(struct robot *robot, const uint8_t *ids, uint8_t count);

/* Returns the servo of lowest ID among those with ID `id` or above, or NULL: there is none. The
 * list itself is in the order of joining. */
const struct cds_servo_state *robot_servo_from(const struct robot *robot, uint8_t id);

/* Call it after servo `id` was given the ID `new_id`: replaces `id` by `new_id` in the group, if it
 * is there. Sends nothing. */
void robot_rename(struct robot *robot, uint8_t id, uint8_t new_id);

/* A packet of the PC passes: delays the state check by ROBOT_HEALTH_DELAY_US, except for servos
 * that have returned. */
void robot_delay_health(struct robot *robot);

/* Forgets all servos, and what the last stop has read of them: stop.servos is NULL then. The drive
 * inhibit stays. Not while an operation is under way. */
void robot_forget(struct robot *robot);

/* Forgets `servo`, an entry, and takes it out of the group; the last entry moves to its place. Not
 * while an operation or a stop is under way. False: not now, and nothing was done; a request is on
 * the bus, or the ID of the servo is in doubt. */
bool robot_forget_servo(struct robot *robot, struct cds_servo_state *servo);

/* Ends the choice of the group, and forgets the servos from index `count` on, unless one of them
 * has an alarm or is inhibited. Not while an operation is under way. */
void robot_forget_group(struct robot *robot, uint8_t count);

#endif
