/* SPDX-License-Identifier: MIT */
#include "avr/gdb.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "memory.h"

#define POLL_EVERY 1024 // instructions
#define CTRL_C     3

/* gdb's numbers of signals. */
enum { SIGNAL_INT = 2, SIGNAL_TRAP = 5, SIGNAL_SEGV = 11 };

/* --- packets --- */

static void send_all(const struct gdb *gdb, const char *bytes, size_t size)
{
    while (size > 0) {
        ssize_t sent = send(gdb->client, bytes, size, MSG_NOSIGNAL);
        if (sent <= 0) {
            return; // the next poll of the socket detects that the client has gone
        }
        bytes += sent;
        size -= (size_t)sent;
    }
}

static void reply(struct gdb *gdb, const char *text)
{
    if (gdb->client < 0) {
        return;
    }
    unsigned sum = 0;
    for (const char *c = text; *c; c++) {
        sum += (uint8_t)*c;
    }
    int size = snprintf(gdb->out, sizeof(gdb->out), "$%s#%02x", text, sum & 0xFF);
    send_all(gdb, gdb->out, (size_t)size);
}

static void reply_stopped(struct gdb *gdb)
{
    char text[40];
    if (gdb->hit) {
        snprintf(text, sizeof(text), "T%02xwatch:%x;", SIGNAL_TRAP,
                 GDB_DATA_SPACE + gdb->hit->address);
    } else {
        snprintf(text, sizeof(text), "S%02x", gdb->signal);
    }
    reply(gdb, text);
}

static void put_hex(char *text, const uint8_t *bytes, unsigned size)
{
    for (unsigned i = 0; i < size; i++) {
        sprintf(text + 2 * i, "%02x", bytes[i]);
    }
}

static unsigned get_hex(const char *text, uint8_t *bytes, unsigned capacity)
{
    unsigned size = 0;
    unsigned byte = 0;
    while (size < capacity && sscanf(text + 2 * size, "%2x", &byte) == 1) {
        bytes[size++] = (uint8_t)byte;
    }
    return size;
}

/* --- commands --- */

static void why_stopped(struct gdb *gdb, const char *arguments)
{
    (void)arguments;
    reply_stopped(gdb);
}

static void read_registers(struct gdb *gdb, const char *arguments)
{
    (void)arguments;
    char text[4 * 2 * GDB_REGISTERS + 1];
    unsigned used = 0;
    for (unsigned i = 0; i < GDB_REGISTERS; i++) {
        uint8_t bytes[4];
        unsigned size = gdb_register_load(&gdb->machine, i, bytes);
        put_hex(text + 2 * used, bytes, size);
        used += size;
    }
    reply(gdb, text);
}

static void write_registers(struct gdb *gdb, const char *arguments)
{
    uint8_t bytes[4 * GDB_REGISTERS] = {0};
    unsigned size = get_hex(arguments, bytes, sizeof(bytes));
    for (unsigned i = 0, used = 0; i < GDB_REGISTERS && used < size; i++) {
        used += gdb_register_store(&gdb->machine, i, bytes + used);
    }
    reply(gdb, "OK");
}

static void read_register(struct gdb *gdb, const char *arguments)
{
    unsigned long number = strtoul(arguments, 0, 16);
    char text[2 * 4 + 1];
    uint8_t bytes[4];
    if (number >= GDB_REGISTERS) {
        reply(gdb, "E01");
        return;
    }
    put_hex(text, bytes, gdb_register_load(&gdb->machine, (unsigned)number, bytes));
    reply(gdb, text);
}

static void write_register(struct gdb *gdb, const char *arguments)
{
    unsigned number = GDB_REGISTERS;
    char hex[9];
    uint8_t bytes[4] = {0};
    bool good = sscanf(arguments, "%x=%8s", &number, hex) == 2 && number < GDB_REGISTERS;
    if (good) {
        get_hex(hex, bytes, sizeof(bytes));
        gdb_register_store(&gdb->machine, number, bytes);
    }
    reply(gdb, good ? "OK" : "E01");
}

static void read_memory(struct gdb *gdb, const char *arguments)
{
    unsigned address = 0;
    unsigned size = 0;
    char text[GDB_SIZE] = "";
    bool good = sscanf(arguments, "%x,%x", &address, &size) == 2;
    for (unsigned i = 0; good && i < size && 2 * i + 2 < sizeof(text); i++) {
        uint8_t byte;
        if (!gdb_memory_load(&gdb->machine, address + i, &byte)) {
            good = i > 0; // the bytes so far
            break;
        }
        put_hex(text + 2 * i, &byte, 1);
    }
    reply(gdb, good ? text : "E01");
}

static void write_memory(struct gdb *gdb, const char *arguments)
{
    unsigned address = 0;
    unsigned size = 0;
    int start = 0;
    bool good = sscanf(arguments, "%x,%x:%n", &address, &size, &start) == 2 && start;
    for (unsigned i = 0; good && i < size; i++) {
        uint8_t byte;
        good = get_hex(arguments + start + 2 * i, &byte, 1) &&
               gdb_memory_store(&gdb->machine, address + i, byte);
    }
    reply(gdb, good ? "OK" : "E01");
}

static bool set_watch(struct gdb *gdb, unsigned address, unsigned size, bool on)
{
    address -= GDB_DATA_SPACE;
    if (address > gdb->machine.avr->ramend || !size || size > GDB_WATCHED_SIZE) {
        return false;
    }
    for (unsigned i = 0; i < GDB_WATCHES; i++) {
        struct gdb_watch *watch = &gdb->watches[i];
        bool same = watch->address == address && watch->size == size;
        if (on ? watch->size == 0 : same) {
            watch->address = (uint16_t)address;
            watch->size = (uint16_t)(on ? size : 0);
            memcpy(watch->bytes, &gdb->machine.avr->data[address], size);
            gdb->watching += on ? 1u : -1u;
            return true;
        }
    }
    return !on;
}

/* Supports both kinds of breakpoints and watchpoints on writes. */
static void change_point(struct gdb *gdb, const char *arguments, bool on)
{
    unsigned kind = 0;
    unsigned address = 0;
    unsigned size = 0;
    if (sscanf(arguments, "%u,%x,%x", &kind, &address, &size) != 3 || kind > 2) {
        reply(gdb, "");
    } else if (kind == 2) {
        reply(gdb, set_watch(gdb, address, size, on) ? "OK" : "E01");
    } else if (address > gdb->machine.avr->flashend) {
        reply(gdb, "E01");
    } else {
        gdb->breakpoints[address / 2] = on;
        reply(gdb, "OK");
    }
}

static void set_point(struct gdb *gdb, const char *arguments)
{
    change_point(gdb, arguments, true);
}

static void clear_point(struct gdb *gdb, const char *arguments)
{
    change_point(gdb, arguments, false);
}

static void resume(struct gdb *gdb, const char *arguments, enum gdb_state state)
{
    if (*arguments) {
        gdb->machine.avr->pc = (avr_flashaddr_t)strtoul(arguments, 0, 16);
    }
    gdb->state = state;
    gdb->depth = gdb->cpu->depth;
    gdb->hit = 0;
    for (unsigned i = 0; i < GDB_WATCHES; i++) {
        struct gdb_watch *watch = &gdb->watches[i];
        memcpy(watch->bytes, &gdb->machine.avr->data[watch->address], watch->size);
    }
}

static void resume_run(struct gdb *gdb, const char *arguments)
{
    resume(gdb, arguments, GDB_RUNNING);
}

static void step(struct gdb *gdb, const char *arguments)
{
    resume(gdb, arguments, GDB_STEPPING);
}

static void drop_client(struct gdb *gdb)
{
    if (gdb->client >= 0) {
        close(gdb->client);
    }
    gdb->client = -1;
    gdb->in_size = 0;
    gdb->watching = 0;
    memset(gdb->watches, 0, sizeof(gdb->watches));
    memset(gdb->breakpoints, 0, gdb->machine.avr->flashend / 2 + 1u);
    gdb->state = GDB_RUNNING;
}

static void detach(struct gdb *gdb, const char *arguments)
{
    (void)arguments;
    reply(gdb, "OK");
    drop_client(gdb);
}

static void kill_run(struct gdb *gdb, const char *arguments)
{
    (void)arguments;
    drop_client(gdb);
    gdb->killed = true;
}

static void choose_thread(struct gdb *gdb, const char *arguments)
{
    (void)arguments;
    reply(gdb, "OK");
}

static void query(struct gdb *gdb, const char *arguments)
{
    char text[40] = "";
    if (strncmp(arguments, "Supported", 9) == 0) {
        snprintf(text, sizeof(text), "PacketSize=%x", GDB_SIZE - 16);
    } else if (strncmp(arguments, "Attached", 8) == 0) {
        strcpy(text, "1");
    }
    reply(gdb, text);
}

static void execute(struct gdb *gdb, const char *packet)
{
    static const struct {
        char letter;
        void (*run)(struct gdb *gdb, const char *arguments);
    } commands[] = {
        {'?', why_stopped},   {'g', read_registers}, {'G', write_registers},
        {'p', read_register}, {'P', write_register}, {'m', read_memory},
        {'M', write_memory},  {'Z', set_point},      {'z', clear_point},
        {'c', resume_run},    {'s', step},           {'D', detach},
        {'k', kill_run},      {'H', choose_thread},  {'q', query},
    };
    for (size_t i = 0; i < sizeof(commands) / sizeof(commands[0]); i++) {
        if (packet[0] == commands[i].letter) {
            commands[i].run(gdb, packet + 1);
            return;
        }
    }
    reply(gdb, ""); // an empty reply means: not supported
}

/* --- the socket --- */

static void stop_here(struct gdb *gdb, uint8_t signal_number)
{
    gdb->state = GDB_STOPPED;
    gdb->signal = signal_number;
    reply_stopped(gdb);
}

/* Processes the first whole packet, or Ctrl-C, of the received bytes. Returns false if there is
 * none. */
static bool take_packet(struct gdb *gdb)
{
    char packet[GDB_SIZE];
    unsigned from = 0;
    while (from < gdb->in_size && gdb->in[from] != '$' && gdb->in[from] != CTRL_C) {
        from++; // acknowledgements
    }
    const char *start = gdb->in + from;
    const char *hash = memchr(start, '#', gdb->in_size - from);
    bool interrupt = from < gdb->in_size && *start == CTRL_C;
    bool whole = hash && hash + 2 < gdb->in + gdb->in_size;
    unsigned used = interrupt ? 1 : whole ? (unsigned)(hash + 3 - start) : 0;
    if (whole && !interrupt) {
        size_t size = (size_t)(hash - start - 1);
        memcpy(packet, start + 1, size);
        packet[size] = 0;
    }
    gdb->in_size -= from + used;
    memmove(gdb->in, start + used, gdb->in_size);
    if (interrupt) {
        if (gdb->state != GDB_STOPPED) {
            stop_here(gdb, SIGNAL_INT);
        }
    } else if (whole) {
        send_all(gdb, "+", 1);
        execute(gdb, packet);
    }
    return used > 0;
}

static void receive(struct gdb *gdb)
{
    size_t capacity = sizeof(gdb->in) - gdb->in_size;
    ssize_t got = capacity ? recv(gdb->client, gdb->in + gdb->in_size, capacity, 0) : 0;
    if (got <= 0) {
        drop_client(gdb); // the client has closed the connection, or its packet is too long
        return;
    }
    gdb->in_size += (unsigned)got;
    while (gdb->client >= 0 && take_packet(gdb)) {
    }
}

static void accept_client(struct gdb *gdb)
{
    int on = 1;
    gdb->client = accept(gdb->listener, 0, 0);
    if (gdb->client >= 0) {
        setsockopt(gdb->client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
        gdb->state = GDB_STOPPED;
        gdb->signal = SIGNAL_TRAP;
        gdb->hit = 0;
    }
}

/* timeout_ms -1: waits until something arrives. Returns false if a signal has arrived. */
static bool poll_socket(struct gdb *gdb, int timeout_ms)
{
    struct pollfd fd = {.fd = gdb->client >= 0 ? gdb->client : gdb->listener, .events = POLLIN};
    int ready = poll(&fd, 1, timeout_ms);
    if (ready > 0 && gdb->client >= 0) {
        receive(gdb);
    } else if (ready > 0) {
        accept_client(gdb);
    }
    return ready >= 0;
}

static void serve(struct gdb *gdb)
{
    while (gdb->state == GDB_STOPPED && !*gdb->stop && poll_socket(gdb, -1)) {
    }
}

/* --- interface --- */

bool gdb_open(struct gdb *gdb, uint16_t port)
{
    *gdb = (struct gdb){.listener = -1, .client = -1, .signal = SIGNAL_TRAP};
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t size = sizeof(address);
    int on = 1;
    gdb->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (gdb->listener < 0 || setsockopt(gdb->listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) ||
        bind(gdb->listener, (struct sockaddr *)&address, size) || listen(gdb->listener, 1) ||
        getsockname(gdb->listener, (struct sockaddr *)&address, &size)) {
        fprintf(stderr, "--gdb %u: %s\n", port, strerror(errno));
        return false;
    }
    fprintf(stderr, "gdb: waiting; in avr-gdb: target remote 127.0.0.1:%u\n",
            ntohs(address.sin_port));
    return true;
}

void gdb_close(struct gdb *gdb)
{
    if (gdb->client >= 0) {
        close(gdb->client);
    }
    if (gdb->listener >= 0) {
        close(gdb->listener);
    }
    free(gdb->breakpoints);
    gdb->breakpoints = 0;
}

void gdb_attach(struct gdb *gdb, avr_t *avr, const struct cpu *cpu,
                const struct eeprom_model *eeprom, const volatile sig_atomic_t *stop)
{
    gdb->machine.avr = avr;
    gdb->cpu = cpu;
    gdb->machine.eeprom = eeprom;
    gdb->stop = stop;
    gdb->breakpoints = memory_checked(calloc(avr->flashend / 2 + 1u, sizeof(*gdb->breakpoints)));
}

static bool watch_changed(struct gdb *gdb)
{
    for (unsigned i = 0; i < GDB_WATCHES && gdb->watching; i++) {
        const struct gdb_watch *watch = &gdb->watches[i];
        if (memcmp(watch->bytes, &gdb->machine.avr->data[watch->address], watch->size) != 0) {
            gdb->hit = watch;
            return true;
        }
    }
    return false;
}

bool gdb_may_run(struct gdb *gdb)
{
    const avr_t *avr = gdb->machine.avr;
    if (gdb->state != GDB_STOPPED) {
        bool stepped = gdb->state == GDB_STEPPING && gdb->runs && gdb->cpu->depth <= gdb->depth;
        bool met =
            avr->state == cpu_Running && avr->pc <= avr->flashend && gdb->breakpoints[avr->pc / 2];
        if (watch_changed(gdb) || stepped || met) {
            stop_here(gdb, SIGNAL_TRAP);
        } else if (gdb->runs % POLL_EVERY == POLL_EVERY - 1) {
            poll_socket(gdb, 0);
        }
    }
    if (gdb->state == GDB_STOPPED) {
        serve(gdb);
        gdb->runs = 0;
    }
    gdb->runs++;
    return !gdb->killed;
}

void gdb_ended(struct gdb *gdb, bool crashed)
{
    if (crashed && gdb->client >= 0) {
        stop_here(gdb, SIGNAL_SEGV);
        while (gdb->state == GDB_STOPPED && poll_socket(gdb, -1)) {
        }
    }
    reply(gdb, crashed ? "X0b" : "W00"); // gdb's codes: killed by a signal; exited
}
