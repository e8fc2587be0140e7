/* SPDX-License-Identifier: MIT */
/* The testbench behind a pty: simulated time follows real time. */
#include "testbench.h"

/* A run in real time sleeps in short steps while there is traffic, so that the client does not wait
 * for its replies, and in longer steps otherwise. A client that writes, connects or disconnects
 * ends the sleep, unless pty_fd() is -1. */
#define TRAFFIC_MS            20   // there is traffic: a byte or an edge within this time
#define CONSOLE_STEPS_PER_MS  5    // with a controller and traffic; without traffic: 1
#define ADAPTER_TRAFFIC_US    200  // without a controller: traffic
#define ADAPTER_NO_TRAFFIC_US 5000 // a client is connected
#define ADAPTER_NO_CLIENT_US  2000 // no client, or no space for its bytes

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

/* pty_read() comes before pty_baud(): bytes that a client writes after it has set a bit rate are
 * never sent at the old one. */
static void read_client(struct testbench *bench, uint64_t now)
{
    uint8_t bytes[PTY_BLOCK];
    struct adapter *adapter = client_adapter(bench);
    size_t space = client_space(bench);
    size_t size = pty_read(&bench->pty, bytes, space < sizeof(bytes) ? space : sizeof(bytes));
    if (bench->options->bus || bench->options->client_baud) {
        adapter_baud(adapter, pty_baud(&bench->pty));
    }
    adapter_send(adapter, now, bytes, size);
    bench->traffic = size ? now : bench->traffic;
}

/* With a controller. Sleeps until the client writes or a step of real time has passed, then
 * simulates as much time as has passed. So bytes of the client reach the firmware at the cycle at
 * which they were read. A run that is late simulates a whole step without a sleep. */
static void step(void *context, uint64_t now)
{
    struct testbench *bench = context;
    uint32_t ms = bench->clock_Hz / 1000;
    read_client(bench, now);
    pty_flush(&bench->pty);
    bool traffic = now - bench->traffic < TRAFFIC_MS * ms;
    uint64_t end = now + (traffic ? ms / CONSOLE_STEPS_PER_MS : ms);
    realtime_wait(&bench->realtime, end, client_space(bench) ? pty_fd(&bench->pty) : -1);
    uint64_t next = realtime_cycle(&bench->realtime);
    next = next > now ? next : now + 1;
    schedule_at(&bench->schedule, &bench->next_step, next < end ? next : end);
}

bool testbench_open_pty(struct testbench *bench)
{
    if (bench->options->bus) {
        return pty_open(&bench->pty, TESTBENCH_BAUD);
    }
    if (!pty_open(&bench->pty, bench->board.host_baud)) {
        return false;
    }
    realtime_start(&bench->realtime, bench->clock_Hz);
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
    realtime_start(&bench->realtime, bench->clock_Hz);
    while (!bench->stop) {
        uint64_t now = realtime_cycle(&bench->realtime);
        schedule_run_until(&bench->schedule, now);
        read_client(bench, now);
        pty_flush(&bench->pty);
        int fd = client_space(bench) ? pty_fd(&bench->pty) : -1;
        realtime_wait(&bench->realtime, now + adapter_step_us(bench, now, fd) * us, fd);
    }
}
