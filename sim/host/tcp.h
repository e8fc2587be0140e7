/* SPDX-License-Identifier: MIT */
/* A TCP port on 127.0.0.1 that carries the bytes of a serial line, for one client at a time. A
 * second client gets one line of text and is closed. */
#ifndef SIM_TCP_H
#define SIM_TCP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host/send_queue.h"

#define TCP_BLOCK 512 // bytes of one tcp_read()

struct tcp {
    int listener; // -1: not open
    int client;   // -1: none
    uint16_t port;
    bool input_ended; // the client sends no more; it still gets what is sent to it
    struct send_queue queue;
    uint64_t bytes_in;  // from clients
    uint64_t bytes_out; // to clients
    uint64_t lost;      // bytes to clients for which the queue had no space
    uint32_t refused;   // clients that came while another one was connected
};

/* Port 0 takes a free port: tcp->port. Returns false, with one line on stderr, if the port is in
 * use. */
bool tcp_open(struct tcp *tcp, uint16_t port);
void tcp_close(struct tcp *tcp);

/* Returns bytes of the client, at most TCP_BLOCK, and takes and refuses clients that come. Call it
 * often. All bytes of a client are returned before the next client is taken. */
size_t tcp_read(struct tcp *tcp, uint8_t *bytes, size_t capacity);

/* Queues bytes for the client. Without a client they are dropped. */
void tcp_send(struct tcp *tcp, const uint8_t *bytes, size_t size);
/* Passes queued bytes to the system, as many as it takes. */
void tcp_flush(struct tcp *tcp);

/* Disconnects the client. */
void tcp_hang_up(struct tcp *tcp);

/* Prints the counts. Prints nothing if the port was never open. */
void tcp_report(const struct tcp *tcp, FILE *out);

/* Returns a file descriptor for poll() with POLLIN: the client writes or leaves; without a client:
 * one comes. */
int tcp_fd(const struct tcp *tcp);

#endif
