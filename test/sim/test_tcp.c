/* SPDX-License-Identifier: MIT */
/* The TCP port of the host link from both ends. */
#include "host/tcp.h"
#include "unity.h"

#include <arpa/inet.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define WAIT_MS 60000 // for what must come: longer than any busy machine takes

static const char busy[] = "cds55xx-sim: another client is connected; close it first\r\n";

static struct tcp tcp;
static uint8_t bytes[10000];

static int come(void)
{
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(tcp.port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    int client = socket(AF_INET, SOCK_STREAM, 0);
    TEST_ASSERT_EQUAL_INT(0, connect(client, (struct sockaddr *)&address, sizeof(address)));
    return client;
}

static void say(int client, const char *text)
{
    TEST_ASSERT_EQUAL_INT(strlen(text), send(client, text, strlen(text), MSG_NOSIGNAL));
}

/* Waits until the simulator's end has something to do. */
static void wait_for_simulator(void)
{
    struct pollfd line = {.fd = tcp_fd(&tcp), .events = POLLIN};
    TEST_ASSERT_EQUAL_INT(1, poll(&line, 1, WAIT_MS));
}

/* Asserts that the next bytes of clients are `text`. */
static void assert_read(const char *text)
{
    char got[100] = "";
    size_t size = 0;
    while (size < strlen(text)) {
        wait_for_simulator();
        size += tcp_read(&tcp, (uint8_t *)got + size, sizeof(got) - 1 - size);
    }
    TEST_ASSERT_EQUAL_STRING(text, got);
}

/* Asserts that the client gets `text`, and then the end of the connection if `end`. */
static void assert_got(int client, const char *text, bool end)
{
    char got[100] = "";
    size_t size = 0;
    ssize_t part;
    while (size < strlen(text) &&
           (part = recv(client, got + size, sizeof(got) - 1 - size, 0)) > 0) {
        size += (size_t)part;
    }
    TEST_ASSERT_EQUAL_STRING(text, got);
    if (end) {
        TEST_ASSERT_EQUAL_INT(0, recv(client, got, 1, 0));
    }
}

void setUp(void)
{
    TEST_ASSERT_TRUE(tcp_open(&tcp, 0));
}

void tearDown(void)
{
    tcp_close(&tcp);
}

void test_port_0_takes_a_free_port_of_this_machine_only(void)
{
    struct sockaddr_in address;
    socklen_t size = sizeof(address);
    TEST_ASSERT_EQUAL_INT(0, getsockname(tcp.listener, (struct sockaddr *)&address, &size));
    TEST_ASSERT_NOT_EQUAL_UINT16(0, tcp.port);
    TEST_ASSERT_EQUAL_UINT16(tcp.port, ntohs(address.sin_port));
    TEST_ASSERT_EQUAL_HEX32(INADDR_LOOPBACK, ntohl(address.sin_addr.s_addr));
}

void test_all_256_bytes_pass_unchanged_both_ways(void)
{
    uint8_t all[256];
    uint8_t got[256];
    for (unsigned i = 0; i < 256; i++) {
        all[i] = (uint8_t)i;
    }
    int client = come();
    TEST_ASSERT_EQUAL_INT(256, send(client, all, 256, 0));
    for (size_t size = 0; size < 256;) {
        wait_for_simulator();
        size += tcp_read(&tcp, got + size, 256 - size);
    }
    TEST_ASSERT_EQUAL_MEMORY(all, got, 256);
    tcp_send(&tcp, all, 256);
    tcp_flush(&tcp);
    TEST_ASSERT_EQUAL_INT(256, recv(client, got, 256, MSG_WAITALL));
    TEST_ASSERT_EQUAL_MEMORY(all, got, 256);
    close(client);
}

void test_second_client_is_told_and_closed(void)
{
    int first = come();
    tcp_read(&tcp, bytes, 10);
    int second = come();
    say(second, "typed before the refusal");
    tcp_read(&tcp, bytes, 10);
    assert_got(second, busy, true);
    TEST_ASSERT_EQUAL_UINT32(1, tcp.refused);
    say(first, "first");
    assert_read("first");
    close(first);
    close(second);
}

void test_next_client_comes_when_the_client_has_left(void)
{
    for (unsigned i = 0; i < 3; i++) {
        int client = come();
        tcp_read(&tcp, bytes, 10);
        say(client, "x");
        assert_read("x");
        tcp_send(&tcp, (const uint8_t *)"y", 1);
        tcp_flush(&tcp);
        assert_got(client, "y", false);
        close(client);
    }
    TEST_ASSERT_EQUAL_UINT32(0, tcp.refused);
}

void test_bytes_of_a_client_that_left_come_before_the_next(void)
{
    int first = come();
    tcp_read(&tcp, bytes, 10);
    say(first, "last words");
    close(first);
    int second = come();
    say(second, ", next");
    TEST_ASSERT_EQUAL_UINT(0, tcp_read(&tcp, bytes, 0)); // no space: the second client waits
    assert_read("last words, next");
    TEST_ASSERT_EQUAL_UINT32(0, tcp.refused);
    close(second);
}

void test_client_that_ended_its_input_still_gets_output(void)
{
    int client = come();
    say(client, "version");
    shutdown(client, SHUT_WR);
    assert_read("version");
    while (!tcp.input_ended) {
        wait_for_simulator();
        TEST_ASSERT_EQUAL_UINT(0, tcp_read(&tcp, bytes, 10));
    }
    tcp_send(&tcp, (const uint8_t *)"ok", 2);
    tcp_flush(&tcp);
    tcp_hang_up(&tcp);
    assert_got(client, "ok", true);
    close(client);
}

void test_without_a_client_bytes_are_dropped(void)
{
    tcp_send(&tcp, (const uint8_t *)"early", 5);
    int client = come();
    tcp_read(&tcp, bytes, 10);
    tcp_send(&tcp, (const uint8_t *)"late", 4);
    tcp_flush(&tcp);
    assert_got(client, "late", false);
    TEST_ASSERT_EQUAL_UINT64(4, tcp.bytes_out);
    close(client);
}

void test_bytes_for_a_client_that_does_not_read_are_counted(void)
{
    int client = come();
    tcp_read(&tcp, bytes, 10);
    while (tcp.lost == 0) { // the system takes some megabytes first
        TEST_ASSERT_TRUE(tcp.client >= 0);
        tcp_send(&tcp, bytes, sizeof(bytes));
        tcp_flush(&tcp);
    }
    TEST_ASSERT_TRUE(tcp.lost < sizeof(bytes));
    TEST_ASSERT_TRUE(tcp.bytes_out > SEND_QUEUE_SIZE + sizeof(bytes));
    say(client, "still here");
    assert_read("still here");
    close(client);
}

void test_reset_by_the_client_makes_room_for_the_next(void)
{
    int first = come();
    tcp_read(&tcp, bytes, 10);
    struct linger at_once = {.l_onoff = 1, .l_linger = 0};
    setsockopt(first, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
    close(first); // resets the connection
    int second = come();
    say(second, "second");
    assert_read("second");
    close(second);
}

void test_port_in_use_is_refused(void)
{
    struct tcp other;
    TEST_ASSERT_FALSE(tcp_open(&other, tcp.port));
    tcp_close(&other);
}
