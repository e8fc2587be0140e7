/* A pseudo terminal: a serial port to which any program on this machine can connect, and at which
 * one can come after the other. Raw from the start, and again whenever the last client has left.
 */
#ifndef SIM_PTY_H
#define SIM_PTY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define PTY_SIZE                                                                                   \
    65536 // bytes for a client that pauses, besides what the system keeps (about 20 kB)

#define PTY_BLOCK 512 // bytes of one pty_read()

struct pty {
    int master;      // -1: not open
    int open_events; // inotify: a program opens the port; -1: not available
    char path[64];
    bool client;             // somebody has opened the port
    uint8_t queue[PTY_SIZE]; // for the client, a ring
    size_t head, waiting;
    uint64_t bytes_in;  // bytes from clients
    uint64_t bytes_out; // bytes for clients that were there
    uint64_t lost;      // of these, for which there was no room
    uint32_t flushes;   // times that clients discarded their output (tcflush), or more
};

/* False, with one line on stderr. `baud` is what the port is set to until a client sets its own. */
bool pty_open(struct pty *pty, uint32_t baud);
void pty_close(struct pty *pty);

/* What a client has said, and who comes and goes: to be called often, at most PTY_BLOCK bytes
 * each time. */
size_t pty_read(struct pty *pty, uint8_t *bytes, size_t capacity);

/* Bytes for the client. Without one they are gone, as at a port that nobody has opened. */
void pty_send(struct pty *pty, const uint8_t *bytes, size_t size);
/* Hands them over, as far as the system takes them. */
void pty_flush(struct pty *pty);

/* As the client has set it, any number; 0: it has hung up. */
uint32_t pty_baud(const struct pty *pty);

/* What passed, in a line or two; nothing when the port was never open. */
void pty_report(const struct pty *pty, FILE *out);

/* To wait on with POLLIN: a client writes, leaves or, while there is none, comes. -1: the system
 * cannot tell when one comes. */
int pty_fd(const struct pty *pty);

#endif
