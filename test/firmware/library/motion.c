/* SPDX-License-Identifier: MIT */
/* 18 joints go to poses at random, each in a time from 0.3 to 3 s, with a rest behind each move.
 * Prints how many moves ended well, and their times. Pin B0 is high while a move is under way. */
#include <cds55xx/motion.h>
#include <stdlib.h>

#include "joints.h"
#include "say.h"

#define MOVES        12
#define LOWEST       50
#define HIGHEST      973
#define REST_PERIODS 75

static struct cds_queue queue;
static struct cds_motion motion;
static struct cds_motion_joint joints[JOINTS];
static uint16_t pose[JOINTS];

static void poll(void)
{
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
    cds_motion_poll(&motion);
}

static void begin(void)
{
    joints_begin(&queue, JOINTS, 2);
    cds_motion_begin(
        &motion, &(struct cds_motion_config){.cycle = &cycle, .servos = &servos, .joints = joints});
    for (uint8_t i = 0; i < JOINTS; i++)
        pose[i] = feedback[i].position;
}

/* At most 0.5 steps in a millisecond: every time is long enough. */
static void choose_pose(uint16_t time_ms)
{
    uint16_t reach = time_ms / 2;

    for (uint8_t i = 0; i < JOINTS; i++) {
        int16_t goal = (int16_t)(pose[i] + (uint16_t)rand() % (2 * reach) - reach);

        pose[i] = (uint16_t)(goal < LOWEST ? LOWEST : goal > HIGHEST ? HIGHEST : goal);
    }
}

static bool move(uint16_t time_ms)
{
    struct cds_move it = {.pose = pose, .time_ms = time_ms};
    uint32_t end;

    choose_pose(time_ms);
    if (cds_motion_move(&motion, &it) != CDS_OK)
        return false;
    while (motion.move_result == CDS_PENDING)
        poll();
    PORTB |= 1 << 0;
    while (motion.result == CDS_PENDING)
        poll();
    PORTB &= (uint8_t) ~(1 << 0);
    end = cycle.counters.periods + REST_PERIODS;
    while (cycle.counters.periods != end)
        poll();
    return motion.move_result == CDS_OK && motion.result == CDS_OK;
}

int main(void)
{
    static uint16_t times_ms[MOVES];
    uint8_t good = 0;

    DDRB = 1 << 0;
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    begin();
    for (uint8_t i = 0; i < MOVES; i++) {
        times_ms[i] = (uint16_t)(300u + (uint16_t)rand() % 2700u);
        if (move(times_ms[i]))
            good++;
    }
    say("good", good);
    say("missed", cycle.counters.missed);
    for (uint8_t i = 0; i < MOVES; i++)
        say("ms", times_ms[i]);
    say_end();
}
