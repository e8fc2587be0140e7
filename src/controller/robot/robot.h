/* The robot at the bus: its servos, and what goes on whether or not somebody looks: the stop, the
 * state check, the cycle, and one long operation at a time (a scan, a diagnosis, a change of ID or
 * rate, a registered move). All of them are polled here, none of them waits for text to leave.
 *
 * Main context.
 */
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
#include "cds55xx/health.h"          // struct cds_health
#include "flash.h"                   // CDS_FLASH
#include "robot/inhibit.h"           // struct inhibit_copy

/* Servos that the controller knows, 1 to 50. Each costs 50 bytes of RAM. */
#ifndef ROBOT_SERVOS
#define ROBOT_SERVOS 18
#endif

/* The state check rests for so long when a program on the PC has spoken to the bus. */
#define ROBOT_REST_US 1000000ul

struct robot;

/* A long operation, in flash beside the command that begins it: robot_start() takes it, so a
 * command that is not linked takes its operation with it. */
struct robot_operation {
    enum cds_result (*begin)(struct robot *robot, const void *config); // in robot->work
    enum cds_result (*poll)(struct robot *robot);                      // CDS_PENDING: goes on
    void (*abort)(struct robot *robot); // ends it soon; NULL: goes on to its end
    bool changes_rate;                  // of the bus: a silent servo is not offline meanwhile
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
    struct {
        struct cds_registered_move move;
        struct cds_goal goals[ROBOT_SERVOS];
    } move;
};

#define ROBOT_NOT_SCANNED UINT8_MAX // in `unlisted`

/* The robot. Fields are read only, but for `work`, which belongs to the operation, and `unlisted`,
 * which belongs to the scan. */
struct robot {
    struct cds_bus *bus;
    struct inhibit_copy *kept; // what a reset leaves of the drive inhibit; NULL: nothing
    const CDS_FLASH struct robot_operation *operation; // under way, or NULL
    struct cds_cycle *cycle; // of the operation that shares the bus with other requests, or NULL
    uint8_t result;          // enum cds_result of the operation: CDS_PENDING while it goes on
    uint8_t baud;            // register value of the bus's rate when it began
    bool stop_waits : 1;     // for the end of an operation: then all are told, or told again
    bool
        stop_told : 1; // a stop has begun since it was asked for, and driving was not allowed since
    bool stopping : 1; // a stop is under way
    bool health_pauses : 1; // the cycle leaves no time for the state check
    bool group_acts : 1;    // the group is moved by REG WRITE and ACTION, else by SYNC WRITE
    bool chosen : 1; // somebody has said which servos they are: the state check looks at them
    uint8_t group_count;
    uint8_t health_servos; // servos that the state check was begun for
    uint8_t unlisted;      // servos that the last whole scan found beyond those of the robot
    struct cds_servos servos;
    struct cds_queue queue;
    uint8_t group[ROBOT_SERVOS]; // IDs of the servos of pose and cycle
    struct cds_torque_off stop;
    struct cds_health health;
    union robot_work work;
    struct cds_servo_state states[ROBOT_SERVOS];
};

/* Begins with no servos on `bus`, which must be open. `shortest_delay`: the smallest value of
 * register 0x05 the board can bear. Zero *robot first (static storage is). */
void robot_begin(struct robot *robot, struct cds_bus *bus, uint8_t shortest_delay);

/* Moves everything on; once in each turn of the main loop, after cds_bus_poll(). */
void robot_poll(struct robot *robot);

/* Goes on as a reset left the drive inhibit: driving is inhibited if `kept`, which stays in place,
 * says so or is damaged; a stop that was not finished begins anew. `powered_on`: there was no
 * power, the content of `kept` is random, and driving is allowed. Once, after robot_begin(). */
void robot_resume(struct robot *robot, struct inhibit_copy *kept, bool powered_on);

/* Inhibits driving, and keeps that for a reset: nothing that can drive a servo is sent any more, to
 * whatever ID. */
void robot_inhibit(struct robot *robot);

/* Ends the inhibit; servos that lost their state stay held. Nothing is sent. False: torque off is
 * under way, and nothing was done. */
bool robot_allow(struct robot *robot);

/* Ends the inhibit, and every servo may be driven again, one that lost its state too. Nothing is
 * sent. False: torque off is under way, and nothing was done. */
bool robot_release(struct robot *robot);

/* Is driving inhibited? */
static inline bool robot_is_inhibited(const struct robot *robot)
{
    return robot->servos.is_inhibited;
}

/* How many servos there may be that the robot does not look at: 0 to 254. After a whole scan, those
 * that the scan found beyond the robot's room, at least 1 if another one was met since; else all
 * IDs that are not of the robot. */
uint8_t robot_unlisted(const struct robot *robot);

/* Torque off everywhere, ahead of everything: driving is inhibited from now on, a cycle or an
 * operation under way is ended. robot->stop says what came of it, when `stopping` is false. */
void robot_stop(struct robot *robot);

/* Is a stop under way? */
static inline bool robot_is_stopping(const struct robot *robot)
{
    return robot->stopping || robot->stop_waits;
}

/* Is something under way during which nobody else may use the bus? */
bool robot_is_exclusive(const struct robot *robot);

/* Nothing to do but the state check, which may wait for the next interrupt? */
bool robot_idle(const struct robot *robot);

/* Is a cycle running that sets the goal of servo `id`, 0 to 253, or of any if it is
 * CDS_BROADCAST_ID? */
bool robot_cycles(const struct robot *robot, uint8_t id);

/* Begins `operation` with `config`. 0: robot_poll() goes on with it; else the enum cds_result of
 * its begin function; ERROR_CYCLE, ERROR_STOPPED: another operation or a stop is under way. */
uint8_t robot_start(struct robot *robot, const CDS_FLASH struct robot_operation *operation,
                    const void *config);

/* An operation that shares the bus with other requests says so when it has begun. */
void robot_share_bus(struct robot *robot, struct cds_cycle *cycle);

/* Ends the operation as soon as it can be; a change of ID or rate goes on to its end. */
void robot_abort(struct robot *robot);

/* Takes servo `id`, 0 to 253, in, and has the robot looked after from now on. False: there is no
 * room. Servos join by themselves, too, when they answer or are written to, for they are to be held
 * with the others; but until somebody says who they are, nothing is sent that was not asked for,
 * except to one that is back. */
bool robot_add(struct robot *robot, uint8_t id);

/* A packet of the PC passes: the state check leaves the bus to it but for servos that are back. */
void robot_yield(struct robot *robot);

/* Forgets all servos. Not while a cycle, operation or stop is under way. The drive inhibit stays.
 */
void robot_forget(struct robot *robot);

#endif
