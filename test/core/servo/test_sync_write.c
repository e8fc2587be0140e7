/* SPDX-License-Identifier: MIT */
/* Many servos in one packet: SYNC WRITE. */
#include "cds55xx/sync_write.h"

#include <string.h>

#include "cds55xx/queue.h"
#include "bus_rig.h"
#include "packets.h"
#include "unity.h"

#define PORT 0

static struct cds_queue queue;
static uint8_t buffer[CDS_SYNC_WRITE_SIZE(4, 4)];
static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(buffer);

static uint8_t other_buffer[8];
static struct cds_request other = CDS_REQUEST_WITHOUT_DATA(other_buffer);

void setUp(void)
{
    rig_open_with_queue(PORT, &queue);
    memset(buffer, 0, sizeof buffer);
    request = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(buffer);
    other = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(other_buffer);
}

void tearDown(void)
{
    rig_check();
}

/* ---- SYNC WRITE ---- */

static void begin_example_5(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_sync_write_add_goal(&request, 0, 0x010, 0x150);
    cds_sync_write_add_goal(&request, 1, 0x220, 0x360);
    cds_sync_write_add_goal(&request, 2, 0x030, 0x170);
    cds_sync_write_add_goal(&request, 3, 0x220, 0x380);
}

static const struct manual_packet *const example_5 = &manual_packets[7];

static void assert_example_5_goes_out(void)
{
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    rig_assert_sent(example_5->bytes, example_5->size);
    port_fake_look(&bus);
    TEST_ASSERT_FALSE(cds_bus_is_busy(&bus)); // nothing is answered
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
}

void test_sync_write_of_goals_is_example_5(void)
{
    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    assert_example_5_goes_out();
}

void test_sync_write_of_bytes_is_example_5(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_sync_write_add(&request, 0, (uint8_t[]){0x10, 0x00, 0x50, 0x01});
    cds_sync_write_add(&request, 1, (uint8_t[]){0x20, 0x02, 0x60, 0x03});
    cds_sync_write_add(&request, 2, (uint8_t[]){0x30, 0x00, 0x70, 0x01});
    cds_sync_write_add(&request, 3, (uint8_t[]){0x20, 0x02, 0x80, 0x03});
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    assert_example_5_goes_out();
}

void test_sync_write_past_the_room_is_refused_and_nothing_is_sent(void)
{
    begin_example_5();
    cds_sync_write_add_goal(&request, 4, 0, 0);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
}

void test_sync_write_can_be_begun_anew_after_a_refusal(void)
{
    begin_example_5();
    cds_sync_write_add_goal(&request, 4, 0, 0);
    cds_sync_write_send(&bus, &request);
    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    assert_example_5_goes_out();
}

void test_sync_write_outside_the_control_table_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_sync_write_begin(&request, 0x30, 3));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_sync_write_begin(&request, 0x32, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_sync_write_begin(&request, 0x18, 0));
}

void test_sync_write_takes_its_turn_and_can_be_sent_again(void)
{
    rig_occupy(&other);
    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_sync_write_send(&bus, &request));
    rig_free();
    assert_example_5_goes_out();
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    assert_example_5_goes_out();
}

/* It stands in the buffer that is being sent. */
void test_sync_write_on_its_way_is_not_built_over(void)
{
    static const uint8_t data[4] = {1, 2, 3, 4};

    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_sync_write_begin(&request, CDS_REG_LED, 1));
    cds_sync_write_add(&request, 9, data);
    cds_sync_write_add_goal(&request, 9, 5000, 0);
    assert_example_5_goes_out();
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request)); // nor was it refused for that
}

void test_goal_out_of_range_is_not_sent(void)
{
    static const uint16_t wrong[][3] = {{254, 0, 0},  {255, 0, 0},    {1, 1024, 0},
                                        {1, 0, 1024}, {1, 0x8000, 0}, {1, 1023, UINT16_MAX}};

    for (uint8_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
        cds_sync_write_add_goal(&request, (uint8_t)wrong[i][0], wrong[i][1], wrong[i][2]);
        TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_sync_write_send(&bus, &request));
    }
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_highest_goal_of_the_last_servo_is_sent(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_sync_write_add_goal(&request, 253, 1023, 1023);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((uint8_t[]){253, 0xFF, 0x03, 0xFF, 0x03}), &port_fake.sent[7], 5);
}

/* No packet is begun, or not that of a SYNC WRITE, or one was ended. */
void test_goal_is_put_into_a_sync_write_only(void)
{
    static uint8_t smallest[CDS_PACKET_SIZE(0)]; // of its own, for AddressSanitizer to watch
    struct cds_request small = CDS_REQUEST_WITHOUT_DATA(smallest);

    cds_sync_write_add_goal(&request, 1, 100, 200);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_sync_write_send(&bus, &request));
    cds_packet_begin(&small.packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
    cds_sync_write_add_goal(&small, 1, 100, 200);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_sync_write_send(&bus, &small));
    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    cds_sync_write_add_goal(&request, 1, 100, 200);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_goal_where_blocks_have_another_length_is_not_sent(void)
{
    uint8_t small[6];
    struct cds_request too_small = CDS_REQUEST_WITHOUT_DATA(small);

    for (uint8_t length = 1; length <= 6; length++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, length));
        cds_sync_write_add_goal(&request, 1, 100, 200);
        TEST_ASSERT_EQUAL(length == 4 ? CDS_OK : CDS_BAD_ARGUMENT, cds_packet_end(&request.packet));
    }
    cds_sync_write_begin(&too_small, CDS_REG_GOAL_POSITION, 4);
    cds_sync_write_add_goal(&too_small, 1, 100, 200);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_sync_write_send(&bus, &too_small));
}
