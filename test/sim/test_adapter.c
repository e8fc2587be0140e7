/* SPDX-License-Identifier: MIT */
/* The serial adapter, alone on a wire and with servos. */
#include "host/adapter.h"
#include "servo/servos.h"
#include "unity.h"

#include <string.h>

#define CLOCK 16000000u
#define ROOM  6000

static struct schedule schedule;
static struct net net;
static struct adapter adapter;
static struct servos servos;
static struct uart_rx onlooker; // at 1 Mbit/s
static uint8_t seen[ROOM];
static unsigned seen_count;
static uint8_t heard[ROOM]; // by the adapter
static unsigned heard_count;
static uint64_t driving_until;
static unsigned times_driving;

static void saw(void *context, uint64_t now, const struct uart_frame *byte)
{
    (void)context;
    (void)now;
    seen[seen_count++] = byte->byte;
}

static void hears(void *context, uint64_t now, uint8_t byte)
{
    (void)context;
    (void)now;
    heard[heard_count++] = byte;
}

static void talks(void *context, uint64_t now, bool talking)
{
    (void)context;
    times_driving += talking;
    driving_until = now;
}

void setUp(void)
{
    schedule_init(&schedule);
    net_init(&net);
    adapter_init(&adapter, &schedule, &net, &net, CLOCK, 1000000);
    adapter.on_byte = hears;
    adapter.on_drive = talks;
    uart_rx_init(&onlooker, &schedule, &net, 0);
    onlooker.bit_time_256 = 16 * 256;
    onlooker.on_byte = saw;
    uart_rx_enable(&onlooker, true);
    servos_init(&servos, &schedule, &net, CLOCK);
    seen_count = heard_count = times_driving = 0;
    driving_until = 0;
}

void tearDown(void)
{
    servos_free(&servos);
    schedule_free(&schedule);
}

static const uint8_t ping[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};

static void put_servo(uint8_t baud)
{
    static const uint8_t id = 1;
    servos_replace(&servos, schedule.now, &id, 1);
    servos_set_eeprom(&servos, 0, servos.node[0].servo.registers);
    servo_node_baud(&servos.node[0], baud);
}

void test_bytes_are_sent_without_gap_then_the_driver_is_off(void)
{
    schedule_run_until(&schedule, 1000);
    adapter_send(&adapter, 1000, ping, sizeof(ping));
    TEST_ASSERT_EQUAL_UINT64(1000 + 6 * 160, adapter_end(&adapter));
    schedule_run_until(&schedule, 10000);
    TEST_ASSERT_EQUAL_UINT(sizeof(ping), seen_count);
    TEST_ASSERT_EQUAL_MEMORY(ping, seen, sizeof(ping));
    TEST_ASSERT_EQUAL_UINT(1, times_driving);
    TEST_ASSERT_EQUAL_UINT64(1000 + 6 * 160, driving_until);
    TEST_ASSERT_EQUAL_UINT(0, net.enabled);
}

void test_half_duplex_receives_the_servo_and_not_itself(void)
{
    put_servo(1);
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, 10000);
    TEST_ASSERT_EQUAL_UINT(6, heard_count);
    TEST_ASSERT_EQUAL_HEX8(0xFC, heard[5]);
    TEST_ASSERT_EQUAL_UINT(0, adapter.framing_errors);
}

void test_reply_without_return_delay_is_received_whole(void)
{
    put_servo(1);
    servos.node[0].servo.registers[TABLE_RETURN_DELAY] = 0;
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, 10000);
    TEST_ASSERT_EQUAL_UINT(6, heard_count);
    TEST_ASSERT_EQUAL_HEX8(0xFF, heard[0]);
}

void test_bytes_of_others_while_driving_are_not_received(void)
{
    struct driver other;
    driver_init(&other, &net);
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, 200);
    driver_set(&other, 200, true, false);
    schedule_run_until(&schedule, 800);
    driver_set(&other, 800, false, true);
    schedule_run_until(&schedule, 10000);
    TEST_ASSERT_EQUAL_UINT(0, heard_count);
}

void test_every_servo_rate_set_by_a_client_works(void)
{
    static const struct {
        uint8_t baud;
        uint32_t rate;
    } rates[] = {{0, 2000000}, {1, 1000000}, {2, 666667}, {3, 500000},  {4, 400000}, {16, 117647},
                 {16, 115200}, {34, 57142},  {34, 57600}, {103, 19200}, {207, 9600}, {254, 7843}};
    for (unsigned i = 0; i < sizeof(rates) / sizeof(rates[0]); i++) {
        put_servo(rates[i].baud);
        adapter_baud(&adapter, rates[i].rate);
        heard_count = 0;
        adapter_send(&adapter, schedule.now, ping, sizeof(ping));
        schedule_run_until(&schedule, schedule.now + CLOCK / 10);
        TEST_ASSERT_EQUAL_UINT_MESSAGE(6, heard_count, "rate");
        TEST_ASSERT_EQUAL_HEX8(0xFC, heard[5]);
    }
    TEST_ASSERT_EQUAL_UINT(0, adapter.framing_errors);
}

void test_packet_at_another_rate_gets_no_reply(void)
{
    put_servo(1);
    adapter_baud(&adapter, 500000);
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, CLOCK / 10);
    TEST_ASSERT_EQUAL_UINT(0, heard_count);
    TEST_ASSERT_NOT_EQUAL(0, memcmp(seen, ping, sizeof(ping)));
}

void test_reply_at_another_rate_is_garbage(void)
{
    put_servo(1);
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, 6 * 160);
    adapter_baud(&adapter, 400000); // before the reply
    schedule_run_until(&schedule, CLOCK / 10);
    TEST_ASSERT_TRUE(heard_count > 0 && heard_count < 6);
    TEST_ASSERT_NOT_EQUAL(0xFF, heard[0]);
}

void test_queued_bytes_keep_the_rate_at_which_they_were_queued(void)
{
    adapter_send(&adapter, 0, ping, sizeof(ping));
    adapter_baud(&adapter, 500000);
    adapter_send(&adapter, 0, ping, 1);
    TEST_ASSERT_EQUAL_UINT64(6 * 160 + 320, adapter_end(&adapter));
    schedule_run_until(&schedule, 6 * 160);
    TEST_ASSERT_EQUAL_MEMORY(ping, seen, sizeof(ping));
    schedule_run_until(&schedule, 10000);
    TEST_ASSERT_EQUAL_UINT64(6 * 160 + 320, driving_until);
}

void test_rate_0_keeps_the_rate(void)
{
    adapter_baud(&adapter, 0);
    adapter_send(&adapter, 0, ping, 1);
    TEST_ASSERT_EQUAL_UINT64(160, adapter_end(&adapter));
}

void test_queue_holds_4096_bytes(void)
{
    static const uint8_t much[5000] = {0x55};
    TEST_ASSERT_EQUAL_UINT(ADAPTER_SIZE, adapter_space(&adapter));
    adapter_send(&adapter, 0, much, sizeof(much));
    TEST_ASSERT_EQUAL_UINT(1, adapter_space(&adapter)); // one byte is being sent
    schedule_run_until(&schedule, 10 * CLOCK);
    TEST_ASSERT_EQUAL_UINT(ADAPTER_SIZE, seen_count);
    TEST_ASSERT_EQUAL_UINT(ADAPTER_SIZE, adapter_space(&adapter));
    TEST_ASSERT_EQUAL_UINT(1, times_driving);
}

void test_full_duplex_receives_while_sending(void)
{
    struct net in;
    struct adapter two;
    struct driver driver;
    struct uart_tx tx;
    net_init(&in);
    adapter_init(&two, &schedule, &net, &in, CLOCK, 1000000);
    two.on_byte = hears;
    driver_init(&driver, &in);
    driver_enable(&driver, 0, true);
    uart_tx_init(&tx, &schedule, &driver, 0);
    adapter.on_byte = 0; // it receives the other adapter
    adapter_send(&two, 0, ping, sizeof(ping));
    uart_tx_send(&tx, 80, 16 * 256, 0xA5);
    schedule_run_until(&schedule, 235);
    TEST_ASSERT_EQUAL_UINT(1, heard_count);
    TEST_ASSERT_EQUAL_HEX8(0xA5, heard[0]);
    TEST_ASSERT_TRUE(two.driver.enabled);
}
