/* SPDX-License-Identifier: MIT */
/* What a servo reports in one READ, and READs of many servos: values, outcomes, ages. */
#include "cds55xx/feedback.h"

#include <string.h>

#include "cds55xx/group_read.h"
#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

/* position 0x0123, speed 0x0405 (CW), load 0x0211, 12.0 V, 32 degrees, registered, -, moving */
static const uint8_t registers[CDS_FEEDBACK_SIZE] = {0x23, 0x01, 0x05, 0x04, 0x11, 0x02,
                                                     0x78, 0x20, 1,    0,    1};

static struct cds_queue queue;
static uint8_t packet_buffer[CDS_PACKET_SIZE(2)], buffer[16];
static struct cds_request request;
static struct cds_feedback feedback;

void setUp(void)
{
    rig_open_with_queue(0, &queue);
    request = (struct cds_request)CDS_REQUEST(packet_buffer, buffer);
    memset(&feedback, 0, sizeof feedback);
}

void tearDown(void)
{
    rig_check();
}

static void answer(uint8_t id, uint8_t error, const uint8_t *data, uint8_t length)
{
    rig_transmit();
    TEST_ASSERT_EQUAL_UINT8(id, port_fake.sent[CDS_AT_ID]);
    port_fake_answer(&bus.link, id, error, data, length);
    port_fake_look(&bus);
}

static void stay_silent(void)
{
    rig_transmit();
    port_fake.now_us += 10000;
    port_fake_look(&bus);
}

static enum cds_result take(void)
{
    return cds_feedback_take(&feedback, &request, cds_port_now_us());
}

static void read_well(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_feedback_read(&bus, &request, 7));
    answer(7, CDS_ERROR_VOLTAGE, registers, sizeof registers);
    TEST_ASSERT_EQUAL(CDS_OK, take());
}

static void assert_values(void)
{
    TEST_ASSERT_TRUE(feedback.known);
    TEST_ASSERT_EQUAL_HEX16(0x0123, feedback.position);
    TEST_ASSERT_EQUAL_HEX16(0x0405, feedback.speed);
    TEST_ASSERT_EQUAL_HEX16(0x0211, feedback.load);
    TEST_ASSERT_EQUAL_UINT8(120, feedback.voltage);
    TEST_ASSERT_EQUAL_UINT8(32, feedback.temperature);
    TEST_ASSERT_EQUAL_UINT8(1, feedback.registered);
    TEST_ASSERT_EQUAL_UINT8(1, feedback.moving);
}

void test_one_read_brings_everything(void)
{
    static const uint8_t packet[] = {0xFF, 0xFF, 7, 4, 2, 0x24, 11, 0xC3};

    port_fake.now_us = 1000;
    TEST_ASSERT_EQUAL(CDS_OK, cds_feedback_read(&bus, &request, 7));
    TEST_ASSERT_EQUAL(CDS_PENDING, take());
    TEST_ASSERT_FALSE(feedback.known);
    answer(7, CDS_ERROR_VOLTAGE, registers, sizeof registers);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, port_fake.sent, sizeof packet);
    TEST_ASSERT_EQUAL(CDS_OK, take());
    assert_values();
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_VOLTAGE, feedback.error);
    TEST_ASSERT_EQUAL_UINT32(1000, feedback.time_us);
}

void test_a_failed_read_keeps_the_old_values_and_their_time(void)
{
    read_well();
    TEST_ASSERT_EQUAL(CDS_OK, cds_feedback_read(&bus, &request, 7));
    memset(buffer, 0, sizeof buffer);
    TEST_ASSERT_EQUAL(CDS_PENDING, take());
    stay_silent();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, take());
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, feedback.result);
    assert_values();
    TEST_ASSERT_EQUAL_UINT32(10000, cds_feedback_age_us(&feedback));
}

void test_a_refusal_brings_error_bits_only(void)
{
    read_well();
    TEST_ASSERT_EQUAL(CDS_OK, cds_feedback_read(&bus, &request, 7));
    answer(7, CDS_ERROR_RANGE, NULL, 0);
    port_fake.now_us = 5;
    TEST_ASSERT_EQUAL(CDS_REFUSED, take());
    TEST_ASSERT_EQUAL(CDS_REFUSED, feedback.result);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, feedback.error);
    TEST_ASSERT_EQUAL_UINT32(0, feedback.time_us);
    assert_values();
}

void test_what_was_never_read_has_no_age(void)
{
    TEST_ASSERT_EQUAL_UINT32(CDS_FEEDBACK_NEVER, cds_feedback_age_us(&feedback));
    TEST_ASSERT_EQUAL(CDS_OK, cds_feedback_read(&bus, &request, 7));
    stay_silent();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, take());
    TEST_ASSERT_EQUAL_UINT32(CDS_FEEDBACK_NEVER, cds_feedback_age_us(&feedback));
}

void test_ages_are_right_across_the_wrap_of_the_clock(void)
{
    port_fake.now_us = 0xFFFFFF00u;
    read_well();
    port_fake.now_us = 0x00000200u;
    TEST_ASSERT_EQUAL_UINT32(0x300, cds_feedback_age_us(&feedback));
}

void test_values_too_old_to_tell_are_no_longer_known(void)
{
    read_well();
    TEST_ASSERT_EQUAL(CDS_OK, cds_feedback_read(&bus, &request, 7));
    stay_silent();
    port_fake.now_us = 0x7FFFFFFFu;
    take();
    TEST_ASSERT_TRUE(feedback.known);
    port_fake.now_us++;
    take();
    TEST_ASSERT_FALSE(feedback.known);
}

/* ---- many servos ---- */

static struct cds_group_read group;
static uint8_t packets[2][CDS_PACKET_SIZE(2)], replies[2][2];
static struct cds_request requests[2];
static struct cds_group_answer answers[3];
static uint8_t data[3 * 2];
static const uint8_t ids[3] = {5, 9, 1};

static void open_requests(void)
{
    for (uint8_t i = 0; i < 2; i++)
        requests[i] = (struct cds_request)CDS_REQUEST(packets[i], replies[i]);
}

static enum cds_result begin_again(const uint8_t *of, uint8_t count, uint8_t length)
{
    struct cds_group_read_config config = {
        .bus = &bus,
        .requests = requests,
        .ids = of,
        .count = count,
        .address = CDS_REG_PRESENT_POSITION,
        .length = length,
        .data = data,
        .answers = answers,
    };

    return cds_group_read_begin(&group, &config);
}

static void begin_group(const uint8_t *of, uint8_t length)
{
    open_requests();
    memset(answers, 0, sizeof answers);
    memset(data, 0xEE, sizeof data);
    TEST_ASSERT_EQUAL(CDS_OK, begin_again(of, 3, length));
}

void test_a_group_is_read_servo_by_servo(void)
{
    static const uint8_t all[] = {5, 1, 9, 1, 1, 1};

    begin_group(ids, 2);
    TEST_ASSERT_NULL(bus.request);
    for (uint8_t i = 0; i < 3; i++) {
        const uint8_t value[2] = {ids[i], 1};

        TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_read_poll(&group));
        TEST_ASSERT_EQUAL(CDS_PENDING, answers[i].result);
        TEST_ASSERT_NULL(requests[i % 2].next);
        port_fake.now_us += 500;
        answer(ids[i], 0, value, 2);
    }
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_read_poll(&group));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(all, data, sizeof all);
    TEST_ASSERT_EQUAL_UINT32(1000, cds_group_read_age_us(&answers[0]));
    TEST_ASSERT_EQUAL_UINT32(500, cds_group_read_age_us(&answers[1]));
    TEST_ASSERT_EQUAL_UINT32(0, cds_group_read_age_us(&answers[2]));
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_read_poll(&group));
    TEST_ASSERT_EQUAL_UINT16(3, port_fake.packets);
}

void test_one_that_fails_does_not_stop_the_others(void)
{
    static const uint8_t all[] = {0xEE, 0xEE, 0xEE, 0xEE, 1, 2}, value[] = {1, 2};

    begin_group(ids, 2);
    cds_group_read_poll(&group);
    stay_silent();
    cds_group_read_poll(&group);
    answer(9, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_read_poll(&group));
    answer(1, 0, value, 2);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_group_read_poll(&group));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(all, data, sizeof all);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, answers[0].result);
    TEST_ASSERT_EQUAL(CDS_REFUSED, answers[1].result);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, answers[1].error);
    TEST_ASSERT_EQUAL(CDS_OK, answers[2].result);
    TEST_ASSERT_EQUAL_UINT32(CDS_GROUP_READ_NEVER, cds_group_read_age_us(&answers[1]));
}

void test_group_read_failed_servo_keeps_data_and_time(void)
{
    static const uint8_t all[] = {5, 1, 8, 8, 8, 8}, old[] = {5, 1}, new[] = {8, 8};

    begin_group(ids, 2);
    cds_group_read_poll(&group);
    answer(5, CDS_ERROR_VOLTAGE, old, 2);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_read_poll(&group));
    cds_bus_open(&bus, 0, CDS_BAUD_1M);  // the others were never read
    port_fake.now_us = UINT32_MAX - 500; // and the clock wraps before they are: in the rest
    answers[0].time_us = port_fake.now_us;
    TEST_ASSERT_EQUAL(CDS_OK, begin_again(ids, 3, 2));
    cds_group_read_poll(&group);
    stay_silent();
    for (uint8_t i = 1; i < 3; i++) {
        cds_group_read_poll(&group);
        answer(ids[i], 0, new, 2);
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_group_read_poll(&group));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(all, data, sizeof all);
    TEST_ASSERT_TRUE(answers[0].known);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, answers[0].result);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_VOLTAGE, answers[0].error);
    TEST_ASSERT_EQUAL_UINT32(port_fake.now_us + 501, cds_group_read_age_us(&answers[0]));
    TEST_ASSERT_LESS_THAN_UINT32(100000, cds_group_read_age_us(&answers[0]));
}

void test_an_impossible_servo_is_passed_over(void)
{
    static const uint8_t some[3] = {254, 9, 255}, value[] = {1, 2};

    begin_group(some, 2);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_read_poll(&group));
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_read_poll(&group));
    answer(9, 0, value, 2);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_group_read_poll(&group));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, answers[0].result);
    TEST_ASSERT_EQUAL(CDS_OK, answers[1].result);
    TEST_ASSERT_TRUE(answers[1].known);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(value, &data[2], sizeof value);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, answers[2].result);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

void test_nobody_to_read_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_again(ids, 0, 1));
    TEST_ASSERT_NULL(bus.request);
}

void test_group_read_no_capacity_or_busy_request_is_refused(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        open_requests();
        requests[i].reply_capacity = 1;
        TEST_ASSERT_EQUAL(CDS_NO_ROOM, begin_again(ids, 3, 2));
        requests[i].reply_capacity = 2;
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[i], 7));
        TEST_ASSERT_EQUAL(CDS_BUSY, begin_again(ids, 3, 2));
        stay_silent();
        requests[i].packet.capacity = CDS_PACKET_SIZE(2) - 1;
        TEST_ASSERT_EQUAL(CDS_NO_ROOM, begin_again(ids, 3, 2));
    }
    memset(&bus, 0, sizeof bus);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_again(ids, 3, 2));
}

void test_group_read_whose_read_is_cancelled_ends(void)
{
    begin_group(ids, 2);
    cds_group_read_poll(&group);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_read_poll(&group));
    rig_transmit();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_group_read_poll(&group));
}

void test_group_read_aborted_keeps_the_reply_in_flight(void)
{
    static const uint8_t value[] = {1, 2}, all[] = {1, 2, 0xEE, 0xEE, 0xEE, 0xEE};

    begin_group(ids, 2);
    cds_group_read_poll(&group);
    cds_group_read_abort(&group);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_read_poll(&group));
    answer(5, 0, value, 2);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_group_read_poll(&group));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(all, data, sizeof all);
    TEST_ASSERT_EQUAL(CDS_OK, answers[0].result);
    TEST_ASSERT_EQUAL(CDS_PENDING, answers[1].result);
    TEST_ASSERT_NULL(bus.request);
}

void test_requests_of_a_higher_priority_slip_in(void)
{
    static const uint8_t value[] = {1, 2};
    static uint8_t bytes[8];
    struct cds_request hurried = CDS_REQUEST_WITHOUT_DATA(bytes);

    hurried.priority = CDS_PRIORITY_HIGH;
    begin_group(ids, 2);
    cds_group_read_poll(&group);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &hurried, 77));
    answer(5, 0, value, 2);
    cds_group_read_poll(&group);
    answer(77, 0, NULL, 0);
    TEST_ASSERT_EQUAL(CDS_OK, hurried.result);
    answer(9, 0, value, 2);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_read_poll(&group));
    answer(1, 0, value, 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_read_poll(&group));
}
