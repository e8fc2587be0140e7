/* SPDX-License-Identifier: MIT */
/* The line while nothing of ours is on it: nothing is sent into one that others use, it recovers by
 * itself, and what nobody waits for is told apart. F9, F10, F15. */
#include "cds55xx/bus.h"

#include <string.h>

#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

#define PORT            1
#define QUIET_US        20 // two byte times at 1 Mbps
#define WAIT_US         (56 * 10 + 508 + 100)
#define LONGEST_REST_US (CDS_STALE_REPLY_US - CDS_REPLY_MARGIN_US - CDS_RETURN_DELAY_MAX_US)
#define REST_US         (CDS_STALE_REPLY_US - CDS_REPLY_MARGIN_US - 2) // a return delay of 2 us was told

static struct cds_queue queue;
static uint8_t buffer[CDS_PACKET_SIZE(2)], other_buffer[CDS_PACKET_SIZE(2)];
static uint8_t urgent_buffer[CDS_PACKET_SIZE(0)];
static uint8_t reply[CDS_REPLY_MAX], other_reply[8];
static struct cds_request request, other, urgent;

void setUp(void)
{
    rig_open_with_queue(PORT, &queue);
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    other = (struct cds_request)CDS_REQUEST(other_buffer, other_reply);
    urgent = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(urgent_buffer);
}

void tearDown(void)
{
    rig_check();
}

static void noise(void)
{
    static const uint8_t byte = 0x55;

    port_fake_hear(&bus.link, &byte, 1);
}

/* As many polls as all that has come takes; the clock stands still. */
static void polls_at(uint32_t after_us)
{
    port_fake.now_us += after_us;
    for (uint8_t i = 0; i < 8; i++)
        cds_bus_poll(&bus);
}

/* The packet leaves after `us`, and not a microsecond sooner. */
static void assert_leaves_after_us(uint16_t us)
{
    rig_poll_after(us - 1u);
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(1);
    TEST_ASSERT_TRUE(rig_is_sending());
}

static void assert_answered(struct cds_request *asked, uint8_t id)
{
    TEST_ASSERT_TRUE(rig_is_sending());
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_answer(&bus.link, id, 0, NULL, 0);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, asked->result);
}

/* Asks servo `id` and gives it up. */
static void give_up(uint8_t id)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, id));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    polls_at(2000);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

void test_line_is_suspect_for_two_byte_times_after_a_byte(void)
{
    noise();
    rig_poll_after(0);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_leaves_after_us(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
    assert_answered(&request, 5);
}

void test_part_of_a_packet_does_not_keep_the_line_suspect(void)
{
    static const uint8_t part[] = {0xFF, 0xFF, 9, 4, 0, 1};

    port_fake_hear(&bus.link, part, sizeof part);
    polls_at(0);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
}

void test_every_byte_begins_the_silence_anew(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    for (uint8_t i = 0; i < 20; i++) {
        rig_poll_after(QUIET_US - 1);
        noise();
        rig_poll_after(QUIET_US - 1);
        TEST_ASSERT_FALSE(rig_is_sending());
    }
    rig_poll_after(QUIET_US);
    assert_answered(&request, 5);
}

void test_babbling_line_ends_the_request_unsent(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    assert_answered(&other, 6);
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    rig_poll_after(0); // the time to wait begins
    for (uint16_t us = 10; us <= WAIT_US; us += 10) {
        noise();
        rig_poll_after(10);
        TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    }
    noise();
    rig_poll_after(10);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, request.result);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().line_busy);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().sent);
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(0); // examines the last byte
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_answered(&request, 5);
}

/* A look at a line in use behind that time, and the last look two byte times later. */
static void poll_while_used(uint16_t us)
{
    rig_poll_after(0); // the time to wait begins
    noise();
    rig_poll_after(us - QUIET_US);
    noise();
    rig_poll_after(QUIET_US);
}

void test_each_of_several_requests_waits_for_itself(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    poll_while_used(WAIT_US);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, request.result);
    TEST_ASSERT_EQUAL(CDS_PENDING, other.result);
    poll_while_used(WAIT_US);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, other.result);
    TEST_ASSERT_NULL(bus.request);
}

void test_damaged_byte_makes_the_line_suspect(void)
{
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    rig_poll_after(0);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
}

void test_nothing_is_sent_while_the_line_is_low(void)
{
    port_fake.low = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_FALSE(rig_is_sending());
    port_fake.low = false; // a bit of somebody's byte
    assert_leaves_after_us(QUIET_US);
    assert_answered(&request, 5);
}

/* Another station's byte, of which one look meets a low bit and all later ones high bits. */
void test_one_low_look_at_submit_delays_the_packet(void)
{
    port_fake.low_looks = 1;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_FALSE(rig_is_sending());
    assert_leaves_after_us(QUIET_US);
    assert_answered(&request, 5);
}

void test_one_low_look_while_a_request_waits_delays_it(void)
{
    port_fake.low_looks = 1;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    rig_poll_after(QUIET_US - 1);
    port_fake.low_looks = 2; // the poll's first look at a line found quiet, then the last one
    rig_poll_after(1);
    TEST_ASSERT_FALSE(rig_is_sending());
    for (uint8_t us = 1; us < QUIET_US; us++) {
        rig_poll_after(1);
        TEST_ASSERT_FALSE(rig_is_sending());
    }
    rig_poll_after(QUIET_US);
    assert_answered(&request, 5);
}

/* A byte of another station is seen low just before two byte times are over. */
void test_low_look_within_two_byte_times_delays_the_packet(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    rig_poll_after(0);
    port_fake.low_looks = 1;
    rig_poll_after(QUIET_US - 1);
    for (uint8_t us = 0; us < QUIET_US; us++) {
        rig_poll_after(1);
        TEST_ASSERT_FALSE(rig_is_sending());
    }
    rig_poll_after(1);
    assert_answered(&request, 5);
}

void test_a_line_low_for_longer_than_a_byte_is_a_fault(void)
{
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING); // all that is ever heard of it
    port_fake.low = true;
    rig_poll_after(0);
    rig_poll_after(QUIET_US - 1);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    rig_poll_after(1);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_FAULT, cds_bus_line(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    rig_poll_after(0);
    rig_poll_after(WAIT_US - QUIET_US);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, request.result);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_FAULT, cds_bus_line(&bus));
}

void test_a_released_line_recovers_by_itself(void)
{
    port_fake.low = true;
    rig_poll_after(0);
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_FAULT, cds_bus_line(&bus));
    rig_poll_after(100000);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_FAULT, cds_bus_line(&bus)); // as long as it lasts
    port_fake.low = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
    assert_answered(&request, 5);
}

void test_bytes_after_a_fault_make_the_line_suspect(void)
{
    port_fake.low = true;
    rig_poll_after(0);
    rig_poll_after(QUIET_US);
    port_fake.low = false;
    noise();
    rig_poll_after(1);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
}

void test_silence_is_measured_across_the_clocks_wrap(void)
{
    port_fake.now_us = UINT32_MAX - 5;
    noise();
    rig_poll_after(0);
    rig_poll_after(QUIET_US - 1);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    rig_poll_after(1);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
}

void test_two_byte_times_are_the_bus_s_own(void)
{
    cds_bus_open(&bus, PORT, 103);
    noise();
    rig_poll_after(0);
    rig_poll_after(1039);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    rig_poll_after(1);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
}

void test_damaged_reply_delays_the_next_packet(void)
{
    static const uint8_t half[] = {0xFF, 0xFF, 0x05, 0x02, 0x00, 0x00};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_hear(&bus.link, half, sizeof half);
    port_fake_look(&bus);
    polls_at(2000);
    TEST_ASSERT_EQUAL(CDS_CORRUPT, request.result);
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(LONGEST_REST_US - 1); // more than two byte times
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(1);
    assert_answered(&other, 6);
}

/* Goals of a cycle do not overtake: their next ones would come before the wait is over. */
void test_only_torque_off_overtakes_a_request_that_waits_for_silence(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    other.priority = CDS_PRIORITY_HIGH;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    urgent.priority = CDS_PRIORITY_TORQUE_OFF;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &urgent, 7));
    rig_poll_after(0);
    rig_poll_after(QUIET_US);
    assert_answered(&urgent, 7);
    assert_answered(&other, 6);
    assert_answered(&request, 5);
}

/* The time that another has waited so far is not taken from its time. */
void test_torque_off_that_overtakes_waits_its_full_time(void)
{
    port_fake.low = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    rig_poll_after(0);
    port_fake.now_us += WAIT_US;
    other.priority = CDS_PRIORITY_TORQUE_OFF;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    rig_poll_after(0);
    rig_poll_after(WAIT_US - QUIET_US);
    rig_poll_after(QUIET_US - 1);
    TEST_ASSERT_EQUAL(CDS_PENDING, other.result);
    rig_poll_after(1);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, other.result);
}

/* Goals come each millisecond, sooner than a wait is over. */
void test_goals_do_not_begin_the_wait_of_another_again(void)
{
    port_fake.low = true;
    other.priority = CDS_PRIORITY_HIGH;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    for (uint8_t ms = 0; ms < 6; ms++) {
        if (other.result != CDS_PENDING)
            TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
        rig_poll_after(500);
        rig_poll_after(QUIET_US);
        rig_poll_after(500 - QUIET_US);
    }
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, request.result);
}

/* A fault ends during the rest after a failure, and the line is low again 30 us later. `is_quiet`:
 * a poll finds it high for two byte times meanwhile. */
static void wait_for_a_line_low_again(bool is_quiet)
{
    setUp();
    give_up(5);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6)); // rests
    port_fake.low = true;
    rig_poll_after(0);
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_FAULT, cds_bus_line(&bus));
    rig_poll_after(200);
    port_fake.low = false;
    rig_poll_after(is_quiet ? QUIET_US : QUIET_US - 1);
    port_fake.low = true;
    rig_poll_after(is_quiet ? 10 : 11);
    rig_poll_after(0);
}

void test_wait_for_the_line_begins_anew_after_a_quiet_rest(void)
{
    wait_for_a_line_low_again(true);
    rig_poll_after(WAIT_US - QUIET_US - 1);
    rig_poll_after(1); // the last look begins
    rig_poll_after(QUIET_US - 1);
    TEST_ASSERT_EQUAL(CDS_PENDING, other.result);
    rig_poll_after(1);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, other.result);
}

void test_wait_for_the_line_goes_on_after_a_short_silence(void)
{
    wait_for_a_line_low_again(false);
    rig_poll_after(WAIT_US - QUIET_US - 250); // the last look begins
    rig_poll_after(QUIET_US - 1);
    TEST_ASSERT_EQUAL(CDS_PENDING, other.result);
    rig_poll_after(1);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, other.result);
}

/* The main loop was away until the time to wait was over; the line has been silent since. */
void test_a_late_poll_that_finds_silence_sends(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    rig_poll_after(0);
    rig_poll_after(5000);
    TEST_ASSERT_TRUE(rig_is_sending());
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    assert_answered(&request, 5);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().line_busy);
}

void test_cancel_of_a_request_that_waits_for_silence(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_CANCELLED, request.result);
    TEST_ASSERT_EQUAL(CDS_BUS_IDLE, bus.state);
    rig_poll_after(QUIET_US);
    TEST_ASSERT_FALSE(rig_is_sending());
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().sent);
}

void test_reply_after_a_timeout_is_stale(void)
{
    give_up(5);
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    polls_at(0);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().stale_replies);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().duplicate_replies);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().unexpected_packets);
}

void test_reply_cut_by_the_deadline_is_stale(void)
{
    static const uint8_t pong[] = {0xFF, 0xFF, 0x05, 0x02, 0x00, 0xF8};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_hear(&bus.link, pong, 4);
    polls_at(2000);
    port_fake_hear(&bus.link, pong + 4, 2);
    polls_at(1);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().stale_replies);
}

void test_unasked_packet_longer_than_the_last_reply_is_found(void)
{
    static const uint8_t data[2] = {1, 2};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_answered(&request, 5);
    port_fake_answer(&bus.link, 6, 0, data, sizeof data);
    polls_at(0);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().malformed);
}

void test_second_reply_is_a_duplicate(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_answered(&request, 5);
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    polls_at(1);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().duplicate_replies);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().stale_replies);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().unexpected_packets);
}

void test_second_reply_before_a_queued_packet_is_a_duplicate(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_FALSE(rig_is_sending());
    polls_at(0);
    TEST_ASSERT_FALSE(rig_is_sending());
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().duplicate_replies);
    rig_poll_after(QUIET_US);
    assert_answered(&other, 6);
}

/* Two servos have the ID, and the header of the second answer fell on the end of the first. */
void test_second_reply_without_its_header_is_noise(void)
{
    static const uint8_t rest[] = {0xFF, 0x05, 0x02, 0x00, 0xF8};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_answered(&request, 5);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().noise_bytes);
    port_fake_hear(&bus.link, rest, sizeof rest);
    rig_poll_after(1);
    TEST_ASSERT_EQUAL_UINT16(4, rig_stats().noise_bytes);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().duplicate_replies);
}

void test_second_reply_to_a_broadcast_ping_is_a_duplicate(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, CDS_BROADCAST_ID));
    assert_answered(&request, 7);
    port_fake_answer(&bus.link, 9, 0, NULL, 0);
    polls_at(1);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().duplicate_replies);
}

void test_packet_of_another_servo_is_unexpected(void)
{
    give_up(5);
    port_fake_answer(&bus.link, 6, 0, NULL, 0);
    polls_at(1);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().stale_replies);
}

void test_stale_reply_amid_the_next_transaction_is_stale(void)
{
    give_up(5);
    rig_poll_after(LONGEST_REST_US);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    port_fake_answer(&bus.link, 6, 0, NULL, 0);
    port_fake_look(&bus);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, other.result);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().stale_replies);
}

static void read_word(struct cds_request *asked, uint8_t id, uint8_t address)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, asked, id, address, 2));
}

/* Polls every 5 us until `until_us`; what the bus sends meanwhile leaves at once. */
static void run_until(uint32_t until_us)
{
    while ((int32_t)(until_us - port_fake.now_us) > 0) {
        rig_poll_after(5);
        if (rig_is_sending())
            TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    }
}

static void run_until_ended(const struct cds_request *asked)
{
    while (asked->result == CDS_PENDING)
        run_until(port_fake.now_us + 5);
}

/* The reply of servo 1 to its first READ of a word, which was sent at 0 us, begins `begins_us`
 * behind the end of that READ. `request` is a later READ of a word of servo 1. */
static void assert_stale_word_is_not_taken(uint16_t begins_us)
{
    static const uint8_t stale[] = {0xFF, 0xFF, 0x01, 0x04, 0x00, 0x11, 0x11, 0xD8};

    for (uint8_t i = 0; i < sizeof stale; i++) {
        run_until(80u + begins_us + 10u * (i + 1u));
        port_fake_hear(&bus.link, &stale[i], 1);
    }
    run_until(port_fake.now_us + 30);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().stale_replies + rig_stats().unexpected_packets);
}

void test_stale_reply_of_an_earlier_servo_is_not_taken(void)
{
    for (uint16_t us = 120; us <= CDS_RETURN_DELAY_MAX_US; us++) {
        setUp();
        cds_bus_set_return_delay(&bus, 2);
        read_word(&request, 1, CDS_REG_PRESENT_POSITION);
        read_word(&other, 2, CDS_REG_PRESENT_POSITION);
        run_until_ended(&request);
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
        read_word(&request, 1, CDS_REG_PRESENT_VOLTAGE);
        assert_stale_word_is_not_taken(us);
    }
}

void test_stale_reply_within_2_ms_is_not_taken(void)
{
    for (uint16_t us = 630; us <= CDS_STALE_REPLY_US; us++) {
        setUp();
        read_word(&request, 1, CDS_REG_GOAL_POSITION);
        run_until_ended(&request);
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
        read_word(&request, 1, CDS_REG_PRESENT_VOLTAGE);
        assert_stale_word_is_not_taken(us);
    }
}

/* With a return delay of 2 us told, an answer up to 506 us after the deadline could pass for the
 * next one's. */
static void give_up_early(uint16_t told_us)
{
    cds_bus_set_return_delay(&bus, told_us);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    polls_at(12 * 10 + told_us + 100u);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

/* Whichever servo is asked: the next request is sent REST_US behind the deadline, not sooner. */
static void assert_rests(uint8_t id, uint16_t told_us, uint16_t rest_us)
{
    give_up_early(told_us);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, id));
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(rest_us - 1u);
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(1);
    assert_answered(&other, id == CDS_BROADCAST_ID ? 7 : id);
}

void test_rest_after_a_timeout_holds_for_every_id(void)
{
    assert_rests(5, 2, REST_US);
    assert_rests(6, 2, REST_US);
    assert_rests(CDS_BROADCAST_ID, 2, REST_US);
}

/* But never shorter than two byte times, as behind every failure. */
void test_rest_is_shorter_after_a_longer_return_delay(void)
{
    assert_rests(6, 508, REST_US + 2 - 508);
    assert_rests(6, CDS_STALE_REPLY_US - CDS_REPLY_MARGIN_US - 1, QUIET_US);
    assert_rests(6, CDS_STALE_REPLY_US - CDS_REPLY_MARGIN_US, QUIET_US);
    assert_rests(6, CDS_STALE_REPLY_US + 1000, QUIET_US);
}

void test_rest_does_not_end_with_a_stale_reply(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    rig_poll_after(500);
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    polls_at(0);
    rig_poll_after(REST_US - 501);
    TEST_ASSERT_FALSE(rig_is_sending());
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    rig_poll_after(QUIET_US);
    assert_answered(&request, 5);
}

/* The longest wait for a quiet line is counted from the end of the rest. */
void test_rest_is_not_taken_from_the_wait_for_a_quiet_line(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    for (uint16_t us = 0; us < REST_US - 10; us += 10)
        rig_poll_after(10);
    for (uint16_t us = 0; us < WAIT_US - 40; us += 10) {
        noise();
        rig_poll_after(10);
        TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    }
    rig_poll_after(QUIET_US);
    assert_answered(&request, 5);
}

void test_packets_without_reply_are_sent_in_the_rest(void)
{
    give_up_early(2);
    other.priority = CDS_PRIORITY_HIGH;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &other, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_leaves_after_us(QUIET_US);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    polls_at(100);
    TEST_ASSERT_EQUAL(CDS_OK, other.result);
    rig_poll_after(REST_US - 101 - QUIET_US);
    TEST_ASSERT_FALSE(rig_is_sending()); // and the rest goes on
    rig_poll_after(1);
    assert_answered(&request, 5);
}

/* One look meets a low bit of another station's byte. */
void test_low_line_in_the_rest_delays_packets_without_reply(void)
{
    give_up_early(2);
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
    TEST_ASSERT_TRUE(cds_bus_is_resting(&bus));
    port_fake.low_looks = 1;
    rig_poll_after(1);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    assert_leaves_after_us(QUIET_US);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
}

/* A line that is low in the rest does not end it. */
void test_fault_in_the_rest_does_not_shorten_it(void)
{
    give_up_early(2);
    port_fake.low = true;
    rig_poll_after(1000);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_FAULT, cds_bus_line(&bus));
    rig_poll_after(1);
    port_fake.low = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    for (uint16_t us = 1001; us < REST_US - 10; us += 10) {
        rig_poll_after(10);
        TEST_ASSERT_FALSE(rig_is_sending());
    }
    rig_poll_after(10);
    rig_poll_after(QUIET_US);
    assert_answered(&request, 5);
}

void test_request_that_ignores_stale_is_sent_after_two_byte_times(void)
{
    give_up_early(2);
    request.ignores_stale = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 6));
    rig_poll_after(QUIET_US);
    assert_answered(&request, 6);
    request.ignores_stale = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 6));
    TEST_ASSERT_FALSE(rig_is_sending());
}

void test_rest_is_over_half_an_hour_later(void)
{
    give_up_early(2);
    rig_poll_after(REST_US);
    rig_poll_after(0x80000000u);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(rig_is_sending());
}

/* A program that blocks polls while it waits, and never else. */
void test_rest_is_over_half_an_hour_later_without_polls(void)
{
    give_up_early(2);
    rig_poll_after(0x80000000u + 1000);
    TEST_ASSERT_FALSE(cds_bus_is_resting(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(rig_is_sending());
}

void test_rest_does_not_begin_anew_when_the_clock_wraps(void)
{
    give_up_early(2);
    rig_poll_after(REST_US);
    port_fake.now_us -= 300;
    TEST_ASSERT_FALSE(cds_bus_is_resting(&bus));
}

void test_failure_of_a_broadcast_does_not_begin_a_stale_rest(void)
{
    cds_bus_set_return_delay(&bus, 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    rig_poll_after(0);
    polls_at(1000);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    rig_poll_after(QUIET_US);
    TEST_ASSERT_TRUE(rig_is_sending());
}

void test_return_delay_is_kept_by_a_packet_on_the_wire(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    cds_bus_set_return_delay(&bus, 2);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    rig_poll_after(12 * 10 + 508 + 99);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    polls_at(1);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

void test_corrupt_reply_is_followed_by_two_byte_times(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    polls_at(2000);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_CORRUPT, request.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    assert_leaves_after_us(QUIET_US);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
}

static void open_again(void)
{
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
}

/* What was asked before may be answered yet. */
void test_open_again_rests_for_2_ms(void)
{
    give_up_early(2);
    open_again();
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, CDS_BAUD_1M));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_leaves_after_us(CDS_STALE_REPLY_US);
    assert_answered(&request, 5);
}

void test_open_again_sends_packets_without_reply_after_20_us(void)
{
    open_again();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    assert_leaves_after_us(QUIET_US);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
}

/* The rate may be set back before the stale reply comes. */
void test_rest_goes_on_at_another_rate(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, 3));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, CDS_BAUD_1M));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_leaves_after_us(REST_US);
    assert_answered(&request, 5);
}

void test_open_again_amid_a_transaction_rests(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    open_again();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(CDS_STALE_REPLY_US);
    assert_answered(&request, 5);
}

/* ---- a main loop that turns seldom ---- */

#define WRAP_US ((uint32_t)32768) // of 16 bits of half microseconds

/* Gaps between two turns of a main loop: a little less and more than one, two and 30 wraps of a
 * 16-bit time, 30 turns a second, seconds. */
static uint32_t gap_us(uint16_t index)
{
    static const uint32_t long_us[] = {3000, 5000, 33333, 40000, 1000000, 5000000, 4000000000ul};
    static const uint8_t wraps[] = {1, 2, 30};
    uint16_t first = sizeof long_us / sizeof *long_us;

    if (index < first)
        return long_us[index];
    index = (uint16_t)(index - first);
    return WRAP_US * wraps[index % 3] - 50 + index / 3 * (uint32_t)7;
}

#define GAPS (7 + 3 * 440) // up to 3 ms behind each wrap

/* Each turn polls `polls` times, 3 us apart. The request is sent within three turns. */
static void assert_sent_on_a_silent_line(uint32_t us, uint8_t polls)
{
    for (uint8_t turn = 0; turn < 3 && !rig_is_sending(); turn++) {
        rig_poll_after(us);
        for (uint8_t i = 1; i < polls; i++)
            rig_poll_after(3);
    }
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    TEST_ASSERT_TRUE(rig_is_sending());
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().line_busy);
}

void test_late_polls_send_after_the_bus_is_opened_again(void)
{
    for (uint16_t i = 0; i < GAPS; i++) {
        setUp();
        open_again();
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
        assert_sent_on_a_silent_line(gap_us(i), 1);
    }
}

void test_late_polls_send_after_noise(void)
{
    static const uint8_t bauds[] = {CDS_BAUD_1M, 34, CDS_BAUD_MAX};

    for (uint16_t i = 0; i < GAPS * 3; i++) {
        setUp();
        TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, bauds[i % 3]));
        cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
        rig_poll_after(0);
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
        assert_sent_on_a_silent_line(gap_us(i / 3), 1);
    }
}

void test_late_polls_send_after_a_timeout(void)
{
    for (uint16_t i = 0; i < GAPS; i++) {
        setUp();
        give_up_early(2);
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
        assert_sent_on_a_silent_line(gap_us(i), 1);
    }
}

/* The line was in use between two turns. When, the bus cannot know. */
void test_late_polls_send_after_a_stale_reply(void)
{
    for (uint8_t polls = 1; polls <= 8; polls++) {
        for (uint16_t i = 0; i < GAPS; i += 3) {
            setUp();
            give_up_early(2);
            TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
            port_fake_answer(&bus.link, 5, 0, NULL, 0);
            assert_sent_on_a_silent_line(gap_us(i), polls);
        }
    }
}

void test_late_polls_find_a_silent_line_quiet(void)
{
    for (uint16_t i = 0; i < GAPS; i++) {
        setUp();
        noise();
        rig_poll_after(0);
        rig_poll_after(gap_us(i));
        TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
    }
}

/* 258 bytes at 7843 bit/s: 329 ms, ten wraps of a 16-bit time. The transmitter has stopped. */
void test_late_polls_end_a_long_transaction_by_its_deadline(void)
{
    static uint8_t bytes[CDS_PACKET_SIZE(CDS_LENGTH_MAX - CDS_LENGTH_MIN)];
    struct cds_request longest = CDS_REQUEST_WITHOUT_DATA(bytes);

    for (uint32_t us = 400000; us < 440000; us += 1111) {
        setUp();
        TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, CDS_BAUD_MAX));
        longest.reply_parameters = CDS_REPLY_NONE;
        longest.result = CDS_OK;
        cds_packet_begin(&longest.packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
        for (uint8_t i = 0; i < CDS_LENGTH_MAX - CDS_LENGTH_MIN; i++)
            cds_packet_put(&longest.packet, 0);
        TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&longest.packet));
        TEST_ASSERT_EQUAL_UINT16(sizeof bytes, longest.packet.size);
        TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &longest));
        rig_poll_after(0);
        rig_poll_after(us);
        rig_poll_after(us);
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, longest.result);
    }
}
