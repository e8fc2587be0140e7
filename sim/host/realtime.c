/* SPDX-License-Identifier: MIT */
#include "host/realtime.h"

#include <poll.h>
#include <time.h>

#define NS          1000000000ull
#define LATE_MAX_NS 100000000ull

uint64_t realtime_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * NS + (uint64_t)now.tv_nsec;
}

void realtime_start(struct realtime *realtime, uint32_t clock_Hz)
{
    *realtime = (struct realtime){.clock_Hz = clock_Hz, .origin_ns = realtime_now_ns()};
}

uint64_t realtime_cycle(const struct realtime *realtime)
{
    uint64_t ns = realtime_now_ns() - realtime->origin_ns;
    return ns / NS * realtime->clock_Hz + ns % NS * realtime->clock_Hz / NS;
}

static uint64_t due_ns(const struct realtime *realtime, uint64_t cycle)
{
    return realtime->origin_ns + cycle / realtime->clock_Hz * NS +
           cycle % realtime->clock_Hz * NS / realtime->clock_Hz;
}

void realtime_wait(struct realtime *realtime, uint64_t cycle, int fd)
{
    uint64_t due = due_ns(realtime, cycle);
    uint64_t now = realtime_now_ns();
    if (now < due) {
        uint64_t rest = due - now;
        struct timespec timeout = {.tv_sec = (time_t)(rest / NS), .tv_nsec = (long)(rest % NS)};
        struct pollfd line = {.fd = fd, .events = POLLIN};
        ppoll(&line, 1, &timeout, 0);
    } else if (now - due > LATE_MAX_NS) {
        realtime->origin_ns += now - due;
        realtime->lost_ns += now - due;
    }
}
