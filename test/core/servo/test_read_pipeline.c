/* SPDX-License-Identifier: MIT */
/* READs of many servos one behind the other: order, what is built ahead, failures, abort. */
#include "cds55xx/read_pipeline.h"

#include <string.h>

#include "bus_rig.h"
#include "cds55xx/servo.h"
#include "unity.h"

#define ITEMS 3

static struct cds_queue queue;
static uint8_t packets[2][CDS_PACKET_SIZE(2)], replies[2][4];
static struct cds_request requests[2];
static struct cds_read_pipeline pipeline;
static struct cds_read_pipeline_config config;

static struct cds_read_item items[ITEMS];
static bool is_sent[ITEMS];
static uint8_t built, taken;
static bool takes; // take() accepts what has ended
static struct cds_request ended[ITEMS];
static uint8_t first_bytes[ITEMS];

static bool next(void *context, struct cds_read_item *item)
{
    TEST_ASSERT_EQUAL_PTR(&built, context);
    TEST_ASSERT_LESS_THAN(ITEMS, built);
    *item = items[built];
    return is_sent[built++];
}

static bool take(void *context, struct cds_request *request)
{
    TEST_ASSERT_EQUAL_PTR(&built, context);
    if (!takes)
        return false;
    TEST_ASSERT_LESS_THAN(ITEMS, taken);
    ended[taken] = *request;
    first_bytes[taken++] = request->reply[0];
    return true;
}

void setUp(void)
{
    rig_open_with_queue(0, &queue);
    for (uint8_t i = 0; i < 2; i++)
        requests[i] = (struct cds_request)CDS_REQUEST(packets[i], replies[i]);
    for (uint8_t i = 0; i < ITEMS; i++) {
        items[i] = (struct cds_read_item){(uint8_t)(10 + i), (uint8_t)(i + 1), (uint8_t)(i + 1)};
        is_sent[i] = true;
    }
    built = taken = 0;
    takes = true;
    memset(&pipeline, 0, sizeof pipeline);
    config = (struct cds_read_pipeline_config){.bus = &bus,
                                               .requests = requests,
                                               .count = ITEMS,
                                               .longest = 4,
                                               .context = &built,
                                               .next = next,
                                               .take = take};
}

void tearDown(void)
{
    rig_check();
}

static void begin(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_begin(&pipeline, &config));
}

static void poll_pending(void)
{
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_read_pipeline_poll(&pipeline));
}

/* The operation ends within a few polls, without a further packet. */
static void assert_ends(enum cds_result result)
{
    for (uint8_t i = 0; i < 5 && pipeline.result == CDS_PENDING; i++)
        cds_read_pipeline_poll(&pipeline);
    TEST_ASSERT_EQUAL(result, pipeline.result);
}

/* Servo 10 + i replies to the READ of item i. */
static void answer_item(uint8_t i)
{
    const uint8_t data[4] = {(uint8_t)(100 + i)};

    rig_transmit();
    TEST_ASSERT_EQUAL_UINT8(10 + i, port_fake.sent[CDS_AT_ID]);
    TEST_ASSERT_EQUAL_UINT8(CDS_READ, port_fake.sent[CDS_AT_INSTRUCTION]);
    TEST_ASSERT_EQUAL_UINT8(items[i].address, port_fake.sent[CDS_AT_PARAMETERS]);
    TEST_ASSERT_EQUAL_UINT8(items[i].length, port_fake.sent[CDS_AT_PARAMETERS + 1]);
    port_fake_answer(&bus.link, (uint8_t)(10 + i), 0, data, items[i].length);
    port_fake_look(&bus);
}

static void assert_taken(uint8_t i, enum cds_result result)
{
    TEST_ASSERT_EQUAL_UINT8(10 + i, ended[i].id);
    TEST_ASSERT_EQUAL(result, ended[i].result);
    if (result == CDS_OK && is_sent[i]) {
        TEST_ASSERT_EQUAL_UINT8(items[i].length, ended[i].length);
        TEST_ASSERT_EQUAL_UINT8(100 + i, first_bytes[i]);
    }
}

void test_pipeline_of_differing_items_reads_each(void)
{
    begin();
    TEST_ASSERT_NULL(bus.request);
    for (uint8_t i = 0; i < ITEMS; i++) {
        poll_pending();
        answer_item(i);
        TEST_ASSERT_EQUAL_UINT8(i + 1, taken);
        assert_taken(i, CDS_OK);
    }
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL_UINT16(ITEMS, port_fake.packets);
    TEST_ASSERT_NULL(requests[0].on_end);
    TEST_ASSERT_NULL(requests[1].on_end);
}

void test_pipeline_sends_the_next_read_before_a_poll(void)
{
    begin();
    poll_pending();
    TEST_ASSERT_TRUE(cds_read_pipeline_is_awaiting(&pipeline));
    TEST_ASSERT_EQUAL_UINT8(2, built);
    answer_item(0);
    TEST_ASSERT_EQUAL_PTR(pipeline.current, bus.request);
    TEST_ASSERT_EQUAL_UINT8(11, bus.request->id);
    TEST_ASSERT_FALSE(cds_read_pipeline_is_awaiting(&pipeline));
}

void test_pipeline_without_a_taker_waits(void)
{
    takes = false;
    begin();
    poll_pending();
    answer_item(0);
    for (uint8_t i = 0; i < 3; i++) {
        poll_pending();
        TEST_ASSERT_EQUAL_UINT8(2, built);
    }
    answer_item(1); // was on its way already
    poll_pending();
    TEST_ASSERT_NULL(bus.request);
    takes = true;
    poll_pending();
    TEST_ASSERT_EQUAL_UINT8(1, taken);
    poll_pending(); // builds item 2, sends it and hands over item 1
    TEST_ASSERT_EQUAL_UINT8(2, taken);
    poll_pending();
    answer_item(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
    for (uint8_t i = 0; i < ITEMS; i++)
        assert_taken(i, CDS_OK);
}

void test_pipeline_with_a_silent_servo_reads_on(void)
{
    begin();
    poll_pending();
    rig_stay_silent();
    assert_taken(0, CDS_TIMEOUT);
    poll_pending();
    answer_item(1);
    poll_pending();
    answer_item(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL_UINT8(3, taken);
}

void test_pipeline_that_stops_on_failure_sends_no_more(void)
{
    config.stops_on_failure = true;
    begin();
    poll_pending();
    answer_item(0);
    poll_pending();
    rig_stay_silent();
    assert_taken(1, CDS_TIMEOUT);
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL_UINT8(2, taken);
    TEST_ASSERT_EQUAL_UINT16(2, port_fake.packets);
}

void test_pipeline_item_that_is_not_sent_keeps_its_turn(void)
{
    is_sent[0] = is_sent[2] = false;
    begin();
    poll_pending();
    TEST_ASSERT_EQUAL_UINT8(1, taken);
    assert_taken(0, CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(0, ended[0].length);
    poll_pending();
    answer_item(1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL_UINT8(3, taken);
    assert_taken(2, CDS_OK);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

void test_pipeline_on_a_locked_bus_waits_for_it(void)
{
    static const struct cds_bus_lock lock;

    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    begin();
    poll_pending();
    poll_pending();
    TEST_ASSERT_NULL(bus.request);
    TEST_ASSERT_EQUAL_UINT8(2, built);
    cds_bus_unlock(&bus, &lock);
    poll_pending();
    answer_item(0);
    TEST_ASSERT_EQUAL_UINT8(1, taken);
    assert_taken(0, CDS_OK);
    cds_read_pipeline_abort(&pipeline);
    answer_item(1);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_read_pipeline_poll(&pipeline));
}

void test_pipeline_aborted_in_flight_ends_after_the_reply(void)
{
    begin();
    poll_pending();
    rig_transmit();
    cds_read_pipeline_abort(&pipeline);
    poll_pending();
    port_fake_answer(&bus.link, 10, 0, first_bytes, 1);
    port_fake_look(&bus);
    TEST_ASSERT_NULL(bus.request);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL_UINT8(1, taken);
    cds_read_pipeline_abort(&pipeline);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_read_pipeline_poll(&pipeline));
}

void test_pipeline_aborted_in_the_queue_ends_at_once(void)
{
    static uint8_t bytes[8];
    struct cds_request ping = CDS_REQUEST_WITHOUT_DATA(bytes);

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &ping, 77));
    begin();
    poll_pending();
    cds_read_pipeline_abort(&pipeline);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL(CDS_CANCELLED, requests[0].result);
    TEST_ASSERT_EQUAL_UINT8(0, taken);
    rig_answer(77, 0, NULL, 0);
    TEST_ASSERT_EQUAL(CDS_OK, ping.result);
    TEST_ASSERT_NULL(bus.request);
}

void test_pipeline_read_cancelled_in_the_queue_ends_cancelled(void)
{
    static uint8_t bytes[8];
    struct cds_request ping = CDS_REQUEST_WITHOUT_DATA(bytes);

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &ping, 77));
    begin();
    poll_pending();
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &requests[0]));
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL_UINT8(0, taken);
    rig_answer(77, 0, NULL, 0);
}

void test_pipeline_on_a_bus_opened_again_ends_cancelled(void)
{
    begin();
    poll_pending();
    rig_transmit();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL_UINT8(0, taken);
}

void test_pipeline_aborted_before_a_poll_sends_nothing(void)
{
    begin();
    cds_read_pipeline_abort(&pipeline);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL_UINT8(0, taken);
    TEST_ASSERT_NULL(bus.request);
}

void test_pipeline_item_beyond_the_reply_buffer_has_no_room(void)
{
    items[1].length = 5;
    begin();
    poll_pending();
    answer_item(0);
    poll_pending();
    assert_taken(1, CDS_NO_ROOM);
    poll_pending();
    answer_item(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
}

/* A READ of more bytes than any servo sends is answered with a range error and no data. */
void test_pipeline_item_beyond_any_reply_is_sent_and_refused(void)
{
    items[0].length = CDS_REPLY_MAX + 1;
    items[1].length = CDS_REPLY_MAX;
    is_sent[2] = false;
    begin();
    poll_pending();
    rig_answer(10, CDS_ERROR_RANGE, NULL, 0);
    assert_taken(1, CDS_NO_ROOM);
    assert_ends(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(CDS_ERROR_RANGE, ended[0].error);
    TEST_ASSERT_EQUAL_UINT8(0, ended[0].length);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
    TEST_ASSERT_EQUAL_UINT8(3, taken);
}

void test_pipeline_item_not_sent_has_no_error_and_no_data(void)
{
    is_sent[2] = false;
    begin();
    poll_pending();
    rig_answer(10, CDS_ERROR_OVERLOAD, (const uint8_t *)"1", 1);
    TEST_ASSERT_EQUAL_UINT8(CDS_ERROR_OVERLOAD, ended[0].error);
    poll_pending();
    answer_item(1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
    assert_taken(2, CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(0, ended[2].error); // the third item has the request of the first
    TEST_ASSERT_EQUAL_UINT8(0, ended[2].length);
}

void test_pipeline_reply_of_another_length_is_not_taken(void)
{
    requests[0].any_length = requests[1].any_length = true; // of a use before
    begin();
    poll_pending();
    rig_answer(10, 0, (const uint8_t *)"12", 2);
    TEST_ASSERT_EQUAL_UINT8(0, taken);
    port_fake.now_us += 10000;
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL_UINT8(1, taken);
    TEST_ASSERT_NOT_EQUAL(CDS_OK, ended[0].result);
    cds_read_pipeline_abort(&pipeline);
    assert_ends(CDS_CANCELLED);
}

void test_pipeline_that_stops_on_failure_stops_at_a_refusal(void)
{
    config.stops_on_failure = true;
    items[0].length = CDS_REPLY_MAX; // beyond the reply buffer
    begin();
    assert_ends(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(1, taken);
    assert_taken(0, CDS_NO_ROOM);
    TEST_ASSERT_NULL(bus.request);
}

void test_pipeline_aborted_after_its_end_leaves_the_requests(void)
{
    static uint8_t bytes[8];
    struct cds_request ping = CDS_REQUEST_WITHOUT_DATA(bytes);

    config.count = 1;
    begin();
    poll_pending();
    answer_item(0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &ping, 77));
    for (uint8_t i = 0; i < 2; i++)
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[i], i)); // waits in the queue
    cds_read_pipeline_abort(&pipeline);
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[0].result);
    TEST_ASSERT_EQUAL(CDS_PENDING, requests[1].result);
    rig_answer(77, 0, NULL, 0);
    rig_answer(0, 0, NULL, 0);
    rig_answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_read_pipeline_poll(&pipeline));
}

void test_pipeline_without_items_or_room_is_refused(void)
{
    config.count = 0;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_read_pipeline_begin(&pipeline, &config));
    config.count = 1;
    for (uint8_t i = 0; i < 2; i++) {
        requests[i].reply_capacity = 3;
        TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_read_pipeline_begin(&pipeline, &config));
        requests[i].reply_capacity = 4;
    }
    TEST_ASSERT_NULL(requests[0].on_end);
}
