/* SPDX-License-Identifier: MIT */
/* 18 joints, 6 legs of coxa, femur and tibia, walk in a tripod gait: forwards, then they turn, then
 * they stop. Prints how the gait ended. A joint that does not follow aborts the gait; then torque
 * is switched off. */
#include <cds55xx/follow.h>
#include <cds55xx/gait.h>

#include "joints.h"
#include "say.h"

#define WALK_PERIODS 750
#define TURN_PERIODS 750

enum { LEFT, RIGHT, LIFT };

/* The foot is in the air in the first half of the turn that begins at `degrees`; meanwhile the coxa
 * swings forwards. */
#define LEG(side, forwards, degrees)                                                               \
    {.rest = 512,                                                                                  \
     .sines = {{.amplitude = forwards,                                                             \
                .phase = CDS_GAIT_PHASE(degrees + 270),                                            \
                .multiple = 1,                                                                     \
                .group = side}}},                                                                  \
        {.rest = 400,                                                                              \
         .sines = {{.amplitude = 70,                                                               \
                    .phase = CDS_GAIT_PHASE(degrees),                                              \
                    .multiple = 1,                                                                 \
                    .wave = CDS_GAIT_LIFT,                                                         \
                    .group = LIFT}}},                                                              \
    {                                                                                              \
        .rest = 600, .sines = {                                                                    \
            {.amplitude = 40,                                                                      \
             .phase = CDS_GAIT_PHASE(degrees),                                                     \
             .multiple = 1,                                                                        \
             .wave = CDS_GAIT_LIFT,                                                                \
             .group = LIFT}                                                                        \
        }                                                                                          \
    }

CDS_GAIT_TABLE(tripod) = {LEG(LEFT, 80, 0),     LEG(LEFT, 80, 180), LEG(LEFT, 80, 0),
                          LEG(RIGHT, -80, 180), LEG(RIGHT, -80, 0), LEG(RIGHT, -80, 180)};

static struct cds_queue queue;
static struct cds_gait gait;
static struct cds_gait_state states[JOINTS];
static struct cds_follow follow;
static struct cds_follow_joint followed[JOINTS];

static void poll(void)
{
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
}

static void begin(void)
{
    joints_begin(&queue, JOINTS, 2);
    cds_follow_begin(&follow, &(struct cds_follow_config){.cycle = &cycle, .joints = followed});
    cds_gait_begin(&gait, &(struct cds_gait_config){.cycle = &cycle,
                                                    .servos = &servos,
                                                    .joints = tripod,
                                                    .states = states,
                                                    .period_ms = 1000,
                                                    .ramp_ms = 1000});
}

/* What the robot does in which period. */
static void steer(void)
{
    if (cycle.counters.periods == WALK_PERIODS)
        cds_gait_set_scale(&gait, RIGHT, -100);
    if (cycle.counters.periods == WALK_PERIODS + TURN_PERIODS)
        cds_gait_stop(&gait);
}

static void walk(void)
{
    while (cds_gait_poll(&gait) == CDS_PENDING) {
        poll();
        steer();
        if (cds_follow_poll(&follow) == CDS_TIMEOUT && !gait.is_ending) {
            say("stuck", follow.joint);
            cds_gait_abort(&gait, CDS_MOTION_DECELERATION);
        }
    }
    if (follow.result == CDS_PENDING)
        return;
    cds_cycle_abort(&cycle);
    while (cds_cycle_poll(&cycle) == CDS_PENDING)
        cds_bus_poll(&bus);
    joints_set_torque(0);
    say("torque_off", 1);
}

int main(void)
{
    uint32_t end;

    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    begin();
    walk();
    end = cycle.counters.periods + 75;
    while (follow.result == CDS_PENDING && cycle.counters.periods != end)
        poll();
    say("result", gait.result);
    say("joint", gait.joint);
    say("missed", cycle.counters.missed);
    say("oldest_us", cycle.counters.oldest_us);
    say_end();
}
