/* SPDX-License-Identifier: MIT */
/* What suites of moves share beside joints_rig.h: a motion of all joints, and random numbers. */
#ifndef MOTION_RIG_H
#define MOTION_RIG_H

#include <stdlib.h> // rand()

#include "cds55xx/motion.h"
#include "joints_rig.h"

static struct cds_motion motion;
static struct cds_motion_joint joints[JOINTS];

/* `acceleration`: as in struct cds_motion_config. */
static inline void rig_begin_motion(uint16_t acceleration)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_begin(&motion, &(struct cds_motion_config){
                                                            .cycle = &cycle,
                                                            .servos = &servos,
                                                            .joints = joints,
                                                            .acceleration = acceleration}));
}

/* From 0 to `end` - 1. */
static inline uint16_t random_below(uint16_t end)
{
    return (uint16_t)(((uint32_t)rand() & 0x7FFF) % end);
}

#endif
