/* SPDX-License-Identifier: MIT */
/* Calls that wait, on a bus without servos: each ends, with the result of what it waits for. */
#include "cds55xx/blocking.h"

#include <string.h>

#include "bus_rig.h"
#include "unity.h"

#define ID 7

static uint8_t packet[CDS_PACKET_SIZE(8)], reply[CDS_DIAGNOSE_REPLY_SIZE];
static struct cds_request request;

void setUp(void)
{
    rig_open(0);
    request = (struct cds_request)CDS_REQUEST(packet, reply);
    port_fake.us_per_reading = 10;
    port_fake.eager = &bus.link;
}

void tearDown(void)
{
    rig_check();
    TEST_ASSERT_NULL(bus.request);
    TEST_ASSERT_NULL(bus.lock);
}

void test_blocking_instructions_without_a_reply_end_as_timeout(void)
{
    static const uint8_t data[] = {1, 2};
    struct cds_feedback feedback = {0};

    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_read(&bus, &request, ID, 0, 2));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_write(&bus, &request, ID, 0x1E, data, 2));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_reg_write(&bus, &request, ID, 0x1E, data, 2));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_action(&bus, &request, ID));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_reset(&bus, &request, ID));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_feedback(&bus, &request, ID, &feedback));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, feedback.result);
    TEST_ASSERT_EQUAL_UINT16(6, port_fake.packets);
}

void test_blocking_instructions_pass_a_refusal_to_submit_on(void)
{
    struct cds_feedback feedback = {.result = CDS_OK};

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_read(&bus, &request, 254, 0, 2));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_action(&bus, &request, 255));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_feedback(&bus, &request, 254, &feedback));
    TEST_ASSERT_EQUAL(CDS_OK, feedback.result);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_blocking_tells_that_the_servo_refused(void)
{
    port_fake.us_per_reading = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, ID));
    port_fake_answer(&bus.link, ID, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL(CDS_REFUSED, cds_blocking_for(&bus, &request, CDS_OK));
}

void test_blocking_sync_write_ends_when_all_is_sent(void)
{
    static const uint8_t ids[] = {1, 2, 3}, data[] = {1, 2, 3};
    struct cds_sync_write_many write;
    struct cds_sync_write_many_config config = {.bus = &bus,
                                                .request = &request,
                                                .ids = ids,
                                                .data = data,
                                                .count = 3,
                                                .address = CDS_REG_LED,
                                                .length = 1};

    cds_sync_write_begin(&request, CDS_REG_LED, 1);
    cds_sync_write_add(&request, ID, data);
    TEST_ASSERT_EQUAL(CDS_OK, cds_blocking_sync_write(&bus, &request));
    config.packet_max = CDS_SYNC_WRITE_SIZE(2, 1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_blocking_sync_write_many(&write, &config));
    TEST_ASSERT_EQUAL_UINT8(2, write.packets);
    config.count = 0;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_sync_write_many(&write, &config));
}

void test_blocking_group_read_and_registered_move_end(void)
{
    static const uint8_t ids[] = {1, 2};
    static uint8_t data[2];
    static struct cds_group_answer answers[2];
    static struct cds_goal goals[1] = {{.id = ID, .position = 1}};
    static uint8_t packets[2][CDS_PACKET_SIZE(2)], replies[2][1];
    struct cds_request requests[2] = {CDS_REQUEST(packets[0], replies[0]),
                                      CDS_REQUEST(packets[1], replies[1])};
    struct cds_group_read read;
    struct cds_group_read_config config = {.bus = &bus,
                                           .requests = requests,
                                           .ids = ids,
                                           .data = data,
                                           .answers = answers,
                                           .count = 2,
                                           .length = 1};
    struct cds_registered_move move;
    struct cds_registered_move_config move_config = {
        .bus = &bus, .request = &request, .goals = goals, .count = 1};

    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_group_read(&read, &config));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, answers[1].result);
    config.count = 0;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_group_read(&read, &config));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_registered_move(&move, &move_config));
    move_config.count = 0;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_registered_move(&move, &move_config));
}

void test_blocking_scan_asks_every_id(void)
{
    struct cds_scan scan;
    struct cds_scan_config config = {.bus = &bus, .request = &request, .last_id = 3};

    TEST_ASSERT_EQUAL(CDS_OK, cds_blocking_scan(&scan, &config));
    TEST_ASSERT_EQUAL_UINT16(24, scan.asked);
    config.first_id = 4;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_scan(&scan, &config));
}

void test_blocking_identity_setup_and_diagnose_end(void)
{
    struct cds_identity identity;
    struct cds_identity_config identity_config = {
        .bus = &bus, .request = &request, .change = CDS_IDENTITY_ID, .id = ID, .new_id = 9};
    struct cds_setup setup;
    struct cds_setup_config setup_config = {
        .bus = &bus, .request = &request, .id = ID, .setting = CDS_SETUP_LOCK};
    struct cds_diagnose diagnose;
    struct cds_diagnose_config diagnose_config = {.bus = &bus, .request = &request, .id = ID};

    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_identity(&identity, &identity_config));
    TEST_ASSERT_EQUAL(CDS_IDENTITY_LOST, identity.state);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_blocking_setup(&setup, &setup_config));
    TEST_ASSERT_EQUAL(CDS_OK, cds_blocking_diagnose(&diagnose, &diagnose_config));
    TEST_ASSERT_EQUAL(CDS_FINDING_SILENCE, diagnose.finding);
    identity_config.id = setup_config.id = diagnose_config.id = 255;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_identity(&identity, &identity_config));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_setup(&setup, &setup_config));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_blocking_diagnose(&diagnose, &diagnose_config));
}
