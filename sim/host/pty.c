/* SPDX-License-Identifier: MIT */
#include "host/pty.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <asm/termbits.h> // struct termios2 has any bit rate; <termios.h> cannot be included too

/* Sets and clears the flags as cfmakeraw() does. */
static void make_raw(struct termios2 *mode)
{
    mode->c_iflag &= (tcflag_t) ~(IGNBRK | BRKINT | PARMRK | ISTRIP | INLCR | IGNCR | ICRNL | IXON);
    mode->c_oflag &= (tcflag_t)~OPOST;
    mode->c_lflag &= (tcflag_t) ~(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
    mode->c_cflag = (mode->c_cflag & (tcflag_t) ~(CSIZE | PARENB)) | CS8;
}

static bool is_raw(const struct termios2 *mode)
{
    struct termios2 raw = *mode;
    make_raw(&raw);
    return memcmp(&raw, mode, sizeof(raw)) == 0;
}

/* Call it before a client knows the path of the port. */
static bool set_up_line(const struct pty *pty, uint32_t baud)
{
    struct termios2 mode;
    if (ioctl(pty->master, TCGETS2, &mode) != 0) {
        return false;
    }
    make_raw(&mode);
    mode.c_cflag = (mode.c_cflag & (tcflag_t) ~(CBAUD | CBAUD << IBSHIFT)) | BOTHER;
    mode.c_ispeed = mode.c_ospeed = baud;
    return ioctl(pty->master, TCSETS2, &mode) == 0;
}

/* Sets the flags and keeps the bit rate, which the next client may set at any moment. TCSETS2 would
 * overwrite the rate with the rate read before. TCSETA has 16 bits of each flag and no rate: with
 * BOTHER the system keeps the rate at the moment of the call. */
static void restore_flags(const struct pty *pty, struct termios2 mode)
{
    make_raw(&mode);
    struct termio flags = {
        .c_iflag = (unsigned short)mode.c_iflag,
        .c_oflag = (unsigned short)mode.c_oflag,
        .c_cflag = (unsigned short)((mode.c_cflag & (tcflag_t)~CBAUD) | BOTHER),
        .c_lflag = (unsigned short)mode.c_lflag,
        .c_line = mode.c_line,
    };
    memcpy(flags.c_cc, mode.c_cc, sizeof(flags.c_cc));
    ioctl(pty->master, TCSETA, &flags);
}

/* Drops what the last client has not read. The system keeps it after the last close, and drops it
 * only through an open port. */
static void discard_unread(struct pty *pty)
{
    send_queue_clear(&pty->queue);
    int slave = open(pty->path, O_RDWR | O_NOCTTY);
    if (slave >= 0) {
        ioctl(slave, TCFLSH, TCIFLUSH);
        close(slave);
    }
}

bool pty_open(struct pty *pty, uint32_t baud)
{
    *pty = (struct pty){.master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    if (pty->master < 0 || grantpt(pty->master) || unlockpt(pty->master) ||
        ptsname_r(pty->master, pty->path, sizeof(pty->path)) ||
        ioctl(pty->master, TIOCPKT, &(int){1}) || !set_up_line(pty, baud)) {
        fprintf(stderr, "pty: %s\n", strerror(errno));
        return false;
    }
    discard_unread(pty); // the system reports "no client" only for a port that was opened once
    pty->open_events = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    inotify_add_watch(pty->open_events, pty->path,
                      IN_OPEN); // without inotify a client is detected a little later
    return true;
}

void pty_close(struct pty *pty)
{
    if (pty->master >= 0) {
        close(pty->master);
        pty->master = -1;
        if (pty->open_events >= 0) {
            close(pty->open_events);
        }
    }
}

/* No client has the port open. Makes the line raw again, also after a client that came, set the
 * line and left at once, as stty does. */
static void watch_line(struct pty *pty)
{
    struct termios2 mode;
    bool raw = ioctl(pty->master, TCGETS2, &mode) != 0 || is_raw(&mode);
    if (pty->client || !raw) {
        discard_unread(pty);
    }
    if (!raw) {
        restore_flags(pty, mode);
    }
}

static void watch_client(struct pty *pty)
{
    char events[PTY_BLOCK];
    while (!pty->client && read(pty->open_events, events, sizeof(events)) > 0) {
    }
    struct pollfd line = {.fd = pty->master, .events = POLLIN};
    bool client = poll(&line, 1, 0) >= 0 && !(line.revents & POLLHUP);
    if (!client) {
        watch_line(pty);
    }
    pty->client = client;
}

/* In packet mode (TIOCPKT) a read returns bytes after a 0, or one byte that reports an action of
 * the client. */
size_t pty_read(struct pty *pty, uint8_t *bytes, size_t capacity)
{
    uint8_t packet[1 + PTY_BLOCK];
    size_t size = 1 + (capacity < PTY_BLOCK ? capacity : PTY_BLOCK);
    ssize_t got = 0;
    watch_client(pty);
    while (capacity && (got = read(pty->master, packet, size)) > 0 && packet[0] != TIOCPKT_DATA) {
        pty->flushes += (packet[0] & TIOCPKT_FLUSHWRITE) != 0;
    }
    size = got > 1 ? (size_t)got - 1 : 0;
    memcpy(bytes, packet + 1, size);
    pty->bytes_in += size;
    return size;
}

void pty_send(struct pty *pty, const uint8_t *bytes, size_t size)
{
    if (pty->client) {
        pty->bytes_out += size;
        pty->lost += size - send_queue_put(&pty->queue, bytes, size);
    }
}

void pty_flush(struct pty *pty)
{
    size_t size;
    const uint8_t *bytes;
    while (bytes = send_queue_oldest(&pty->queue, &size), size > 0) {
        ssize_t put = write(pty->master, bytes, size);
        if (put <= 0) {
            return; // full: the client does not read
        }
        send_queue_remove(&pty->queue, (size_t)put);
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
    fprintf(out, "pty:     %" PRIu64 " bytes from clients, %" PRIu64 " to clients\n", pty->bytes_in,
            pty->bytes_out);
    if (pty->lost) {
        fprintf(out, "pty:     %" PRIu64 " bytes lost: the client did not read them\n", pty->lost);
    }
    if (pty->flushes) {
        fprintf(out,
                "pty:     %" PRIu32
                " flushes of output by clients (tcflush) may have discarded what "
                "they had just written: docs/simulated-bus.md\n",
                pty->flushes);
    }
}

int pty_fd(const struct pty *pty)
{
    return pty->client ? pty->master : pty->open_events;
}
