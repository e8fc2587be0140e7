/* SPDX-License-Identifier: MIT */
/* What suites of moving joints share: servos 1 to JOINTS with limits, a cycle, and the goals that
 * leave in its SYNC WRITE. A suite may define JOINTS before it includes this file. */
#ifndef JOINTS_RIG_H
#define JOINTS_RIG_H

#include <string.h>

#include "bus_rig.h"
#include "cds55xx/cycle.h"
#include "cds55xx/servos.h"

#ifndef JOINTS
#define JOINTS 7 // more than one poll of a motion or a gait sets
#endif

static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state states[JOINTS];
static struct cds_cycle cycle;
static struct cds_feedback feedback[JOINTS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(JOINTS)], ids[JOINTS];
static uint16_t goals[JOINTS], speeds[JOINTS]; // of the last SYNC WRITE

/* setUp(): all joints report `position`, and have no limits. */
static inline void rig_begin_joints(uint16_t position)
{
    rig_open(0);
    memset(&servos, 0, sizeof servos);
    memset(states, 0, sizeof states);
    for (uint8_t i = 0; i < JOINTS; i++) {
        states[i].id = ids[i] = (uint8_t)(i + 1);
        feedback[i] = (struct cds_feedback){.known = true, .position = position};
    }
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                                            .queue = &queue,
                                                                            .states = states,
                                                                            .count = JOINTS,
                                                                            .capacity = JOINTS}));
}

/* The first goals of the cycle are where the joints are. */
static inline void rig_begin_cycle_again(uint16_t period_us)
{
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_cycle_begin(&cycle, &(struct cds_cycle_config){.bus = &bus,
                                                                         .ids = ids,
                                                                         .packets = packets,
                                                                         .feedback = feedback,
                                                                         .count = JOINTS,
                                                                         .period_us = period_us}));
    for (uint8_t i = 0; i < JOINTS; i++)
        TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, i, feedback[i].position, 1));
    cds_cycle_commit(&cycle);
}

static inline void rig_begin_cycle(uint16_t period_us)
{
    memset(&cycle, 0, sizeof cycle);
    rig_begin_cycle_again(period_us);
}

/* A period passes, and its goals leave. */
static inline void rig_send_goals(void)
{
    port_fake.now_us += cycle.period_us;
    while (!cds_bus_is_busy(&bus))
        cds_cycle_poll(&cycle);
    rig_transmit();
    port_fake_look(&bus);
    for (uint8_t i = 0; i < JOINTS; i++) {
        const uint8_t *block = port_fake.sent + CDS_AT_PARAMETERS + 2 + 5 * i;

        goals[i] = (uint16_t)(block[1] | block[2] << 8);
        speeds[i] = (uint16_t)(block[3] | block[4] << 8);
    }
}

#endif
