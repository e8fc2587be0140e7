/* SPDX-License-Identifier: MIT */
/* What suites of moves share in addition to joints_rig.h: a motion of all joints, moves from
 * `pose`, periods that pass, and random numbers.
 *
 *     pose[0] = 900;
 *     rig_move(1000, CDS_MOTION_LINEAR);
 *     while (rig_pass_period() == CDS_PENDING)
 *         TEST_ASSERT_LESS_OR_EQUAL_UINT16(900, goals[0]);
 */
#ifndef MOTION_RIG_H
#define MOTION_RIG_H

#include <stdlib.h> // rand()
#include <string.h>

#include "cds55xx/motion.h"
#include "joints_rig.h"

#define PERIOD_US 4000

/* The simulated AVR is slow: there a suite divides random inputs and the lengths of long moves by
 * AVR_DIVIDES_RANDOM, and the rounds of other loops by AVR_DIVIDES_LOOPS. Each suite is limited to
 * 60 s of simulated time; it uses at most 48 s. */
#ifdef __AVR__
#define AVR_DIVIDES_RANDOM 200
#define AVR_DIVIDES_LOOPS  6
#else
#define AVR_DIVIDES_RANDOM 1
#define AVR_DIVIDES_LOOPS  1
#endif

static struct cds_motion motion;
static struct cds_motion_joint joints[JOINTS];
static uint16_t pose[JOINTS]; // of the next move
static uint32_t sent;         // SYNC WRITEs of rig_pass_period()

/* `acceleration`: as in struct cds_motion_config. */
static inline void rig_begin_motion(uint16_t acceleration)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_begin(&motion, &(struct cds_motion_config){
                                                            .cycle = &cycle,
                                                            .servos = &servos,
                                                            .joints = joints,
                                                            .acceleration = acceleration}));
}

static inline void rig_begin_cycle_and_motion(uint16_t period_us)
{
    rig_begin_cycle(period_us);
    rig_begin_motion(0);
}

/* setUp(): all joints stand at 500, and `pose` names no joint. */
static inline void rig_begin_moves(void)
{
    rig_begin_joints(500);
    rig_begin_cycle_and_motion(PERIOD_US);
    memset(pose, 0xFF, sizeof pose); // CDS_POSE_NONE
    sent = 0;
}

/* The goals leave, and all servos report. */
static inline void rig_send_goals_and_report(void)
{
    rig_send_goals();
    TEST_ASSERT_EQUAL_UINT16(8 + 5 * JOINTS, port_fake.sent_size);
    for (uint8_t i = 0; i < JOINTS; i++)
        feedback[i].time_us = port_fake.now_us;
}

/* Polls enough to check a move, and to set the goals of a period. Returns what the last poll has
 * returned. */
static inline enum cds_result rig_poll_motion(void)
{
    enum cds_result result = CDS_OK;

    for (uint8_t i = 0; i < 3 * JOINTS + 10; i++)
        result = cds_motion_poll(&motion);
    return result;
}

/* The goals leave, and the motion sets those of the next period. Returns what its last poll has
 * returned. */
static inline enum cds_result rig_pass_period(void)
{
    rig_send_goals_and_report();
    sent++;
    return rig_poll_motion();
}

/* Returns move_result; if it is pending, one period passes first. */
static inline enum cds_result rig_try_move(uint32_t time_ms, enum cds_motion_curve curve)
{
    struct cds_move it = {.pose = pose, .time_ms = time_ms, .curve = curve, .acceleration = 4000};

    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &it));
    rig_poll_motion();
    if (motion.move_result == CDS_PENDING)
        rig_pass_period();
    return (enum cds_result)motion.move_result;
}

static inline void rig_move(uint32_t time_ms, enum cds_motion_curve curve)
{
    TEST_ASSERT_EQUAL(CDS_OK, rig_try_move(time_ms, curve));
}

/* The move under way goes up to `end`: no goal is below the last one or beyond `end`. */
static inline void rig_check_goals_rise_to(uint16_t end)
{
    uint16_t last = goals[0];

    while (motion.result == CDS_PENDING || motion.move_result == CDS_PENDING) {
        rig_pass_period();
        TEST_ASSERT_GREATER_OR_EQUAL_UINT16(last, goals[0]);
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(end, goals[0]);
        last = goals[0];
        feedback[0].position = goals[0];
    }
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(end, goals[0]);
}

static inline uint16_t distance(uint16_t from, uint16_t to)
{
    return to > from ? to - from : from - to;
}

/* From 0 to `end` - 1. */
static inline uint16_t random_below(uint16_t end)
{
    return (uint16_t)(((uint32_t)rand() & 0x7FFF) % end);
}

#endif
