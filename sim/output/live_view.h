/* SPDX-License-Identifier: MIT */
/* A table of the servos (--follow). On a terminal it is drawn over itself ten times a second,
 * elsewhere it is printed once a second. On a terminal it keeps what is printed on stdout, and
 * prints it above the next table. */
#ifndef SIM_LIVE_VIEW_H
#define SIM_LIVE_VIEW_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "board.h"
#include "servo/servos.h"
#include "wire/schedule.h"

struct live_view {
    FILE *out; // 0: every call does nothing
    bool terminal;
    const struct servos *bus[BOARD_BUSES_MAX];
    unsigned buses;
    struct schedule *schedule;
    uint32_t clock_Hz;
    struct event refresh; // checks real time, 50 times in a simulated second
    uint64_t drawn_ns;    // real time
    unsigned lines;
    bool keeps_stdout;  // stdout is a terminal, too: it is printed before each table
    bool *line_is_open; // the last line on stdout has no end yet
};

void live_view_init(struct live_view *view, FILE *out, struct schedule *schedule, uint32_t clock_Hz,
                    bool *line_is_open);
void live_view_add_bus(struct live_view *view, const struct servos *servos);

/* Leaves the last table, with the cursor below it. */
void live_view_end(struct live_view *view, uint64_t now);

#endif
