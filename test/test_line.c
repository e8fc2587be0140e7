/* The line while nothing of ours is on it: nothing is sent into one that others use, it recovers by
 * itself, and what nobody waits for is told apart. F9, F10, F15. */
#include "cds55xx/bus.h"

#include <string.h>

#include "cds55xx/servo.h"
#include "port_fake.h"
#include "unity.h"

#define PORT     1
#define QUIET_US 20 // two byte times at 1 Mbps
#define WAIT_US  (56 * 10 + 508 + 100)

static struct cds_bus bus;
static uint8_t buffer[CDS_PACKET_SIZE(CDS_REPLY_MAX)], other_buffer[CDS_PACKET_SIZE(8)];
static struct cds_request request, other;

void setUp(void)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    request = (struct cds_request)CDS_REQUEST(buffer);
    other = (struct cds_request)CDS_REQUEST(other_buffer);
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    cds_bus_set_queue(&bus, true);
    port_fake_forget();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static struct cds_counters counters(void)
{
    struct cds_counters count;

    cds_bus_counters(&bus, &count);
    return count;
}

static void noise(void)
{
    static const uint8_t byte = 0x55;

    port_fake_hear(&bus.link, &byte, 1);
}

static void poll_at(uint32_t after_us)
{
    port_fake.now_us += after_us;
    cds_bus_poll(&bus);
}

static bool is_sent(void)
{
    return port_fake.lines[PORT] == FAKE_TALK;
}

static void assert_answered(struct cds_request *asked, uint8_t id)
{
    TEST_ASSERT_TRUE(is_sent());
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_answer(&bus.link, id, 0, NULL, 0);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, asked->result);
}

/* Asks servo `id` and gives it up. */
static void give_up(uint8_t id)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, id));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    poll_at(2000);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

void test_a_line_heard_from_is_busy_until_two_byte_times_are_silent(void)
{
    noise();
    poll_at(0);
    TEST_ASSERT_EQUAL(CDS_BUS_BUSY, cds_bus_state(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    poll_at(QUIET_US - 1);
    TEST_ASSERT_FALSE(is_sent());
    poll_at(1);
    TEST_ASSERT_EQUAL(CDS_BUS_OK, cds_bus_state(&bus));
    assert_answered(&request, 5);
}

void test_part_of_a_packet_does_not_keep_the_line_busy(void)
{
    static const uint8_t part[] = {0xFF, 0xFF, 9, 4, 0, 1};

    port_fake_hear(&bus.link, part, sizeof part);
    poll_at(0);
    TEST_ASSERT_EQUAL(CDS_BUS_BUSY, cds_bus_state(&bus));
    poll_at(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_OK, cds_bus_state(&bus));
}

void test_every_byte_begins_the_silence_anew(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    for (uint8_t i = 0; i < 20; i++) {
        poll_at(QUIET_US - 1);
        noise();
        poll_at(QUIET_US - 1);
        TEST_ASSERT_FALSE(is_sent());
    }
    poll_at(QUIET_US);
    assert_answered(&request, 5);
}

void test_a_line_that_babbles_on_ends_the_request_unsent(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    assert_answered(&other, 6);
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    for (uint16_t us = 10; us < WAIT_US; us += 10) {
        noise();
        poll_at(10);
        TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    }
    noise();
    poll_at(10);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, request.result);
    TEST_ASSERT_EQUAL(CDS_BUS_BUSY, cds_bus_state(&bus));
    TEST_ASSERT_EQUAL_UINT16(1, counters().unsent);
    TEST_ASSERT_EQUAL_UINT16(1, counters().sent);
    TEST_ASSERT_FALSE(is_sent());
    poll_at(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_answered(&request, 5);
}

void test_each_of_several_requests_waits_for_itself(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    noise();
    poll_at(WAIT_US);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, request.result);
    TEST_ASSERT_EQUAL(CDS_PENDING, other.result);
    noise();
    poll_at(WAIT_US);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, other.result);
    TEST_ASSERT_NULL(bus.request);
}

void test_a_damaged_byte_makes_the_line_busy_too(void)
{
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    poll_at(0);
    TEST_ASSERT_EQUAL(CDS_BUS_BUSY, cds_bus_state(&bus));
    poll_at(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_OK, cds_bus_state(&bus));
}

void test_nothing_is_sent_while_the_line_is_low(void)
{
    port_fake.low = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_FALSE(is_sent());
    port_fake.low = false; // a bit of somebody's byte
    poll_at(QUIET_US - 1);
    TEST_ASSERT_FALSE(is_sent());
    poll_at(1);
    assert_answered(&request, 5);
}

void test_a_line_low_for_longer_than_a_byte_is_a_fault(void)
{
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING); // all that is ever heard of it
    port_fake.low = true;
    poll_at(0);
    poll_at(QUIET_US - 1);
    TEST_ASSERT_EQUAL(CDS_BUS_BUSY, cds_bus_state(&bus));
    poll_at(1);
    TEST_ASSERT_EQUAL(CDS_BUS_FAULT, cds_bus_state(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    poll_at(WAIT_US);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, request.result);
    TEST_ASSERT_EQUAL(CDS_BUS_FAULT, cds_bus_state(&bus));
}

void test_a_released_line_recovers_by_itself(void)
{
    port_fake.low = true;
    poll_at(0);
    poll_at(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_FAULT, cds_bus_state(&bus));
    poll_at(100000);
    TEST_ASSERT_EQUAL(CDS_BUS_FAULT, cds_bus_state(&bus)); // as long as it lasts
    port_fake.low = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_FALSE(is_sent());
    poll_at(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_BUS_OK, cds_bus_state(&bus));
    assert_answered(&request, 5);
}

void test_babble_after_a_fault_is_busy(void)
{
    port_fake.low = true;
    poll_at(0);
    poll_at(QUIET_US);
    port_fake.low = false;
    noise();
    poll_at(1);
    TEST_ASSERT_EQUAL(CDS_BUS_BUSY, cds_bus_state(&bus));
}

void test_silence_is_measured_across_the_clocks_wrap(void)
{
    port_fake.now_us = UINT32_MAX - 5;
    noise();
    poll_at(0);
    poll_at(QUIET_US - 1);
    TEST_ASSERT_EQUAL(CDS_BUS_BUSY, cds_bus_state(&bus));
    poll_at(1);
    TEST_ASSERT_EQUAL(CDS_BUS_OK, cds_bus_state(&bus));
}

void test_two_byte_times_are_the_bus_s_own(void)
{
    cds_bus_open(&bus, PORT, 103);
    cds_bus_set_queue(&bus, true);
    noise();
    poll_at(0);
    poll_at(1039);
    TEST_ASSERT_EQUAL(CDS_BUS_BUSY, cds_bus_state(&bus));
    poll_at(1);
    TEST_ASSERT_EQUAL(CDS_BUS_OK, cds_bus_state(&bus));
}

void test_damage_must_be_followed_by_silence_before_the_next_packet(void)
{
    static const uint8_t half[] = {0xFF, 0xFF, 0x05, 0x02, 0x00, 0x00};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_hear(&bus.link, half, sizeof half);
    port_fake_look(&bus);
    poll_at(2000);
    TEST_ASSERT_EQUAL(CDS_CORRUPT, request.result);
    TEST_ASSERT_FALSE(is_sent());
    poll_at(QUIET_US);
    assert_answered(&other, 6);
}

void test_an_urgent_request_overtakes_one_that_waits_for_silence(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    other.urgent = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    poll_at(QUIET_US);
    assert_answered(&other, 6);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    assert_answered(&request, 5);
}

/* What another has waited so far is not taken from its time. */
void test_an_urgent_request_that_overtakes_one_has_all_its_time_to_wait(void)
{
    port_fake.low = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    port_fake.now_us += WAIT_US;
    other.urgent = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    poll_at(WAIT_US - 1);
    TEST_ASSERT_EQUAL(CDS_PENDING, other.result);
    poll_at(1);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, other.result);
}

/* The main loop was away until the time to wait was over; the line has been silent since. */
void test_a_late_poll_that_finds_silence_sends(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    poll_at(5000);
    TEST_ASSERT_TRUE(is_sent());
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    assert_answered(&request, 5);
    TEST_ASSERT_EQUAL_UINT16(0, counters().unsent);
}

void test_one_that_waits_for_silence_can_be_taken_back(void)
{
    noise();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_CANCELLED, request.result);
    TEST_ASSERT_EQUAL(CDS_BUS_IDLE, bus.flight);
    poll_at(QUIET_US);
    TEST_ASSERT_FALSE(is_sent());
    TEST_ASSERT_EQUAL_UINT16(0, counters().sent);
}

void test_the_answer_of_a_servo_given_up_is_late(void)
{
    give_up(5);
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    poll_at(0);
    TEST_ASSERT_EQUAL_UINT16(1, counters().late);
    TEST_ASSERT_EQUAL_UINT16(0, counters().extra);
    TEST_ASSERT_EQUAL_UINT16(0, counters().foreign);
}

void test_half_an_answer_by_the_deadline_and_the_rest_of_it_are_late(void)
{
    static const uint8_t pong[] = {0xFF, 0xFF, 0x05, 0x02, 0x00, 0xF8};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_hear(&bus.link, pong, 4);
    poll_at(2000);
    port_fake_hear(&bus.link, pong + 4, 2);
    poll_at(1);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
    TEST_ASSERT_EQUAL_UINT16(1, counters().late);
}

void test_a_packet_longer_than_the_last_reply_due_is_found_all_the_same(void)
{
    static const uint8_t data[2] = {1, 2};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_answered(&request, 5);
    port_fake_answer(&bus.link, 6, 0, data, sizeof data);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL_UINT16(1, counters().foreign);
    TEST_ASSERT_EQUAL_UINT16(0, counters().refuted);
}

void test_a_second_answer_is_extra(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_answered(&request, 5);
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    poll_at(1);
    TEST_ASSERT_EQUAL_UINT16(1, counters().extra);
    TEST_ASSERT_EQUAL_UINT16(0, counters().late);
    TEST_ASSERT_EQUAL_UINT16(0, counters().foreign);
}

void test_a_second_answer_before_the_next_packet_is_extra_too(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_FALSE(is_sent());
    cds_bus_poll(&bus); // a poll for each
    TEST_ASSERT_FALSE(is_sent());
    TEST_ASSERT_EQUAL_UINT16(1, counters().extra);
    poll_at(QUIET_US);
    assert_answered(&other, 6);
}

/* Two servos have the ID, and the header of the second answer fell on the end of the first. */
void test_a_second_answer_without_its_header_is_stray(void)
{
    static const uint8_t rest[] = {0xFF, 0x05, 0x02, 0x00, 0xF8};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    assert_answered(&request, 5);
    TEST_ASSERT_EQUAL_UINT16(0, counters().stray);
    port_fake_hear(&bus.link, rest, sizeof rest);
    poll_at(1);
    TEST_ASSERT_EQUAL_UINT16(4, counters().stray);
    TEST_ASSERT_EQUAL_UINT16(0, counters().extra);
}

void test_who_answers_a_broadcast_ping_second_is_extra(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, CDS_BROADCAST_ID));
    assert_answered(&request, 7);
    port_fake_answer(&bus.link, 9, 0, NULL, 0);
    poll_at(1);
    TEST_ASSERT_EQUAL_UINT16(1, counters().extra);
}

void test_a_packet_of_another_servo_is_foreign(void)
{
    give_up(5);
    port_fake_answer(&bus.link, 6, 0, NULL, 0);
    poll_at(1);
    TEST_ASSERT_EQUAL_UINT16(1, counters().foreign);
    TEST_ASSERT_EQUAL_UINT16(0, counters().late);
}

void test_a_late_answer_amid_another_exchange_is_late(void)
{
    give_up(5);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    port_fake_answer(&bus.link, 6, 0, NULL, 0);
    port_fake_look(&bus);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, other.result);
    TEST_ASSERT_EQUAL_UINT16(1, counters().late);
}

/* With a return delay of 2 us told, an answer up to 506 us after the deadline could pass for the
 * next one's. */
static void give_up_early(uint16_t told_us)
{
    cds_bus_set_return_delay(&bus, told_us);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    poll_at(12 * 10 + 2 + 100);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

void test_a_servo_given_up_early_is_not_asked_again_before_it_must_be_silent(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    poll_at(505);
    TEST_ASSERT_FALSE(is_sent());
    poll_at(1);
    assert_answered(&request, 5);
}

void test_others_are_asked_meanwhile(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    assert_answered(&other, 6);
}

void test_that_another_answers_does_not_make_an_old_answer_a_new_one(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    assert_answered(&other, 6);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_FALSE(is_sent());
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    poll_at(505);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    poll_at(QUIET_US);
    assert_answered(&request, 5);
}

void test_what_is_not_answered_is_sent_meanwhile(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &other, CDS_BROADCAST_ID));
    TEST_ASSERT_TRUE(is_sent());
}

void test_everybody_is_not_asked_meanwhile(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, CDS_BROADCAST_ID));
    TEST_ASSERT_FALSE(is_sent());
}

void test_an_old_answer_is_not_feared_half_an_hour_later(void)
{
    give_up_early(2);
    poll_at(600);
    poll_at(0x80000000u);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(is_sent());
}

/* A program that blocks polls while it waits, and never else. */
void test_an_old_answer_is_not_feared_where_nobody_has_polled_for_half_an_hour(void)
{
    give_up_early(2);
    port_fake.now_us += 0x80000000u + 1000;
    TEST_ASSERT_FALSE(cds_bus_may_answer_late(&bus, 5, port_fake.now_us));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(is_sent());
}

void test_an_old_answer_is_not_feared_when_the_clock_comes_round(void)
{
    give_up_early(2);
    poll_at(600);
    port_fake.now_us -= 300;
    TEST_ASSERT_FALSE(cds_bus_may_answer_late(&bus, 5, port_fake.now_us));
}

void test_nobody_is_feared_when_what_is_not_answered_was_never_sent(void)
{
    cds_bus_set_return_delay(&bus, 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    poll_at(0);
    poll_at(1000);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 6));
    TEST_ASSERT_TRUE(is_sent());
}

void test_what_was_submitted_keeps_the_return_delay_of_that_time(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    cds_bus_set_return_delay(&bus, 2);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    poll_at(12 * 10 + 508 + 99);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    poll_at(1);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

static enum cds_result admit_as_quick(struct cds_bus_observer *observer, struct cds_request *asked)
{
    (void)observer;
    cds_bus_set_return_delay_of_(asked, 2);
    return CDS_OK;
}

static void hear_no_news(struct cds_bus_observer *observer, const struct cds_bus_news *news)
{
    (void)observer;
    (void)news;
}

void test_the_observer_says_how_long_a_servo_waits(void)
{
    struct cds_bus_observer observer = {.admit = admit_as_quick, .on_news = hear_no_news};

    cds_bus_set_observer(&bus, &observer);
    give_up_early(508);
    cds_bus_set_observer(&bus, NULL);
}

void test_a_corrupt_reply_is_followed_by_silence_of_two_byte_times(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    poll_at(2000);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_CORRUPT, request.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    poll_at(QUIET_US - 1);
    TEST_ASSERT_FALSE(is_sent());
    poll_at(1);
    assert_answered(&request, 5);
}

void test_opening_again_waits_until_no_old_answer_can_come(void)
{
    give_up_early(2);
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    cds_bus_set_queue(&bus, true);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, CDS_BAUD_1M));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    poll_at(CDS_RETURN_DELAY_MAX_US + CDS_REPLY_MARGIN_US - 1);
    TEST_ASSERT_FALSE(is_sent());
    poll_at(1);
    TEST_ASSERT_TRUE(is_sent());
}

void test_noise_does_not_shorten_that_wait(void)
{
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    cds_bus_set_queue(&bus, true);
    noise();
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    poll_at(CDS_RETURN_DELAY_MAX_US + CDS_REPLY_MARGIN_US - 1);
    TEST_ASSERT_FALSE(is_sent());
    poll_at(1);
    assert_answered(&request, 5);
    noise();
    poll_at(0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5)); // as ever, from then on
    poll_at(QUIET_US);
    assert_answered(&request, 5);
}

void test_at_another_rate_no_old_answer_is_feared(void)
{
    give_up_early(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, 3));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(is_sent());
}

void test_opening_again_amid_an_exchange_waits_for_its_answer(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    cds_bus_set_queue(&bus, true);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_FALSE(is_sent());
    poll_at(12 * 10 + 508 + 100);
    assert_answered(&request, 5);
}
