/* SPDX-License-Identifier: MIT */
/* What the files of motions and sequences need of each other; not installed. Positions and speeds
 * as in struct cds_motion_joint. Main context. */
#ifndef CDS_MOTION_INTERNAL_H
#define CDS_MOTION_INTERNAL_H

#include "cds55xx/motion.h"

#define CDS_MOTION_STEP     8    // positions are in 1/8 step
#define CDS_MOTION_UNIT     16   // speeds are in 1/16 of a register's unit
#define CDS_MOTION_CARRY_1  4096 // of motion->carry
#define CDS_MOTION_QUARTERS 4    // cds_motion_speed() counts in 1/4 unit
#define CDS_MOTION_RATE_1   ((uint32_t)65536)
#define CDS_MOTION_HALF     ((int32_t)32768) // of a share in 1/65536

/* An argument of cds_motion_move() that is out of range: motion.wrong_argument. From
 * CDS_MOTION_NEXT_TIME on it belongs to the move behind a passed pose. */
enum cds_motion_argument {
    CDS_MOTION_NO_ARGUMENT,
    CDS_MOTION_TIME,
    CDS_MOTION_CURVE,
    CDS_MOTION_ACCELERATION,
    CDS_MOTION_POSE,
    CDS_MOTION_NEXT_TIME,
    CDS_MOTION_NEXT_POSE,
} __attribute__((packed));

/* From where to where, and with which speeds, in 1/16 unit. */
struct cds_motion_path {
    int16_t position, goal, begin_speed, end_speed;
};

/* Returns the servo of joint `index`; NULL: it has no soft limits. */
const struct cds_servo_state *cds_motion_servo(const struct cds_motion *motion, uint8_t index);

/* Begins to check and plan motion->next. */
void cds_motion_begin_check(struct cds_motion *motion);

/* Checks one joint, or does a step of the plan. Returns CDS_PENDING until that is over; CDS_OK: the
 * move is possible, and motion->next_plan is its plan; else why it is refused. */
enum cds_result cds_motion_check(struct cds_motion *motion);

/* Returns by how much `acceleration` changes a speed in a period, in 1/16 unit, 1 or more. */
uint32_t cds_motion_speed_change(const struct cds_motion *motion, uint16_t acceleration);

/* Finds the path of joint `index` in motion->next, which takes `duration` periods. The path begins
 * at the goal of `basis`, with its speed. If the joint rests and its servo reports a position more
 * than CDS_MOTION_NEAR_STEPS away, the path begins at the reported position. False: not known. */
bool cds_motion_find_path(const struct cds_motion *motion, uint8_t index,
                          const struct cds_motion_basis *basis, uint32_t duration,
                          struct cds_motion_path *path);

/* Sets the path of *joint to `path`, in the duration and window of `plan`. */
void cds_motion_set_path(struct cds_motion_joint *joint, const struct cds_motion_path *path,
                         const struct cds_motion_plan *plan);

/* Joint `index` begins the move that was checked. A joint that is not in the pose brakes, or if the
 * curve is linear or by servo, stops at its last goal. False: its feedback is older than 0.5 s. */
bool cds_motion_begin_path(struct cds_motion *motion, uint8_t index);

/* Sets the next goal of joint `index`. The speed leads there within a period; it is never 0, which
 * would be full speed. Returns as cds_cycle_goal(). */
enum cds_result cds_motion_set_goal(struct cds_motion *motion, uint8_t index,
                                    const struct cds_motion_joint *joint);

/* Sets *basis to the end of the move under way. */
void cds_motion_set_end(const struct cds_motion *motion, struct cds_motion_basis *basis);

/* Returns the speed of the joint at `basis`, in 1/4 of a register's unit. */
int16_t cds_motion_speed(const struct cds_motion_joint *joint,
                         const struct cds_motion_basis *basis);

#endif
