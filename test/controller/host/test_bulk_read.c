/* SPDX-License-Identifier: MIT */
/* SYNC READ and BULK READ: packets of the host, READs on the bus, status packets to the host. */
#include "bridge_rig.h"
#include "cds55xx/control_table.h"
#include "cds55xx/servo.h"

#define SYNC_READ INSTRUCTION_SYNC_READ
#define BULK_READ INSTRUCTION_BULK_READ

void setUp(void)
{
    open_all();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void read_and_answer(uint8_t id, uint8_t address, uint8_t count, uint8_t error,
                            uint8_t answered)
{
    const uint8_t parameters[] = {address, count};

    assert_sent(id, CDS_READ, parameters, 2);
    fill(answered, (uint8_t)(10 * id));
    answer(id, error, data, answered);
}

void test_sync_read_puts_all_servos_into_one_packet(void)
{
    SAY(254, SYNC_READ, 0x24, 2, 3, 1, DEVICE_IS, 2);
    read_and_answer(3, 0x24, 2, 0, 2);
    read_and_answer(1, 0x24, 2, CDS_ERROR_OVERLOAD, 2);
    read_and_answer(2, 0x24, 2, 0, 2);
    turns(20);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x1E\x1F\x0A\x0B\x00\x00\x14\x15", 8);
    TEST_ASSERT_EQUAL_UINT8(0, device.failed);
}

void test_sync_read_marks_the_servos_that_failed(void)
{
    SAY(DEVICE_IS, SYNC_READ, 0x24, 2, 1, 2, 3, 254, 5);
    TEST_ASSERT_TRUE(sent());
    turns(450); // 1 is absent
    read_and_answer(2, 0x24, 2, 0, 2);
    read_and_answer(3, 0x24, 2, CDS_ERROR_RANGE, 0); // refuses
    read_and_answer(5, 0x24, 2, 0, 2);
    turns(20);
    assert_heard(DEVICE_IS, 0x80, (const uint8_t *)"\xFF\xFF\x14\x15\xFF\xFF\xFF\xFF\x32\x33", 10);
    TEST_ASSERT_EQUAL_UINT8(3, device.failed);
    SAY(DEVICE_IS, CDS_READ, 0x50, 32);
    TEST_ASSERT_EQUAL_HEX8(0x0A, heard[5]);
    TEST_ASSERT_EQUAL_HEX8(0x40, heard[5 + 31]);
    SAY(DEVICE_IS, SYNC_READ, 0x24, 2, 5);
    read_and_answer(5, 0x24, 2, 0, 2);
    turns(20);
    TEST_ASSERT_EQUAL_UINT8(0, device.failed);
    SAY(DEVICE_IS, CDS_READ, 0x50, 1);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\0", 1);
}

void test_sync_read_with_retries_sends_a_read_again(void)
{
    cds_queue_set_retries(&robot.queue, 1);
    SAY(254, SYNC_READ, 0x24, 2, 1);
    TEST_ASSERT_TRUE(sent());
    turns(450);
    read_and_answer(1, 0x24, 2, 0, 2);
    turns(20);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x0A\x0B", 2);
}

void test_bulk_read_with_retries_sends_each_read_once(void)
{
    cds_queue_set_retries(&robot.queue, 1);
    for (uint8_t i = 0; i < 2; i++) { // also after a SYNC READ
        SAY(254, BULK_READ, 0, 2, 1, 0x24);
        TEST_ASSERT_TRUE(sent());
        turns(450);
        TEST_ASSERT_FALSE(sent());
        TEST_ASSERT_TRUE(bridge_idle(&bridge));
        SAY(254, SYNC_READ, 0x24, 2, 1);
        TEST_ASSERT_TRUE(sent());
        turns(450);
        read_and_answer(1, 0x24, 2, 0, 2);
    }
}

void test_sync_read_of_more_data_than_ids(void)
{
    uint8_t list[14] = {0x24, 21, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1}, expected[252];

    say(254, SYNC_READ, list, 14);
    for (uint8_t id = 12; id; id--) {
        read_and_answer(id, 0x24, 21, 0, 21);
        memcpy(&expected[21 * (12 - id)], data, 21);
    }
    turns(40);
    assert_heard(DEVICE_IS, 0, expected, 252);
}

void test_sync_read_of_all_that_one_packet_holds(void)
{
    uint8_t list[254] = {0x03, 1};

    for (uint8_t i = 0; i < 250; i++)
        list[2 + i] = i;
    say(254, SYNC_READ, list, 252);
    for (uint8_t i = 0; i < 250; i++)
        read_and_answer(i, 3, 1, 0, 1);
    turns(40);
    for (uint8_t i = 0; i < 250; i++)
        list[i] = (uint8_t)(10 * i);
    assert_heard(DEVICE_IS, 0, list, 250);
}

void test_sync_read_of_too_much_or_nothing_is_a_range_error(void)
{
    SAY(254, SYNC_READ, 0, 85, 1, 2, 3);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    SAY(254, SYNC_READ, 0, 0, 1, 2, 3);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    SAY(254, SYNC_READ, 0, 4);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_bulk_read_hands_over_a_reply_during_the_next_read(void)
{
    SAY(254, BULK_READ, 0, 8, 1, 0x24, 1, DEVICE_IS, 3, 2, 2, 0x24);
    read_and_answer(1, 0x24, 8, 0, 8);
    TEST_ASSERT_EQUAL(CDS_LINK_TALKING, bus.link.state); // servo 3, since 2 is the device
    TEST_ASSERT_EQUAL_UINT16(14 + 7, heard_size);
    TEST_ASSERT_EQUAL_UINT8(DEVICE_IS, heard[14 + 2]);
    heard_size = 14;
    assert_heard(1, 0, data, 8);
    read_and_answer(2, 0x24, 2, CDS_ERROR_VOLTAGE, 2);
    assert_heard(2, CDS_ERROR_VOLTAGE, data, 2);
    turns(20);
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
}

void test_bulk_read_sends_the_next_read_in_the_poll_that_ends_one(void)
{
    SAY(254, BULK_READ, 0, 8, 1, 0x24, 1, 2, 3);
    TEST_ASSERT_TRUE(sent());
    turns(3);
    fill(8, 0);
    port_fake_answer(&bus.link, 1, 0, data, 8);
    for (uint8_t i = 0; i < 3; i++)
        cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_LINK_TALKING, bus.link.state);
    TEST_ASSERT_EQUAL_UINT8(14, cds_ring_count(&output));
    read_and_answer(2, 3, 1, 0, 1);
}

void test_bulk_read_reply_wraps_around_the_end_of_the_ring(void)
{
    for (uint8_t head = 48; head <= 64; head++) { // from its last 14 bytes on, then over its end
        output.head = output.tail = head;
        SAY(254, BULK_READ, 0, 8, 1, 0x24);
        read_and_answer(1, 0x24, 8, 0, 8);
        assert_heard(1, 0, data, 8);
    }
    SAY(254, BULK_READ, 0, 8, 1, 0x24);
    read_and_answer(1, 0x24, 8, CDS_ERROR_RANGE, 0);
    assert_heard(1, CDS_ERROR_RANGE, NULL, 0);
}

void test_bulk_read_reply_that_just_fits_the_ring_does_not_wait(void)
{
    for (uint8_t room = 13; room <= 14; room++) {
        SAY(254, BULK_READ, 0, 8, 1, 0x24);
        TEST_ASSERT_TRUE(sent());
        turns(3);
        while (cds_ring_count(&output) < 64 - room)
            cds_ring_put(&output, 'x');
        fill(8, 0);
        port_fake_answer(&bus.link, 1, 0, data, 8);
        for (uint8_t i = 0; i < 3; i++)
            cds_bus_poll(&bus);
        TEST_ASSERT_EQUAL_UINT8(room == 14 ? 64 : 64 - 13, cds_ring_count(&output));
        turns(20);
    }
}

void test_bulk_read_waits_for_room_in_the_ring(void)
{
    SAY(254, BULK_READ, 0, 1, 1, 3, 1, 2, 3, 1, 4, 3);
    while (cds_ring_put(&output, 'x')) {
    }
    for (uint8_t id = 1; id <= 2; id++) {
        TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
        TEST_ASSERT_EQUAL_UINT8(id, port_fake.sent[2]);
        port_fake_answer(&bus.link, id, 0, &id, 1);
        for (uint8_t i = 0; i < 20; i++) {
            cds_bus_poll(&bus);
            bridge_poll(&bridge);
        }
    }
    TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, bus.link.state); // both reply buffers are full
    TEST_ASSERT_TRUE(bridge_talks(&bridge));               // no text may be put between
    turns(20);
    TEST_ASSERT_EQUAL_UINT16(64 + 7 + 7, heard_size);
    TEST_ASSERT_EQUAL_UINT8(1, heard[64 + 2]);
    TEST_ASSERT_EQUAL_UINT8(2, heard[64 + 7 + 2]);
    heard_size = 0;
    read_and_answer(4, 3, 1, 0, 1);
    assert_heard(4, 0, data, 1);
}

/* Servo 3 gets a READ and answers 500 us later. */
static void hear_slow_servo_3(void)
{
    TEST_ASSERT_TRUE(sent());
    turns(250);
    fill(1, 30);
    answer(3, 0, data, 1);
    turns(20);
}

void test_sync_read_marks_a_servo_that_the_permit_refuses(void)
{
    attach(&robot.servos.hooks);
    cds_servos_add(&robot.servos, 2);
    cds_servos_add(&robot.servos, 3);
    robot.states[0].status_return_level = 0; // answers PING only
    robot.states[1].return_delay = 250;      // 500 us
    cds_bus_set_return_delay(&bus, 2);
    SAY(254, SYNC_READ, 0x24, 1, 1, 2, 3);
    read_and_answer(1, 0x24, 1, 0, 1);
    hear_slow_servo_3();
    assert_heard(DEVICE_IS, 0x80, (const uint8_t *)"\x0A\xFF\x1E", 3);
    TEST_ASSERT_EQUAL_UINT16(2, port_fake.packets);
}

void test_sync_read_uses_the_return_delay_of_each_servo(void)
{
    attach(&robot.servos.hooks);
    cds_servos_add(&robot.servos, 3);
    robot.states[0].return_delay = 250; // 500 us
    cds_bus_set_return_delay(&bus, 2);
    SAY(254, SYNC_READ, 0x24, 1, 1, 3);
    read_and_answer(1, 0x24, 1, 0, 1);
    hear_slow_servo_3();
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x0A\x1E", 2);
}

void test_sync_read_lets_a_waiting_request_go_first(void)
{
    static uint8_t bytes[2][16];
    struct cds_request ping = CDS_REQUEST_WITHOUT_DATA(bytes[0]),
                       torque = CDS_REQUEST_WITHOUT_DATA(bytes[1]);

    attach(&robot.servos.hooks);
    cds_servos_add(&robot.servos, 7);
    SAY(254, SYNC_READ, 0x24, 1, 1, 2, 3);
    cds_servo_ping(&bus, &ping, 7);
    read_and_answer(1, 0x24, 1, 0, 1);
    assert_sent(7, CDS_PING, NULL, 0);
    answer(7, 0, NULL, 0);
    cds_servo_write(&bus, &torque, 7, CDS_REG_TORQUE_ENABLE, (const uint8_t *)"\1", 1);
    TEST_ASSERT_EQUAL(CDS_PENDING, torque.result);
    robot_inhibit(&robot);
    read_and_answer(2, 0x24, 1, 0, 1);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, torque.result);
    read_and_answer(3, 0x24, 1, 0, 1);
    turns(20);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x0A\x14\x1E", 3);
}

void test_bulk_read_stops_after_a_servo_that_does_not_answer(void)
{
    SAY(254, BULK_READ, 0, 1, 1, 3, 1, 9, 3, 1, 2, 3, 1, 4, 3);
    read_and_answer(1, 3, 1, 0, 1);
    assert_heard(1, 0, data, 1);
    TEST_ASSERT_TRUE(sent()); // 9
    TEST_ASSERT_FALSE(bridge_idle(&bridge));
    turns(650);
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    TEST_ASSERT_EQUAL_UINT16(2, port_fake.packets);
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
    TEST_ASSERT_EQUAL_UINT8(1, device.failed);
    SAY(3, CDS_PING);
    TEST_ASSERT_TRUE(sent());
    answer(3, 0, NULL, 0);
    assert_heard(3, 0, NULL, 0);
}

void test_bulk_read_of_a_device_range_beyond_a_reply_is_refused(void)
{
    SAY(254, BULK_READ, 0, CDS_REPLY_MAX + 1, DEVICE_IS, 0, 112, DEVICE_IS, 0, 1, DEVICE_IS, 0);
    turns(20);
    TEST_ASSERT_EQUAL_UINT16(6 + 6 + 7, heard_size);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, heard[CDS_AT_ERROR]);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, heard[6 + CDS_AT_ERROR]);
    TEST_ASSERT_EQUAL_HEX8(0, heard[6 + 6 + CDS_AT_ERROR]);
}

void test_bulk_read_that_is_malformed_is_dropped(void)
{
    memset(buffers, 1, sizeof buffers); // a valid ID where the packet has none
    say(254, BULK_READ, NULL, 0);
    SAY(254, BULK_READ, 0);
    SAY(254, BULK_READ, 0, 1, 1);
    SAY(254, BULK_READ, 0, 1, 254, 3);
    SAY(254, BULK_READ, 0, 1, 1, 3, 1);
    TEST_ASSERT_EQUAL_UINT16(5, bridge.counters.refused);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
}

void test_sync_and_bulk_read_without_a_device_go_out_unchanged(void)
{
    SAY(DEVICE_IS, CDS_WRITE, 0x03, DEVICE_OFF);
    SAY(254, BULK_READ, 0, 1, 1, 3);
    assert_sent(254, BULK_READ, (const uint8_t *)"\0\1\1\3", 4);
    turns(3);
    SAY(DEVICE_IS, SYNC_READ, 3, 1, 1);
    assert_sent(DEVICE_IS, SYNC_READ, (const uint8_t *)"\3\1\1", 3);
    wait_for_deadline();
    SAY(254, SYNC_READ, 3, 1, 1);
    assert_sent(254, SYNC_READ, (const uint8_t *)"\3\1\1", 3);
}

/* ---- beside an operation that has the bus to itself ---- */

/* The bridge answers the next packet with one status packet, that of the servo. */
static void assert_ping_is_answered(void)
{
    SAY(7, CDS_PING);
    assert_sent(7, CDS_PING, NULL, 0);
    answer(7, 0, NULL, 0);
    assert_heard(7, 0, NULL, 0);
}

void test_sync_read_beside_an_operation_is_dropped_after_15_ms(void)
{
    SAY(254, SYNC_READ, 0x24, 1, 1, 2, 3);
    TEST_ASSERT_TRUE(sent());
    begin_operation();
    answer(1, 0, data, 1);
    turns(HOST_SILENCE_US / 2 - 500);
    TEST_ASSERT_FALSE(bridge_idle(&bridge));
    turns(500);
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.late);
    end_operation();
    turns(2000);
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
    assert_ping_is_answered();
}

void test_sync_read_goes_on_after_a_short_operation(void)
{
    SAY(254, SYNC_READ, 0x24, 1, 1, 2);
    TEST_ASSERT_TRUE(sent());
    begin_operation();
    answer(1, 0, (const uint8_t *)"\1", 1);
    turns(2000); // 4 ms
    end_operation();
    TEST_ASSERT_TRUE(sent());
    answer(2, 0, (const uint8_t *)"\2", 1);
    turns(20);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\1\2", 2);
    TEST_ASSERT_EQUAL_UINT16(0, host.counters.late);
}

void test_late_bulk_read_beside_an_operation_ends_after_its_read(void)
{
    SAY(254, BULK_READ, 0, 1, 1, 3, 1, 2, 3);
    TEST_ASSERT_TRUE(sent());
    port_fake.now_us += HOST_SILENCE_US;
    begin_operation();
    turns(500);
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.late);
    end_operation();
    turns(2000);
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
    assert_ping_is_answered();
}
