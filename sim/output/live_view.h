/* A table of the servos as they are now, drawn over itself ten times a second on a terminal, or
 * once a second one below the other elsewhere. */
#ifndef SIM_LIVE_VIEW_H
#define SIM_LIVE_VIEW_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "board.h"
#include "wire/schedule.h"
#include "servo/servos.h"

struct follow {
    FILE *out; // 0: every call does nothing
    bool terminal;
    const struct servos *bus[BOARD_BUSES_MAX];
    unsigned buses;
    struct schedule *schedule;
    uint32_t clock_Hz;
    struct event look; // at the clock on the wall, 50 times in a simulated second
    uint64_t drawn_ns; // real time
    unsigned lines;
};

void follow_init(struct follow *follow, FILE *out, struct schedule *schedule, uint32_t clock_Hz);
void follow_bus(struct follow *follow, const struct servos *servos);
void follow_draw(struct follow *follow, uint64_t now);

/* The last picture stays, with the cursor below it. */
void follow_end(struct follow *follow, uint64_t now);

#endif
