/* SPDX-License-Identifier: MIT */
/* What an upper layer adds to a bus: permit, news of packets, priority; and the lock of an
 * operation. */
#include "cds55xx/bus.h"

#include <string.h>

#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

#define PORT     0
#define REQUESTS 3
#define QUIET_US 20 // two byte times at 1 Mbps

static struct cds_queue queue;
static struct cds_bus_hooks hooks;
static uint8_t buffers[REQUESTS][CDS_PACKET_SIZE(2)], replies[REQUESTS][8];
static struct cds_request requests[REQUESTS];

/* What the permit answers, and what it was asked. */
static enum cds_result answer;
static uint16_t delay_us;
static bool mutes;
static uint8_t asked;
static struct cds_request *last_asked;

static uint8_t sending_left; // polls for which on_sending has more to do
static uint8_t sending_calls;
static uint8_t ended;
static struct {
    uint8_t count, event, id, error;
} packet;

static enum cds_result permit(void *context, struct cds_request *request)
{
    TEST_ASSERT_EQUAL_PTR(&queue, context);
    asked++;
    last_asked = request;
    request->return_delay_us = delay_us;
    request->is_muted = mutes;
    return answer;
}

/* As an upper layer does: the request is checked, then the queue takes it over. */
static enum cds_result submit(void *context, struct cds_request *request)
{
    enum cds_result result = permit(context, request);

    if (result != CDS_OK && result != CDS_PENDING)
        return result;
    return queue.hooks.submit(&queue, request);
}

static bool cancel(void *context, struct cds_request *request)
{
    return queue.hooks.cancel(context, request);
}

static bool on_sending(void *context, struct cds_request *request)
{
    TEST_ASSERT_EQUAL_PTR(&queue, context);
    TEST_ASSERT_EQUAL_PTR(bus.request, request);
    sending_calls++;
    if (sending_left == 0)
        return false;
    sending_left--;
    return true;
}

static enum cds_result on_end(void *context, struct cds_request *request, enum cds_result result)
{
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, result);
    ended++;
    return queue.hooks.request_ended(context, request, result);
}

static void on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    TEST_ASSERT_EQUAL_PTR(&queue, context);
    packet.count++;
    packet.event = (uint8_t)event;
    packet.id = id;
    packet.error = error;
}

static const struct cds_bus_hooks upper = {
    .context = &queue,
    .permit = permit,
    .submit = submit,
    .cancel = cancel,
    .on_sending = on_sending,
    .request_ended = on_end,
    .on_packet = on_packet,
};

void setUp(void)
{
    rig_open(PORT);
    memset(&packet, 0, sizeof packet);
    cds_queue_begin(&queue, &bus);
    hooks = upper;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, &hooks));
    for (uint8_t i = 0; i < REQUESTS; i++)
        requests[i] = (struct cds_request){
            .packet = {.bytes = buffers[i], .capacity = sizeof buffers[i]},
            .reply = replies[i],
            .reply_capacity = sizeof replies[i],
        };
    answer = CDS_OK;
    delay_us = CDS_RETURN_DELAY_MAX_US;
    mutes = false;
    asked = sending_left = sending_calls = ended = 0;
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

static void broadcast(uint8_t i)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &requests[i], CDS_BROADCAST_ID));
}

static void be_answered(uint8_t i)
{
    TEST_ASSERT_TRUE(rig_is_sending());
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    TEST_ASSERT_EQUAL_UINT8(i + 1, port_fake.sent[CDS_AT_ID]);
    port_fake_answer(&bus.link, (uint8_t)(i + 1), 0, NULL, 0);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, requests[i].result);
}

static void fail(void)
{
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake.now_us += 2000;
    port_fake_look(&bus);
}

/* ---- attach ---- */

void test_attach_same_hooks_again_is_ok(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, &hooks));
}

void test_attach_other_hooks_is_refused(void)
{
    static struct cds_bus_hooks other;
    static struct cds_queue second;

    other = upper;
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_attach(&bus, &other));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_queue_attach(&second, &bus));
    ping(0);
    TEST_ASSERT_EQUAL_UINT8(1, asked);
    be_answered(0);
}

void test_attach_while_a_request_is_in_flight_is_refused(void)
{
    memset(&bus, 0, sizeof bus);
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    ping(0);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_attach(&bus, &hooks));
    be_answered(0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, &hooks));
}

void test_open_again_keeps_the_hooks(void)
{
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    ping(0);
    TEST_ASSERT_NOT_EQUAL(0, asked);
    port_fake_settle(&bus);
    be_answered(0);
}

/* ---- permit ---- */

void test_permit_that_refuses_at_submit_sends_nothing(void)
{
    static const enum cds_result refusals[] = {CDS_NO_REPLY_DUE, CDS_LIMIT, CDS_INHIBITED,
                                               CDS_TOO_EARLY};

    for (uint8_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
        answer = refusals[i];
        TEST_ASSERT_EQUAL(refusals[i], cds_servo_ping(&bus, &requests[0], 1));
        TEST_ASSERT_EQUAL(refusals[i], requests[0].result);
        TEST_ASSERT_NULL(bus.request);
        TEST_ASSERT_FALSE(rig_is_sending());
    }
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.sent);
    answer = CDS_OK;
    ping(0);
    be_answered(0);
}

/* Refused behind a request in flight, too. */
void test_permit_that_refuses_behind_another_queues_nothing(void)
{
    ping(0);
    answer = CDS_LIMIT;
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_servo_ping(&bus, &requests[1], 2));
    TEST_ASSERT_EQUAL(CDS_LIMIT, requests[1].result);
    be_answered(0);
    TEST_ASSERT_FALSE(rig_is_sending());
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
}

void test_permit_is_asked_before_a_queued_packet_leaves(void)
{
    ping(0);
    ping(1);
    asked = 0;
    be_answered(0);
    TEST_ASSERT_NOT_EQUAL(0, asked);
    TEST_ASSERT_EQUAL_PTR(&requests[1], last_asked);
    be_answered(1);
}

void test_permit_that_refuses_a_queued_request_in_its_turn(void)
{
    ping(0);
    ping(1);
    ping(2);
    answer = CDS_INHIBITED;
    be_answered(0);
    TEST_ASSERT_FALSE(rig_is_sending());
    TEST_ASSERT_TRUE(cds_bus_poll(&bus)); // one transaction a poll
    TEST_ASSERT_EQUAL(CDS_INHIBITED, requests[1].result);
    answer = CDS_OK;
    cds_bus_poll(&bus);
    be_answered(2);
    TEST_ASSERT_EQUAL_UINT16(2, bus.stats.sent);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.line_busy);
}

void test_permit_is_asked_before_a_retry_leaves(void)
{
    cds_queue_set_retries(&queue, 2);
    ping(0);
    asked = 0;
    fail();
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    answer = CDS_INHIBITED;
    port_fake_settle(&bus);
    for (uint8_t i = 0; i < 250; i++)
        rig_poll_after(10);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT,
                      requests[0].result); // not CDS_INHIBITED: the packet was sent once
    TEST_ASSERT_NOT_EQUAL(0, asked);
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.sent);
    TEST_ASSERT_NULL(bus.request);
}

void test_permit_is_asked_after_the_wait_for_a_quiet_line(void)
{
    port_fake.low = true;
    ping(0);
    answer = CDS_LIMIT;
    rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    port_fake.low = false;
    for (uint8_t i = 0; i < 5; i++)
        rig_poll_after(QUIET_US);
    TEST_ASSERT_EQUAL(CDS_LIMIT, requests[0].result);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.sent);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.line_busy);
}

void test_permit_that_goes_on_delays_the_packet(void)
{
    answer = CDS_PENDING;
    ping(0);
    for (uint8_t i = 0; i < 10; i++) {
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
        TEST_ASSERT_FALSE(rig_is_sending());
        TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    }
    answer = CDS_OK;
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    be_answered(0);
}

/* The check of 50 goals takes longer than a request may wait for the line. */
void test_permit_that_goes_on_is_no_wait_for_the_line(void)
{
    answer = CDS_PENDING;
    ping(0);
    for (uint8_t i = 0; i < 100; i++)
        rig_poll_after(100);
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    answer = CDS_OK;
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    be_answered(0);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.line_busy);
}

void test_permit_that_goes_on_is_asked_once_a_poll(void)
{
    answer = CDS_PENDING;
    ping(0);
    cds_bus_poll(&bus);
    asked = 0;
    for (uint8_t i = 0; i < 10; i++)
        cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL_UINT8(10, asked);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &requests[0]));
}

void test_permit_that_goes_on_and_then_refuses(void)
{
    answer = CDS_PENDING;
    ping(0);
    cds_bus_poll(&bus);
    answer = CDS_LIMIT;
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_LIMIT, requests[0].result);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.sent);
}

/* A line in use while the check goes on: the packet waits for it afterwards. */
void test_permit_that_goes_on_does_not_hide_the_line(void)
{
    answer = CDS_PENDING;
    ping(0);
    cds_bus_poll(&bus);
    cds_link_on_rx(&bus.link, 0x55, 0);
    answer = CDS_OK;
    rig_poll_after(0);
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(QUIET_US - 1);
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(1);
    be_answered(0);
}

void test_permit_sets_the_return_delay_of_a_request(void)
{
    delay_us = 2;
    ping(0);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake.now_us += 12 * 10 + 2 + CDS_REPLY_MARGIN_US - 1;
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    port_fake.now_us++;
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
}

/* The rest after that timeout is as long as the delay of that request asks for. */
void test_rest_follows_the_return_delay_of_a_request(void)
{
    const uint16_t rest_us = CDS_STALE_REPLY_US - CDS_REPLY_MARGIN_US - 2;

    delay_us = 2;
    ping(0);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake.now_us += 12 * 10 + 2 + CDS_REPLY_MARGIN_US;
    port_fake_look(&bus);
    ping(1);
    rig_poll_after(rest_us - 1u);
    TEST_ASSERT_FALSE(rig_is_sending());
    rig_poll_after(1);
    be_answered(1);
}

void test_muted_request_expects_no_reply(void)
{
    mutes = true;
    ping(0);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_BUS_SENDING_ONLY, bus.state);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    TEST_ASSERT_EQUAL_UINT8(0, requests[0].length);
    TEST_ASSERT_EQUAL_UINT8(0, requests[0].error);
    mutes = false; // the same request again: a reply is due
    ping(0);
    be_answered(0);
}

/* ---- on_sending ---- */

void test_on_sending_is_called_while_no_reply_is_due(void)
{
    broadcast(0);
    cds_bus_poll(&bus);
    cds_bus_poll(&bus);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL_UINT8(2, sending_calls);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
}

void test_on_sending_that_has_more_to_do_keeps_the_transaction(void)
{
    sending_left = 5;
    broadcast(0);
    ping(1);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    for (uint8_t i = 0; i < 6; i++) { // one sets the deadline
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
        TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    }
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    TEST_ASSERT_EQUAL_UINT8(6, sending_calls);
    be_answered(1);
}

void test_on_sending_is_not_called_while_a_reply_is_due(void)
{
    ping(0);
    be_answered(0);
    TEST_ASSERT_EQUAL_UINT8(0, sending_calls);
}

/* ---- on_end ---- */

void test_on_end_hears_of_each_end(void)
{
    cds_queue_set_retries(&queue, 1);
    ping(0);
    be_answered(0);
    TEST_ASSERT_EQUAL_UINT8(1, ended);
    ping(1);
    fail();
    TEST_ASSERT_EQUAL_UINT8(2, ended);
    port_fake_settle(&bus);
    be_answered(1);
    TEST_ASSERT_EQUAL_UINT8(3, ended);
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.retried);
}

/* ---- on_packet ---- */

static void assert_packet(uint8_t count, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    for (uint8_t i = 0; i < 4; i++)
        cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL_UINT8(count, packet.count);
    TEST_ASSERT_EQUAL_UINT8(event, packet.event);
    TEST_ASSERT_EQUAL_UINT8(id, packet.id);
    TEST_ASSERT_EQUAL_HEX8(error, packet.error);
}

void test_on_packet_hears_of_a_stale_reply(void)
{
    ping(0);
    fail();
    port_fake_answer(&bus.link, 1, CDS_ERROR_VOLTAGE, NULL, 0);
    assert_packet(1, CDS_EVENT_STALE_REPLY, 1, CDS_ERROR_VOLTAGE);
}

void test_on_packet_hears_of_a_duplicate_reply(void)
{
    ping(0);
    be_answered(0);
    TEST_ASSERT_EQUAL_UINT8(0, packet.count); // the reply due is none
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    assert_packet(1, CDS_EVENT_DUPLICATE_REPLY, 1, 0);
}

void test_on_packet_hears_of_an_unexpected_packet(void)
{
    port_fake_answer(&bus.link, 7, CDS_ERROR_OVERLOAD, NULL, 0);
    assert_packet(1, CDS_EVENT_UNEXPECTED_PACKET, 7, CDS_ERROR_OVERLOAD);
    ping(0);
    rig_transmit();
    port_fake_answer(&bus.link, 9, 0, NULL, 0);
    assert_packet(2, CDS_EVENT_UNEXPECTED_PACKET, 9, 0);
}

/* Of a reply whose first bytes came before the deadline, too. */
void test_on_packet_hears_of_a_stale_reply_begun_in_time(void)
{
    static const uint8_t hot[] = {0xFF, 0xFF, 0x01, 0x04, 0x04, 0x34, 0x12, 0xB0};

    for (uint8_t cut = 0; cut < sizeof hot; cut++) {
        setUp();
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &requests[0], 1, 0x24, 2));
        TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
        port_fake_hear(&bus.link, hot, cut);
        port_fake.now_us += 2000;
        port_fake_look(&bus);
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
        port_fake_hear(&bus.link, hot + cut, (uint16_t)(sizeof hot - cut));
        assert_packet(1, CDS_EVENT_STALE_REPLY, 1, CDS_ERROR_OVERHEATING);
    }
}

/* ---- priority ---- */

void test_priority_overtakes_a_request_that_waits_for_the_line(void)
{
    port_fake.low = true;
    ping(0);
    ping(1);
    requests[2].priority = CDS_PRIORITY_TORQUE_OFF;
    ping(2);
    TEST_ASSERT_EQUAL_PTR(&requests[2], bus.request);
    port_fake.low = false;
    port_fake_settle(&bus);
    be_answered(2);
    be_answered(0); // in their old order
    be_answered(1);
}

void test_priority_does_not_overtake_a_packet_on_the_wire(void)
{
    ping(0);
    requests[2].priority = CDS_PRIORITY_TORQUE_OFF;
    ping(2);
    be_answered(0);
    be_answered(2);
}

void test_same_priority_does_not_overtake(void)
{
    port_fake.low = true;
    requests[0].priority = requests[1].priority = CDS_PRIORITY_HIGH;
    ping(0);
    ping(1);
    TEST_ASSERT_EQUAL_PTR(&requests[0], bus.request);
    port_fake.low = false;
    port_fake_settle(&bus);
    be_answered(0);
    be_answered(1);
}

/* ---- lock ---- */

static void never(void *context)
{
    (void)context;
    TEST_FAIL_MESSAGE("the bus ends no operation");
}

static const struct cds_bus_lock lock = {.abort = never}, other_lock = {.abort = never};

void test_lock_of_a_closed_bus_is_refused(void)
{
    memset(&bus, 0, sizeof bus);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_lock(&bus, &lock));
}

void test_lock_refuses_requests_without_passes_lock(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &requests[0], 1));
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, requests[0].result);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.sent);
    requests[1].passes_lock = true;
    ping(1);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &requests[0], 1)); // behind it, too
    be_answered(1);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &requests[0], 1));
    cds_bus_unlock(&bus, &lock);
    ping(0);
    be_answered(0);
}

void test_lock_lets_a_request_with_passes_lock_leave_at_once(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    requests[0].passes_lock = requests[1].passes_lock = true;
    ping(0);
    ping(1);
    be_answered(0);
    be_answered(1);
}

void test_lock_without_hooks(void)
{
    memset(&bus, 0, sizeof bus);
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &requests[0], 1));
    requests[0].passes_lock = true;
    ping(0);
    be_answered(0);
}

void test_lock_of_another_operation_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_lock(&bus, &other_lock));
    cds_bus_unlock(&bus, &other_lock); // holds nothing
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &requests[0], 1));
    TEST_ASSERT_EQUAL_PTR(&lock, bus.lock);
    cds_bus_unlock(&bus, &lock);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &other_lock));
}

void test_lock_leaves_a_transaction_in_flight_alone(void)
{
    ping(0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    be_answered(0);
}

void test_lock_stays_when_a_rest_ends(void)
{
    ping(0);
    fail();
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    for (uint8_t i = 0; i < 100; i++)
        rig_poll_after(50);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &requests[0], 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, 3));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &requests[0], 1));
}

void test_open_again_ends_the_lock(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    TEST_ASSERT_NULL(bus.lock);
    ping(0);
    port_fake_settle(&bus);
    be_answered(0);
}
