/* SPDX-License-Identifier: MIT */
/* Timed moves at 250 Hz, with feedback and the permit. Byte 0 of the EEPROM: number of joints.
 * While a move begins, MARK_SLOW is cds_motion_poll(); on the way MARK_POLL is. MARK_CALL is
 * cds_cycle_goal() for six joints. */
#include <cds55xx/motion.h>

#include "benchmark.h"

#if RAMEND < 0x1100
#define JOINTS 18
#else
#define JOINTS 50 // too many for 4 KB of RAM
#endif
#define MOVES 3

#include "../firmware/library/joints.h"

static uint8_t joint_count;
static struct cds_motion motion;
static struct cds_motion_joint joints[JOINTS];
static uint16_t pose[JOINTS];

static void begin(void)
{
    say("joints", joints_begin(&bench_queue, joint_count, 1));
    say("motion",
        cds_motion_begin(&motion, &(struct cds_motion_config){.cycle = &cycle,
                                                              .servos = &servos,
                                                              .joints = joints}) == CDS_OK);
}

/* Sends all joints where they are. */
static void begin_goals(void)
{
    for (uint8_t i = 0; i < joint_count; i++)
        cds_cycle_goal(&cycle, i, feedback[i].position, 512);
    cds_cycle_commit(&cycle);
}

static void poll(void)
{
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
    if (motion.move_result == CDS_PENDING || motion.begun < joint_count) {
        mark(MARK_SLOW);
        cds_motion_poll(&motion);
        unmark(MARK_SLOW);
    } else {
        mark(MARK_POLL);
        cds_motion_poll(&motion);
        unmark(MARK_POLL);
    }
}

/* All joints go to other places, none further than it can in 2 s. Returns 1 if they did. */
static uint8_t move(uint8_t number)
{
    uint8_t begun = 0;

    for (uint8_t i = 0; i < joint_count; i++)
        pose[i] = (uint16_t)(number * 211u + i * 371u) & 0x3FF;
    if (cds_motion_move(&motion, &(struct cds_move){.pose = pose, .time_ms = 2000}) == CDS_OK)
        begun = 1;
    do
        poll();
    while (motion.move_result == CDS_PENDING || motion.result == CDS_PENDING);
    return begun && motion.result == CDS_OK;
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
    uint8_t moves = 0;

    bench_open_bare(&bus);
    joint_count = bench_option(0);
    begin();
    begin_goals();
    for (uint8_t i = 0; i < MOVES; i++)
        moves = (uint8_t)(moves + move(i));
    while (set_six_goals() != CDS_OK)
        poll();
    say("moves", moves);
    say("missed", cycle.counters.missed);
    say("unsent", cycle.counters.unsent);
    say("periods", cycle.counters.periods);
    say("reads", cycle.counters.reads);
    say_end();
}
