/* SPDX-License-Identifier: MIT */
/* Timed moves: the joints of a robot go to a pose in a given time and arrive together. In each
 * period of a cycle (cycle.h) every joint gets the next goal on its curve, and the speed that leads
 * there. Formulas and bounds: docs/internals/motion.md.
 *
 *     static struct cds_motion_joint joints[SERVOS];
 *     cds_motion_begin(&motion, &(struct cds_motion_config){
 *         .cycle = &cycle, .servos = &servos, .joints = joints});
 *     cds_motion_move(&motion, &(struct cds_move){.pose = stand, .time_ms = 1500});
 *     for (;;) {
 *         cds_bus_poll(&bus);
 *         cds_cycle_poll(&cycle);
 *         cds_motion_poll(&motion);
 *     }
 *
 * The program sets no goals (cds_cycle_goal()) of joints that move. Manual: 2.4.7, registers 0x1E
 * and 0x20; rulings R8, R10 (docs/internals/rulings.md). All functions: main context. */
#ifndef CDS_MOTION_H
#define CDS_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/cycle.h"  // struct cds_cycle
#include "cds55xx/servos.h" // struct cds_servos
#include "cds55xx/units.h"  // struct cds_register_profile

#ifdef __cplusplus
extern "C" {
#endif

/* The longest time of a move. */
#define CDS_MOTION_TIME_MAX_MS 600000ul

/* The curve from the beginning to the end of a move. */
enum cds_motion_curve {
    CDS_MOTION_MINIMUM_JERK, // smooth start and end; the highest speed is 15/8 of the mean speed
    CDS_MOTION_LINEAR,       // the same speed all the time
    CDS_MOTION_TRAPEZOID,    // speeds up, keeps the speed, slows down: at move.acceleration
    CDS_MOTION_BY_SERVO,     // one goal; each joint gets the speed at which all arrive together
} __attribute__((packed));

/* cds_motion_acceleration() of the factory value of registers 0x22 and 0x23. */
#define CDS_MOTION_FACTORY_ACCELERATION 8000u

/* A deceleration for pause and abort, in speed register units per second: a joint at full speed
 * stops within 128 ms and 81 steps. */
#define CDS_MOTION_DECELERATION CDS_MOTION_FACTORY_ACCELERATION

/* In a pose: the joint takes no part in the move. */
#define CDS_POSE_NONE UINT16_MAX

/* A joint that is at rest starts from its last goal, or if its servo reports a position further
 * than this from the goal, from the reported position. */
#define CDS_MOTION_NEAR_STEPS 16

/* What a motion works on. It is copied; what the pointers point to stays in place. */
struct cds_motion_config {
    struct cds_cycle *cycle;         // begun, with periods of 200 us or more; its servos are the
                                     // joints, in the same order
    struct cds_servos *servos;       // their soft limits; NULL: none
    struct cds_motion_joint *joints; // one for each servo of the cycle
    const struct cds_register_profile *const *profiles; // one for each joint; NULL: all CDS55xx
    uint16_t acceleration; // the most of minimum jerk and trapezoid, for joints that begin and end
                           // at rest, above 100 % for all, in speed register units (62/1023
                           // RPM) per second: cds_motion_acceleration(); 0: not checked
};

/* Returns the acceleration that a CDS55xx has with the value `acc`, 0 to 255, in register 0x22 or
 * 0x23, as far as is known; 0 if it has no ramp. Factory value 32: 8000. The manual gives no unit
 * (R40): the simulated servo changes its speed by `acc` units each 4 ms. Measure a real one. */
static inline uint16_t cds_motion_acceleration(uint8_t acc)
{
    return (uint16_t)(250u * acc);
}

/* A move. What the pointers point to stays in place until the move is over. */
struct cds_move {
    const uint16_t *pose;      // position of each joint, 0 to 1023, or CDS_POSE_NONE
    uint32_t time_ms;          // 1 to CDS_MOTION_TIME_MAX_MS, rounded up to whole periods
    uint8_t curve;             // enum cds_motion_curve
    bool may_take_longer;      // a time that is too short is stretched, not refused
    bool waits;                // true: the move begins when the move under way has ended, or at
                               // once if there is none. False: it replaces the move under way
    uint16_t acceleration;     // of a trapezoid: of the joint with the longest distance, in speed
                               // register units per second, 1 or more; config.acceleration at most
    const uint16_t *next_pose; // NULL: the joints stop at `pose`. Else they pass `pose` without a
                               // stop, towards next_pose
    uint32_t next_ms;          // time from `pose` to next_pose. The program submits that move with
                               // `waits`
    uint32_t pass_rate;        // internal: highest rate, in 1/65536, beside a passed pose of a
                               // sequence that was tried; 0: 65536
};

/* The curve that all joints of a move share. Its fields are internal. */
struct cds_curve {
    uint8_t kind;          // enum cds_motion_curve
    uint16_t ramp;         // trapezoid: share of the time that speeding up takes, 1/65536
    uint16_t inverse_ramp; // 1 / that share, in 1/1024
    uint16_t rate;         // the highest speed, in 1/16384 of the mean speed
};

/* One joint. A position is in 1/8 step, a speed in 1/16 of a register's unit. The fields are
 * internal. */
struct cds_motion_joint {
    uint16_t scale;   // speed of one step per period, in 1/16 of a register's unit
    uint16_t fastest; // the most that is sent, in 1/4 of a register's unit
    int16_t lowest;   // soft limits
    int16_t highest;
    uint16_t start;      // where the move began
    int16_t distance;    // that follows the curve
    int16_t braking;     // twice the distance in which it brakes from begin_speed
    int16_t passing;     // twice the distance in which it speeds up to end_speed
    int16_t mean_speed;  // of `distance` over the duration
    int16_t begin_speed; // when the move began
    int16_t end_speed;   // when it ends
    int16_t trial_end;   // where the trial before ends
    int16_t trial_speed; // speed there
    bool has_speeds : 1; // begin_speed or end_speed is not 0
    bool is_known : 1;   // the position of the joint is known
    bool is_moving : 1;  // takes part in the move
    bool is_tried : 1;   // trial_end and trial_speed are set
};

/* What one moment of a move means for all its joints. The fields are internal. */
struct cds_motion_basis {
    uint16_t progress;         // of the curve, in 1/65536 of the distance
    uint16_t rate;             // of the curve, in 1/16384 of the mean speed
    uint16_t sent_rate;        // `rate`, and a reserve
    uint16_t braking_progress; // in 1/65536 of `braking`
    uint16_t braking_rate;     // in 1/16384 of the speed at the beginning
    uint16_t passing_progress; // in 1/65536 of `passing`
    uint16_t passing_rate;     // in 1/16384 of the speed at the end
    bool is_end;               // the move is over
    bool is_at_rest;           // all speeds are 0
};

/* A time that passes from 0 to 1, in 1/2^32, the low part in 1/2^48. The fields are internal. */
struct cds_motion_clock {
    uint32_t time;
    uint32_t step; // in a period
    uint16_t time_low, step_low;
};

/* The timing of a move. The fields are internal. */
struct cds_motion_plan {
    struct cds_motion_clock time;
    struct cds_motion_clock braking_time;
    struct cds_curve curve;
    uint32_t duration;      // in periods
    uint32_t next_duration; // of the move behind it, if it passes
    uint32_t peak;          // highest speed of a joint, in 1/16 unit
    uint32_t rate_most;     // how fast the time may run, in 1/65536
    uint32_t window;        // of braking, in periods
    bool passes;            // the joints may have a speed at the end
};

/* A motion. Zero it (static storage is), then cds_motion_begin(). The program reads the first four
 * fields; the rest is internal. */
struct cds_motion {
    uint8_t result;      // of the last move: CDS_PENDING while it is under way or paused
    uint8_t move_result; // of the last cds_motion_move() or cds_motion_try(): CDS_PENDING while the
                         // move is checked, CDS_OK once it has begun or was tried, or why it was
                         // refused
    uint8_t joint;       // for which the move was refused or ended
    uint32_t shortest_ms; // refused as CDS_LIMIT: a time in which the move works, or 0: none
    // internal:
    struct cds_motion_config config;
    struct cds_motion_basis basis; // of the goals that are set now
    uint8_t count;                 // of joints
    uint8_t index;                 // joint whose goal is set next; `count`: none in this period
    uint8_t begun;                 // joints before this one have begun the move
    uint8_t cycle_begun;           // cycle->begun when the motion began
    uint8_t stage;                 // of the check
    uint8_t checked;               // joint that is checked next in this stage
    uint8_t outcome;               // of a motion that is ending
    uint8_t wrong_argument;        // of `next`: enum cds_motion_argument
    bool is_paused : 1;            // until cds_motion_resume(), or the motion has ended
    bool is_ready : 1;             // the move is checked, and begins with the next goals
    bool is_under_way : 1;
    bool is_ending : 1;                 // ends as soon as it is at rest
    bool is_trial : 1;                  // the move that is checked does not begin
    bool follows : 1;                   // the next move waited for the end of another one
    bool checks_from_rest : 1;          // the check takes the joints to be at rest
    uint32_t periods;                   // of the cycle, when the last goals were set
    uint32_t rate;                      // at which the time runs, in 1/65536
    uint32_t rate_goal;                 // the rate that `rate` approaches
    uint32_t rate_step;                 // largest change of `rate` in a period
    uint16_t deceleration;              // of the last pause: the next move begins paused, too
    uint16_t carry;                     // speeds at the beginning are multiplied by this, in
                                        // 1/4096: the next move may have to run its time slower
    uint32_t override;                  // rate that cds_motion_set_override() asks for, in 1/65536
    struct cds_motion_plan plan;        // of the move under way
    struct cds_motion_basis last_basis; // of the goals before it
    struct cds_move next;               // the move that is checked
    struct cds_motion_plan next_plan;   // of that move
    uint32_t shortest_periods;          // that it takes at least, as far as is checked
    uint32_t longest_distance;          // of its joints: register units x periods
    uint32_t longest_window;            // periods in which all joints brake within their limits
    bool has_speeds;                    // a joint moves when the move begins, or when it ends
};

/* Begins, at rest. CDS_OK; CDS_BAD_ARGUMENT: the cycle was not begun, its period is shorter than
 * 200 us, or period_us x full_speed_mrpm of a profile is below 12 210 000. */
enum cds_result cds_motion_begin(struct cds_motion *motion, const struct cds_motion_config *config);

/* Checks a move, then begins it: from where the joints are, or if they move, from the goals under
 * way with their speed. cds_motion_poll() checks one joint each time; until then a move under way
 * goes on. A joint that moves and is not in the pose brakes within 250 ms if the curve is minimum
 * jerk or trapezoid; with the other curves it stops at its last goal. A joint that moves is at most
 * 1/8 faster than its speed limit, and its goals never leave the soft limits.
 * motion.move_result tells:
 *
 *   CDS_OK            the move has begun
 *   CDS_LIMIT         shortest_ms is 0: the goal of motion.joint is beyond a soft limit, or the
 *                     joint rests beyond one; by the servo (CDS_MOTION_BY_SERVO) it may rest there
 *   CDS_LIMIT         shortest_ms is 0: the move needs more than CDS_MOTION_TIME_MAX_MS
 *   CDS_LIMIT         shortest_ms is not 0: the time is too short for motion.joint. shortest_ms is
 *                     a time that works: the shortest one if all joints begin and end at rest, else
 *                     up to 1/8 longer
 *   CDS_INHIBITED     motion.joint may not be driven
 *   CDS_TIMEOUT       the position of motion.joint is not known: the cycle has not read it yet, or
 *                     not in the last 0.5 s
 *
 * Returns CDS_OK: it is checked now. CDS_BUSY: the move before is still checked, or this move waits
 * and the motion is being aborted: try again when result is CDS_CANCELLED. CDS_BAD_ARGUMENT:
 * time, curve, acceleration or a position is out of range, or no joint is in the pose:
 * cds_motion_text() names the argument. A move under way goes on. */
enum cds_result cds_motion_move(struct cds_motion *motion, const struct cds_move *move);

/* Tries a move: checks it as cds_motion_move() does, and does not begin it. So a program checks the
 * moves of a sequence one after the other before the first one begins. A joint starts from where
 * the trial before ends, with the speed it has there; `is_first`, or no trial had this joint: from
 * where it is. cds_motion_poll() goes on with the trial, and motion.move_result tells, as for
 * cds_motion_move(). move->waits is not used. Returns as cds_motion_move(); CDS_BUSY, too, while a
 * move is under way. */
enum cds_result cds_motion_try(struct cds_motion *motion, const struct cds_move *move,
                               bool is_first);

/* True while cds_motion_move() returns CDS_BUSY for every move. */
static inline bool cds_motion_is_busy(const struct cds_motion *motion)
{
    return motion->move_result == CDS_PENDING || motion->begun < motion->count;
}

/* Moves on; call it after cds_cycle_poll() from the main loop. Each call checks one joint, or sets
 * the goals of at most 6. Returns motion.result:
 *
 *   CDS_PENDING    a move is under way or paused
 *   CDS_OK         the last goals were sent, or nothing has moved yet, or it was never begun
 *   CDS_CANCELLED  aborted; the joints stand still
 *   CDS_LIMIT      the permit refused a goal of motion.joint; the other joints have stopped where
 *                  they were
 *   CDS_INHIBITED  the permit refused a goal because motion.joint may not be driven; or the cycle
 *                  was aborted, or begun again
 *   CDS_TIMEOUT    when the move began, the last feedback of motion.joint was older than 0.5 s */
enum cds_result cds_motion_poll(struct cds_motion *motion);

/* Brings the joints to a standstill on their way, at `deceleration` at most (speed register units
 * per second, 1 or more; what the curve itself slows down adds to that). cds_motion_resume() speeds
 * up at the same rate. A move that is still checked, or waits, begins paused: move_result is
 * CDS_OK, no joint moves, and cds_motion_is_busy() is true until cds_motion_resume(). A move by the
 * servo (CDS_MOTION_BY_SERVO) goes on to its goal. Does nothing if no move is under way or checked,
 * or while a move is tried. */
void cds_motion_pause(struct cds_motion *motion, uint16_t deceleration);
void cds_motion_resume(struct cds_motion *motion);

/* Brings the joints to a standstill as cds_motion_pause() does, then ends the move as
 * CDS_CANCELLED. A move that is checked is not begun. */
void cds_motion_abort(struct cds_motion *motion, uint16_t deceleration);

/* Range of `percent` of cds_motion_set_override(). */
#define CDS_MOTION_OVERRIDE_MIN 10
#define CDS_MOTION_OVERRIDE_MAX 200

/* Lets the time of this and later moves run at `percent`, 10 to 200, as far as speed limits and
 * config.acceleration permit. A move that begins or ends in motion takes its time as given, or
 * longer, unless it belongs to a sequence with checks_all. Changes within a quarter of a second.
 * CDS_OK; CDS_BAD_ARGUMENT: out of range. */
enum cds_result cds_motion_set_override(struct cds_motion *motion, uint8_t percent);

/* Copies why a move was refused or has ended to `text`: at most capacity - 1 characters and a 0,
 * `capacity` 1 or more; CDS_RESULT_TEXT_SIZE holds every text. `result`: what the last
 * cds_motion_move() or cds_motion_try() has returned, motion.move_result, motion.result, or
 * sequence.result of a sequence with this motion. Call it while the pose of that move is in place.
 * The texts:
 *
 *   CDS_LIMIT         "too fast, it needs 196 ms", of motion.joint;
 *                     "it stands beyond its limits": motion.joint does, its goal is within
 *   CDS_BAD_ARGUMENT  "time 0 ms is out of range: 1 to 600000 ms"; "there is no such curve";
 *                     "a trapezoid has no acceleration";
 *                     "a position is above 1023, or no joint is in the pose"
 *   CDS_TIMEOUT       "its feedback is too old: no reply, or a slow main loop", of motion.joint
 *   other results, and CDS_LIMIT of another cause: cds_result_text()
 *
 * Returns the length of what was copied. */
uint8_t cds_motion_text(const struct cds_motion *motion, uint8_t result, char *text,
                        uint8_t capacity);

#ifdef __cplusplus
}
#endif

#endif
