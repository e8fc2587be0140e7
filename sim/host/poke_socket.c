/* SPDX-License-Identifier: MIT */
#include "host/poke_socket.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "host/realtime.h"

#define BACKLOG         8             // clients that wait
#define LINE_TIMEOUT_NS 2000000000ull // a client that sends no whole line is disconnected

static bool make_address(struct sockaddr_un *address, const char *path)
{
    *address = (struct sockaddr_un){.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof(address->sun_path)) {
        errno = ENAMETOOLONG;
        return false;
    }
    strcpy(address->sun_path, path);
    return true;
}

/* Returns a connection to the simulator at `path`, or -1. */
static int connect_to(const char *path)
{
    struct sockaddr_un address;
    int file = make_address(&address, path) ? socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0) : -1;
    if (file >= 0 && connect(file, (struct sockaddr *)&address, sizeof(address)) != 0) {
        int why = errno;
        close(file);
        errno = why;
        file = -1;
    }
    return file;
}

/* --- the simulator's end --- */

/* Removes the socket of a simulator that was killed. A file that is no socket stays. */
static void remove_stale(const char *path)
{
    struct stat found;
    int file = connect_to(path);
    if (file >= 0) {
        close(file);
    } else if (errno == ECONNREFUSED && lstat(path, &found) == 0 && S_ISSOCK(found.st_mode)) {
        unlink(path);
    }
}

bool poke_socket_open(struct poke_socket *poke, const char *path)
{
    struct sockaddr_un address;
    *poke = (struct poke_socket){.listener = -1, .client = -1, .path = path};
    int file = -1;
    if (make_address(&address, path)) {
        remove_stale(path);
        file = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    }
    if (file < 0 || bind(file, (struct sockaddr *)&address, sizeof(address)) ||
        listen(file, BACKLOG)) {
        bool in_use = errno == EADDRINUSE;
        fprintf(stderr, "--poke %s: %s\n", path,
                in_use
                    ? "another simulator listens there, or it is a file: end that simulator with "
                      "Ctrl-C in its terminal, run another board, or name another socket"
                : errno == ENOENT ? "its folder does not exist: make it, or name another socket"
                                  : strerror(errno));
        if (file >= 0) {
            close(file);
        }
        return false;
    }
    poke->listener = file;
    return true;
}

static void disconnect(struct poke_socket *poke)
{
    if (poke->client >= 0) {
        close(poke->client);
        poke->client = -1;
    }
    poke->size = 0;
}

void poke_socket_close(struct poke_socket *poke)
{
    disconnect(poke);
    if (poke->listener >= 0) {
        unlink(poke->path);
        close(poke->listener);
        poke->listener = -1;
    }
}

void poke_socket_answer(struct poke_socket *poke, const char *text, size_t size)
{
    send(poke->client, text, size, MSG_NOSIGNAL);
    disconnect(poke);
}

static void complain(struct poke_socket *poke, const char *text)
{
    poke_socket_answer(poke, text, strlen(text));
}

const char *poke_socket_read(struct poke_socket *poke)
{
    if (poke->client < 0) {
        poke->client = accept4(poke->listener, 0, 0, SOCK_NONBLOCK | SOCK_CLOEXEC);
        poke->came_ns = realtime_now_ns();
        if (poke->client < 0) {
            return 0;
        }
    }
    size_t space = sizeof(poke->line) - poke->size;
    ssize_t got = recv(poke->client, poke->line + poke->size, space, 0);
    poke->size += got > 0 ? (size_t)got : 0;
    char *end = memchr(poke->line, '\n', poke->size);
    if (end) {
        *end = 0;
        return poke->line;
    }
    if (poke->size == sizeof(poke->line)) {
        complain(poke, "error: the line is too long: 4095 characters at most\n");
    } else if (got == 0) {
        disconnect(poke);
    } else if (realtime_now_ns() - poke->came_ns > LINE_TIMEOUT_NS) {
        complain(poke, "error: no line came within 2 s\n");
    }
    return 0;
}

bool poke_socket_client_left(const struct poke_socket *poke)
{
    struct pollfd client = {.fd = poke->client, .events = POLLRDHUP};
    return poll(&client, 1, 0) > 0;
}

/* --- the client's end --- */

/* Prints the answer line by line. Returns POKE_ERROR if it has no end. */
static enum poke_result print_answer(FILE *answer)
{
    static const char error[] = "error: ";
    char line[POKE_LINE_SIZE];
    bool good = false;
    bool failed = false;
    if (isatty(STDOUT_FILENO)) {
        fputs("\033[J", stdout); // the live table of a run may stand below the cursor
        fflush(stdout);
    }
    while (fgets(line, sizeof(line), answer)) {
        good = strcmp(line, "ok\n") == 0;
        failed = strncmp(line, error, strlen(error)) == 0;
        fputs(line, failed ? stderr : stdout);
    }
    if (!good && !failed) {
        fputs("error: the simulator ended before it answered\n", stderr);
    }
    return good ? POKE_OK : POKE_ERROR;
}

enum poke_result poke_send(const char *path, const char *order)
{
    int file = connect_to(path);
    FILE *simulator = file >= 0 ? fdopen(file, "r+") : 0;
    if (!simulator) {
        fprintf(stderr, "no simulator listens at %s: start one with make run or --poke\n", path);
        return POKE_NO_SIMULATOR;
    }
    fprintf(simulator, "%s\n", order);
    fflush(simulator);
    enum poke_result result = print_answer(simulator);
    fclose(simulator);
    return result;
}
