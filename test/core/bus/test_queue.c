/* SPDX-License-Identifier: MIT */
/* Requests that wait for the bus: their order, priorities, retries, callbacks, cancelling. */
#include <string.h>

#include "cds55xx/blocking.h"
#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

#define REQUESTS 5

static struct cds_queue queue;
static uint8_t buffers[REQUESTS][16], replies[REQUESTS][8];
static struct cds_request requests[REQUESTS];

/* The order in which on_end was called: indices of `requests`. */
static uint8_t ended[16];
static uint8_t ended_count;

static void note_end(struct cds_request *request)
{
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, request->result);
    TEST_ASSERT_EQUAL_PTR(&bus, request->context);
    ended[ended_count++] = (uint8_t)(request - requests);
}

void setUp(void)
{
    rig_open_with_queue(0, &queue);
    for (uint8_t i = 0; i < REQUESTS; i++)
        requests[i] = (struct cds_request){
            .packet = {.bytes = buffers[i], .capacity = sizeof buffers[i]},
            .reply = replies[i],
            .reply_capacity = sizeof replies[i],
            .on_end = note_end,
            .context = &bus,
        };
    ended_count = 0;
}

void tearDown(void)
{
    rig_check();
}

/* Request i pings servo i + 1. */
static void ping(uint8_t i)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[i], (uint8_t)(i + 1)));
}

/* The packet in flight leaves, is for this servo, and is answered; the next begins. */
static void answer(uint8_t id)
{
    rig_transmit();
    TEST_ASSERT_EQUAL_UINT8(id, port_fake.sent[CDS_AT_ID]);
    port_fake_answer(&bus.link, id, 0, NULL, 0);
    port_fake_look(&bus);
}

/* The packet in flight leaves, and is not answered: the transaction ends at its deadline. */
static void stay_silent(void)
{
    rig_transmit();
    port_fake.now_us += 10000;
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, bus.link.state);
    cds_bus_poll(&bus);
}

static void assert_ended_in_order(const uint8_t *order, uint8_t count)
{
    TEST_ASSERT_EQUAL_UINT8(count, ended_count);
    TEST_ASSERT_EQUAL_UINT8_ARRAY(order, ended, count);
}

void test_requests_go_out_in_the_order_they_were_submitted(void)
{
    static const uint8_t order[] = {0, 1, 2, 3, 4};

    for (uint8_t i = 0; i < REQUESTS; i++)
        ping(i);
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.sent);
    for (uint8_t i = 0; i < REQUESTS; i++) {
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
        answer((uint8_t)(i + 1));
        TEST_ASSERT_EQUAL(CDS_OK, requests[i].result);
    }
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    assert_ended_in_order(order, sizeof order);
}

void test_priority_goes_first_but_not_before_the_one_in_flight(void)
{
    static const uint8_t order[] = {0, 2, 4, 1, 3};

    requests[2].priority = requests[4].priority = CDS_PRIORITY_HIGH;
    for (uint8_t i = 0; i < REQUESTS; i++)
        ping(i);
    for (uint8_t i = 0; i < REQUESTS; i++)
        answer((uint8_t)(order[i] + 1));
    assert_ended_in_order(order, sizeof order);
}

/* The header of the next one is on the line before the end is noted: but not on one that others
 * use, at which the next poll looks. */
static void assert_waits_behind_a_reply_and(uint8_t line_errors, bool low)
{
    setUp();
    ping(0);
    ping(1);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    if (!low)
        cds_link_on_rx(&bus.link, 0xFF, line_errors);
    port_fake.low = low;
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[0]);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    port_fake.low = false;
    port_fake_settle(&bus);
    answer(2);
    TEST_ASSERT_EQUAL(CDS_OK, requests[1].result);
}

void test_next_request_waits_for_a_quiet_line_after_ok(void)
{
    assert_waits_behind_a_reply_and(0, false);
    assert_waits_behind_a_reply_and(CDS_LINE_FRAMING, false);
    assert_waits_behind_a_reply_and(0, true);
}

/* ... and until an old answer can no longer come. */
void test_next_request_waits_for_stale_replies_after_ok(void)
{
    uint32_t failed_us;

    cds_bus_set_return_delay(&bus, 2);
    ping(0);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake.now_us += 12 * 10 + 2 + CDS_REPLY_MARGIN_US;
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
    failed_us = port_fake.now_us;
    requests[1].ignores_stale = true;
    ping(1);
    ping(0);
    answer(2);
    TEST_ASSERT_EQUAL(CDS_OK, requests[1].result);
    TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[0]);
    port_fake.now_us = failed_us + CDS_STALE_REPLY_US - CDS_REPLY_MARGIN_US - 2 - 1;
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[0]);
    port_fake.now_us++;
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(FAKE_TALK, port_fake.lines[0]);
    answer(1);
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
}

void test_failed_request_does_not_hold_up_the_next(void)
{
    ping(0);
    ping(1);
    stay_silent();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[1].result);
    answer(2);
    TEST_ASSERT_EQUAL(CDS_OK, requests[1].result);
}

/* Behind a bad end one waits on a line that is free: it must not be passed, let alone forgotten. */
void test_submit_after_a_failure_waits_behind_queued_requests(void)
{
    requests[0].reply_parameters = CDS_REPLY_NONE;
    cds_packet_action(&requests[0].packet, CDS_BROADCAST_ID);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &requests[0]));
    ping(1);
    cds_bus_poll(&bus);
    port_fake.now_us += 10000; // the transmitter has stopped
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
    ping(2);
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.sent);
    cds_bus_poll(&bus);
    answer(2);
    answer(3);
    TEST_ASSERT_EQUAL(CDS_OK, requests[1].result);
    TEST_ASSERT_EQUAL(CDS_OK, requests[2].result);
}

/* ... nor one that is to be sent once more. A poll says that there is work. */
void test_submit_after_a_failure_waits_behind_the_retry(void)
{
    cds_queue_set_retries(&queue, 1);
    ping(0);
    cds_bus_poll(&bus);
    port_fake.now_us += 10000; // the transmitter has stopped
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    port_fake.now_us += CDS_STALE_REPLY_US; // the rest is over
    ping(1);
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.sent);
    port_fake.low = true;
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    port_fake.low = false;
    port_fake_settle(&bus);
    answer(1);
    answer(2);
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    TEST_ASSERT_EQUAL(CDS_OK, requests[1].result);
}

void test_poll_that_ends_one_and_begins_the_next_returns_true(void)
{
    ping(0);
    ping(1);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    TEST_ASSERT_TRUE(cds_bus_poll(&bus)); // the deadline
    TEST_ASSERT_TRUE(cds_bus_poll(&bus)); // the head
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    TEST_ASSERT_EQUAL(FAKE_TALK, port_fake.lines[0]);
}

void test_each_waiting_request_has_a_deadline_of_its_own(void)
{
    ping(0);
    ping(1);
    port_fake.now_us += 5000; // long after what would have been the deadline of the second
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
    rig_transmit();
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[1].result);
    port_fake_answer(&bus.link, 2, 0, NULL, 0);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, requests[1].result);
}

static void ping_again(struct cds_request *request)
{
    note_end(request);
    if (ended_count < 4)
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, request, 1));
}

void test_on_end_may_submit_again_and_takes_its_turn(void)
{
    static const uint8_t order[] = {0, 1, 0, 0};

    requests[0].on_end = ping_again;
    ping(0);
    ping(1);
    answer(1);
    answer(2);
    answer(1);
    answer(1);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    assert_ended_in_order(order, sizeof order);
}

void test_a_poll_ends_at_most_one_transaction(void)
{
    for (uint8_t i = 0; i < 3; i++) {
        requests[i].reply_parameters = CDS_REPLY_NONE;
        cds_packet_action(&requests[i].packet, CDS_BROADCAST_ID);
        TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &requests[i]));
    }
    for (uint8_t i = 1; i <= 3; i++) {
        TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
        cds_bus_poll(&bus); // the deadline
        TEST_ASSERT_EQUAL_UINT8(i - 1, ended_count);
        cds_bus_poll(&bus);
        TEST_ASSERT_EQUAL_UINT8(i, ended_count);
    }
}

/* ---- repeats ---- */

void test_nothing_is_retried_by_default(void)
{
    ping(0);
    stay_silent();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.sent);
    TEST_ASSERT_EQUAL(CDS_BUS_IDLE, bus.state);
}

void test_request_is_retried_at_most_the_number_set(void)
{
    cds_queue_set_retries(&queue, 2);
    ping(0);
    ping(1);
    stay_silent();
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    stay_silent();
    TEST_ASSERT_EQUAL_UINT8(0, ended_count);
    stay_silent();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
    TEST_ASSERT_EQUAL_UINT8(1, ended_count);
    TEST_ASSERT_EQUAL_UINT16(2, bus.stats.retried);
    TEST_ASSERT_EQUAL_UINT16(3, bus.stats.timeouts);
    answer(2);
}

void test_good_reply_to_a_retry_is_ok(void)
{
    static const uint8_t data[2] = {0x34, 0x02};
    uint16_t value = 0;

    cds_queue_set_retries(&queue, 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &requests[0], 1, CDS_REG_PRESENT_POSITION, 2));
    stay_silent();
    rig_transmit();
    TEST_ASSERT_EQUAL_HEX8(CDS_REG_PRESENT_POSITION, port_fake.sent[CDS_AT_PARAMETERS]);
    port_fake_answer(&bus.link, 1, 0, data, 2);
    port_fake_look(&bus);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, cds_request_word(&requests[0], 0, &value));
    TEST_ASSERT_EQUAL_HEX16(0x0234, value);
}

void test_refused_request_is_not_retried(void)
{
    cds_queue_set_retries(&queue, 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &requests[0], 1, CDS_REG_LED, 1));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 1, CDS_ERROR_RANGE, NULL, 0);
    port_fake_look(&bus);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.retried);
}

/* How often the packet is sent again when it is never answered. */
static uint16_t retries_of(enum cds_result submitted)
{
    uint16_t before = bus.stats.retried;

    TEST_ASSERT_EQUAL(CDS_OK, submitted);
    while (requests[0].result == CDS_PENDING)
        stay_silent();
    port_fake.now_us += CDS_STALE_REPLY_US;
    cds_bus_poll(&bus);
    ended_count = 0;
    return (uint16_t)(bus.stats.retried - before);
}

void test_only_idempotent_requests_are_retried(void)
{
    struct cds_request *request = &requests[0];
    uint8_t data[6] = {0};

    cds_queue_set_retries(&queue, 2);
    TEST_ASSERT_EQUAL_UINT8(2, retries_of(cds_servo_ping(&bus, request, 1)));
    TEST_ASSERT_EQUAL_UINT8(2, retries_of(cds_servo_read(&bus, request, 1, 0, 5)));
    TEST_ASSERT_EQUAL_UINT8(2, retries_of(cds_servo_write(&bus, request, 1, 5, data, 6)));
    TEST_ASSERT_EQUAL_UINT8(2, retries_of(cds_servo_write(&bus, request, 1, 0, data, 3)));
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_write(&bus, request, 1, 0, data, 4)));
    TEST_ASSERT_EQUAL_UINT8(2, retries_of(cds_servo_write(&bus, request, 1, 0x2D, data, 2)));
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_write(&bus, request, 1, 0x2D, data, 3)));
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_write(&bus, request, 1, 0x2F, data, 1)));
    TEST_ASSERT_EQUAL_UINT8(2, retries_of(cds_servo_write(&bus, request, 1, 0x30, data, 2)));
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_write_byte(&bus, request, 1, 3, 7)));
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_write_byte(&bus, request, 1, 4, 1)));
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_reg_write(&bus, request, 1, 0x1E, data, 4)));
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_action(&bus, request, 1)));
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_reset(&bus, request, 1)));
}

void test_request_with_no_retry_is_sent_once(void)
{
    cds_queue_set_retries(&queue, 2);
    requests[0].no_retry = true;
    TEST_ASSERT_EQUAL_UINT8(0, retries_of(cds_servo_ping(&bus, &requests[0], 1)));
    requests[0].no_retry = false;
    TEST_ASSERT_EQUAL_UINT8(2, retries_of(cds_servo_ping(&bus, &requests[0], 1)));
}

/* Only a packet that was sent is sent again. */
void test_request_that_found_no_quiet_line_is_not_retried(void)
{
    cds_queue_set_retries(&queue, 2);
    port_fake.low = true;
    ping(0);
    for (uint16_t us = 0; us < 2000; us += 10) {
        port_fake.now_us += 10;
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, requests[0].result);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.retried);
    TEST_ASSERT_NULL(bus.request);
}

/* Attached again while requests wait: they are not lost. */
void test_attach_again_while_requests_wait_is_refused(void)
{
    cds_queue_set_retries(&queue, 1);
    ping(0);
    ping(1);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_queue_attach(&queue, &bus));
    answer(1);
    stay_silent();
    answer(2);
    TEST_ASSERT_EQUAL(CDS_OK, requests[1].result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
}

void test_second_queue_is_refused(void)
{
    static struct cds_queue second;

    TEST_ASSERT_EQUAL(CDS_BUSY, cds_queue_attach(&second, &bus));
    ping(0);
    ping(1);
    answer(1);
    answer(2);
}

void test_cancel_of_a_retry_that_waits(void)
{
    cds_queue_set_retries(&queue, 2);
    ping(0);
    stay_silent();
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &requests[0]));
    TEST_ASSERT_EQUAL(CDS_CANCELLED, requests[0].result);
    TEST_ASSERT_EQUAL_UINT8(0, ended_count);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
}

/* A retry begins a new count when its request is submitted anew. */
void test_retries_are_counted_anew_with_each_submit(void)
{
    cds_queue_set_retries(&queue, 1);
    for (uint8_t i = 0; i < 3; i++)
        TEST_ASSERT_EQUAL_UINT16(1, retries_of(cds_servo_ping(&bus, &requests[0], 1)));
}

void test_priority_goes_before_retries(void)
{
    static const uint8_t order[] = {3, 2, 0, 1};

    cds_queue_set_retries(&queue, 2);
    requests[2].priority = CDS_PRIORITY_HIGH;
    requests[3].priority = CDS_PRIORITY_TORQUE_OFF;
    ping(0);
    ping(1);
    ping(2);
    ping(3);
    stay_silent();
    answer(4);
    answer(3);
    answer(1); // before those that were submitted after it
    answer(2);
    assert_ended_in_order(order, sizeof order);
}

void test_retry_that_waits_for_the_line_is_overtaken_in_order(void)
{
    static const uint8_t order[] = {3, 2, 0};

    cds_queue_set_retries(&queue, 2);
    requests[2].priority = CDS_PRIORITY_HIGH;
    requests[3].priority = CDS_PRIORITY_TORQUE_OFF;
    ping(0);
    stay_silent();
    rig_transmit();
    port_fake.now_us += 10000;
    port_fake_look(&bus);
    port_fake.low = true;
    cds_bus_poll(&bus);
    ping(3);
    ping(2);
    port_fake.low = false;
    port_fake_settle(&bus);
    answer(4);
    answer(3);
    answer(1);
    assert_ended_in_order(order, sizeof order);
}

/* ---- taking back ---- */

void test_cancel_gives_the_next_request_its_full_time(void)
{
    port_fake.low = true;
    cds_bus_poll(&bus);
    ping(0);
    ping(1);
    cds_bus_poll(&bus); // the time to wait begins
    port_fake.now_us += 1160;
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &requests[0]));
    cds_bus_poll(&bus);
    port_fake.now_us += 1160;
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[1].result);
    port_fake.now_us += 20; // the last look
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, requests[1].result);
}

void test_cancel_of_a_queued_request(void)
{
    static const uint8_t order[] = {0, 2};

    for (uint8_t i = 0; i < 3; i++)
        ping(i);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &requests[1]));
    TEST_ASSERT_EQUAL(CDS_CANCELLED, requests[1].result);
    answer(1);
    answer(3);
    assert_ended_in_order(order, sizeof order);
    ping(1); // and submitted again
    answer(2);
}

void test_cancel_in_flight_or_unknown_is_refused(void)
{
    ping(0);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_cancel(&bus, &requests[0]));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_cancel(&bus, &requests[1]));
    answer(1);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_cancel(&bus, &requests[0]));
}

void test_opening_again_cancels_all(void)
{
    ping(0);
    ping(1);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, requests[0].result);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, requests[1].result);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL_UINT8(0, ended_count);
}

/* ---- lock ---- */

static void no_abort(void *context)
{
    (void)context;
}

void test_lock_lets_what_waited_leave_before_its_holder(void)
{
    static const struct cds_bus_lock lock = {.abort = no_abort};
    static const uint8_t order[] = {4, 1, 0, 2, 3};
    static uint8_t buffer[CDS_PACKET_SIZE(0)];
    struct cds_request unlocked = CDS_REQUEST_WITHOUT_DATA(buffer);

    cds_queue_set_retries(&queue, 1);
    requests[1].priority = CDS_PRIORITY_HIGH;
    for (uint8_t i = 0; i < 3; i++)
        ping(i);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    requests[3].passes_lock = requests[4].passes_lock = true;
    requests[4].priority = CDS_PRIORITY_TORQUE_OFF;
    ping(3); // of the holder
    ping(4);
    stay_silent(); // 0 is sent again
    for (uint8_t i = 0; i < sizeof order; i++) {
        TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_set_baud(&bus, CDS_BAUD(500000)));
        TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &unlocked, 9));
        answer((uint8_t)(order[i] + 1));
    }
    assert_ended_in_order(order, sizeof order);
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.retried);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, CDS_BAUD(500000)));
}

/* ---- waiting ---- */

/* The clock runs while the caller waits: that is what ends a transaction without a reply. */
void test_waiting_for_an_absent_servo_ends(void)
{
    uint16_t value = 0x1234;

    port_fake.us_per_reading = 10;
    port_fake.eager = &bus.link;
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_ping(&bus, &requests[0], 1));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_read_word(&bus, &requests[0], 1,
                                                          CDS_REG_PRESENT_POSITION, &value));
    TEST_ASSERT_EQUAL_HEX16(0x1234, value);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_write_byte(&bus, &requests[0], 1, CDS_REG_LED, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_blocking_write_word(&bus, &requests[0], CDS_BROADCAST_ID,
                                                      CDS_REG_GOAL_POSITION, 512));
}

void test_waiting_passes_a_refusal_to_submit_on(void)
{
    uint8_t value = 0x12;

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_read_byte(&bus, &requests[0], 254, 3, &value));
    TEST_ASSERT_EQUAL_HEX8(0x12, value);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}
