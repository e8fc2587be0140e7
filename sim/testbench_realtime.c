/* SPDX-License-Identifier: MIT */
/* The testbench behind a pty or a TCP port: simulated time follows real time. */
#include "testbench.h"

#include <errno.h> // program_invocation_name
#include <inttypes.h>

/* A run in real time sleeps in short steps while there is traffic, so that the client does not wait
 * for its replies, and in longer steps otherwise. A client that writes, connects or disconnects
 * ends the sleep, unless client_fd() is -1. */
#define TRAFFIC_MS            20   // there is traffic: a byte or an edge within this time
#define CONSOLE_STEPS_PER_MS  5    // with a controller and traffic; without traffic: 1
#define ADAPTER_TRAFFIC_US    200  // without a controller: traffic
#define ADAPTER_NO_TRAFFIC_US 5000 // a client is connected
#define ADAPTER_NO_CLIENT_US  2000 // no client, or no space for its bytes

/* A TCP client that has ended its input, as `nc -N` does, may wait for a reply. It is disconnected
 * after so much time without a byte. */
#define TCP_HANG_UP_S 1

#define BLOCK PTY_BLOCK // bytes that are read at once
_Static_assert(PTY_BLOCK == TCP_BLOCK, "the same block for both");

/* --- the client, at the pty or at the TCP port --- */

static bool is_tcp(const struct testbench *bench)
{
    return bench->options->host == TESTBENCH_HOST_TCP;
}

static bool open_port(struct testbench *bench)
{
    if (is_tcp(bench)) {
        adapter_follow(&bench->host_link.adapter, usart_get_bit_time, &bench->host_link.usart);
        bench->cannot_listen = !tcp_open(&bench->tcp, bench->options->tcp_port);
        return !bench->cannot_listen;
    }
    return pty_open(&bench->pty, bench->options->bus ? TESTBENCH_BAUD : bench->board.host_baud);
}

void testbench_print_client(const struct testbench *bench)
{
    if (bench->tcp.listener >= 0) {
        uint16_t port = bench->tcp.port;
        printf("127.0.0.1:%" PRIu16 "\n"
               "connect with: nc 127.0.0.1 %" PRIu16 " (apt-get install netcat-openbsd; or socat, "
               "or pyserial's socket://127.0.0.1:%" PRIu16 "); Ctrl-C here ends the run\n",
               port, port, port);
    } else if (bench->pty.master >= 0) {
        const char *path = bench->pty.path;
        printf("%s\n", path);
        char rate[24] = "";
        if (bench->options->client_baud) { // picocom begins with 9600
            snprintf(rate, sizeof(rate), "-b %" PRIu32 " ", bench->board.host_baud);
        }
        if (!bench->options->bus) {
            printf(
                "open it in another terminal: picocom -q -e t %s%s (apt-get install picocom); "
                "then press Ctrl-C. Ctrl-T, then Ctrl-Q ends picocom. Ctrl-C here ends the run\n",
                rate, path);
        }
    }
    if (bench->options->poke_hint) {
        printf("poke the servos with: %s\n", bench->options->poke_hint);
    } else if (bench->options->poke) {
        printf("poke the servos with: %s poke %s \"load 1 300\"\n", program_invocation_name,
               bench->options->poke);
    }
    fflush(stdout);
}

void testbench_send_to_client(struct testbench *bench, uint8_t byte)
{
    if (is_tcp(bench)) {
        tcp_send(&bench->tcp, &byte, 1);
    } else {
        pty_send(&bench->pty, &byte, 1);
    }
}

void testbench_flush_client(struct testbench *bench)
{
    if (is_tcp(bench)) {
        tcp_flush(&bench->tcp);
    } else {
        pty_flush(&bench->pty);
    }
}

static int client_fd(const struct testbench *bench)
{
    return is_tcp(bench) ? tcp_fd(&bench->tcp) : pty_fd(&bench->pty);
}

/* Disconnects a TCP client that has ended its input when no reply comes any more. */
static void hang_up_on_silence(struct testbench *bench, uint64_t now)
{
    uint64_t sent = adapter_end(&bench->host_link.adapter);
    uint64_t last = bench->traffic > sent ? bench->traffic : sent;
    if (bench->tcp.input_ended && now > last + TCP_HANG_UP_S * (uint64_t)bench->clock_Hz) {
        tcp_hang_up(&bench->tcp);
    }
}

/* --- bytes of the client --- */

static struct adapter *client_adapter(struct testbench *bench)
{
    return bench->options->bus ? &bench->bus[0].adapter : &bench->host_link.adapter;
}

/* How many bytes of the client the testbench takes now. Bytes of a client that connects before the
 * firmware has enabled its receiver wait. */
static size_t client_space(struct testbench *bench)
{
    if (!bench->options->bus && !usart_rxen(&bench->host_link.usart)) {
        return 0;
    }
    return adapter_space(client_adapter(bench));
}

static size_t read_tcp(struct testbench *bench, uint64_t now, uint8_t *bytes, size_t capacity)
{
    hang_up_on_silence(bench, now);
    return tcp_read(&bench->tcp, bytes, capacity);
}

/* pty_read() comes before pty_baud(): bytes that a client writes after it has set a bit rate are
 * never sent at the old one. */
static void read_client(struct testbench *bench, uint64_t now)
{
    uint8_t bytes[BLOCK];
    struct adapter *adapter = client_adapter(bench);
    size_t space = client_space(bench);
    space = space < BLOCK ? space : BLOCK;
    size_t size =
        is_tcp(bench) ? read_tcp(bench, now, bytes, space) : pty_read(&bench->pty, bytes, space);
    if (bench->options->bus || bench->options->client_baud) {
        adapter_baud(adapter, pty_baud(&bench->pty));
    }
    adapter_send(adapter, now, bytes, size);
    bench->traffic = size ? now : bench->traffic;
}

/* --- real time --- */

/* With a controller. Sleeps until the client writes or a step of real time has passed, then
 * simulates as much time as has passed. So bytes of the client reach the firmware at the cycle at
 * which they were read. A run that is late simulates a whole step without a sleep. */
static void step(void *context, uint64_t now)
{
    struct testbench *bench = context;
    uint32_t ms = bench->clock_Hz / 1000;
    read_client(bench, now);
    testbench_flush_client(bench);
    testbench_poll_poke(bench, now);
    bool traffic = now - bench->traffic < TRAFFIC_MS * ms;
    uint64_t end = now + (traffic ? ms / CONSOLE_STEPS_PER_MS : ms);
    realtime_wait(&bench->realtime, end, client_space(bench) ? client_fd(bench) : -1);
    uint64_t next = realtime_cycle(&bench->realtime);
    next = next > now ? next : now + 1;
    schedule_at(&bench->schedule, &bench->next_step, next < end ? next : end);
}

static void start_realtime(struct testbench *bench)
{
    unsigned long slow = bench->options->slow;
    realtime_start(&bench->realtime, bench->clock_Hz / (uint32_t)(slow ? slow : 1));
}

bool testbench_open_client(struct testbench *bench)
{
    if (!open_port(bench)) {
        return false;
    }
    if (bench->options->bus) {
        return true; // testbench_run_adapter_in_realtime()
    }
    start_realtime(bench);
    event_init(&bench->next_step, step, bench);
    schedule_at(&bench->schedule, &bench->next_step, 0);
    return true;
}

static uint64_t adapter_step_us(const struct testbench *bench, uint64_t now, int fd)
{
    const struct testbench_bus *bus = &bench->bus[0];
    uint64_t ms = bench->clock_Hz / 1000;
    if (bus->adapter.tx.busy || now - bus->wire->time < TRAFFIC_MS * ms) {
        return ADAPTER_TRAFFIC_US;
    }
    return fd >= 0 ? ADAPTER_NO_TRAFFIC_US : ADAPTER_NO_CLIENT_US;
}

void testbench_run_adapter_in_realtime(struct testbench *bench)
{
    uint64_t us = bench->clock_Hz / 1000000;
    start_realtime(bench);
    while (!bench->stop) {
        uint64_t now = realtime_cycle(&bench->realtime);
        schedule_run_until(&bench->schedule, now);
        read_client(bench, now);
        testbench_flush_client(bench);
        testbench_poll_poke(bench, now);
        int fd = client_space(bench) ? client_fd(bench) : -1;
        realtime_wait(&bench->realtime, now + adapter_step_us(bench, now, fd) * us, fd);
    }
}
