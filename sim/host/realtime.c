#include "host/realtime.h"

#include <poll.h>
#include <time.h>

#define NS          1000000000ull
#define LATE_MAX_NS 100000000ull

uint64_t pace_real_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * NS + (uint64_t)now.tv_nsec;
}

void pace_start(struct pace *pace, uint32_t clock_Hz)
{
    *pace = (struct pace){.clock_Hz = clock_Hz, .origin_ns = pace_real_ns()};
}

uint64_t pace_cycle(const struct pace *pace)
{
    uint64_t ns = pace_real_ns() - pace->origin_ns;
    return ns / NS * pace->clock_Hz + ns % NS * pace->clock_Hz / NS;
}

static uint64_t due_ns(const struct pace *pace, uint64_t cycle)
{
    return pace->origin_ns + cycle / pace->clock_Hz * NS +
           cycle % pace->clock_Hz * NS / pace->clock_Hz;
}

void pace_wait(struct pace *pace, uint64_t cycle, int fd)
{
    uint64_t due = due_ns(pace, cycle);
    uint64_t now = pace_real_ns();
    if (now < due) {
        uint64_t rest = due - now;
        struct timespec timeout = {.tv_sec = (time_t)(rest / NS), .tv_nsec = (long)(rest % NS)};
        struct pollfd line = {.fd = fd, .events = POLLIN};
        ppoll(&line, 1, &timeout, 0);
    } else if (now - due > LATE_MAX_NS) {
        pace->origin_ns += now - due;
        pace->lost_ns += now - due;
    }
}
