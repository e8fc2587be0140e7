#include "pty.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#define BLOCK 512
#define NS    1000000000ull

/* Sleeps until real time has caught up with `now`. */
static void wait_for(const struct pty *pty, uint64_t now)
{
    uint64_t ns = now / pty->clock_Hz * NS + now % pty->clock_Hz * NS / pty->clock_Hz;
    uint64_t sum = (uint64_t)pty->start.tv_nsec + ns;
    struct timespec until = {
        .tv_sec = pty->start.tv_sec + (time_t)(sum / NS),
        .tv_nsec = (long)(sum % NS),
    };
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, 0);
}

static void pace(void *owner, uint64_t now)
{
    struct pty *pty = owner;
    char block[BLOCK];
    wait_for(pty, now);
    size_t room = pty->room(pty->owner);
    ssize_t got = read(pty->master, block, room < sizeof(block) ? room : sizeof(block));
    if (got > 0) {
        pty->on_bytes(pty->owner, now, block, (size_t)got);
    }
    schedule_at(pty->schedule, &pty->pace, now + pty->clock_Hz / 1000);
}

static bool open_pair(struct pty *pty)
{
    pty->master = posix_openpt(O_RDWR | O_NOCTTY);
    if (pty->master < 0 || grantpt(pty->master) || unlockpt(pty->master)) {
        return false;
    }
    const char *path = ptsname(pty->master);
    if (!path || fcntl(pty->master, F_SETFL, O_NONBLOCK) < 0) {
        return false;
    }
    snprintf(pty->path, sizeof(pty->path), "%s", path);
    pty->slave = open(path, O_RDWR | O_NOCTTY);
    struct termios mode;
    if (pty->slave < 0 || tcgetattr(pty->slave, &mode)) {
        return false;
    }
    cfmakeraw(&mode);
    return tcsetattr(pty->slave, TCSANOW, &mode) == 0;
}

bool pty_open(struct pty *pty, struct schedule *schedule, uint32_t clock_Hz)
{
    *pty = (struct pty){.master = -1, .slave = -1, .schedule = schedule, .clock_Hz = clock_Hz};
    if (!open_pair(pty)) {
        fprintf(stderr, "pty: %s\n", strerror(errno));
        return false;
    }
    clock_gettime(CLOCK_MONOTONIC, &pty->start);
    event_init(&pty->pace, pace, pty);
    schedule_at(schedule, &pty->pace, 0);
    return true;
}

void pty_close(struct pty *pty)
{
    if (pty->master >= 0) {
        close(pty->master);
    }
    if (pty->slave >= 0) {
        close(pty->slave);
    }
}

void pty_say(struct pty *pty, const char *bytes, size_t size)
{
    ssize_t written = write(pty->master, bytes, size);
    (void)written;
}
