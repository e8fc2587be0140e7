/* SPDX-License-Identifier: MIT */
/* SYNC WRITE to any number of servos: how it is split, what is sent, and what is refused before
 * anything is. */
#include "cds55xx/sync_write.h"

#include <string.h>

#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

#define PORT   0
#define SERVOS 254 // all there can be

static struct cds_queue queue;
static uint8_t buffer[CDS_SYNC_WRITE_PACKET_MAX];
static struct cds_request request;
static struct cds_sync_write_many group;
static uint8_t ids[SERVOS];
static uint8_t data[SERVOS * 4];

void setUp(void)
{
    rig_open_with_queue(PORT, &queue);
    request = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(buffer);
    for (uint16_t i = 0; i < sizeof ids; i++)
        ids[i] = (uint8_t)(253 - i); // the highest first
    for (uint16_t i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)(i * 7 + i / 251);
}

void tearDown(void)
{
    rig_check();
}

static enum cds_result try_to_begin(uint8_t count, uint8_t address, uint8_t length,
                                    uint16_t packet_max)
{
    struct cds_sync_write_many_config config = {
        .bus = &bus,
        .request = &request,
        .ids = ids,
        .data = data,
        .count = count,
        .address = address,
        .length = length,
        .packet_max = packet_max,
    };

    return cds_sync_write_many_begin(&group, &config);
}

static void begin_short(uint8_t count, uint8_t length, uint16_t packet_max)
{
    TEST_ASSERT_EQUAL(CDS_OK, try_to_begin(count, 0x00, length, packet_max));
}

static void begin(uint8_t count, uint8_t length)
{
    begin_short(count, length, 0);
}

/* The packet now on the line is whole, and holds the servos from `first` on; returns how many. */
static uint8_t assert_packet(uint16_t first, uint8_t length)
{
    const uint8_t *sent = port_fake.sent;
    uint16_t block_size = (uint16_t)(length + 1);
    uint16_t count, size;
    uint8_t sum = 0;

    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    size = port_fake.sent_size;
    count = (uint16_t)((size - 8u) / block_size);
    TEST_ASSERT_EQUAL_UINT16(size, 8u + count * block_size);
    TEST_ASSERT_EQUAL_UINT8(size - 4, sent[3]);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((uint8_t[]){0xFF, 0xFF, 0xFE}), sent, 3);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((uint8_t[]){0x83, 0x00, length}), sent + 4, 3);
    for (uint16_t i = 0; i < count; i++) {
        const uint8_t *block = sent + 7 + i * block_size;

        TEST_ASSERT_EQUAL_UINT8(ids[first + i], block[0]);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(data + (first + i) * length, block + 1, length);
    }
    for (uint16_t i = 2; i < size; i++)
        sum = (uint8_t)(sum + sent[i]);
    TEST_ASSERT_EQUAL_HEX8(0xFF, sum);
    return (uint8_t)count;
}

/* All of it goes out, in `packets`, of which none is longer than `longest`, and none could have
 * taken one servo more. */
static void assert_written(uint8_t count, uint8_t length, uint8_t packets, uint16_t longest)
{
    uint16_t done = 0;

    for (uint8_t i = 0; i < packets; i++) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_sync_write_many_poll(&group));
        TEST_ASSERT_EQUAL_UINT8(i, group.packets);
        TEST_ASSERT_EQUAL_UINT8(done, group.next);
        done = (uint16_t)(done + assert_packet(done, length));
        TEST_ASSERT_LESS_OR_EQUAL(longest, port_fake.sent_size);
        if (i < packets - 1)
            TEST_ASSERT_GREATER_THAN(longest - length - 1, port_fake.sent_size);
        port_fake_look(&bus);
        TEST_ASSERT_FALSE(cds_bus_is_busy(&bus));
    }
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_many_poll(&group));
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_many_poll(&group));
    TEST_ASSERT_EQUAL_UINT16(count, done);
    TEST_ASSERT_EQUAL_UINT8(packets, group.packets);
    TEST_ASSERT_EQUAL_UINT8(count, group.next);
}

/* Begins with the longest packets, and sees all of them leave. */
static void assert_takes_packets(uint8_t packets, uint8_t count, uint8_t length)
{
    begin(count, length);
    assert_written(count, length, packets, 258);
}

void test_what_fits_is_one_packet(void)
{
    assert_takes_packets(1, 1, 1);
    assert_takes_packets(1, 50, 4); // R23
    assert_takes_packets(1, 83, 2);
    assert_takes_packets(1, 125, 1);
}

void test_one_servo_more_is_one_packet_more(void)
{
    assert_takes_packets(2, 51, 4);
    assert_takes_packets(2, 84, 2);
    assert_takes_packets(2, 126, 1);
}

void test_all_254_servos(void)
{
    assert_takes_packets(6, 254, 4);
    assert_takes_packets(3, 254, 1);
}

/* 50 bytes: five servos of 51 make 263, so four in a packet. */
void test_the_whole_table_of_each(void)
{
    assert_takes_packets(1, 4, 50);
    assert_takes_packets(5, 20, 50);
}

void test_a_servo_with_a_short_buffer_sets_the_limit(void)
{
    static const uint8_t limits[][3] = {
        // longest, servos, packets: 4 bytes each
        {64, 18, 2}, {63, 11, 1}, {63, 12, 2}, {62, 11, 2}, {143, 27, 1}, {143, 28, 2}, {13, 3, 3},
    };

    for (uint8_t i = 0; i < sizeof limits / 3; i++) {
        begin_short(limits[i][1], 4, limits[i][0]);
        assert_written(limits[i][1], 4, limits[i][2], limits[i][0]);
    }
}

void test_the_buffer_sets_the_limit_too(void)
{
    request.packet.capacity = CDS_SYNC_WRITE_SIZE(3, 4) + 4;
    begin_short(7, 4, 143);
    assert_written(7, 4, 3, request.packet.capacity);
}

/* LENGTH does, whatever is asked for and however large the buffer. */
void test_a_longer_limit_than_there_is_packet(void)
{
    static uint8_t large[300];

    request = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(large);
    begin_short(51, 4, 1000);
    assert_written(51, 4, 2, 258);
}

static void assert_refused(enum cds_result result, uint8_t count, uint8_t address, uint8_t length)
{
    TEST_ASSERT_EQUAL(result, try_to_begin(count, address, length, 0));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, request.result);
}

void test_one_bad_id_anywhere_and_nothing_is_sent(void)
{
    for (uint8_t at = 0; at < 60; at++) {
        for (uint8_t id = 255; id > CDS_ID_MAX; id--) {
            uint8_t good = ids[at];

            ids[at] = id;
            assert_refused(CDS_BAD_ARGUMENT, 60, 0, 4);
            ids[at] = good;
        }
    }
}

void test_bad_arguments_are_refused(void)
{
    assert_refused(CDS_BAD_ARGUMENT, 0, 0, 4);
    assert_refused(CDS_BAD_ARGUMENT, 60, 0, 0);
    assert_refused(CDS_BAD_ARGUMENT, 60, 0, 51);
    assert_refused(CDS_BAD_ARGUMENT, 60, 0x2F, 4);
    begin(60, 4);
    bus = (struct cds_bus){.port = 0}; // not open
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_sync_write_many_poll(&group));
    assert_refused(CDS_BAD_ARGUMENT, 60, 0, 4);
}

void test_no_room_for_even_one_servo(void)
{
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, try_to_begin(2, 0, 4, CDS_SYNC_WRITE_SIZE(1, 4) - 1));
    for (uint8_t room = 0; room < CDS_SYNC_WRITE_SIZE(1, 4); room++) {
        request.packet.capacity = room;
        assert_refused(CDS_NO_ROOM, 2, 0, 4);
    }
    request.packet.capacity = CDS_SYNC_WRITE_SIZE(1, 4);
    begin(2, 4);
    assert_written(2, 4, 2, 13);
}

void test_an_abort_lets_the_packet_on_the_wire_out(void)
{
    begin(120, 4);
    cds_sync_write_many_poll(&group);
    cds_sync_write_many_abort(&group);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_sync_write_many_poll(&group));
    assert_packet(0, 4);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_sync_write_many_poll(&group));
    TEST_ASSERT_EQUAL_UINT8(50, group.next);
    TEST_ASSERT_EQUAL_UINT8(1, group.packets);
    TEST_ASSERT_NULL(bus.request);
}

void test_nothing_is_sent_before_the_first_poll(void)
{
    begin(60, 4);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
}

/* A request that another transaction uses is not built over. */
void test_a_request_on_its_way_is_not_taken(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_BUSY, try_to_begin(60, 0, 4, 0));
    TEST_ASSERT_EQUAL_HEX8(CDS_ACTION, buffer[4]);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_look(&bus);
    TEST_ASSERT_FALSE(cds_bus_is_busy(&bus));
    assert_takes_packets(2, 60, 4);
}

void test_request_that_is_in_use_at_first_is_awaited(void)
{
    begin(60, 4);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_sync_write_many_poll(&group));
    TEST_ASSERT_EQUAL_HEX8(CDS_ACTION, buffer[4]);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_look(&bus);
    assert_written(60, 4, 2, 258);
}

/* The bus stays taken for no longer than a turn of the main loop. */
void test_many_next_packet_leaves_in_the_poll_that_ends_the_last(void)
{
    begin(60, 4);
    cds_sync_write_many_poll(&group);
    assert_packet(0, 4);
    port_fake_look(&bus);
    cds_sync_write_many_poll(&group);
    TEST_ASSERT_EQUAL(CDS_LINK_TALKING, bus.link.state);
}

/* What is in flight leaves: this one is next. */
static void assert_next(struct cds_request *next, uint8_t instruction)
{
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL_PTR(next, bus.request);
    TEST_ASSERT_EQUAL_HEX8(instruction, bus.request->packet.bytes[4]);
}

void test_all_packets_have_the_priority_of_the_request(void)
{
    static uint8_t bytes[2][8];
    struct cds_request flying = {.packet = {.bytes = bytes[0], .capacity = 8}};
    struct cds_request waiting = {.packet = {.bytes = bytes[1], .capacity = 8}};

    cds_servo_action(&bus, &flying, CDS_BROADCAST_ID);
    cds_servo_action(&bus, &waiting, CDS_BROADCAST_ID);
    request.priority = CDS_PRIORITY_HIGH;
    begin(60, 4);
    cds_sync_write_many_poll(&group);
    assert_next(&request, CDS_SYNC_WRITE); // before the one that waits
    cds_servo_action(&bus, &flying, CDS_BROADCAST_ID);
    assert_next(&waiting, CDS_ACTION); // it was next before the second part was there
    cds_sync_write_many_poll(&group);
    assert_next(&request, CDS_SYNC_WRITE); // before `flying`
    assert_next(&flying, CDS_ACTION);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_many_poll(&group));
}

void test_requests_of_a_higher_priority_slip_in(void)
{
    static uint8_t bytes[8];
    struct cds_request hurried = {.packet = {.bytes = bytes, .capacity = 8},
                                  .priority = CDS_PRIORITY_HIGH};

    begin(60, 4);
    cds_sync_write_many_poll(&group);
    cds_servo_action(&bus, &hurried, CDS_BROADCAST_ID);
    assert_next(&hurried, CDS_ACTION);
    cds_sync_write_many_poll(&group);
    assert_next(&request, CDS_SYNC_WRITE);
    assert_packet(50, 4);
}

/* A transmitter that is dead, a bus that is opened anew: the remaining packets stay unsent. */
void test_a_packet_that_never_leaves_ends_it(void)
{
    begin(120, 4);
    cds_sync_write_many_poll(&group);
    assert_packet(0, 4);
    port_fake_look(&bus);
    cds_sync_write_many_poll(&group);
    port_fake.now_us += 10000;
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_sync_write_many_poll(&group));
    TEST_ASSERT_EQUAL_UINT8(50, group.next);
    TEST_ASSERT_EQUAL_UINT8(1, group.packets);
    TEST_ASSERT_NULL(bus.request);
    begin(120, 4);
    cds_sync_write_many_poll(&group);
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_sync_write_many_poll(&group));
    TEST_ASSERT_EQUAL_UINT8(0, group.next);
    TEST_ASSERT_NULL(bus.request);
}
