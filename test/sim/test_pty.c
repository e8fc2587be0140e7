/* SPDX-License-Identifier: MIT */
/* The pseudo terminal from both ends, and the real time of a run. */
#include "host/pty.h"
#include "host/realtime.h"
#include "unity.h"

#include <fcntl.h>
#include <poll.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <asm/termbits.h>

static struct pty pty;
static int line;
static int countdown = -1; // ioctl() calls of the simulator before a client comes; -1: none comes
static uint32_t client_rate;

static void client_sets(uint32_t baud)
{
    struct termios2 mode;
    syscall(SYS_ioctl, line, TCGETS2, &mode);
    mode.c_cflag = (mode.c_cflag & (tcflag_t)~CBAUD) | BOTHER;
    mode.c_ispeed = mode.c_ospeed = baud;
    syscall(SYS_ioctl, line, TCSETS2, &mode);
}

/* Replaces the C library's ioctl(): a client opens the port and sets its rate just before the
 * simulator's next system call. The race is then always lost. */
int ioctl(int file, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    if (countdown == 0) {
        line = open(pty.path, O_RDWR | O_NOCTTY | O_NONBLOCK);
        client_sets(client_rate);
    }
    countdown -= countdown >= 0;
    return (int)syscall(SYS_ioctl, file, request, argument);
}

static uint8_t bytes[200000];

static void come(void)
{
    line = open(pty.path, O_RDWR | O_NOCTTY | O_NONBLOCK);
    TEST_ASSERT_TRUE(line >= 0);
    pty_read(&pty, bytes, 0);
    TEST_ASSERT_TRUE(pty.client);
}

static void leave(void)
{
    close(line);
    line = -1;
    pty_read(&pty, bytes, 0);
    TEST_ASSERT_FALSE(pty.client);
}

static void set_line(uint32_t baud, tcflag_t local)
{
    struct termios2 mode;
    TEST_ASSERT_EQUAL_INT(0, ioctl(line, TCGETS2, &mode));
    mode.c_cflag = (mode.c_cflag & (tcflag_t)~CBAUD) | BOTHER;
    mode.c_ispeed = mode.c_ospeed = baud;
    mode.c_lflag |= local;
    TEST_ASSERT_EQUAL_INT(0, ioctl(line, TCSETS2, &mode));
}

/* Returns what the client can read now. */
static size_t take(uint8_t *into, size_t capacity)
{
    size_t size = 0;
    struct pollfd ready = {.fd = line, .events = POLLIN};
    while (size < capacity && poll(&ready, 1, 50) > 0) {
        ssize_t got = read(line, into + size, capacity - size);
        if (got <= 0) {
            break;
        }
        size += (size_t)got;
        pty_flush(&pty);
    }
    return size;
}

void setUp(void)
{
    line = -1;
    TEST_ASSERT_TRUE(pty_open(&pty, 1000000));
}

void tearDown(void)
{
    if (line >= 0) {
        close(line);
    }
    pty_close(&pty);
}

void test_all_256_bytes_pass_unchanged_both_ways(void)
{
    uint8_t all[256];
    uint8_t got[300];
    for (unsigned i = 0; i < 256; i++) {
        all[i] = (uint8_t)i;
    }
    come();
    TEST_ASSERT_EQUAL_INT(256, write(line, all, 256));
    TEST_ASSERT_EQUAL_UINT(256, pty_read(&pty, got, sizeof(got)));
    TEST_ASSERT_EQUAL_MEMORY(all, got, 256);
    pty_send(&pty, all, 256);
    pty_flush(&pty);
    TEST_ASSERT_EQUAL_UINT(256, take(got, sizeof(got)));
    TEST_ASSERT_EQUAL_MEMORY(all, got, 256);
}

void test_any_rate_that_a_client_sets(void)
{
    static const uint32_t rates[] = {1000000, 57600, 57142, 117647, 115200, 2000000, 666666, 7843};
    TEST_ASSERT_EQUAL_UINT32(1000000, pty_baud(&pty));
    come();
    for (unsigned i = 0; i < sizeof(rates) / sizeof(rates[0]); i++) {
        set_line(rates[i], 0);
        TEST_ASSERT_EQUAL_UINT32(rates[i], pty_baud(&pty));
    }
    leave();
    TEST_ASSERT_EQUAL_UINT32(7843, pty_baud(&pty)); // as for a serial port
}

void test_port_that_was_never_opened_has_no_client(void)
{
    pty_read(&pty, bytes, 0);
    TEST_ASSERT_FALSE(pty.client);
}

static bool wakes(int timeout_ms)
{
    struct pollfd file = {.fd = pty_fd(&pty), .events = POLLIN};
    TEST_ASSERT_TRUE(file.fd >= 0);
    return poll(&file, 1, timeout_ms) > 0;
}

void test_client_that_comes_wakes_the_simulator(void)
{
    for (unsigned i = 0; i < 3; i++) {
        pty_read(&pty, bytes, 0);
        TEST_ASSERT_FALSE(wakes(0));
        line = open(pty.path, O_RDWR | O_NOCTTY | O_NONBLOCK);
        TEST_ASSERT_TRUE(wakes(5000));
        TEST_ASSERT_EQUAL_UINT(0, pty_read(&pty, bytes, 10));
        TEST_ASSERT_TRUE(pty.client);
        TEST_ASSERT_FALSE(wakes(0));
        leave();
    }
}

void test_client_that_writes_or_leaves_wakes_the_simulator(void)
{
    come();
    TEST_ASSERT_EQUAL_INT(1, write(line, "x", 1));
    TEST_ASSERT_TRUE(wakes(5000));
    TEST_ASSERT_EQUAL_UINT(1, pty_read(&pty, bytes, 10));
    TEST_ASSERT_FALSE(wakes(0));
    close(line);
    line = -1;
    TEST_ASSERT_TRUE(wakes(5000));
    pty_read(&pty, bytes, 0);
    pty_read(&pty, bytes, 0);
    TEST_ASSERT_FALSE(wakes(0));
}

void test_without_a_client_bytes_are_dropped(void)
{
    pty_send(&pty, (const uint8_t *)"early", 5);
    come();
    pty_flush(&pty);
    TEST_ASSERT_EQUAL_UINT(0, take(bytes, 10));
    TEST_ASSERT_EQUAL_UINT64(0, pty.lost);
}

void test_unread_bytes_are_dropped_when_the_client_leaves(void)
{
    come();
    pty_send(&pty, (const uint8_t *)"given", 5);
    pty_flush(&pty);
    pty_send(&pty, (const uint8_t *)"kept", 4);
    leave();
    come();
    pty_flush(&pty);
    TEST_ASSERT_EQUAL_UINT(0, take(bytes, 10));
}

void test_bytes_of_a_client_that_has_left_are_read(void)
{
    come();
    TEST_ASSERT_EQUAL_INT(4, write(line, "last", 4));
    close(line);
    line = -1;
    TEST_ASSERT_EQUAL_UINT(4, pty_read(&pty, bytes, 10));
}

void test_the_line_is_raw_again_when_a_client_has_left(void)
{
    struct termios2 mode;
    come();
    set_line(57600, ECHO | ICANON);
    leave();
    come();
    TEST_ASSERT_EQUAL_INT(0, ioctl(line, TCGETS2, &mode));
    TEST_ASSERT_EQUAL_HEX32(0, mode.c_lflag & (ECHO | ICANON));
}

void test_line_is_raw_again_after_an_undetected_client(void)
{
    struct termios2 mode;
    line = open(pty.path, O_RDWR | O_NOCTTY);
    set_line(57600, ECHO | ICANON);
    leave();
    come();
    TEST_ASSERT_EQUAL_INT(0, ioctl(line, TCGETS2, &mode));
    TEST_ASSERT_EQUAL_HEX32(0, mode.c_lflag & (ECHO | ICANON));
}

/* The client before has left the line with these flags. Returns how many ioctl() calls of the
 * simulator were raced. */
static unsigned race_after(tcflag_t local)
{
    unsigned raced = 0;
    for (int call = 0; call < 10; call++) {
        come();
        set_line(1000000, local);
        close(line);
        line = -1;
        client_rate = 57600 + (uint32_t)call;
        countdown = call;
        pty_read(&pty, bytes, 0); // detects that the client has left
        bool came = countdown < 0;
        countdown = -1;
        if (came) {
            raced++;
            TEST_ASSERT_EQUAL_UINT32(client_rate, pty_baud(&pty));
            leave();
        }
    }
    return raced;
}

void test_rate_set_while_another_client_leaves_is_kept(void)
{
    TEST_ASSERT_GREATER_THAN_UINT(0, race_after(0));
}

void test_rate_set_while_flags_are_restored_is_kept(void)
{
    TEST_ASSERT_GREATER_THAN_UINT(1, race_after(ECHO | ICANON));
}

void test_flush_of_output_by_the_client_is_counted(void)
{
    come();
    syscall(SYS_ioctl, line, TCFLSH, TCIFLUSH); // drops the client's input; it has no effect
    pty_read(&pty, bytes, 10);
    TEST_ASSERT_EQUAL_UINT32(0, pty.flushes);
    for (unsigned i = 1; i <= 3; i++) {
        syscall(SYS_ioctl, line, TCFLSH, TCOFLUSH);
        TEST_ASSERT_EQUAL_INT(4, write(line, "next", 4));
        struct pollfd data = {.fd = pty.master, .events = POLLIN};
        size_t size = 0;
        while (size < 4 && poll(&data, 1, 5000) > 0) {
            size += pty_read(&pty, bytes + size, 10);
        }
        TEST_ASSERT_EQUAL_UINT(4, size);
        TEST_ASSERT_EQUAL_MEMORY("next", bytes, 4);
        TEST_ASSERT_EQUAL_UINT32(i, pty.flushes);
    }
}

/* tcflush() drops what the system has not passed to the simulator's end yet. Bytes that can be read
 * there stay. */
void test_readable_bytes_survive_a_flush(void)
{
    come();
    for (unsigned i = 0; i < 100; i++) {
        struct pollfd data = {.fd = pty.master, .events = POLLIN};
        TEST_ASSERT_EQUAL_INT(4, write(line, "kept", 4));
        TEST_ASSERT_EQUAL_INT(1, poll(&data, 1, 5000));
        syscall(SYS_ioctl, line, TCFLSH, TCIOFLUSH);
        TEST_ASSERT_EQUAL_UINT(4, pty_read(&pty, bytes, 10));
    }
}

void test_paused_client_loses_nothing_until_the_queue_is_full(void)
{
    static uint8_t much[SEND_QUEUE_SIZE];
    for (unsigned i = 0; i < sizeof(much); i++) {
        much[i] = (uint8_t)(i * 7 + i / 256);
    }
    come();
    pty_send(&pty, much, sizeof(much));
    pty_flush(&pty);
    pty_send(&pty, much, 10000); // the system has taken some
    TEST_ASSERT_EQUAL_UINT64(0, pty.lost);
    TEST_ASSERT_EQUAL_UINT(sizeof(much) + 10000, take(bytes, sizeof(bytes)));
    TEST_ASSERT_EQUAL_MEMORY(much, bytes, sizeof(much));
    TEST_ASSERT_EQUAL_MEMORY(much, bytes + sizeof(much), 10000);
}

void test_bytes_for_a_full_queue_are_counted(void)
{
    come();
    pty_send(&pty, bytes, SEND_QUEUE_SIZE);
    pty_send(&pty, bytes, 3);
    TEST_ASSERT_EQUAL_UINT64(3, pty.lost);
    TEST_ASSERT_EQUAL_UINT64(SEND_QUEUE_SIZE + 3, pty.bytes_out);
}

void test_wait_lasts_until_its_cycle_or_a_byte_of_the_client(void)
{
    struct realtime realtime;
    realtime_start(&realtime, 1000000);
    realtime_wait(&realtime, 20000, -1);
    TEST_ASSERT_TRUE(realtime_cycle(&realtime) >= 20000);
    come();
    TEST_ASSERT_EQUAL_INT(1, write(line, "x", 1));
    uint64_t before = realtime_cycle(&realtime);
    realtime_wait(&realtime, before + 5000000, pty_fd(&pty));
    TEST_ASSERT_TRUE(realtime_cycle(&realtime) < before + 2000000);
}

void test_late_run_does_not_catch_up_and_counts_lost_time(void)
{
    struct realtime realtime;
    realtime_start(&realtime, 1000000);
    realtime.origin_ns -= 5000000000u;     // 5 s ago
    realtime_wait(&realtime, 1000000, -1); // a second is skipped
    TEST_ASSERT_TRUE(realtime.lost_ns >= 4000000000u);
    TEST_ASSERT_TRUE(realtime_cycle(&realtime) < 2000000);
    realtime_start(&realtime, 1000000);
    realtime.origin_ns -= 50000000; // 50 ms are caught up
    realtime_wait(&realtime, 0, -1);
    TEST_ASSERT_EQUAL_UINT64(0, realtime.lost_ns);
}
