/* SPDX-License-Identifier: MIT */
/* Finds a joint that does not follow its goals: a collision, an overload, an output that is
 * blocked. It compares the goals of a cycle (cycle.h) with the feedback. The goals come from
 * motion.h, gait.h or the program itself.
 *
 *     static struct cds_follow_joint joints[SERVOS];
 *     cds_follow_begin(&follow, &(struct cds_follow_config){.cycle = &cycle, .joints = joints});
 *     ...
 *     cds_motion_poll(&motion);
 *     if (cds_follow_poll(&follow) == CDS_TIMEOUT)
 *         cds_motion_abort(&motion, CDS_MOTION_DECELERATION); // joint follow.joint is blocked
 *
 * Beside a sequence: examples/keyframes.c.
 * Poll it while torque is on. Defaults, and the time until a report: docs/internals/motion.md.
 * Manual: registers 0x1E and 0x24. All functions: main context. */
#ifndef CDS_FOLLOW_H
#define CDS_FOLLOW_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/cycle.h" // struct cds_cycle

#ifdef __cplusplus
extern "C" {
#endif

/* Defaults: simulated servos lag up to 55 steps behind in moves at their highest speed, and up to
 * 81 steps, above 80 for at most 32 ms, if they also carry 40 % of their stall torque. In a linear
 * move (CDS_MOTION_LINEAR) at nearly 62 RPM their lag grows by 81 steps while they speed up, and
 * stays: use steps = 160. */
#define CDS_FOLLOW_STEPS 80
#define CDS_FOLLOW_MS    200

/* A joint follows if it comes nearer to its goal by at least this distance. */
#define CDS_FOLLOW_PROGRESS_STEPS 3

/* What is compared. It is copied; what the pointers point to stays in place. */
struct cds_follow_config {
    const struct cds_cycle *cycle;   // begun
    struct cds_follow_joint *joints; // one for each servo of the cycle
    uint16_t steps;    // permitted distance from the goal, 1 to 1023; 0: CDS_FOLLOW_STEPS
    uint16_t time_ms;  // permitted time beyond that distance, up to 60000; 0: CDS_FOLLOW_MS
    bool skips_silent; // a joint that does not report is not compared: robot.h finds it (OFFLINE)
};

/* One joint. The fields are internal. */
struct cds_follow_joint {
    uint16_t distance; // from its goal, when `away` began at 0; 0: it follows
    uint16_t position; // at that time
    uint16_t time;     // of the last feedback that was compared, in 1024 us
    uint16_t away;     // how long it is away and comes no nearer, in 1024 us
};

/* Zero it (static storage is), then cds_follow_begin(). The program reads `result` and `joint`. */
struct cds_follow {
    uint8_t result; // CDS_PENDING: all joints follow; CDS_TIMEOUT: `joint` does not
    uint8_t joint;  // CDS_PENDING: compared next; CDS_TIMEOUT: does not follow
    // internal:
    const struct cds_cycle *cycle;
    struct cds_follow_joint *joints;
    uint16_t steps;       // as in the config, or the default
    uint16_t time_1024us; // config.time_ms or the default, rounded up to units of 1024 us
    bool skips_silent;    // as in the config
};

/* Begins; also begins again after a report. CDS_OK; CDS_BAD_ARGUMENT: the cycle was not begun, or a
 * value is out of range. */
enum cds_result cds_follow_begin(struct cds_follow *follow, const struct cds_follow_config *config);

/* Compares one joint. Call it after cds_cycle_poll() from the main loop. Returns follow.result:
 *
 *   CDS_PENDING  all joints follow
 *   CDS_TIMEOUT  follow.joint is further than `steps` from its goal for `time_ms`, and did not come
 *                nearer; or, unless the config skips it, it has not reported for `time_ms` +
 *                CDS_FOLLOW_MS. It stays so until cds_follow_begin()
 *
 * The report comes at the latest `time_ms` + 2 ms + twice the age that feedback reaches
 * (counters.oldest_us of the cycle) after the goal is further away than `steps`, if the program
 * polls once for each servo meanwhile. If a joint is read less often than each `time_ms` / 2, the
 * third feedback reports. A joint that never reported and one that is left out of the goals is not
 * compared: the presence of servos.h tells about these. In a move by servo (CDS_MOTION_BY_SERVO) a
 * joint must go 3 steps in `time_ms`. */
enum cds_result cds_follow_poll(struct cds_follow *follow);

#ifdef __cplusplus
}
#endif

#endif
