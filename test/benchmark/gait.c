/* SPDX-License-Identifier: MIT */
/* A gait of 18 joints at 250 Hz, with feedback and the permit. Byte 0 of the EEPROM: sines of each
 * joint, 1 or 3. While the gait is checked, MARK_SLOW is cds_gait_poll(); then MARK_POLL is.
 * MARK_CALL is cds_cycle_goal() for six joints. */
#include <cds55xx/gait.h>

#include "../firmware/library/joints.h"
#include "benchmark.h"

#define ONE(turn)                                                                                  \
    {                                                                                              \
        .rest = 512, .sines = { {.amplitude = 100, .multiple = 1, .phase = CDS_GAIT_PHASE(turn)} } \
    }
#define THREE(turn)                                                                                \
    {                                                                                              \
        .rest = 512, .sines = {                                                                    \
            {.amplitude = 60, .multiple = 1, .phase = CDS_GAIT_PHASE(turn)},                       \
            {.amplitude = -30, .multiple = 2, .wave = CDS_GAIT_LIFT, .group = 1},                  \
            {.amplitude = 10, .multiple = 3, .phase = CDS_GAIT_PHASE(turn), .group = 2}            \
        }                                                                                          \
    }
#define ALL(shape)                                                                                 \
    shape(0), shape(20), shape(40), shape(60), shape(80), shape(100), shape(120), shape(140),      \
        shape(160), shape(180), shape(200), shape(220), shape(240), shape(260), shape(280),        \
        shape(300), shape(320), shape(340)

CDS_GAIT_TABLE(of_one_sine) = {ALL(ONE)};
CDS_GAIT_TABLE(of_three_sines) = {ALL(THREE)};

static struct cds_gait gait;
static struct cds_gait_state joints[JOINTS];

/* Sends all joints where they are. */
static void begin_goals(void)
{
    for (uint8_t i = 0; i < JOINTS; i++)
        cds_cycle_goal(&cycle, i, feedback[i].position, 512);
    cds_cycle_commit(&cycle);
}

static void poll(void)
{
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
    if (gait.is_under_way) {
        mark(MARK_POLL);
        cds_gait_poll(&gait);
        unmark(MARK_POLL);
    } else {
        mark(MARK_SLOW);
        cds_gait_poll(&gait);
        unmark(MARK_SLOW);
    }
}

/* Returns 1 if the gait ends in the rest positions. */
static uint8_t walk(uint8_t sines)
{
    cds_gait_begin(&gait,
                   &(struct cds_gait_config){.cycle = &cycle,
                                             .servos = &servos,
                                             .joints = sines == 1 ? of_one_sine : of_three_sines,
                                             .states = joints,
                                             .period_ms = 1000,
                                             .ramp_ms = 1000});
    while (gait.result == CDS_PENDING) {
        poll();
        if (cycle.counters.periods == 1000)
            cds_gait_stop(&gait);
    }
    return gait.result == CDS_OK;
}

/* Returns CDS_BUSY while the goals before are sent. */
static enum cds_result set_six_goals(void)
{
    enum cds_result result = CDS_OK;

    mark(MARK_CALL);
    for (uint8_t i = 0; i < 6; i++)
        result = cds_cycle_goal(&cycle, i, 500, 500);
    unmark(MARK_CALL);
    return result;
}

int main(void)
{
    bench_open_bare(&bus);
    say("joints", joints_begin(&bench_queue, JOINTS, 1));
    begin_goals();
    say("walked", walk(bench_option(0)));
    while (set_six_goals() != CDS_OK)
        poll();
    say("missed", cycle.counters.missed);
    say("unsent", cycle.counters.unsent);
    say("periods", cycle.counters.periods);
    say("reads", cycle.counters.reads);
    say_end();
}
