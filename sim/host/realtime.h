/* Real time for a run: which cycle it stands at, and sleeping until it has caught up. */
#ifndef SIM_REALTIME_H
#define SIM_REALTIME_H

#include <stdint.h>

struct realtime {
    uint32_t clock_Hz;
    uint64_t origin_ns; // monotonic time of cycle 0
    uint64_t lost_ns;   // by which the run fell behind for good
};

/* Monotonic. */
uint64_t realtime_now_ns(void);

/* Cycle 0 is now. */
void realtime_start(struct realtime *realtime, uint32_t clock_Hz);

/* The cycle that real time stands at. */
uint64_t realtime_cycle(const struct realtime *realtime);

/* Sleeps until real time has reached `cycle`, `fd` has something to read or is hung up, or a signal
 * came. fd -1: there is none. A run that is more than 100 ms late does not hurry to catch up: its
 * time is moved. */
void realtime_wait(struct realtime *realtime, uint64_t cycle, int fd);

#endif
