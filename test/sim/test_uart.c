/* SPDX-License-Identifier: MIT */
/* Transmitter and receiver on one net at 16 MHz: bit times, wrong bit rates, breaks, collisions. */
#include "unity.h"
#include "wire/uart.h"

#include <string.h>

#define MHZ16 16000000u
#define ROOM  600
#define FAST  (16u * 256u) // 1 Mbit/s

struct line {
    struct driver driver;
    struct uart_tx tx;
    const char *text; // to be sent
    uint32_t bit_time_256;
    uint64_t ended;
};

static struct schedule schedule;
static struct net net;
static struct uart_rx rx;
static struct listener listener;
static struct line one, two;
static struct uart_frame heard[ROOM];
static uint64_t delivered[ROOM];
static unsigned count;
static uint64_t edges[ROOM];
static unsigned edge_count;
static uint64_t started[ROOM];
static unsigned start_count;

static void on_edge(void *context, uint64_t time, bool level)
{
    (void)context;
    (void)level;
    if (edge_count < ROOM) {
        edges[edge_count++] = time;
    }
}

static void on_byte(void *context, uint64_t now, const struct uart_frame *byte)
{
    (void)context;
    TEST_ASSERT_TRUE(count < ROOM);
    delivered[count] = now;
    heard[count++] = *byte;
}

static void on_start(void *context, uint64_t now)
{
    (void)context;
    started[start_count++] = now;
}

static void on_end(void *context, uint64_t now)
{
    struct line *line = context;
    line->ended = now;
    if (line->text && *++line->text) {
        uart_tx_send(&line->tx, now, line->bit_time_256, (uint8_t)*line->text);
    }
}

static void line_init(struct line *line)
{
    memset(line, 0, sizeof(*line));
    driver_init(&line->driver, &net);
    driver_enable(&line->driver, 0, true);
    uart_tx_init(&line->tx, &schedule, &line->driver, line);
    line->tx.on_end = on_end;
}

static void say(struct line *line, uint64_t start, uint32_t bit_time_256, const char *text)
{
    line->text = text;
    line->bit_time_256 = bit_time_256;
    uart_tx_send(&line->tx, start, bit_time_256, (uint8_t)*text);
}

void setUp(void)
{
    schedule_init(&schedule);
    net_init(&net);
    line_init(&one);
    line_init(&two);
    listener = (struct listener){.on_level = on_edge};
    net_listen(&net, &listener);
    uart_rx_init(&rx, &schedule, &net, 0);
    rx.on_byte = on_byte;
    rx.bit_time_256 = FAST;
    uart_rx_enable(&rx, true);
    count = edge_count = start_count = 0;
}

void tearDown(void)
{
    schedule_free(&schedule);
}

void test_bit_times_are_right_to_a_256th_of_a_cycle(void)
{
    TEST_ASSERT_EQUAL_UINT32(FAST, uart_bit_time_256(MHZ16, 1000000));
    TEST_ASSERT_EQUAL_UINT32(35556, uart_bit_time_256(MHZ16, 115200)); // 138.89 cycles
    TEST_ASSERT_EQUAL_UINT64(1389, uart_cycles_of_half_bits(35556, 20));
}

void test_a_frame_is_a_start_bit_eight_bits_and_a_stop_bit(void)
{
    static const uint64_t expected[] = {100, 116, 132, 148, 164, 180, 196, 212, 228, 244};
    say(&one, 100, FAST, "U"); // 0x55 has an edge at every bit
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_EQUAL_UINT(10, edge_count);
    TEST_ASSERT_EQUAL_UINT64_ARRAY(expected, edges, 10);
    TEST_ASSERT_EQUAL_UINT64(260, one.ended);
    TEST_ASSERT_FALSE(one.tx.busy);
}

void test_edges_at_115200_fall_on_the_nearest_cycle(void)
{
    say(&one, 0, uart_bit_time_256(MHZ16, 115200), "U");
    schedule_run_until(&schedule, 2000);
    for (unsigned i = 0; i < 10; i++) {
        TEST_ASSERT_EQUAL_UINT64((i * 35556u + 128) / 256, edges[i]);
    }
    TEST_ASSERT_EQUAL_UINT64(1389, one.ended);
}

void test_frames_follow_each_other_without_a_gap(void)
{
    say(&one, 0, FAST, "0123456789");
    schedule_run_until(&schedule, 5000);
    TEST_ASSERT_EQUAL_UINT64(1600, one.ended);
    TEST_ASSERT_EQUAL_UINT(10, count);
    for (unsigned i = 0; i < 10; i++) {
        TEST_ASSERT_EQUAL_UINT8('0' + i, heard[i].byte);
        TEST_ASSERT_FALSE(heard[i].framing_error);
    }
}

void test_receiver_delivers_in_the_middle_of_the_stop_bit(void)
{
    say(&one, 100, FAST, "A");
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_EQUAL_UINT64(252, delivered[0]);
    TEST_ASSERT_EQUAL_UINT64(100, heard[0].start);
    TEST_ASSERT_EQUAL_UINT64(260, heard[0].end);
}

void test_all_256_bytes_pass(void)
{
    for (unsigned byte = 0; byte < 256; byte++) {
        uart_tx_send(&one.tx, byte * 200, FAST, (uint8_t)byte);
        schedule_run_until(&schedule, byte * 200 + 199);
        TEST_ASSERT_EQUAL_UINT(byte + 1, count);
        TEST_ASSERT_EQUAL_UINT8(byte, heard[byte].byte);
        TEST_ASSERT_FALSE(heard[byte].framing_error);
    }
}

void test_two_percent_of_rate_error_is_received(void)
{
    rx.bit_time_256 = uart_bit_time_256(MHZ16, 115200);
    say(&one, 0, uart_bit_time_256(MHZ16, 117647), "kangaroo");
    schedule_run_until(&schedule, 20000);
    TEST_ASSERT_EQUAL_UINT(8, count);
    for (unsigned i = 0; i < 8; i++) {
        TEST_ASSERT_EQUAL_UINT8("kangaroo"[i], heard[i].byte);
    }
}

void test_receiver_at_twice_the_rate_gets_other_bytes(void)
{
    rx.bit_time_256 = FAST / 2; // 2 Mbit/s
    uart_tx_send(&one.tx, 0, FAST, 0xF0);
    schedule_run_until(&schedule, 1000);
    /* At double speed the low start bit and four zeros are ten low bits: 0x00 without a stop bit.
     */
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_EQUAL_HEX8(0x00, heard[0].byte);
    TEST_ASSERT_TRUE(heard[0].framing_error);
}

void test_receiver_at_half_the_rate_gets_other_bytes(void)
{
    rx.bit_time_256 = FAST * 2; // 500 kbit/s
    uart_tx_send(&one.tx, 0, FAST, 0xAA);
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_NOT_EQUAL(0xAA, heard[0].byte);
}

void test_slow_receiver_accepts_any_number_of_fast_edges(void)
{
    rx.bit_time_256 = uart_bit_time_256(MHZ16, 7843); // register 254
    for (unsigned i = 0; i < 60; i++) {
        uart_tx_send(&one.tx, i * 160, FAST, 0x55);
        schedule_run_until(&schedule, i * 160 + 160);
    }
    schedule_run_until(&schedule, 100000);
    TEST_ASSERT_TRUE(count <= 1);
}

void test_a_break_is_one_framing_error(void)
{
    driver_level(&one.driver, 50, false);
    schedule_run_until(&schedule, 5000);
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_EQUAL_HEX8(0x00, heard[0].byte);
    TEST_ASSERT_TRUE(heard[0].framing_error);
    driver_level(&one.driver, 5000, true);
    say(&one, 5100, FAST, "A");
    schedule_run_until(&schedule, 6000);
    TEST_ASSERT_EQUAL_UINT(2, count);
    TEST_ASSERT_EQUAL_UINT8('A', heard[1].byte);
    TEST_ASSERT_FALSE(heard[1].framing_error);
}

void test_a_glitch_shorter_than_half_a_bit_is_no_start_bit(void)
{
    rx.on_start = on_start;
    driver_level(&one.driver, 100, false);
    schedule_run_until(&schedule, 105);
    driver_level(&one.driver, 105, true);
    schedule_run_until(&schedule, 300);
    TEST_ASSERT_EQUAL_UINT(0, count);
    TEST_ASSERT_EQUAL_UINT(0, start_count);
    say(&one, 300, FAST, "B");
    schedule_run_until(&schedule, 500);
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_EQUAL_UINT8('B', heard[0].byte);
}

void test_frame_right_after_a_glitch_is_received(void)
{
    driver_level(&one.driver, 100, false);
    schedule_run_until(&schedule, 104);
    driver_level(&one.driver, 104, true);
    say(&one, 112, FAST, "C"); // before the frame of the glitch would end
    schedule_run_until(&schedule, 500);
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_EQUAL_UINT8('C', heard[0].byte);
    TEST_ASSERT_EQUAL_UINT64(112, heard[0].start);
}

void test_the_start_bit_is_verified_in_its_middle(void)
{
    rx.on_start = on_start;
    say(&one, 100, FAST, "xy");
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_EQUAL_UINT(2, start_count);
    TEST_ASSERT_EQUAL_UINT64(108, started[0]);
    TEST_ASSERT_EQUAL_UINT64(268, started[1]);
}

void test_frame_begun_while_the_receiver_was_off_is_dropped(void)
{
    uart_rx_enable(&rx, false);
    say(&one, 100, FAST, "\x80"); // its only high bit is the last one
    schedule_run_until(&schedule, 150);
    uart_rx_enable(&rx, true);
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_EQUAL_UINT(0, count);
    say(&one, 1000, FAST, "D");
    schedule_run_until(&schedule, 2000);
    TEST_ASSERT_EQUAL_UINT(1, count);
}

void test_disabled_receiver_drops_its_frame(void)
{
    say(&one, 100, FAST, "E");
    schedule_run_until(&schedule, 240);
    uart_rx_enable(&rx, false);
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_EQUAL_UINT(0, count);
}

void test_two_transmitters_at_once_are_anded(void)
{
    uart_tx_send(&one.tx, 100, FAST, 0x3C);
    uart_tx_send(&two.tx, 100, FAST, 0x66);
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_EQUAL_HEX8(0x3C & 0x66, heard[0].byte);
}

void test_late_second_transmitter_damages_the_frame(void)
{
    uart_tx_send(&one.tx, 100, FAST, 0xFF);
    uart_tx_send(&two.tx, 180, FAST, 0x00);
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_TRUE(count >= 1);
    TEST_ASSERT_NOT_EQUAL(0xFF, heard[0].byte);
    TEST_ASSERT_TRUE(heard[0].framing_error);
}

void test_stopped_transmitter_leaves_the_line_high(void)
{
    uart_tx_send(&one.tx, 100, FAST, 0x00);
    schedule_run_until(&schedule, 150);
    uart_tx_stop(&one.tx, 150);
    schedule_run_until(&schedule, 1000);
    TEST_ASSERT_TRUE(net.level);
    TEST_ASSERT_EQUAL_UINT64(0, one.ended);
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_EQUAL_HEX8(0xFC, heard[0].byte); // two low bits were sent
}

static void set(struct line *line, uint64_t time, bool level)
{
    schedule_run_until(&schedule, time);
    driver_level(&line->driver, time, level);
}

/* The line was low. One driver turns off and the other one pulls low in the same cycle. */
void test_pulse_of_0_cycles_starts_no_frame(void)
{
    set(&one, 100, false);
    schedule_run_until(&schedule, 1000); // a break gives one byte with a framing error
    set(&one, 1000, true);
    set(&two, 1000, false);
    set(&two, 1500, true);
    schedule_run_until(&schedule, 3000);
    TEST_ASSERT_EQUAL_UINT(1, count);
    set(&one, 3000, false); // a real edge starts a frame
    set(&one, 3100, true);
    schedule_run_until(&schedule, 4000);
    TEST_ASSERT_EQUAL_UINT(2, count);
}

/* The stop bit is sampled at 100 + 152, when the other transmitter pulls low. */
void test_sample_on_an_edge_reads_the_level_after_it(void)
{
    uart_tx_send(&two.tx, 100 + 152, FAST, 0xFF);
    uart_tx_send(&one.tx, 100, FAST, 0x55);
    schedule_run_until(&schedule, 300);
    TEST_ASSERT_TRUE(heard[0].framing_error);
    schedule_run_until(&schedule, 1000);
    count = 0;
    uart_tx_send(&one.tx, 1100, FAST, 0x55);
    uart_tx_send(&two.tx, 1100 + 152, FAST, 0xFF);
    schedule_run_until(&schedule, 1300);
    TEST_ASSERT_TRUE(heard[0].framing_error);
}
