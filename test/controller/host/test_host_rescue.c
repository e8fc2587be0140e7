/* SPDX-License-Identifier: MIT */
/* The window after a reset in which a person gets the host link back at the board's own rate. */
#include "host/host_rescue.h"

#include <string.h>

#include "ring_input.h"
#include "robot/failsafe.h" // FAILSAFE_RESET_...
#include "port_fake.h"
#include "unity.h"

#define CR     '\r'
#define LF     '\n'
#define CTRL_X 0x18

#define TICK_US    256   // as exact as the rescue takes the time
#define SILENCE_US 20224 // 79 ticks: the first whole number of them that is over 20 ms

static struct host_rescue rescue;
static struct cds_ring input;
static uint8_t stops; // how often Ctrl-X was told

void setUp(void)
{
    port_fake_reset();
    port_fake.now_us = UINT32_MAX - 1000; // the clock wraps in every test
    memset(&rescue, 0, sizeof rescue);
    memset(&input, 0, sizeof input);
    stops = 0;
    TEST_ASSERT_TRUE(host_rescue_begin(&rescue, FAILSAFE_RESET_POWER));
}

void tearDown(void)
{
}

/* As the main loop does. */
static void poll(void)
{
    if (rescue.state != HOST_RESCUE_SHUT)
        stops = (uint8_t)(stops + host_rescue_poll(&rescue, &input));
}

static void hear(uint8_t byte)
{
    TEST_ASSERT_TRUE(cds_ring_put(&input, byte));
    poll();
}

static void hear_all(const char *bytes)
{
    while (*bytes)
        hear((uint8_t)*bytes++);
}

static void pass(uint32_t us)
{
    port_fake.now_us += us;
    poll();
}

static bool is_open(void)
{
    return rescue.state == HOST_RESCUE_OPEN;
}

static bool is_kept(void)
{
    return rescue.enters == HOST_RESCUE_ENTERS;
}

static bool begins(uint8_t cause)
{
    memset(&rescue, 0, sizeof rescue);
    return host_rescue_begin(&rescue, cause);
}

void test_window_opens_after_power_on_and_external_reset(void)
{
    TEST_ASSERT_TRUE(begins(FAILSAFE_RESET_POWER));
    TEST_ASSERT_TRUE(is_open());
    TEST_ASSERT_TRUE(begins(FAILSAFE_RESET_EXTERNAL));
    TEST_ASSERT_TRUE(begins(FAILSAFE_RESET_POWER | FAILSAFE_RESET_BROWN_OUT)); // as chips say it
    TEST_ASSERT_TRUE(begins(FAILSAFE_RESET_EXTERNAL | FAILSAFE_RESET_WATCHDOG));
}

void test_window_opens_if_the_cause_is_not_known(void)
{
    TEST_ASSERT_TRUE(begins(0));
    TEST_ASSERT_TRUE(begins(FAILSAFE_RESET_JTAG));
}

void test_window_stays_shut_after_watchdog_and_brown_out(void)
{
    TEST_ASSERT_FALSE(begins(FAILSAFE_RESET_WATCHDOG));
    TEST_ASSERT_FALSE(is_open());
    TEST_ASSERT_FALSE(begins(FAILSAFE_RESET_BROWN_OUT));
    TEST_ASSERT_FALSE(begins(FAILSAFE_RESET_BROWN_OUT | FAILSAFE_RESET_WATCHDOG));
    hear_all("\r\r\r");
    TEST_ASSERT_FALSE(is_kept());
    TEST_ASSERT_EQUAL_UINT8(3, cds_ring_count(&input)); // the host's
}

void test_window_expires_after_two_seconds(void)
{
    uint32_t us = 0;

    for (; is_open(); us += 1000)
        pass(1000);
    TEST_ASSERT_EQUAL_UINT8(HOST_RESCUE_EXPIRED, rescue.state);
    TEST_ASSERT_UINT32_WITHIN(35000, 2000000, us);
    TEST_ASSERT_FALSE(is_kept());
    TEST_ASSERT_EQUAL_UINT8(0, stops);
}

/* Bytes come until the rate changes: the host's parser must not see those of a wrong rate. */
void test_expired_window_takes_input_and_stays_expired(void)
{
    pass(2035000);
    hear_all("help");
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&input));
    for (uint16_t ms = 0; ms < 20000; ms += 50) {
        pass(50000);
        TEST_ASSERT_EQUAL_UINT8(HOST_RESCUE_EXPIRED, rescue.state);
    }
}

void test_three_enters_keep_the_rate_and_end_the_window(void)
{
    static const char *const enters[] = {"\r\r\r", "\n\n\n", "\r\n\r\n\r", "\r\r\n\n", "\n\r\r"};

    for (uint8_t i = 0; i < sizeof enters / sizeof enters[0]; i++) {
        size_t last = strlen(enters[i]) - 1;

        TEST_ASSERT_TRUE(begins(0));
        for (size_t at = 0; at < last; at++) {
            pass(300000);
            hear((uint8_t)enters[i][at]);
            TEST_ASSERT_FALSE(is_kept());
            TEST_ASSERT_TRUE(is_open());
        }
        hear((uint8_t)enters[i][last]);
        TEST_ASSERT_TRUE(is_kept());
        TEST_ASSERT_FALSE(is_open());
        TEST_ASSERT_EQUAL_UINT8(0, stops);
        TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&input));
    }
}

void test_bytes_after_the_third_enter_are_left_to_the_demux(void)
{
    for (uint8_t i = 0; i < 3; i++)
        cds_ring_put(&input, CR);
    cds_ring_put(&input, 'h');
    cds_ring_put(&input, 'i');
    for (uint8_t i = 0; i < 5; i++)
        poll();
    TEST_ASSERT_TRUE(is_kept());
    TEST_ASSERT_EQUAL_UINT8(2, cds_ring_count(&input));
    TEST_ASSERT_EQUAL_UINT8('h', ring_peek(&input, 0));
}

void test_cr_lf_of_one_key_counts_once(void)
{
    hear_all("\r\n\r\n");
    TEST_ASSERT_FALSE(is_kept());
    hear_all("\r");
    TEST_ASSERT_TRUE(is_kept());
}

void test_other_byte_restarts_the_count_of_enters(void)
{
    for (uint16_t byte = 0; byte <= UINT8_MAX; byte++) {
        if (byte == CR || byte == LF)
            continue;
        TEST_ASSERT_TRUE(begins(0));
        hear_all("\r\r");
        hear((uint8_t)byte);
        hear_all("\r\r");
        TEST_ASSERT_FALSE(is_kept());
        hear(CR);
        TEST_ASSERT_TRUE(is_kept());
    }
}

void test_damaged_byte_restarts_the_count_of_enters(void)
{
    hear_all("\r\r");
    host_rescue_damage(&rescue);
    hear_all("\r\r");
    TEST_ASSERT_FALSE(is_kept());
    hear_all("\r");
    TEST_ASSERT_TRUE(is_kept());
}

/* LF belongs to the CR that is the last byte before it, and to no other. */
void test_lf_counts_if_a_damaged_byte_follows_the_cr(void)
{
    hear(CR);
    host_rescue_damage(&rescue);
    hear_all("\n\n\n");
    TEST_ASSERT_TRUE(is_kept());
}

void test_ctrl_x_stops_after_a_silence(void)
{
    hear(CTRL_X);
    pass(SILENCE_US - 2 * TICK_US);
    TEST_ASSERT_EQUAL_UINT8(0, stops);
    pass(2 * TICK_US);
    TEST_ASSERT_EQUAL_UINT8(1, stops);
    TEST_ASSERT_TRUE(is_open());
    TEST_ASSERT_FALSE(is_kept());
}

void test_ctrl_x_stops_once_for_each_press(void)
{
    for (uint8_t i = 1; i <= 3; i++) {
        hear(CTRL_X);
        pass(SILENCE_US);
        TEST_ASSERT_EQUAL_UINT8(i, stops);
        pass(SILENCE_US);
        TEST_ASSERT_EQUAL_UINT8(i, stops);
    }
}

void test_ctrl_x_among_enters_stops(void)
{
    hear_all("\r\n\x18");
    pass(SILENCE_US);
    TEST_ASSERT_EQUAL_UINT8(1, stops);
}

void test_ctrl_x_that_repeats_stops_at_the_end_of_the_window(void)
{
    while (is_open()) {
        hear(CTRL_X);
        pass(10000);
    }
    TEST_ASSERT_EQUAL_UINT8(1, stops);
}

void test_ctrl_x_before_three_enters_stops(void)
{
    hear_all("\x18\r\r\r");
    TEST_ASSERT_TRUE(is_kept());
    TEST_ASSERT_EQUAL_UINT8(1, stops);
}

/* A program that talks at another rate gives any bytes, and many damaged ones. */
void test_ctrl_x_of_a_host_at_another_rate_does_not_stop(void)
{
    hear_all("x\x18");
    pass(SILENCE_US);
    TEST_ASSERT_EQUAL_UINT8(0, stops);
    TEST_ASSERT_TRUE(begins(0));
    hear_all("\x18\x80");
    pass(SILENCE_US);
    TEST_ASSERT_EQUAL_UINT8(0, stops);
    TEST_ASSERT_TRUE(begins(0));
    host_rescue_damage(&rescue);
    hear(CTRL_X);
    pass(SILENCE_US);
    TEST_ASSERT_EQUAL_UINT8(0, stops);
    TEST_ASSERT_TRUE(begins(0));
    hear(CTRL_X);
    host_rescue_damage(&rescue);
    pass(2035000);
    TEST_ASSERT_FALSE(is_open());
    TEST_ASSERT_EQUAL_UINT8(0, stops);
}
