/* SPDX-License-Identifier: MIT */
#include "host/tcp.h"

#include <arpa/inet.h>
#include <errno.h>
#include <inttypes.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define BACKLOG 8 // connections that wait to be accepted

static const char busy[] = "cds55xx-sim: another client is connected; close it first\r\n";

bool tcp_open(struct tcp *tcp, uint16_t port)
{
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t size = sizeof(address);
    int on = 1;
    *tcp = (struct tcp){.client = -1};
    tcp->listener = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (tcp->listener < 0 || setsockopt(tcp->listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) ||
        bind(tcp->listener, (struct sockaddr *)&address, size) || listen(tcp->listener, BACKLOG) ||
        getsockname(tcp->listener, (struct sockaddr *)&address, &size)) {
        fprintf(stderr, "--host tcp:%u: 127.0.0.1:%u: %s; port 0 takes a free port\n", port, port,
                strerror(errno));
        return false;
    }
    tcp->port = ntohs(address.sin_port);
    return true;
}

void tcp_close(struct tcp *tcp)
{
    tcp_hang_up(tcp);
    if (tcp->listener >= 0) {
        close(tcp->listener);
        tcp->listener = -1;
    }
}

void tcp_hang_up(struct tcp *tcp)
{
    if (tcp->client >= 0) {
        close(tcp->client);
        tcp->client = -1;
    }
    tcp->input_ended = false;
    send_queue_clear(&tcp->queue);
}

/* --- clients that come --- */

static bool poll_for(int file, short events)
{
    struct pollfd entry = {.fd = file, .events = events};
    return poll(&entry, 1, 0) > 0;
}

/* shutdown() ends the connection before close() resets it, which close() does if input of the
 * client was not read. So the client sees the line and then the end, not an error. */
static void refuse(struct tcp *tcp, int client)
{
    send(client, busy, sizeof(busy) - 1, MSG_NOSIGNAL);
    shutdown(client, SHUT_WR);
    close(client);
    tcp->refused++;
}

static void take(struct tcp *tcp, int client)
{
    int on = 1;
    tcp_hang_up(tcp);
    setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    tcp->client = client;
}

/* If the client has closed its end but its bytes are not read yet, new clients stay in the backlog.
 * The listener is polled before the client, so that a client that comes after the other has left is
 * never refused. */
static void take_clients(struct tcp *tcp)
{
    while (poll_for(tcp->listener, POLLIN)) {
        bool is_connected = tcp->client >= 0 && !tcp->input_ended;
        if (is_connected && poll_for(tcp->client, POLLRDHUP)) {
            return;
        }
        int client = accept4(tcp->listener, 0, 0, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (client < 0) {
            return;
        }
        if (is_connected) {
            refuse(tcp, client);
        } else {
            take(tcp, client);
        }
    }
}

/* --- bytes --- */

/* After an error, such as a reset by the client, the next recv() returns 0. */
size_t tcp_read(struct tcp *tcp, uint8_t *bytes, size_t capacity)
{
    take_clients(tcp);
    if (tcp->client < 0 || tcp->input_ended || capacity == 0) {
        return 0;
    }
    ssize_t got = recv(tcp->client, bytes, capacity < TCP_BLOCK ? capacity : TCP_BLOCK, 0);
    tcp->input_ended = got == 0;
    size_t size = got > 0 ? (size_t)got : 0;
    tcp->bytes_in += size;
    return size;
}

void tcp_send(struct tcp *tcp, const uint8_t *bytes, size_t size)
{
    if (tcp->client >= 0) {
        tcp->bytes_out += size;
        tcp->lost += size - send_queue_put(&tcp->queue, bytes, size);
    }
}

void tcp_flush(struct tcp *tcp)
{
    size_t size;
    const uint8_t *bytes;
    while (bytes = send_queue_oldest(&tcp->queue, &size), size > 0) {
        ssize_t put = send(tcp->client, bytes, size, MSG_NOSIGNAL);
        if (put < 0 && errno != EAGAIN && errno != EINTR) {
            tcp_hang_up(tcp);
        }
        if (put <= 0) {
            return; // gone, or full: the client does not read
        }
        send_queue_remove(&tcp->queue, (size_t)put);
    }
}

void tcp_report(const struct tcp *tcp, FILE *out)
{
    if (tcp->listener < 0) {
        return;
    }
    fprintf(out, "tcp:     %" PRIu64 " bytes from clients, %" PRIu64 " to clients\n", tcp->bytes_in,
            tcp->bytes_out);
    if (tcp->lost) {
        fprintf(out, "tcp:     %" PRIu64 " bytes lost: the client did not read them\n", tcp->lost);
    }
    if (tcp->refused) {
        fprintf(out, "tcp:     %" PRIu32 " clients refused: another one was connected\n",
                tcp->refused);
    }
}

int tcp_fd(const struct tcp *tcp)
{
    return tcp->client >= 0 && !tcp->input_ended ? tcp->client : tcp->listener;
}
