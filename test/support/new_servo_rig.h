/* SPDX-License-Identifier: MIT */
/* What suites of new_servo.h share: the set-up of a servo of servos_fake.h as ID NEW at HOME, the
 * rate of the bus:
 *
 *     servo_fake_put(0, 1, 34);
 *     rig_begin_new_servo();
 *     TEST_ASSERT_EQUAL_UINT8(NEW_SERVO_OK, rig_run_new_servo());
 *     rig_assert_set_up();
 */
#ifndef NEW_SERVO_RIG_H
#define NEW_SERVO_RIG_H

#include "bus_rig.h"
#include "robot/new_servo.h"
#include "servos_fake.h"
#include "unity.h"

#define HOME 1
#define NEW  9

static uint8_t buffer[32];
static uint8_t reply[CDS_REPLY_MAX];
static struct cds_request request;
static struct new_servo servo;
static struct cds_servo_state states[2]; // of `known`
static struct cds_servos known;

/* setUp(): there are no servos, and none is known. */
static inline void rig_open_new_servo(void)
{
    port_fake_reset();
    memset(&servos, 0, sizeof servos);
    memset(&bus, 0, sizeof bus);
    known = (struct cds_servos){.states = states};
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    cds_bus_open(&bus, 0, HOME);
    cds_bus_set_return_delay(&bus, 2);
}

static inline void rig_begin_new_servo(void)
{
    TEST_ASSERT_EQUAL(CDS_OK,
                      new_servo_begin(&servo, &(struct new_servo_config){.bus = &bus,
                                                                         .request = &request,
                                                                         .servos = &known,
                                                                         .id = NEW,
                                                                         .return_delay = 1}));
}

/* A poll of the set-up and a turn of the main loop. */
static inline void rig_turn_new_servo(void)
{
    new_servo_poll(&servo);
    servos_turn(&bus);
    cds_bus_poll(&bus);
}

/* Returns the outcome. */
static inline uint8_t rig_run_new_servo(void)
{
    while (new_servo_poll(&servo) == CDS_PENDING) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL_UINT8(HOME, bus.baud_reg);
    TEST_ASSERT_NULL(bus.lock);
    return servo.outcome;
}

static inline void rig_assert_set_up(void)
{
    TEST_ASSERT_EQUAL_UINT8(NEW, servos.servo[0].table[0x03]);
    TEST_ASSERT_EQUAL_UINT8(HOME, servos.servo[0].table[0x04]);
    TEST_ASSERT_EQUAL_UINT8(1, servos.servo[0].table[0x05]);
}

#endif
