/* A pseudo terminal as the PC's end of a serial line, and the pace of real time. */
#ifndef SIM_PTY_H
#define SIM_PTY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

#include "schedule.h"

struct pty {
    int master;
    int slave; // kept open, so that the line stays up when a client leaves
    char path[64];
    struct schedule *schedule;
    uint32_t clock_Hz;
    struct timespec start;
    struct event pace;
    void *owner;
    size_t (*room)(void *owner); // bytes that may come now
    void (*on_bytes)(void *owner, uint64_t now, const char *bytes, size_t size);
};

/* False, with one line on stderr. The run is paced from now on, a millisecond at a time. */
bool pty_open(struct pty *pty, struct schedule *schedule, uint32_t clock_Hz);
void pty_close(struct pty *pty);

/* Bytes for the client; lost when nobody reads them. */
void pty_say(struct pty *pty, const char *bytes, size_t size);

#endif
