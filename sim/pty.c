#include "pty.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <asm/termbits.h> // any rate (struct termios2); does not go together with <termios.h>

/* What cfmakeraw() does. The rate stays, unless `baud` is given. */
static void make_raw(struct termios2 *mode, uint32_t baud)
{
    mode->c_iflag &= (tcflag_t) ~(IGNBRK | BRKINT | PARMRK | ISTRIP | INLCR | IGNCR | ICRNL | IXON);
    mode->c_oflag &= (tcflag_t)~OPOST;
    mode->c_lflag &= (tcflag_t) ~(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
    mode->c_cflag = (mode->c_cflag & (tcflag_t) ~(CSIZE | PARENB)) | CS8;
    if (baud) {
        mode->c_cflag = (mode->c_cflag & (tcflag_t) ~(CBAUD | CBAUD << IBSHIFT)) | BOTHER;
        mode->c_ispeed = mode->c_ospeed = baud;
    }
}

/* Nobody is there: what the last client has not read is gone, and the next one finds a raw line.
 * The system keeps both beyond the last close, but only an open port can be set. */
static bool renew_line(struct pty *pty, uint32_t baud)
{
    struct termios2 mode;
    int slave = open(pty->path, O_RDWR | O_NOCTTY);
    if (slave < 0) {
        return false;
    }
    bool good = ioctl(slave, TCGETS2, &mode) == 0;
    make_raw(&mode, baud);
    good = good && ioctl(slave, TCSETS2, &mode) == 0 && ioctl(slave, TCFLSH, TCIFLUSH) == 0;
    return close(slave) == 0 && good;
}

bool pty_open(struct pty *pty, uint32_t baud)
{
    *pty = (struct pty){.master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    if (pty->master < 0 || grantpt(pty->master) || unlockpt(pty->master) ||
        ptsname_r(pty->master, pty->path, sizeof(pty->path)) || !renew_line(pty, baud)) {
        fprintf(stderr, "pty: %s\n", strerror(errno));
        return false;
    }
    return true;
}

void pty_close(struct pty *pty)
{
    if (pty->master >= 0) {
        close(pty->master);
        pty->master = -1;
    }
}

static bool is_raw(const struct pty *pty)
{
    struct termios2 mode = {0};
    bool known = ioctl(pty->master, TCGETS2, &mode) == 0;
    struct termios2 raw = mode;
    make_raw(&raw, 0);
    return known && memcmp(&raw, &mode, sizeof(mode)) == 0;
}

/* One that comes, sets the line and leaves at once, as stty does, may not be seen at all. */
static void watch_client(struct pty *pty)
{
    struct pollfd line = {.fd = pty->master, .events = POLLIN};
    bool client = poll(&line, 1, 0) >= 0 && !(line.revents & POLLHUP);
    if (!client && (pty->client || !is_raw(pty))) {
        pty->waiting = 0;
        renew_line(pty, 0);
    }
    pty->arrived |= client && !pty->client;
    pty->client = client;
}

bool pty_arrived(struct pty *pty)
{
    bool arrived = pty->arrived;
    pty->arrived = false;
    return arrived;
}

size_t pty_read(struct pty *pty, uint8_t *bytes, size_t room)
{
    watch_client(pty);
    ssize_t got = room ? read(pty->master, bytes, room) : 0;
    size_t size = got > 0 ? (size_t)got : 0;
    pty->heard += size;
    return size;
}

void pty_say(struct pty *pty, const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size && pty->client; i++) {
        pty->said++;
        if (pty->waiting == PTY_ROOM) {
            pty->lost++;
        } else {
            pty->queue[(pty->head + pty->waiting++) % PTY_ROOM] = bytes[i];
        }
    }
}

void pty_flush(struct pty *pty)
{
    while (pty->waiting) {
        size_t size = PTY_ROOM - pty->head;
        size = size < pty->waiting ? size : pty->waiting;
        ssize_t put = write(pty->master, pty->queue + pty->head, size);
        if (put <= 0) {
            return; // full: the client pauses
        }
        pty->head = (pty->head + (size_t)put) % PTY_ROOM;
        pty->waiting -= (size_t)put;
    }
}

uint32_t pty_baud(const struct pty *pty)
{
    struct termios2 mode;
    return ioctl(pty->master, TCGETS2, &mode) == 0 ? mode.c_ospeed : 0;
}

void pty_report(const struct pty *pty, FILE *out)
{
    if (pty->master < 0) {
        return;
    }
    fprintf(out, "pty:     %" PRIu64 " bytes from clients, %" PRIu64 " for them\n", pty->heard,
            pty->said);
    if (pty->lost) {
        fprintf(out, "pty:     %" PRIu64 " of these lost: the client did not read them\n",
                pty->lost);
    }
}

int pty_fd(const struct pty *pty)
{
    return pty->client ? pty->master : -1;
}
