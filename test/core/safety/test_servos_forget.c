/* SPDX-License-Identifier: MIT */
/* One servo leaves the list: cds_servos_forget_one(). */
#include <string.h>

#include "bus_rig.h"
#include "cds55xx/control_table.h"
#include "cds55xx/servo.h"
#include "cds55xx/servos.h"
#include "unity.h"

#define PORT 1

static struct cds_servos servos;
static struct cds_queue queue;
static struct cds_servo_state states[4];
static uint8_t buffer[CDS_PACKET_SIZE(CDS_REPLY_MAX)], reply[CDS_REPLY_MAX];
static struct cds_request request;

void setUp(void)
{
    rig_open(PORT);
    memset(&servos, 0, sizeof servos);
    memset(states, 0, sizeof states);
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    states[0].id = 1;
    states[1].id = 2;
    states[2].id = 30;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                                            .queue = &queue,
                                                                            .states = states,
                                                                            .count = 3,
                                                                            .capacity = 4}));
}

void tearDown(void)
{
    rig_check();
}

/* The request that was submitted gets no reply. */
static void silence(enum cds_result submitted)
{
    TEST_ASSERT_EQUAL(CDS_OK, submitted);
    rig_transmit();
    port_fake.now_us += 5000;
    for (uint8_t i = 0; i < 20; i++)
        cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

void test_forget_one_moves_the_last_entry_with_what_is_known(void)
{
    cds_servos_inhibit(&servos, &states[2], CDS_INHIBIT_STOPPED);
    states[2].presence = CDS_PRESENCE_ONLINE;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_forget_one(&servos, &states[0]));
    TEST_ASSERT_EQUAL_UINT8(2, servos.count);
    TEST_ASSERT_EQUAL_UINT8(30, states[0].id);
    TEST_ASSERT_EQUAL_UINT8(CDS_INHIBIT_STOPPED, states[0].inhibits);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 30));
    TEST_ASSERT_NULL(cds_servos_find(&servos, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_forget_one(&servos, &states[1])); // the last entry
    TEST_ASSERT_EQUAL_UINT8(1, servos.count);
}

void test_forget_one_is_refused_while_the_bus_has_a_request(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 2));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servos_forget_one(&servos, &states[0]));
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
    silence(CDS_OK);
}

void test_forget_one_keeps_both_entries_of_an_id_in_doubt(void)
{
    silence(cds_servo_write_byte(&bus, &request, 30, CDS_REG_ID, 31));
    TEST_ASSERT_EQUAL_UINT8(4, servos.count);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servos_forget_one(&servos, &states[2]));
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servos_forget_one(&servos, &states[0])); // entry 3 moves to place 0
    TEST_ASSERT_EQUAL_UINT8(31, states[0].id);
    TEST_ASSERT_EQUAL_UINT8(2, states[0].second);
    TEST_ASSERT_EQUAL_UINT8(0, states[2].second);
}
