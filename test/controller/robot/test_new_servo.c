/* SPDX-License-Identifier: MIT */
/* The set-up of a new servo, with packets and replies lost. */
#include "robot/new_servo.h"

#include "bus_rig.h"
#include "permit_fake.h"
#include "servos_fake.h"
#include "unity.h"

#define HOME 1
#define NEW  9

/* The simulated AVR is slow: it tries a part of the faults. */
#ifdef __AVR__
#define PART        20
#define POLLS_TIMES 16
#else
#define PART        1
#define POLLS_TIMES 2
#endif

static uint8_t buffer[32];
static uint8_t reply[CDS_REPLY_MAX];
static struct cds_request request;
static struct new_servo servo;
static struct cds_servo_state states[2];
static struct cds_servos known;

void setUp(void)
{
    port_fake_reset();
    memset(&servos, 0, sizeof servos);
    memset(&bus, 0, sizeof bus);
    known = (struct cds_servos){.states = states};
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    cds_bus_open(&bus, 0, HOME);
    cds_bus_set_return_delay(&bus, 2);
}

void tearDown(void)
{
    rig_check();
}

static void begin(void)
{
    TEST_ASSERT_EQUAL(CDS_OK,
                      new_servo_begin(&servo, &(struct new_servo_config){.bus = &bus,
                                                                         .request = &request,
                                                                         .servos = &known,
                                                                         .id = NEW,
                                                                         .return_delay = 1}));
}

static uint8_t run(void)
{
    while (new_servo_poll(&servo) == CDS_PENDING) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL_UINT8(HOME, bus.baud_reg);
    TEST_ASSERT_NULL(bus.lock);
    return servo.outcome;
}

static void know(uint8_t id)
{
    states[0].id = 5;
    states[1].id = id;
    known.count = 2;
}

static void assert_set_up(void)
{
    TEST_ASSERT_EQUAL_UINT8(NEW, servos.servo[0].table[0x03]);
    TEST_ASSERT_EQUAL_UINT8(HOME, servos.servo[0].table[0x04]);
    TEST_ASSERT_EQUAL_UINT8(1, servos.servo[0].table[0x05]);
}

void test_servo_at_listed_rate_is_set_up(void)
{
    servo_fake_put(0, 1, 34);
    begin();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, run());
    assert_set_up();
    TEST_ASSERT_EQUAL_UINT8(1, servo.found[0].id);
    TEST_ASSERT_EQUAL_UINT8(34, servo.found[0].baud_reg);
    TEST_ASSERT_FALSE(servo.searched_any);
}

void test_servo_at_unlisted_rate_is_set_up(void)
{
    servo_fake_put(0, 200, 66);
    begin();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, run());
    assert_set_up();
    TEST_ASSERT_TRUE(servo.searched_any);
}

void test_servo_in_place_is_not_changed(void)
{
    servo_fake_put(0, NEW, HOME);
    servos.servo[0].table[0x05] = 1;
    begin();
    know(NEW); // as its reply to the search does if link_loss_ms is set
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, run());
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

void test_servo_that_is_not_alone_is_not_changed(void)
{
    servo_fake_put(0, 1, HOME);
    servo_fake_put(1, 2, 34);
    begin();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_NOT_ALONE, run());
    TEST_ASSERT_EQUAL_UINT8(2, servo.count);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

void test_known_id_at_rate_of_bus_is_not_changed(void)
{
    servo_fake_put(0, 1, HOME);
    know(1);
    begin();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_KNOWN, run());
    TEST_ASSERT_EQUAL_UINT8(1, servo.id);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

void test_known_id_at_another_rate_is_set_up(void)
{
    servo_fake_put(0, 1, 34);
    know(1);
    begin();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, run());
    assert_set_up();
}

void test_no_servo_is_found(void)
{
    begin();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_NONE, run());
}

void test_lost_packets_and_replies_of_set_up_are_tried_again(void)
{
    const uint16_t search = 254 * CDS_SCAN_LISTED_BAUDS;

    for (uint8_t at = 1; at <= 20; at = (uint8_t)(at + PART)) {
        setUp();
        servo_fake_put(0, 1, 34);
        begin();
        while (servos.packets < search) { // struct servos_plan counts up to 255
            new_servo_poll(&servo);
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        servos.packets = 0;
        servos.plan[0] = (struct servos_plan){.at = at, .fault = (uint8_t)(LOSE_PACKET + at % 3)};
        TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, run());
        assert_set_up();
    }
}

void test_servo_lost_after_write_of_id_ends_as_lost(void)
{
    servo_fake_put(0, 1, HOME);
    begin();
    while (servo.step != NEW_SERVO_SET_ID) {
        new_servo_poll(&servo);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    while (servos.servo[0].table[0x03] != NEW) {
        new_servo_poll(&servo);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    servos.servo[0].there = false;
    servos.packets = 0;
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_LOST, run());
    TEST_ASSERT_LESS_THAN_UINT16(50, servos.packets);
}

void test_locked_servo_ends_as_refused(void)
{
    servo_fake_put(0, 1, HOME);
    servos.servo[0].table[0x2F] = 1;
    begin();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_FAILED, run());
    TEST_ASSERT_EQUAL_UINT8(CDS_REFUSED, servo.result);
}

void test_two_servos_with_one_id_end_as_damaged(void)
{
    servo_fake_put(0, 1, HOME);
    servo_fake_put(1, 1, HOME);
    begin();
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_DAMAGED, run());
    TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_CHECK, servo.step);
}

void test_abort_ends_each_search(void)
{
    for (uint32_t polls = 0; polls < 12000; polls = polls * POLLS_TIMES + 1) {
        setUp();
        begin();
        for (uint32_t i = 0; i < polls; i++) {
            new_servo_poll(&servo);
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        new_servo_abort(&servo);
        TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_ENDED, run());
    }
}
