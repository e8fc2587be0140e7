/* SPDX-License-Identifier: MIT */
/* A Unix socket at which a simulator in real time takes orders, and the program that sends one.
 *
 * A client connects, sends one line, and gets lines back. The last line is "ok" or begins with
 * "error: "; then the simulator disconnects the client. Other clients wait meanwhile. */
#ifndef SIM_POKE_SOCKET_H
#define SIM_POKE_SOCKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define POKE_LINE_SIZE 4096 // of an order, with the \n

struct poke_socket {
    int listener; // -1: not open
    int client;   // -1: none
    const char *path;
    uint64_t came_ns; // when the client came, in real time
    char line[POKE_LINE_SIZE];
    size_t size;
};

/* Replaces a socket that a killed simulator has left. Returns false, with one line on stderr, for
 * example if another simulator listens at `path`. */
bool poke_socket_open(struct poke_socket *socket, const char *path);
/* Removes the file, too. */
void poke_socket_close(struct poke_socket *socket);

/* Returns the order of a client, without its \n, or 0. It is to be answered before the next call.
 */
const char *poke_socket_read(struct poke_socket *socket);
/* Sends the answer to the order and disconnects the client. */
void poke_socket_answer(struct poke_socket *socket, const char *text, size_t size);
/* The client waits no more for its answer. */
bool poke_socket_client_left(const struct poke_socket *socket);

enum poke_result { POKE_OK, POKE_ERROR, POKE_NO_SIMULATOR };

/* Sends an order to the simulator at `path` and prints the answer on stdout, an error on stderr.
 * Waits until it is carried out. */
enum poke_result poke_send(const char *path, const char *order);

#endif
