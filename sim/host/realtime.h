/* SPDX-License-Identifier: MIT */
/* Lets a run follow real time: tells the cycle of real time, and sleeps until a cycle. */
#ifndef SIM_REALTIME_H
#define SIM_REALTIME_H

#include <stdint.h>

struct realtime {
    uint32_t clock_Hz;  // cycles in a second of real time
    uint64_t origin_ns; // monotonic time of cycle 0
    uint64_t lost_ns;   // time that the run has lost for good
};

/* Returns monotonic time. */
uint64_t realtime_now_ns(void);

/* Cycle 0 is now. */
void realtime_start(struct realtime *realtime, uint32_t clock_Hz);

/* Returns the cycle that real time has reached. */
uint64_t realtime_cycle(const struct realtime *realtime);

/* Sleeps until real time reaches `cycle`, until `fd` can be read or is hung up, or until a signal
 * arrives. fd -1: none. A run that is more than 100 ms late does not catch up: the origin of its
 * time moves. */
void realtime_wait(struct realtime *realtime, uint64_t cycle, int fd);

#endif
