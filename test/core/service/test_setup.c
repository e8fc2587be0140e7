/* SPDX-License-Identifier: MIT */
/* Settings that are written only if they differ, and read back. */
#include "cds55xx/setup.h"

#include "cds55xx/queue.h"
#include "bus_rig.h"
#include "permit_fake.h"
#include "servos_fake.h"
#include "unity.h"

static struct cds_queue queue;
static uint8_t packet[CDS_PACKET_SIZE(5)], reply[4];
static struct cds_request request;
static struct cds_setup setup;
static const uint8_t limits[4] = {0x10, 0x00, 0xF0, 0x03};

void setUp(void)
{
    rig_open(0);
    memset(&servos, 0, sizeof servos);
    request = (struct cds_request)CDS_REQUEST(packet, reply);
    servo_fake_put(0, 5, 1);
}

void tearDown(void)
{
    rig_check();
}

static enum cds_result run(void)
{
    enum cds_result result;

    while ((result = cds_setup_poll(&setup)) == CDS_PENDING) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    return result;
}

static enum cds_result begin(const struct cds_setup_config *what, uint8_t id)
{
    struct cds_setup_config config = *what;

    config.bus = &bus;
    config.request = &request;
    config.id = id;
    return cds_setup_begin(&setup, &config);
}

static enum cds_result begin_write(uint8_t id, uint8_t address, const uint8_t *data, uint8_t length)
{
    struct cds_setup_config config = {.address = address, .length = length, .data = data};

    return begin(&config, id);
}

static enum cds_result begin_limits(void)
{
    return begin_write(5, CDS_REG_CW_ANGLE_LIMIT, limits, 4);
}

static enum cds_result begin_delay(uint16_t delay_us)
{
    struct cds_setup_config config = {.setting = CDS_SETUP_RETURN_DELAY,
                                      .return_delay_us = delay_us};

    return begin(&config, 5);
}

static enum cds_result begin_lock(void)
{
    struct cds_setup_config config = {.setting = CDS_SETUP_LOCK};

    return begin(&config, 5);
}

static bool holds_limits(void)
{
    return memcmp(&servos.servo[0].table[6], limits, 4) == 0;
}

void test_setup_difference_is_written_once_and_read_back(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin_limits());
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_TRUE(setup.is_written);
    TEST_ASSERT_EQUAL_UINT16(3, servos.packets);
    TEST_ASSERT_EQUAL_UINT16(1, servos.writes);
    TEST_ASSERT_TRUE(holds_limits());
    TEST_ASSERT_EQUAL(CDS_OK, begin_limits());
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_FALSE(setup.is_written);
    TEST_ASSERT_EQUAL_UINT16(4, servos.packets);
}

void test_any_byte_that_differs_is_a_difference(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        memcpy(&servos.servo[0].table[6], limits, 4);
        servos.servo[0].table[6 + i] ^= 1;
        begin_limits();
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_TRUE(setup.is_written);
        TEST_ASSERT_TRUE(holds_limits());
    }
}

void test_ok_means_that_it_holds_whatever_was_lost(void)
{
    for (uint8_t fault = 1; fault < FAULTS; fault++)
        for (uint8_t at = 1; at <= 3; at++) {
            setUp();
            servos.plan[0] = (struct servos_plan){at, fault, 0};
            begin_limits();
            if (run() == CDS_OK)
                TEST_ASSERT_TRUE(holds_limits());
            else
                TEST_ASSERT_TRUE(at != 2 || !holds_limits()); // a lost answer alone is made good
            begin_limits();
            TEST_ASSERT_EQUAL(CDS_OK, run());
            TEST_ASSERT_TRUE(holds_limits());
        }
}

void test_an_absent_servo_is_not_written_to(void)
{
    servos.dark = SERVOS_FOREVER;
    begin_limits();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
    TEST_ASSERT_EQUAL_UINT16(1, servos.packets);
    TEST_ASSERT_FALSE(setup.is_written);
}

void test_a_locked_servo_refuses_and_says_why(void)
{
    servos.servo[0].table[0x2F] = 1;
    begin_limits();
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, setup.error);
    TEST_ASSERT_EQUAL_UINT16(3, servos.packets);
}

void test_a_refusal_stands_if_it_cannot_be_read_back(void)
{
    servos.servo[0].table[0x2F] = 1;
    servos.plan[0] = (struct servos_plan){3, LOSE_REPLY, 0};
    begin_limits();
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, setup.error);
}

/* A WRITE that was carried out, and of which only the refusal of its repeat is heard. */
void test_one_that_refuses_and_holds_the_value_has_it(void)
{
    begin_limits();
    while (!servos.packets || bus.request) {
        cds_setup_poll(&setup);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    memcpy(&servos.servo[0].table[6], limits, 4);
    servos.servo[0].table[0x2F] = 1;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_HEX8(0, setup.error);
    TEST_ASSERT_TRUE(setup.is_written);
}

void test_a_lock_whose_answer_is_lost_is_not_sent_twice(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    cds_queue_set_retries(&queue, 2);
    servos.plan[0] = (struct servos_plan){2, LOSE_REPLY, 0};
    TEST_ASSERT_EQUAL(CDS_OK, begin_lock());
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(1, servos.writes);
}

void test_return_delay_is_rounded_up_within_the_bus_deadline(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin_delay(3));
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(2, servos.servo[0].table[5]);
    TEST_ASSERT_EQUAL(CDS_OK, begin_delay(508));
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(254, servos.servo[0].table[5]);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_delay(509));
    cds_bus_set_return_delay(&bus, 10);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_delay(11));
    cds_bus_set_return_delay(&bus, 600);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_delay(509)); // more than the register can hold
}

void test_lock_is_verified_and_may_be_set_already(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL(CDS_OK, begin_lock());
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL_UINT8(1, servos.servo[0].table[0x2F]);
        TEST_ASSERT_EQUAL_UINT8(!i, setup.is_written);
    }
}

void test_an_abort_at_any_poll_ends_it_as_cancelled(void)
{
    for (uint8_t polls = 0; polls < 200; polls++) {
        setUp();
        begin_limits();
        for (uint8_t i = 0; i < polls && cds_setup_poll(&setup) == CDS_PENDING; i++) {
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        if (setup.steps.result != CDS_PENDING)
            return;
        cds_setup_abort(&setup);
        TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
        TEST_ASSERT_NULL(bus.request);
        TEST_ASSERT_EQUAL_UINT8(servos.writes, setup.is_written);
    }
    TEST_FAIL_MESSAGE("never ended");
}

static bool at_its_turn; // not when it is submitted

static enum cds_result refusal;

static enum cds_result refuse_writes(struct cds_request *asked)
{
    bool waits = asked->result == CDS_PENDING;

    if (asked->packet.bytes[CDS_AT_INSTRUCTION] != CDS_WRITE)
        return CDS_OK;
    port_fake.low_looks = at_its_turn && !waits; // it must wait for the line
    return at_its_turn == waits ? refusal : CDS_OK;
}

void test_what_is_not_admitted_was_not_written(void)
{
    for (uint8_t i = 0; i < 2 * (CDS_RESERVED - CDS_LINE_BUSY); i++) {
        setUp();
        at_its_turn = i % 2;
        refusal = (enum cds_result)(CDS_NO_REPLY_DUE + i / 2);
        permit_fake_attach(&bus, refuse_writes);
        TEST_ASSERT_EQUAL(CDS_OK, begin_limits());
        TEST_ASSERT_EQUAL(refusal, run());
        TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
        TEST_ASSERT_FALSE(setup.is_written);
    }
}

void test_nonsense_and_the_identity_are_refused(void)
{
    static const uint8_t data[50];

    for (uint8_t from = 0; from < 50; from++)
        for (uint8_t length = 0; length <= 4; length++) {
            bool fine = length && from + length <= 50 && (from > 4 || from + length <= 3);

            TEST_ASSERT_EQUAL(fine ? CDS_OK : CDS_BAD_ARGUMENT, begin_write(5, from, data, length));
        }
    for (uint8_t length = CDS_TABLE_SIZE - 5; length; length++)
        TEST_ASSERT_EQUAL(length == CDS_TABLE_SIZE - 5 ? CDS_NO_ROOM : CDS_BAD_ARGUMENT,
                          begin_write(5, 5, data, length));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_write(254, 6, data, 1));
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, begin_write(5, 6, data, 5));
    request.reply_capacity = 3;
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, begin_limits());
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT,
                      begin(&(struct cds_setup_config){.setting = CDS_SETUP_LOCK + 1}, 5));
    request.result = CDS_PENDING;
    TEST_ASSERT_EQUAL(CDS_BUSY, begin_limits());
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    memset(&bus, 0, sizeof bus);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_limits());
}

void test_setup_whose_request_is_cancelled_ends_cancelled(void)
{
    begin_limits();
    port_fake.low = true; // the packet has to wait
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_setup_poll(&setup));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
    port_fake.low = false;
    TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
    TEST_ASSERT_EQUAL_UINT16(0, servos.packets);
}

void test_setup_on_a_bus_opened_again_ends_cancelled(void)
{
    for (uint8_t packets = 1; packets <= 3; packets++) {
        setUp();
        begin_limits();
        while (servos.packets < packets) {
            TEST_ASSERT_EQUAL(CDS_PENDING, cds_setup_poll(&setup));
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        cds_bus_open(&bus, 0, CDS_BAUD_1M);
        TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
        TEST_ASSERT_EQUAL_UINT16(packets, servos.packets);
    }
}
