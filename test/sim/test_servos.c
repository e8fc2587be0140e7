/* SPDX-License-Identifier: MIT */
/* Servos on a wire without an AVR: reply times, received bytes, and bit rates. */
#include "servo/servos.h"
#include "unity.h"

#include <string.h>

#define CLOCK 16000000u
#define FAST  (16u * 256u)
#define ROOM  2000

static struct schedule schedule;
static struct net net;
static struct driver driver;
static struct uart_tx tx;
static struct servos servos;
static struct uart_rx rx; // at 1 Mbit/s
static uint8_t heard[ROOM];
static unsigned count;
static uint64_t began; // first byte of a servo
static unsigned most;  // highest number of servos that drove together
static struct listener listener;

static void ended(void *context, uint64_t now)
{
    (void)context;
    (void)now;
}

static void on_byte(void *context, uint64_t now, const struct uart_frame *byte)
{
    (void)context;
    (void)now;
    heard[count++] = byte->byte;
}

static void servo_byte(void *context, uint64_t now, const struct servo_node *node)
{
    (void)context;
    TEST_ASSERT_TRUE(uart_tx_end(&node->tx) > now);
    if (!began) {
        began = now;
    }
}

static void on_driver(void *context, uint64_t time, struct driver *who)
{
    (void)context;
    (void)time;
    (void)who;
    most = net.enabled > most ? net.enabled : most;
}

void setUp(void)
{
    schedule_init(&schedule);
    net_init(&net);
    driver_init(&driver, &net);
    uart_tx_init(&tx, &schedule, &driver, 0);
    tx.on_end = ended;
    listener = (struct listener){.on_driver = on_driver};
    net_listen(&net, &listener);
    servos_init(&servos, &schedule, &net, CLOCK);
    servos.on_byte = servo_byte;
    uart_rx_init(&rx, &schedule, &net, 0);
    rx.bit_time_256 = FAST;
    rx.on_byte = on_byte;
    uart_rx_enable(&rx, true);
    count = most = 0;
    began = 0;
}

void tearDown(void)
{
    servos_free(&servos);
    schedule_free(&schedule);
}

static void put(const uint8_t *ids, unsigned number)
{
    servos_replace(&servos, schedule.now, ids, number);
}

/* Sends bytes. Returns the end of the last stop bit. */
static uint64_t say_bytes(uint32_t bit_time_256, const uint8_t *bytes, unsigned size)
{
    uint64_t time = schedule.now + 100;
    driver_enable(&driver, time, true);
    for (unsigned i = 0; i < size; i++) {
        uart_tx_send(&tx, time, bit_time_256, bytes[i]);
        time = uart_tx_end(&tx);
        schedule_run_until(&schedule, time);
    }
    driver_enable(&driver, time, false);
    count = most = 0; // drops its own bytes
    began = 0;
    return time;
}

/* Sends an instruction packet and adds the checksum. Returns the end of its last stop bit. */
static uint64_t say(uint32_t bit_time_256, const uint8_t *body, unsigned size)
{
    uint8_t packet[32] = {0xFF, 0xFF};
    unsigned sum = 0;
    memcpy(packet + 2, body, size);
    for (unsigned i = 0; i < size; i++) {
        sum += body[i];
    }
    packet[size + 2] = (uint8_t)~sum;
    return say_bytes(bit_time_256, packet, size + 3);
}

static const uint8_t one[] = {1};
static const uint8_t ping[] = {0x01, 0x02, 0x01};

void test_return_delay_counts_from_the_end_of_the_last_stop_bit(void)
{
    put(one, 1);
    uint64_t end = say(FAST, ping, 3);
    schedule_run_until(&schedule, end + 2000);
    TEST_ASSERT_EQUAL_UINT64(end + 32, began); // factory value: 2 us
    TEST_ASSERT_EQUAL_UINT(6, count);
    TEST_ASSERT_EQUAL_HEX8(0xFC, heard[5]);
    TEST_ASSERT_EQUAL_UINT(0, net.enabled);
}

void test_written_return_delay_is_used(void)
{
    static const uint8_t write[] = {0x01, 0x04, 0x03, 0x05, 0x08};
    put(one, 1);
    schedule_run_until(&schedule, say(FAST, write, 5) + 2000);
    uint64_t end = say(FAST, ping, 3);
    schedule_run_until(&schedule, end + 2000);
    TEST_ASSERT_EQUAL_UINT64(end + 16 * 16, began);
}

void test_only_the_addressed_servo_replies(void)
{
    static const uint8_t ids[] = {1, 2, 3};
    static const uint8_t ping_2[] = {0x02, 0x02, 0x01};
    put(ids, 3);
    schedule_run_until(&schedule, say(FAST, ping_2, 3) + 2000);
    TEST_ASSERT_EQUAL_UINT(6, count);
    TEST_ASSERT_EQUAL_UINT8(2, heard[2]);
    TEST_ASSERT_EQUAL_UINT(1, most);
}

void test_servos_of_same_id_drive_at_once(void)
{
    static const uint8_t ids[] = {1, 1};
    put(ids, 2);
    schedule_run_until(&schedule, say(FAST, ping, 3) + 2000);
    TEST_ASSERT_EQUAL_UINT(2, most);
}

void test_new_baud_rate_is_used_after_the_reply(void)
{
    static const uint8_t write[] = {0x01, 0x04, 0x03, 0x04, 0x10}; // 115200, as the servo has it
    uint32_t slow = 17 * 8 * 256;
    put(one, 1);
    schedule_run_until(&schedule, say(FAST, write, 5) + 2000);
    TEST_ASSERT_EQUAL_UINT(6, count); // received at 1 Mbit/s
    schedule_run_until(&schedule, say(FAST, ping, 3) + 5000);
    TEST_ASSERT_EQUAL_UINT(0, count);
    TEST_ASSERT_EQUAL_UINT64(0, began);
    schedule_run_until(&schedule, schedule.now + 20000);
    rx.bit_time_256 = slow;
    schedule_run_until(&schedule, say(slow, ping, 3) + 20000);
    TEST_ASSERT_EQUAL_UINT(6, count);
    TEST_ASSERT_EQUAL_HEX8(0xFC, heard[5]);
}

/* Returns the bytes of the reply to a PING at 57600 bit/s, `us` after the reply to the WRITE of
 * that rate. */
static unsigned answer_soon_after_new_baud(uint32_t us)
{
    static const uint8_t write[] = {0x01, 0x04, 0x03, 0x04, 0x22};
    uint32_t slow = 35 * 8 * 256;
    put(one, 1);
    rx.bit_time_256 = FAST;
    uint64_t end = say(FAST, write, 5);
    while (count < 6 || net.enabled) {
        end += 16;
        schedule_run_until(&schedule, end);
    }
    schedule_run_until(&schedule, end + us * 16);
    rx.bit_time_256 = slow;
    schedule_run_until(&schedule, say(slow, ping, 3) + 40000);
    return count;
}

void test_new_baud_rate_hears_a_packet_right_after_the_reply(void)
{
    for (uint32_t us = 0; us < 200; us += 5) {
        TEST_ASSERT_EQUAL_UINT(6, answer_soon_after_new_baud(us));
    }
}

/* Returns the bytes of the reply to a PING with a silence in it. */
static unsigned answer_after_silence_in_ping(uint32_t us)
{
    static const uint8_t whole[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};
    put(one, 1);
    uint64_t end = say_bytes(FAST, whole, 3);
    schedule_run_until(&schedule, end + us * 16 - 100);
    schedule_run_until(&schedule, say_bytes(FAST, whole + 3, 3) + 2000);
    return count;
}

void test_a_packet_may_pause_for_less_than_100_ms(void)
{
    TEST_ASSERT_EQUAL_UINT(6, answer_after_silence_in_ping(SERVO_PACKET_TIMEOUT_US - 1));
    TEST_ASSERT_EQUAL_UINT(0, answer_after_silence_in_ping(SERVO_PACKET_TIMEOUT_US));
}

void test_a_fast_sender_pauses_nowhere(void)
{
    put(one, 1);
    schedule_run_until(&schedule, say(FAST * 98 / 100, ping, 3) + 2000);
    TEST_ASSERT_EQUAL_UINT(6, count);
}

void test_servo_without_power_receives_and_drives_nothing(void)
{
    put(one, 1);
    uint64_t end = say(FAST, ping, 3);
    schedule_run_until(&schedule, end + 500); // in the middle of its reply
    TEST_ASSERT_EQUAL_UINT(1, net.enabled);
    servos_power(&servos, schedule.now, false);
    TEST_ASSERT_EQUAL_UINT(0, net.enabled);
    TEST_ASSERT_TRUE(net.level);
    schedule_run_until(&schedule, say(FAST, ping, 3) + 2000);
    TEST_ASSERT_EQUAL_UINT(0, count);
    servos_power(&servos, schedule.now, true);
    schedule_run_until(&schedule, say(FAST, ping, 3) + 2000);
    TEST_ASSERT_EQUAL_UINT(6, count);
}

void test_servos_can_be_replaced_during_a_reply(void)
{
    static const uint8_t others[] = {7, 8};
    put(one, 1);
    uint64_t end = say(FAST, ping, 3);
    schedule_run_until(&schedule, end + 500);
    put(others, 2);
    TEST_ASSERT_EQUAL_UINT(0, net.enabled);
    schedule_run_until(&schedule, say(FAST, ping, 3) + 2000);
    TEST_ASSERT_EQUAL_UINT(0, count);
}

void test_servos_tick_every_4_ms(void)
{
    static const uint8_t write[] = {0x01, 0x05, 0x03, 0x1E, 0x00, 0x00};
    static const uint8_t torque[] = {0x01, 0x04, 0x03, 0x18, 0x01};
    put(one, 1);
    schedule_run_until(&schedule, say(FAST, torque, 5) + 2000);
    schedule_run_until(&schedule, say(FAST, write, 6) + 2000);
    uint16_t before = servo_present_position(&servos.node[0].servo);
    schedule_run_until(&schedule, schedule.now + CLOCK / 2);
    TEST_ASSERT_LESS_THAN_UINT16(before, servo_present_position(&servos.node[0].servo));
}
