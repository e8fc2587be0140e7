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

struct live_view {
    FILE *out; // 0: every call does nothing
    bool terminal;
    const struct servos *bus[BOARD_BUSES_MAX];
    unsigned buses;
    struct schedule *schedule;
    uint32_t clock_Hz;
    struct event refresh; // at the clock on the wall, 50 times in a simulated second
    uint64_t drawn_ns;    // real time
    unsigned lines;
};

void live_view_init(struct live_view *view, FILE *out, struct schedule *schedule,
                    uint32_t clock_Hz);
void live_view_add_bus(struct live_view *view, const struct servos *servos);
void live_view_draw(struct live_view *view, uint64_t now);

/* The last picture stays, with the cursor below it. */
void live_view_end(struct live_view *view, uint64_t now);

#endif
