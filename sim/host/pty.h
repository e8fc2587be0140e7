/* SPDX-License-Identifier: MIT */
/* A pseudo terminal: a serial port that programs on this machine can open, one after the other. It
 * is raw from the start, and again after each client. */
#ifndef SIM_PTY_H
#define SIM_PTY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host/send_queue.h"

#define PTY_BLOCK 512 // bytes of one pty_read()

struct pty {
    int master;      // -1: not open
    int open_events; // inotify: a program opens the port; -1: not available
    char path[64];
    bool client; // a program has the port open
    /* For a client that does not read; the system has about 20 kB more. */
    struct send_queue queue;
    uint64_t bytes_in;  // from clients
    uint64_t bytes_out; // to clients
    uint64_t lost;      // bytes to clients for which the queue had no space
    uint32_t flushes;   // how often clients have dropped their output (tcflush), at least
};

/* Sets the port to `baud` until a client sets its own rate. Returns false, with one line on stderr.
 */
bool pty_open(struct pty *pty, uint32_t baud);
void pty_close(struct pty *pty);

/* Returns bytes of the client, at most PTY_BLOCK, and detects clients that come and go. Call it
 * often. */
size_t pty_read(struct pty *pty, uint8_t *bytes, size_t capacity);

/* Queues bytes for the client. Without a client they are dropped. */
void pty_send(struct pty *pty, const uint8_t *bytes, size_t size);
/* Passes queued bytes to the system, as many as it takes. */
void pty_flush(struct pty *pty);

/* Returns the bit rate that the client has set; 0: it has hung up. */
uint32_t pty_baud(const struct pty *pty);

/* Prints the counts. Prints nothing if the port was never open. */
void pty_report(const struct pty *pty, FILE *out);

/* Returns a file descriptor for poll() with POLLIN: a client writes or leaves; without a client:
 * one comes. -1: the system cannot report when one comes. */
int pty_fd(const struct pty *pty);

#endif
