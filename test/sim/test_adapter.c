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
static struct uart_rx onlooker; // at 1 Mbps
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
    onlooker.bit_256 = 16 * 256;
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

void test_bytes_go_out_back_to_back_and_the_driver_is_released_after_the_last_stop_bit(void)
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

void test_it_does_not_hear_itself_and_hears_the_servo(void)
{
    put_servo(1);
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, 10000);
    TEST_ASSERT_EQUAL_UINT(6, heard_count);
    TEST_ASSERT_EQUAL_HEX8(0xFC, heard[5]);
    TEST_ASSERT_EQUAL_UINT(0, adapter.framing_errors);
}

void test_a_servo_without_return_delay_is_heard_whole(void)
{
    put_servo(1);
    servos.node[0].servo.registers[TABLE_RETURN_DELAY] = 0;
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, 10000);
    TEST_ASSERT_EQUAL_UINT(6, heard_count);
    TEST_ASSERT_EQUAL_HEX8(0xFF, heard[0]);
}

void test_who_talks_while_it_drives_is_not_heard(void)
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

void test_every_rate_of_the_servos_as_a_client_sets_it(void)
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

void test_at_another_rate_there_is_no_answer(void)
{
    put_servo(1);
    adapter_baud(&adapter, 500000);
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, CLOCK / 10);
    TEST_ASSERT_EQUAL_UINT(0, heard_count);
    TEST_ASSERT_NOT_EQUAL(0, memcmp(seen, ping, sizeof(ping)));
}

void test_an_answer_at_another_rate_is_garbage(void)
{
    put_servo(1);
    adapter_send(&adapter, 0, ping, sizeof(ping));
    schedule_run_until(&schedule, 6 * 160);
    adapter_baud(&adapter, 400000); // before the answer
    schedule_run_until(&schedule, CLOCK / 10);
    TEST_ASSERT_TRUE(heard_count > 0 && heard_count < 6);
    TEST_ASSERT_NOT_EQUAL(0xFF, heard[0]);
}

void test_bytes_keep_the_rate_that_held_when_they_were_given(void)
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

void test_a_line_that_was_hung_up_keeps_its_rate(void)
{
    adapter_baud(&adapter, 0);
    adapter_send(&adapter, 0, ping, 1);
    TEST_ASSERT_EQUAL_UINT64(160, adapter_end(&adapter));
}

void test_there_is_room_for_4096_bytes_and_no_more(void)
{
    static const uint8_t much[5000] = {0x55};
    TEST_ASSERT_EQUAL_UINT(ADAPTER_SIZE, adapter_space(&adapter));
    adapter_send(&adapter, 0, much, sizeof(much));
    TEST_ASSERT_EQUAL_UINT(1, adapter_space(&adapter)); // one is on its way
    schedule_run_until(&schedule, 10 * CLOCK);
    TEST_ASSERT_EQUAL_UINT(ADAPTER_SIZE, seen_count);
    TEST_ASSERT_EQUAL_UINT(ADAPTER_SIZE, adapter_space(&adapter));
    TEST_ASSERT_EQUAL_UINT(1, times_driving);
}

void test_on_two_wires_it_hears_while_it_talks(void)
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
    adapter.on_byte = 0; // it hears the other one
    adapter_send(&two, 0, ping, sizeof(ping));
    uart_tx_send(&tx, 80, 16 * 256, 0xA5);
    schedule_run_until(&schedule, 235);
    TEST_ASSERT_EQUAL_UINT(1, heard_count);
    TEST_ASSERT_EQUAL_HEX8(0xA5, heard[0]);
    TEST_ASSERT_TRUE(two.driver.enabled);
}
