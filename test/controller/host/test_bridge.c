/* SPDX-License-Identifier: MIT */
/* Bridge and virtual device: bytes of the host in and out, packets on the bus. */
#include "bridge_rig.h"
#include "cds55xx/servo.h"

void setUp(void)
{
    open_all();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_packet_of_any_length_goes_out_unchanged(void)
{
    struct cds_stats stats;

    for (uint8_t count = 0; count <= 252; count = (uint8_t)(count + 21)) {
        fill(count, 200);
        say(254, 0x83, data, count);
        assert_sent(254, 0x83, data, count);
        wait_for_deadline();
    }
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    cds_bus_stats(&bus, &stats);
    TEST_ASSERT_EQUAL_UINT16(bridge.counters.passed, stats.ok);
}

void test_reply_of_any_length_and_error_comes_back_unchanged(void)
{
    for (uint8_t count = 0; count <= CDS_REPLY_ANY; count++) {
        SAY(9, CDS_READ, 0, count);
        TEST_ASSERT_TRUE(sent());
        fill(count, 0xF0);
        answer(9, count & 0x7F, data, count);
        assert_heard(9, count & 0x7F, data, count);
    }
    SAY(9, 0x77, 1, 2, 3); // no instruction of a servo
    assert_sent(9, 0x77, (const uint8_t *)"\1\2\3", 3);
    answer(9, 0x40, data, 5);
    assert_heard(9, 0x40, data, 5);
    TEST_ASSERT_EQUAL_UINT16(bridge.counters.answered, bridge.counters.passed);
}

static uint8_t due(uint8_t id, uint8_t length, uint8_t instruction, uint8_t count)
{
    const uint8_t packet[] = {0xFF, 0xFF, id, length, instruction, 0, count, 0};

    return status_packet_due(packet);
}

void test_status_packet_due_follows_the_instruction(void)
{
    TEST_ASSERT_EQUAL_UINT8(8, due(1, 4, CDS_READ, 8));
    TEST_ASSERT_EQUAL_UINT8(50, due(1, 4, CDS_READ, 50));
    TEST_ASSERT_EQUAL_UINT8(0, due(1, 4, CDS_READ, 51));
    TEST_ASSERT_EQUAL_UINT8(0, due(1, 5, CDS_READ, 8)); // no READ that a servo knows
    TEST_ASSERT_EQUAL_UINT8(0, due(1, 2, CDS_PING, 8));
    TEST_ASSERT_EQUAL_UINT8(0, due(1, 4, CDS_WRITE, 8));
    TEST_ASSERT_EQUAL_UINT8(0, due(254, 2, CDS_PING, 8));
    TEST_ASSERT_EQUAL_UINT8(CDS_REPLY_NONE, due(254, 4, CDS_READ, 8));
    TEST_ASSERT_EQUAL_UINT8(CDS_REPLY_NONE, due(254, 8, 0x83, 8));
}

void test_reply_longer_than_the_buffer_is_refused(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(0)], bytes[CDS_REPLY_ANY];
    struct cds_request request = CDS_REQUEST(packet, bytes);

    request.any_length = true;
    cds_packet_ping(&request.packet, 1);
    request.reply_capacity--;
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_bus_submit(&bus, &request));
    request.reply_capacity++;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
    TEST_ASSERT_TRUE(sent());
    answer(1, 0, data, CDS_REPLY_ANY);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL_UINT8(CDS_REPLY_ANY, request.length);
}

void test_reply_missing_or_damaged_is_not_answered(void)
{
    SAY(9, CDS_PING);
    TEST_ASSERT_TRUE(sent());
    wait_for_deadline();
    SAY(9, CDS_PING);
    TEST_ASSERT_TRUE(sent());
    port_fake_hear(&bus.link, (const uint8_t *)"\xFF\xFF\x09\x02\x00\x00", 6);
    wait_for_deadline();
    SAY(9, CDS_PING);
    TEST_ASSERT_TRUE(sent());
    answer(8, 0, NULL, 0); // of another servo
    wait_for_deadline();
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    TEST_ASSERT_EQUAL_UINT16(3, bridge.counters.unanswered);
    TEST_ASSERT_EQUAL_UINT16(3, port_fake.packets); // no retries
}

void test_broadcast_is_answered_only_if_it_is_a_ping(void)
{
    SAY(254, CDS_PING);
    TEST_ASSERT_TRUE(sent());
    answer(42, 0, NULL, 0);
    assert_heard(42, 0, NULL, 0);
    SAY(254, CDS_READ, 0, 1);
    TEST_ASSERT_TRUE(sent());
    turns(2);
    TEST_ASSERT_TRUE(bridge_idle(&bridge)); // it awaits no reply
    TEST_ASSERT_EQUAL_UINT16(0, bridge.counters.unanswered);
}

void test_packet_waits_for_the_reply_to_the_one_before(void)
{
    SAY(1, CDS_PING);
    SAY(2, CDS_PING);
    TEST_ASSERT_TRUE(sent());
    TEST_ASSERT_EQUAL_UINT8(1, port_fake.sent[2]);
    answer(1, 0, NULL, 0);
    assert_heard(1, 0, NULL, 0);
    TEST_ASSERT_TRUE(sent());
    TEST_ASSERT_EQUAL_UINT8(2, port_fake.sent[2]);
    answer(2, 0, NULL, 0);
    assert_heard(2, 0, NULL, 0);
}

void test_reply_without_room_in_the_ring_comes_later_and_whole(void)
{
    SAY(1, CDS_READ, 0, 50);
    TEST_ASSERT_TRUE(sent());
    while (cds_ring_put(&output, 'x')) {
    }
    fill(50, 0);
    port_fake_answer(&bus.link, 1, 0, data, 50);
    for (uint8_t i = 0; i < 20; i++) {
        cds_bus_poll(&bus);
        bridge_poll(&bridge);
    }
    TEST_ASSERT_TRUE(bridge_talks(&bridge));
    for (uint16_t i = 0; i < 64 + 56; i++) { // a byte at a time
        if (ring_peek(&output, 0) != 'x' || i >= 64)
            heard[heard_size++] = ring_peek(&output, 0);
        ring_drop(&output, 1);
        bridge_poll(&bridge);
    }
    TEST_ASSERT_FALSE(bridge_talks(&bridge));
    assert_heard(1, 0, data, 50);
}

/* ---- the device ---- */

void test_registers_do_not_overlap_and_lie_within_the_table(void)
{
    static const uint8_t row[][2] = {
#define ROW(name, address, bytes, access, lowest, highest, unit, what) {address, bytes},
        DEVICE_REGISTERS(ROW)
#undef ROW
    };
    static uint8_t used[DEVICE_TABLE_SIZE];

    memset(used, 0, sizeof used);
    for (uint8_t reg = 0; reg < DEVICE_REGISTER_COUNT; reg++)
        for (uint8_t i = 0; i < row[reg][1]; i++) {
            TEST_ASSERT_LESS_THAN(DEVICE_TABLE_SIZE, row[reg][0] + i);
            TEST_ASSERT_EQUAL_UINT8(0, used[row[reg][0] + i]++);
        }
    TEST_ASSERT_EQUAL(DEVICE_MODEL, DEVICE_SETTING_COUNT); // the first register that is no setting
}

/* A new controller reads 2, and what is read may be written. */
void test_device_echo_takes_each_mode_of_the_console(void)
{
    for (uint8_t echo = SETTINGS_ECHO_OFF; echo <= SETTINGS_ECHO_PERSON; echo++) {
        SAY(DEVICE_IS, CDS_WRITE, 0x08, echo);
        assert_heard(DEVICE_IS, 0, NULL, 0);
        SAY(DEVICE_IS, CDS_READ, 0x08, 1);
        assert_heard(DEVICE_IS, 0, &echo, 1);
    }
    SAY(DEVICE_IS, CDS_WRITE, 0x08, 3);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
}

void test_device_answers_and_the_bus_stays_silent(void)
{
    SAY(DEVICE_IS, CDS_PING);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    SAY(DEVICE_IS, CDS_READ, 0, 4);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x55\xCD\x01\xFD", 4);
    SAY(DEVICE_IS, CDS_READ, 0x0F, 3); // an address without a register reads 0
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\0\0\0", 3);
    SAY(DEVICE_IS, CDS_READ, DEVICE_TABLE_SIZE - 1, 1);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\0", 1);
    SAY(DEVICE_IS, CDS_READ, DEVICE_TABLE_SIZE - 1, 2);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    SAY(DEVICE_IS, CDS_REG_WRITE, 7, 1);
    assert_heard(DEVICE_IS, CDS_ERROR_INSTRUCTION, NULL, 0);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_device_write_is_carried_out_whole_or_not_at_all(void)
{
    SAY(DEVICE_IS, CDS_WRITE, 0x06, 7, 2, 0, 1, 0x34, 0x12); // 0x06 to 0x0B
    assert_heard(DEVICE_IS, 0, NULL, 0);
    TEST_ASSERT_EQUAL_UINT16(7, settings.return_delay);
    TEST_ASSERT_EQUAL_UINT16(2, settings.repeats);
    TEST_ASSERT_EQUAL_UINT16(0x1234, settings.link_loss_ms);
    TEST_ASSERT_EQUAL_UINT16(14, bus.return_delay_us);
    TEST_ASSERT_EQUAL_UINT8(2, robot.queue.retries);
    SAY(DEVICE_IS, CDS_WRITE, 0x06, 9, 3); // 3 is out of range
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    SAY(DEVICE_IS, CDS_WRITE, 0x0F, 0); // no register
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    SAY(DEVICE_IS, CDS_WRITE, 0x02, 1, 5); // VERSION is read-only
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL_UINT16(7, settings.return_delay);
    TEST_ASSERT_EQUAL_UINT16(DEVICE_IS, settings.device_id);
    SAY(DEVICE_IS, CDS_WRITE, 0x0B, 0x56); // the high byte alone
    TEST_ASSERT_EQUAL_UINT16(0x5634, settings.link_loss_ms);
    SAY(DEVICE_IS, CDS_WRITE, 0x0C, 0xCF, 0x07); // 1999
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    SAY(DEVICE_IS, CDS_WRITE, 0x03, 255);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
}

void test_device_change_of_id_is_answered_with_the_old_id(void)
{
    SAY(DEVICE_IS, CDS_WRITE, 0x03, 7);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    SAY(7, CDS_RESET);
    assert_heard(7, 0, NULL, 0);
    SAY(DEVICE_IS, CDS_WRITE, 0x03, DEVICE_OFF);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    SAY(DEVICE_IS, CDS_PING);
    assert_sent(DEVICE_IS, CDS_PING, NULL, 0);
}

void test_device_bus_baud_waits_for_the_end_of_the_transaction(void)
{
    static uint8_t bytes[64];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(bytes);

    cds_packet_ping(&other.packet, 5);
    other.reply_parameters = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
    SAY(DEVICE_IS, CDS_WRITE, 0x05, 34);
    TEST_ASSERT_EQUAL_UINT8(1, bus.baud_reg);
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    TEST_ASSERT_TRUE(sent());
    turns(2000);
    TEST_ASSERT_EQUAL_UINT8(34, bus.baud_reg);
    assert_heard(DEVICE_IS, 0, NULL, 0);
}

void test_device_save_keeps_settings_and_tells_its_end(void)
{
    SAY(DEVICE_IS, CDS_WRITE, 0x04, 16);
    SAY(DEVICE_IS, CDS_WRITE, 0x10, 1);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    SAY(DEVICE_IS, CDS_READ, 0x10, 1);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\1", 1);
    SAY(DEVICE_IS, CDS_WRITE, 0x10, 1); // waits for the save before it
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    while (settings_save_poll(&store)) {
    }
    turns(60);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    while (settings_save_poll(&store)) {
    }
    SAY(DEVICE_IS, CDS_READ, 0x10, 1);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\0", 1);
    settings_load(&store, &settings);
    TEST_ASSERT_EQUAL_UINT8(16, settings.host_baud);
    TEST_ASSERT_EQUAL_UINT8(3, store.sequence + 1); // two saves
}

void test_answer_to_a_delayed_write_is_dropped_after_15_ms(void)
{
    SAY(DEVICE_IS, CDS_WRITE, 0x10, 1);
    SAY(DEVICE_IS, CDS_WRITE, 0x10, 1); // waits for the save before it
    heard_size = 0;
    begin_operation();
    turns(HOST_SILENCE_US / 2 + 10);
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.late);
    while (settings_save_poll(&store)) {
    }
    end_operation();
    turns(100);
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    SAY(DEVICE_IS, CDS_PING);
    TEST_ASSERT_EQUAL_UINT16(6, heard_size);
}

void test_device_save_that_fails_reads_2(void)
{
    eeprom_fake.dead = SETTINGS_PLACE + 3;
    SAY(DEVICE_IS, CDS_WRITE, 0x10, 1);
    while (settings_save_poll(&store)) {
    }
    SAY(DEVICE_IS, CDS_READ, 0x10, 1);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\2", 1);
}

void test_device_reset_restores_the_defaults(void)
{
    SAY(DEVICE_IS, CDS_WRITE, 0x0C, 0x88, 0x13);
    TEST_ASSERT_EQUAL_UINT16(5000, settings.cycle_us);
    SAY(DEVICE_IS, CDS_RESET);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    TEST_ASSERT_EQUAL_UINT16(4000, settings.cycle_us);
}

void test_device_registers_show_the_state_of_the_failsafe(void)
{
    failsafe.reset_cause = FAILSAFE_RESET_WATCHDOG;
    failsafe.link_lost = true;
    cds_servos_add(&robot.servos, 7);
    cds_servos_add(&robot.servos, 9);
    robot_inhibit(&robot);
    robot.states[1].alarms = robot.servos.alarms = CDS_ERROR_OVERLOAD;
    SAY(DEVICE_IS, CDS_READ, 0x12, 4);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x08\x01\x20\x09", 4);
    SAY(DEVICE_IS, CDS_WRITE, 0x14, 0);
    SAY(DEVICE_IS, CDS_READ, 0x12, 4);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x08\x01\x00\xFF", 4);
    TEST_ASSERT_EQUAL_UINT8(CDS_INHIBIT_STOPPED,
                            cds_servos_inhibits(&robot.servos, &robot.states[0]));
    robot.stopping = true;
    SAY(DEVICE_IS, CDS_WRITE, 0x13, 0); // not before torque is off
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_TRUE(failsafe.link_lost);
    robot.stopping = false;
    turns(60);
    TEST_ASSERT_TRUE(failsafe.link_lost);
    SAY(DEVICE_IS, CDS_WRITE, 0x13, 0);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    TEST_ASSERT_FALSE(failsafe.link_lost);
    TEST_ASSERT_EQUAL_UINT8(0, cds_servos_inhibits(&robot.servos, &robot.states[0]));
    SAY(DEVICE_IS, CDS_WRITE, 0x13, 1);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
}

void test_inhibit_register_written_0_releases(void)
{
    robot_inhibit(&robot);
    SAY(DEVICE_IS, CDS_READ, 0x17, 1);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\1", 1);
    SAY(DEVICE_IS, CDS_WRITE, 0x17, 1); // only 0 may be written
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    failsafe.link_lost = true;
    SAY(DEVICE_IS, CDS_WRITE, 0x17, 0);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_TRUE(robot_is_inhibited(&robot));
    failsafe.link_lost = false;
    robot.stopping = true;
    SAY(DEVICE_IS, CDS_WRITE, 0x17, 0); // not before torque is off
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    robot.stopping = false;
    turns(60);
    TEST_ASSERT_TRUE(robot_is_inhibited(&robot));
    SAY(DEVICE_IS, CDS_WRITE, 0x17, 0);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    SAY(DEVICE_IS, CDS_READ, 0x17, 1);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\0", 1);
}

void test_inhibit_of_a_host_packet_sends_nothing(void)
{
    attach(&robot.servos.hooks);
    robot_inhibit(&robot);
    SAY(99, CDS_WRITE, 0x18, 1);
    SAY(254, CDS_WRITE, 0x1E, 0, 2);
    SAY(254, CDS_SYNC_WRITE, 0x1E, 2, 7, 0, 2);
    SAY(99, CDS_REG_WRITE, 0x1E, 0, 2);
    SAY(254, CDS_ACTION);
    SAY(99, CDS_RESET);
    SAY(99, 0x84, 1, 2);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
    TEST_ASSERT_EQUAL_UINT16(7, bridge.counters.refused);
    SAY(99, CDS_WRITE, 0x18, 0);
    assert_sent(99, CDS_WRITE, (const uint8_t *)"\x18\0", 2);
}

void test_delay_below_what_the_board_bears_is_a_range_error(void)
{
    attach(&robot.servos.hooks);
    robot.servos.shortest_delay = 1;
    SAY(99, CDS_WRITE, 0x05, 0);
    assert_heard(99, CDS_ERROR_RANGE, NULL, 0);
    SAY(99, CDS_REG_WRITE, 0x05, 0);
    assert_heard(99, CDS_ERROR_RANGE, NULL, 0);
    SAY(254, CDS_WRITE, 0x05, 0); // a broadcast is never answered
    SAY(254, CDS_SYNC_WRITE, 0x05, 1, 99, 0);
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
    TEST_ASSERT_EQUAL_UINT16(4, robot.servos.too_early);
    SAY(99, CDS_WRITE, 0x05, 1);
    assert_sent(99, CDS_WRITE, (const uint8_t *)"\x05\1", 2);
}

/* A motion moves servo 99. Its goals have a request of their own. */
void test_goal_id_and_rate_in_motion_are_a_range_error(void)
{
    static const uint8_t ids[] = {99}, registers[] = {0x03, 0x04, 0x1E};
    static struct cds_request goals;

    attach(&robot.servos.hooks);
    cds_servos_reserve(&robot.servos, &goals, ids, 1);
    for (uint8_t i = 0; i < sizeof registers; i++) {
        SAY(99, CDS_WRITE, registers[i], 1);
        assert_heard(99, CDS_ERROR_RANGE, NULL, 0);
    }
    SAY(99, CDS_REG_WRITE, 0x1E, 0, 2);
    assert_heard(99, CDS_ERROR_RANGE, NULL, 0);
    SAY(CDS_BROADCAST_ID, CDS_SYNC_WRITE, 0x1E, 2, 99, 0, 2); // no reply is due
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
    TEST_ASSERT_EQUAL_UINT16(5, bridge.counters.refused);
    SAY(98, CDS_WRITE, 0x04, 34);
    assert_sent(98, CDS_WRITE, (const uint8_t *)"\x04\x22", 2);
    wait_for_deadline();
    TEST_ASSERT_TRUE(robot_add(&robot, 99));
    cds_servos_find(&robot.servos, 99)->status_return_level = 1; // PING and READ
    heard_size = 0;
    SAY(99, CDS_WRITE, 0x1E, 0, 2); // the host does not expect an answer to a WRITE
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    TEST_ASSERT_EQUAL_UINT16(6, bridge.counters.refused);
    cds_servos_reserve(&robot.servos, NULL, NULL, 0);
}

/* A packet refused when its turn comes is counted and answered like a packet refused at once. */
void test_inhibit_of_a_host_packet_that_waits_counts_it_refused(void)
{
    static uint8_t buffer[CDS_PACKET_SIZE(0)];
    struct cds_request ping = CDS_REQUEST_WITHOUT_DATA(buffer);

    attach(&robot.servos.hooks);
    cds_servo_ping(&bus, &ping, 7);
    SAY(99, CDS_WRITE, 0x18, 1);
    robot_inhibit(&robot);
    TEST_ASSERT_TRUE(sent());
    answer(7, 0, NULL, 0);
    TEST_ASSERT_EQUAL_UINT16(1, bridge.counters.refused);
    TEST_ASSERT_EQUAL_UINT16(0, bridge.counters.unanswered);
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
    cds_servo_ping(&bus, &ping, 7);
    SAY(99, CDS_WRITE, 0x05, 0);
    robot.servos.shortest_delay = 1;
    TEST_ASSERT_TRUE(robot_release(&robot)); // a change: the permit checks again
    TEST_ASSERT_TRUE(sent());
    answer(7, 0, NULL, 0);
    assert_heard(99, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL_UINT16(2, bridge.counters.refused);
}

/* At 7843 bit/s the PING of another request takes 16 ms. */
void test_packet_that_waits_15_ms_for_the_bus_is_dropped(void)
{
    static uint8_t buffer[CDS_PACKET_SIZE(0)];
    struct cds_request ping = CDS_REQUEST_WITHOUT_DATA(buffer);

    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, CDS_BAUD_MAX));
    cds_servo_ping(&bus, &ping, 7);
    SAY(99, CDS_WRITE, 0x1E, 0, 2);
    TEST_ASSERT_FALSE(bridge_idle(&bridge));
    turns(HOST_SILENCE_US / 2);
    TEST_ASSERT_EQUAL(CDS_PENDING, ping.result);
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.late);
    turns(20000);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_packet_that_waits_15_ms_for_the_bridge_is_dropped(void)
{
    static const uint8_t ping_7[] = {0xFF, 0xFF, 7, 2, 1, 0xF5},
                         read_24[] = {0xFF, 0xFF, 7, 4, 2, 0x18, 1, 0xD9};

    for (uint8_t i = 0; i < sizeof ping_7; i++)
        cds_ring_put(&input, ping_7[i]);
    for (uint8_t i = 0; i < sizeof read_24; i++)
        cds_ring_put(&input, read_24[i]);
    begin_operation();
    for (uint8_t i = 0; i < 200; i++) {
        port_fake.now_us += 100;
        turn();
    }
    end_operation();
    TEST_ASSERT_FALSE(host.has_packet);
    TEST_ASSERT_EQUAL_UINT16(2, host.counters.late);
    TEST_ASSERT_FALSE(host.stop); // the 0x18 stands in a good packet
    turns(200);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
    SAY(7, CDS_PING);
    assert_sent(7, CDS_PING, NULL, 0);
}

void test_answer_without_room_leaves_beside_an_operation(void)
{
    static const uint8_t bulk_read[] = {0, 1, 1, 3}, read[] = {3, 1};

    for (uint8_t is_bulk = 0; is_bulk < 2; is_bulk++) {
        say(is_bulk ? 254 : 1, is_bulk ? INSTRUCTION_BULK_READ : CDS_READ,
            is_bulk ? bulk_read : read, is_bulk ? sizeof bulk_read : sizeof read);
        TEST_ASSERT_TRUE(sent());
        while (cds_ring_put(&output, 'x')) {
        }
        port_fake_answer(&bus.link, 1, 0, data, 1);
        for (uint8_t i = 0; i < 20; i++) {
            cds_bus_poll(&bus);
            bridge_poll(&bridge);
        }
        TEST_ASSERT_TRUE(bridge_talks(&bridge));
        begin_operation();
        turns(20);
        TEST_ASSERT_FALSE(bridge_talks(&bridge)); // the console may print
        TEST_ASSERT_EQUAL_UINT16(64 + 7, heard_size);
        end_operation();
        turns(20);
    }
}

void test_device_read_beside_an_operation_is_answered(void)
{
    static const uint8_t read_all[] = {0xFF, 0xFF, DEVICE_IS, 4, CDS_READ, 0, 0x70, 0x8C};

    for (uint8_t i = 0; i < sizeof read_all; i++)
        cds_ring_put(&input, read_all[i]);
    while (bridge.state != BRIDGE_DEVICE)
        turn();
    begin_operation();
    turns(200);
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
    TEST_ASSERT_EQUAL_UINT16(0x70 + 6, heard_size);
    end_operation();
}

void test_device_write_waits_for_the_end_of_an_operation(void)
{
    static uint8_t bytes[64];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(bytes);

    cds_packet_ping(&other.packet, 5);
    other.reply_parameters = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
    SAY(DEVICE_IS, CDS_WRITE, 0x05, 34);
    begin_operation();
    TEST_ASSERT_TRUE(sent());
    turns(2000);
    TEST_ASSERT_EQUAL_UINT8(1, bus.baud_reg);
    end_operation();
    turns(20);
    TEST_ASSERT_EQUAL_UINT8(34, bus.baud_reg);
}

void test_device_answer_that_waits_has_the_id_that_was_asked(void)
{
    static uint8_t buffer[CDS_PACKET_SIZE(0)];
    struct cds_request action = CDS_REQUEST_WITHOUT_DATA(buffer);

    cds_servo_action(&bus, &action,
                     CDS_BROADCAST_ID); // the rate of the bus cannot change before its end
    SAY(DEVICE_IS, CDS_WRITE, 0x03, 9, 255, 3);
    TEST_ASSERT_EQUAL_UINT16(0, heard_size);
    TEST_ASSERT_TRUE(sent());
    turns(20);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    TEST_ASSERT_EQUAL_UINT8(9, settings.device_id);
    TEST_ASSERT_EQUAL_UINT8(3, bus.baud_reg);
}

void test_device_counter_registers_match_their_counters(void)
{
    struct cds_bus_counts *c = &bus.stats;
    uint16_t *const counts[] = {&c->sent,
                                &c->retried,
                                &c->timeouts,
                                &c->corrupt,
                                &c->line_busy,
                                &c->malformed,
                                &c->not_due[CDS_EVENT_STALE_REPLY],
                                &c->not_due[CDS_EVENT_DUPLICATE_REPLY],
                                &c->not_due[CDS_EVENT_UNEXPECTED_PACKET],
                                &host.counters.malformed,
                                &host.counters.silent,
                                &host.counters.gaps,
                                &host.counters.late,
                                &host.counters.stops,
                                &robot.servos.too_early,
                                &bridge.counters.passed,
                                &bridge.counters.answered,
                                &bridge.counters.unanswered,
                                &bridge.counters.refused};
    static const uint8_t at[] = {0x18, 0x1A, 0x1E, 0x20, 0x22, 0x24, 0x26, 0x28, 0x2A, 0x36,
                                 0x38, 0x3A, 0x4C, 0x48, 0x4A, 0x3E, 0x40, 0x42, 0x44};

    for (uint8_t i = 0; i < sizeof at; i++) {
        uint16_t value = (uint16_t)(0x0100u * (i + 1u) + i);
        uint8_t bytes[2] = {(uint8_t)value, (uint8_t)(value >> 8)};

        *counts[i] = value;
        SAY(DEVICE_IS, CDS_READ, at[i], 2);
        assert_heard(DEVICE_IS, 0, bytes, 2);
    }
    c->sent = 0x1234;
    c->timeouts = 0x0030;
    c->corrupt = 0x0200;
    SAY(DEVICE_IS, CDS_READ, 0x1C, 2); // BUS_OK: all other transactions
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x04\x10", 2);
    gaps = 0x4321;
    SAY(DEVICE_IS, CDS_READ, 0x3C, 2);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x21\x43", 2);
    gaps = 0;
}
