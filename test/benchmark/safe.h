/* SPDX-License-Identifier: MIT */
/* Shared by the programs of the safe_ rows: 50 servos with soft limits on a bus with queue and
 * retries, as in examples/robot.c. Only this file uses the API of servos.h. */
#ifndef SAFE_H
#define SAFE_H

#include <cds55xx/blocking.h>
#include <cds55xx/servos.h>
#include <cds55xx/sync_write.h>
#include <cds55xx/torque_off.h>

#include "benchmark.h"

#define SERVOS  50
#define LOWEST  300 // soft limits, as in examples/robot.c
#define HIGHEST 724
#define FASTEST 512
#define MIDDLE  512
#define SPEED   300
#define RETRIES 2

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

BENCH_REQUEST(request, CDS_REPLY_MAX);
static struct cds_servos servos;
static struct cds_servo_state states[SERVOS];

/* Sets the soft limits of all servos. */
static inline void safe_set_limits(uint16_t lowest, uint16_t highest)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        cds_servos_set_limits(&servos, &states[i], lowest, highest, FASTEST);
}

/* Ends the drive inhibit of a torque off. */
static inline void safe_release(void)
{
    cds_servos_release_all(&servos);
}

/* Writes a goal and its speed to servo `id` in one WRITE. A goal alone would be refused, because
 * the servo has a speed limit. */
static inline enum cds_result safe_send_goal(uint8_t id)
{
    static const uint8_t goal[] = {MIDDLE & 0xFF, MIDDLE >> 8, SPEED & 0xFF, SPEED >> 8};

    return cds_servo_write(&bus, &request, id, CDS_REG_GOAL_POSITION, goal, sizeof(goal));
}

/* Reads mode, goal and speed of servo `id`, and writes a goal, so that its limits can be checked.
 */
static inline bool safe_prepare(uint8_t id)
{
    return cds_blocking_for(&bus, &request,
                            cds_servo_read(&bus, &request, id, CDS_REG_CW_ANGLE_LIMIT, 4)) ==
               CDS_OK &&
           cds_blocking_for(&bus, &request, safe_send_goal(id)) == CDS_OK &&
           cds_blocking_for(&bus, &request,
                            cds_servo_read(&bus, &request, id, CDS_REG_GOAL_POSITION, 4)) == CDS_OK;
}

/* True: the bus is open, and all servos may be driven within their limits. */
static inline bool safe_open(void)
{
    const struct cds_servos_config config = {
        .bus = &bus, .queue = &bench_queue, .states = states, .count = SERVOS, .capacity = SERVOS};
    bool good = true;

    bench_open_bare(&bus);
    for (uint8_t i = 0; i < SERVOS; i++)
        states[i].id = (uint8_t)(i + 1);
    good &= cds_servos_begin(&servos, &config) == CDS_OK;
    bench_set_retries(&bus, RETRIES);
    cds_bus_set_return_delay(&bus, 2);
    safe_set_limits(LOWEST, HIGHEST);
    for (uint8_t i = 0; i < SERVOS; i++)
        good &= safe_prepare((uint8_t)(i + 1));
    return good;
}

#endif
