/* SPDX-License-Identifier: MIT */
/* Another baud rate for several servos: where the servos and the bus are afterwards. */
#include "robot/baud_change.h"

#include "bus_rig.h"
#include "permit_fake.h"
#include "servos_fake.h"
#include "unity.h"

#define OLD 1
#define NEW 3

static uint8_t buffer[CDS_PACKET_SIZE(2)];
static struct cds_request request;
static struct baud_change change;

void setUp(void)
{
    port_fake_reset();
    memset(&servos, 0, sizeof servos);
    memset(&bus, 0, sizeof bus);
    request = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(buffer);
    for (uint8_t i = 0; i < SERVOS_FAKE; i++)
        servo_fake_put(i, (uint8_t)(i + 1), OLD);
    cds_bus_open(&bus, 0, OLD);
    cds_bus_set_return_delay(&bus, 2);
}

void tearDown(void)
{
    rig_check();
}

static enum cds_result begin(uint8_t count)
{
    static const uint8_t ids[] = {1, 2, 3};

    return baud_change_begin(
        &change,
        &(struct baud_change_config){
            .bus = &bus, .request = &request, .ids = ids, .count = count, .baud_reg = NEW});
}

static enum cds_result run(void)
{
    enum cds_result result;

    TEST_ASSERT_EQUAL(CDS_OK, begin(3));
    while ((result = baud_change_poll(&change)) == CDS_PENDING) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL_UINT8(bus.baud_reg, port_fake.bauds[0]);
    TEST_ASSERT_NULL(bus.lock);
    return result;
}

static void assert_at(uint8_t index, uint8_t baud_reg, uint8_t state)
{
    TEST_ASSERT_EQUAL_UINT8(baud_reg, servos.servo[index].table[0x04]);
    TEST_ASSERT_EQUAL_UINT8(state, change.states[index]);
}

void test_all_servos_and_bus_go_to_new_rate(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, run());
    for (uint8_t i = 0; i < 3; i++)
        assert_at(i, NEW, CDS_IDENTITY_CHANGED);
    TEST_ASSERT_EQUAL_UINT8(NEW, bus.baud_reg);
    TEST_ASSERT_EQUAL_UINT16(3, servos.writes);
}

void test_servo_that_refuses_stays_and_bus_goes_along(void)
{
    servos.servo[1].table[0x2F] = 1; // locked
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_at(0, NEW, CDS_IDENTITY_CHANGED);
    assert_at(1, OLD, CDS_IDENTITY_UNCHANGED);
    assert_at(2, NEW, CDS_IDENTITY_CHANGED);
    TEST_ASSERT_EQUAL_UINT8(CDS_REFUSED, change.results[1]);
    TEST_ASSERT_EQUAL_UINT8(NEW, bus.baud_reg);
}

void test_lost_write_is_tried_again(void)
{
    servos.plan[0] = (struct servos_plan){.at = 5, .fault = LOSE_PACKET}; // the WRITE to servo 1
    TEST_ASSERT_EQUAL(CDS_OK, run());
    for (uint8_t i = 0; i < 3; i++)
        assert_at(i, NEW, CDS_IDENTITY_CHANGED);
}

void test_every_lost_packet_and_reply_is_made_good(void)
{
    for (uint8_t fault = LOSE_PACKET; fault <= SPOIL_REPLY; fault++) {
        for (uint8_t at = 1; at <= 30; at++) {
            setUp();
            servos.plan[0] = (struct servos_plan){.at = at, .fault = fault};
            TEST_ASSERT_EQUAL(CDS_OK, run());
            for (uint8_t i = 0; i < 3; i++)
                assert_at(i, NEW, CDS_IDENTITY_CHANGED);
        }
    }
}

void test_servo_at_new_rate_already_has_followed(void)
{
    servo_fake_put(2, 3, NEW);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_at(2, NEW, CDS_IDENTITY_CHANGED);
    TEST_ASSERT_EQUAL_UINT16(2, servos.writes);
}

void test_absent_servo_is_lost_and_others_follow(void)
{
    servos.servo[0].there = false;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(CDS_IDENTITY_LOST, change.states[0]);
    TEST_ASSERT_EQUAL_UINT8(CDS_TIMEOUT, change.results[0]);
    assert_at(1, NEW, CDS_IDENTITY_CHANGED);
    TEST_ASSERT_EQUAL_UINT8(NEW, bus.baud_reg);
}

void test_bus_stays_if_no_servo_follows(void)
{
    for (uint8_t i = 0; i < 3; i++)
        servos.servo[i].there = false;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(OLD, bus.baud_reg);
}

void test_count_out_of_range_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin(0));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin(BAUD_CHANGE_SERVOS + 1));
}
