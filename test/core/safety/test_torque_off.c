/* SPDX-License-Identifier: MIT */
/* Torque off for all, on a wire that takes its time: nothing that drives goes out any more, three
 * broadcasts, and each servo looked at until it is known. */
#include "cds55xx/torque_off.h"

#include "bus/steps_internal.h" // an operation that holds the bus
#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "cds55xx/sync_write.h"
#include "bus_rig.h"
#include "torque_fake.h"
#include "unity.h"

#define BROADCAST_US 80 // on the wire
#define READ_US      (80 + 2 + 80)
#define TOLD         (CDS_TORQUE_OFF_BROADCASTS + CDS_TORQUE_OFF_CLEARS) // packets
#define TURN_US      10 // from the end of one to the beginning of the next, polled every microsecond

static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state states[TORQUE_SERVOS];
static struct cds_torque_off torque_off;
static uint8_t packets[4][32], replies[4][2];
static struct cds_request requests[4];

static void begin_servos(struct cds_queue *with, uint8_t count)
{
    bus.hooks = NULL;
    TEST_ASSERT_EQUAL(
        CDS_OK, cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                                      .queue = with,
                                                                      .states = states,
                                                                      .count = count,
                                                                      .capacity = TORQUE_SERVOS}));
}

void setUp(void)
{
    rig_open(0);
    memset(&wire, 0, sizeof wire);
    memset(&torque_off, 0, sizeof torque_off);
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++) {
        states[i].id = (uint8_t)(i + 1);
        wire.servo[i].torque = 1;
    }
    for (uint8_t i = 0; i < 4; i++)
        requests[i] = (struct cds_request)CDS_REQUEST(packets[i], replies[i]);
    begin_servos(&queue, TORQUE_SERVOS);
}

void tearDown(void)
{
    rig_check();
}

static void begin(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_torque_off_begin(&torque_off, &servos));
}

/* Until it is over, at most 30 ms. */
static enum cds_result run(void)
{
    for (uint16_t i = 0; i < 60000 && cds_torque_off_poll(&torque_off) == CDS_PENDING; i++) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
    }
    return cds_torque_off_poll(&torque_off);
}

static void run_for(uint16_t us)
{
    while (us--) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
    }
}

/* From packet `first` on: torque off three times, then registered writes are cleared three times.
 */
static void assert_packets_tell_all(uint8_t first)
{
    for (uint8_t i = first; i < first + TOLD; i++) {
        TEST_ASSERT_EQUAL_HEX8(CDS_BROADCAST_ID, wire.log[i].id);
        TEST_ASSERT_EQUAL_HEX8(CDS_WRITE, wire.log[i].instruction);
        TEST_ASSERT_EQUAL_HEX8(i < first + 3 ? 0x18 : 0x2C, wire.log[i].address);
        TEST_ASSERT_EQUAL_HEX8(0, wire.log[i].data);
    }
}

static void assert_all_told(uint8_t first)
{
    assert_packets_tell_all(first);
    TEST_ASSERT_EQUAL_UINT8(3, torque_off.broadcasts);
}

void test_broadcasts_go_first_then_each_servo_is_read(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    TEST_ASSERT_EQUAL_UINT8(TOLD + TORQUE_SERVOS, wire.count);
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++) {
        TEST_ASSERT_EQUAL_HEX8(i + 1, wire.log[TOLD + i].id);
        TEST_ASSERT_EQUAL_HEX8(CDS_READ, wire.log[TOLD + i].instruction);
        TEST_ASSERT_EQUAL_HEX8(0x18, wire.log[TOLD + i].address);
        TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, states[i].torque_off);
        TEST_ASSERT_EQUAL_UINT8(0, wire.servo[i].torque);
        TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STOPPED, cds_servos_inhibits(&servos, &states[i]));
    }
}

/* What the packet in flight switches on is off soon: to learn it first would hold up torque off. */
void test_torque_in_flight_is_not_learnt_before_torque_off(void)
{
    static uint8_t bytes[CDS_SYNC_WRITE_SIZE(20, 1)];
    struct cds_request request = CDS_REQUEST_WITHOUT_DATA(bytes);
    const uint8_t on = 1;
    uint8_t polls = 0;

    cds_packet_sync_begin(&request.packet, CDS_REG_TORQUE_ENABLE, 1);
    for (uint8_t i = 0; i < 20; i++)
        cds_packet_sync_add(&request.packet, (uint8_t)(1 + i % 3), &on);
    cds_packet_end(&request.packet);
    request.reply_parameters = CDS_REPLY_NONE;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
    while (bus.state != CDS_BUS_SENDING)
        cds_bus_poll(&bus);
    begin();
    while (wire.count == 0)
        torque_wire(&bus);
    for (; bus.request == &request; polls++)
        cds_bus_poll(&bus);
    TEST_ASSERT_LESS_OR_EQUAL_UINT8(2, polls); // the deadline is set, the request ends
    TEST_ASSERT_EQUAL_PTR(&torque_off.requests[0], bus.request);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(1);
    TEST_ASSERT_FALSE(states[0].torque);
}

/* The priority of torque off is no permit: what waited while driving was inhibited stays refused.
 */
void test_torque_on_at_priority_of_torque_off_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 1)); // in flight
    requests[1].priority = CDS_PRIORITY_TORQUE_OFF;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &requests[1], CDS_BROADCAST_ID,
                                                   CDS_REG_TORQUE_ENABLE, 1));
    cds_servos_inhibit_all(&servos);
    cds_servos_release_all(&servos);
    run_for(1000);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, requests[1].result);
    TEST_ASSERT_EQUAL_UINT8(1, wire.count);
}

/* What was admitted before must not go out behind the torque off. */
void test_driving_requests_in_the_queue_are_never_sent(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 1)); // in flight
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &requests[1], CDS_BROADCAST_ID,
                                                   CDS_REG_TORQUE_ENABLE, 1));
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servo_write_word(&bus, &requests[2], 2, CDS_REG_GOAL_POSITION, 100));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &requests[3], 3, CDS_REG_TORQUE_ENABLE, 1));
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    run_for(1000);
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, requests[1].result);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, requests[2].result);
    TEST_ASSERT_EQUAL(CDS_OK, requests[3].result); // cannot drive
    TEST_ASSERT_EQUAL_UINT8(TOLD, torque_packets(0, CDS_BROADCAST_ID, CDS_WRITE));
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(0, 2, CDS_WRITE));
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[0].torque);
    TEST_ASSERT_EQUAL_UINT16(wire.count, bus.stats.sent);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.line_busy);
}

/* Of the two that wait with a high priority one drives, and one does not. */
void test_high_priority_requests_go_behind(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 1));
    requests[1].priority = requests[2].priority = CDS_PRIORITY_HIGH;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servo_write_word(&bus, &requests[1], 2, CDS_REG_GOAL_POSITION, 100));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[2], 2));
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    run_for(1000);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, requests[1].result);
    TEST_ASSERT_EQUAL(CDS_OK, requests[2].result);
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(0, 2, CDS_WRITE));
    assert_all_told(1);
}

void test_first_broadcast_waits_for_one_transaction(void)
{
    uint32_t begun_us;

    begin();
    run_for(2);
    TEST_ASSERT_UINT32_WITHIN(1, port_fake.now_us, wire.log[0].us); // at once if the bus is free

    setUp();
    for (uint8_t i = 0; i < 4; i++)
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &requests[i], 1, CDS_REG_TORQUE_ENABLE, 1));
    run_for(5);
    begun_us = port_fake.now_us;
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(1); // none of those that wait in between
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(begun_us + READ_US + TURN_US, wire.log[1].us);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(wire.log[1].us + 2 * (BROADCAST_US + TURN_US), wire.log[3].us);
}

/* The broadcasts follow from within cds_bus_poll(). */
void test_all_are_told_if_only_the_bus_is_polled(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 1));
    begin();
    run_for(TOLD * (BROADCAST_US + TURN_US) + READ_US);
    TEST_ASSERT_EQUAL_UINT8(1 + TOLD, wire.count);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_off_poll(&torque_off));
    assert_all_told(1);
    TEST_ASSERT_EQUAL(CDS_OK, run());
}

/* It got no answer. While torque off waits nothing is retried. */
void test_a_driving_packet_in_flight_is_not_retried(void)
{
    wire.servo[1].dead = true;
    cds_queue_set_retries(&queue, 2);
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servo_write_word(&bus, &requests[0], 2, CDS_REG_GOAL_POSITION, 100));
    run_for(20);
    begin();
    run();
    run_for(3000);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
    TEST_ASSERT_EQUAL_HEX8(0x1E, wire.log[0].address);
    assert_all_told(1);
    for (uint8_t i = 1 + TOLD; i < wire.count; i++)
        TEST_ASSERT_EQUAL_HEX8(0x18, wire.log[i].address);
}

void test_nothing_drives_until_released(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID,
                                                          CDS_REG_TORQUE_ENABLE, 1));
    TEST_ASSERT_EQUAL(CDS_INHIBITED,
                      cds_servo_write_word(&bus, &requests[0], 3, CDS_REG_GOAL_POSITION, 5));
    cds_servos_release_all(&servos);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID,
                                                   CDS_REG_TORQUE_ENABLE, 1));
    run_for(200);
    TEST_ASSERT_EQUAL_UINT8(1, wire.servo[2].torque);
}

void test_a_servo_that_missed_the_broadcasts_is_told_itself(void)
{
    wire.servo[1].deaf = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(TOLD + TORQUE_SERVOS, 2, CDS_WRITE));
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(TOLD + TORQUE_SERVOS, 2, CDS_READ));
    TEST_ASSERT_EQUAL_UINT8(TOLD + TORQUE_SERVOS + 2, wire.count);
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[1].torque);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, states[1].torque_off);
}

void test_a_servo_that_stays_on_is_told_twice_and_reported(void)
{
    wire.servo[0].deaf = wire.servo[0].stubborn = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_ON, states[0].torque_off);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, states[1].torque_off);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, states[2].torque_off);
    TEST_ASSERT_EQUAL_UINT8(2, torque_packets(0, 1, CDS_WRITE));
    TEST_ASSERT_EQUAL_UINT8(3, torque_packets(0, 1, CDS_READ));
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(0, 3, CDS_READ));
}

void test_a_silent_servo_does_not_hold_up_the_others(void)
{
    wire.servo[0].dead = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_SILENT, states[0].torque_off);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, states[2].torque_off);
    TEST_ASSERT_EQUAL_HEX8(3, wire.log[TOLD + 2].id);
    TEST_ASSERT_EQUAL_UINT8(3, torque_packets(0, 1, CDS_READ));
}

void test_a_servo_that_answers_no_read_is_reported(void)
{
    states[1].status_return_level = 0;
    wire.servo[1].mute = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_NO_REPLY_DUE, run());
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_MUTE, states[1].torque_off);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, states[2].torque_off);
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(0, 2, CDS_READ));
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(0, 2, CDS_WRITE)); // it is not told for ever
    wire.servo[2].dead = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, run()); // the worst of them is the result
    wire.servo[0].deaf = wire.servo[0].stubborn = true;
    wire.servo[0].torque = 1;
    begin();
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
}

void test_without_servos_the_broadcasts_are_sent(void)
{
    begin_servos(&queue, 0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_torque_off_begin(&torque_off, &servos));
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    TEST_ASSERT_EQUAL_UINT8(TOLD, wire.count);
}

/* The line is low. In each turn the clock moves on by more than a request waits; a request takes
 * three turns: it sets its timer, the timer expires, and the last look. */
static uint16_t turns_until_given_up(uint16_t released_at)
{
    uint16_t turns = 0;

    port_fake.low = true;
    begin();
    while (cds_torque_off_poll(&torque_off) == CDS_PENDING && turns < 4000 && port_fake.low) {
        port_fake.now_us += 4000;
        cds_bus_poll(&bus);
        if (++turns == released_at)
            port_fake.low = false;
    }
    return turns;
}

/* A request waits for 1168 us, counted as 21 x 56 us. */
void test_a_line_in_use_is_given_up_after_1100_ms(void)
{
    const uint16_t requests = (CDS_TORQUE_OFF_LINE_WAIT + 20) / 21;

    cds_bus_poll(&bus);
    port_fake.low = true;
    cds_bus_poll(&bus); // seen
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(3 * requests + 3, turns_until_given_up(0));
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, cds_torque_off_poll(&torque_off));
    TEST_ASSERT_EQUAL_UINT16(21 * requests, torque_off.line_wait);
    TEST_ASSERT_EQUAL_UINT16(requests, bus.stats.line_busy);
    TEST_ASSERT_EQUAL_UINT8(0, torque_off.broadcasts);
    TEST_ASSERT_EQUAL_UINT8(0, wire.count);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_UNKNOWN, states[0].torque_off);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 1));
    TEST_ASSERT_NULL(bus.request); // nothing comes after all when the line is free
    port_fake.low = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_torque_off_begin(&torque_off, &servos));
    TEST_ASSERT_EQUAL_UINT16(0, torque_off.line_wait);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    begin();
    TEST_ASSERT_EQUAL_UINT8(0, torque_off.broadcasts);
}

/* The line is in use, or the bus is opened anew, while a servo is read. */
void test_a_read_that_was_not_sent_is_sent_again(void)
{
    for (uint8_t reopened = 0; reopened < 2; reopened++) {
        setUp();
        begin();
        run_for(TOLD * (BROADCAST_US + TURN_US));
        cds_bus_poll(&bus);
        if (!reopened) {
            port_fake.low = true;
            cds_bus_poll(&bus);
        }
        cds_torque_off_poll(&torque_off);
        cds_torque_off_poll(&torque_off);
        TEST_ASSERT_EQUAL(CDS_PENDING, torque_off.requests[0].result);
        if (reopened)
            cds_bus_open(&bus, 0, CDS_BAUD_1M);
        for (uint8_t i = 0; i < 3; i++) { // timer set, timer expired, last look
            port_fake.now_us += 5000;
            cds_bus_poll(&bus);
        }
        TEST_ASSERT_EQUAL(reopened ? CDS_CANCELLED : CDS_LINE_BUSY, torque_off.requests[0].result);
        port_fake.low = false;
        memset(&wire.talking, 0, sizeof wire.talking);
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL_UINT16(reopened ? 0 : 21, torque_off.line_wait);
        TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, states[0].torque_off);
    }
}

void test_a_line_that_is_free_again_is_used(void)
{
    port_fake.low = true;
    cds_bus_poll(&bus);
    turns_until_given_up(400);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_GREATER_THAN_UINT16(2100, torque_off.line_wait);
    assert_all_told(0);
}

/* Released and driven again while servos are still read: all of them are read again. */
void test_second_begin_reads_all_servos_anew(void)
{
    begin();
    while (states[1].torque_off == CDS_TORQUE_OFF_UNKNOWN) {
        cds_torque_off_poll(&torque_off);
        run_for(1);
    }
    cds_torque_off_poll(&torque_off);
    TEST_ASSERT_EQUAL_UINT8(TOLD + 2, wire.count);
    cds_servos_release_all(&servos);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID,
                                                   CDS_REG_TORQUE_ENABLE, 1));
    run_for(READ_US + BROADCAST_US + TURN_US);
    TEST_ASSERT_EQUAL_UINT8(1, wire.servo[0].torque);
    wire.servo[0].deaf = true;
    begin();
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 1));
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_UNKNOWN, states[0].torque_off);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(TOLD + 4); // behind the READ that was under way, and the torque on
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++)
        TEST_ASSERT_EQUAL_UINT8(0, wire.servo[i].torque);
}

/* The broadcast on the wire is not one of the three: it began before. */
void test_second_begin_while_telling_tells_three_times_anew(void)
{
    begin();
    run_for(BROADCAST_US + TURN_US + 20); // the second one is on the wire
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_packets_tell_all(2);
    TEST_ASSERT_EQUAL_UINT8(4, torque_off.broadcasts);
    TEST_ASSERT_EQUAL_UINT8(2 + TOLD + TORQUE_SERVOS, wire.count);
    begin(); // and again when it is over
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(2 + TOLD + TORQUE_SERVOS);
    TEST_ASSERT_EQUAL_UINT8(2 + 2 * (TOLD + TORQUE_SERVOS), wire.count);
}

void test_second_begin_takes_back_a_read_that_waits(void)
{
    begin();
    run_for(TOLD * (BROADCAST_US + TURN_US));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 3));
    cds_torque_off_poll(&torque_off);
    TEST_ASSERT_EQUAL(CDS_PENDING, torque_off.requests[0].result);
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    TEST_ASSERT_EQUAL_HEX8(CDS_PING, wire.log[TOLD].instruction);
    assert_all_told(TOLD + 1);
    TEST_ASSERT_EQUAL_UINT8(TOLD + 1 + TOLD + TORQUE_SERVOS, wire.count);
}

/* The result of that READ is ignored, and it does not count as a broadcast. */
void test_second_begin_goes_right_behind_a_read_in_flight(void)
{
    begin();
    while (wire.count < TOLD || torque_off.requests[0].id == CDS_BROADCAST_ID) {
        run_for(1);
        cds_torque_off_poll(&torque_off);
    }
    run_for(20);
    TEST_ASSERT_EQUAL(CDS_PENDING, torque_off.requests[0].result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 3));
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    run_for(READ_US);
    TEST_ASSERT_EQUAL_HEX8(CDS_READ, wire.log[TOLD].instruction);
    assert_all_told(TOLD + 1);
    TEST_ASSERT_EQUAL_HEX8(CDS_PING, wire.log[2 * TOLD + 1].instruction);
    TEST_ASSERT_EQUAL_UINT8(TOLD + 1 + TOLD + 1 + TORQUE_SERVOS, wire.count);
}

void test_a_line_in_use_is_given_up_as_soon_at_the_slowest_rate(void)
{
    uint32_t from_us;

    cds_bus_open(&bus, 0, CDS_BAUD_MAX);
    port_fake.low = true;
    from_us = port_fake.now_us;
    begin();
    while (cds_torque_off_poll(&torque_off) == CDS_PENDING &&
           port_fake.now_us - from_us < 5000000) {
        port_fake.now_us += 500;
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, torque_off.steps.result);
    TEST_ASSERT_UINT32_WITHIN(100000, 1200000, port_fake.now_us - from_us);
}

void test_after_the_last_try_nothing_is_sent(void)
{
    begin();
    run_for(20);
    torque_off.line_wait = CDS_TORQUE_OFF_LINE_WAIT;
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, cds_torque_off_poll(&torque_off));
    run_for(1000);
    TEST_ASSERT_EQUAL_UINT8(1, wire.count);
    TEST_ASSERT_NULL(bus.request);
}

void test_a_bus_opened_anew_is_told_all_again(void)
{
    begin();
    run_for(BROADCAST_US / 2);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    memset(&wire.talking, 0, sizeof wire.talking);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    TEST_ASSERT_EQUAL_UINT16(0, torque_off.line_wait);
}

void test_a_closed_bus_is_refused(void)
{
    bus.state = CDS_BUS_CLOSED;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_torque_off_begin(&torque_off, &servos));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_torque_off_poll(&torque_off));
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 2)); // inhibited nevertheless
}

/* ---- a transaction that fails, a bus without queue ---- */

/* A failed transaction makes the line suspect for two byte times: 20 us at 1 Mbps. */
void test_after_a_failed_transaction_it_waits_two_byte_times(void)
{
    wire.servo[0].dead = true;
    cds_bus_set_return_delay(&bus, 20);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 1));
    run_for(30);
    begin();
    while (requests[0].result == CDS_PENDING)
        run_for(1);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, requests[0].result);
    run_for(25);
    TEST_ASSERT_EQUAL(CDS_LINK_TALKING, bus.link.state);
    run();
    assert_all_told(1);
}

void test_without_a_queue_all_are_told_and_read(void)
{
    begin_servos(NULL, TORQUE_SERVOS);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 1));
    run_for(20);
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    assert_all_told(1);
    TEST_ASSERT_EQUAL_UINT8(1 + TOLD + TORQUE_SERVOS, wire.count);
    TEST_ASSERT_EQUAL_UINT16(0, torque_off.line_wait);
}

/* ---- abort ---- */

void test_abort_sends_only_what_is_on_the_wire(void)
{
    for (uint16_t us = 0; us < TOLD * (BROADCAST_US + TURN_US) + 2 * READ_US; us += 40) {
        uint8_t count;

        setUp();
        begin();
        for (uint16_t i = 0; i < us; i++) {
            run_for(1);
            TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_off_poll(&torque_off));
        }
        count = (uint8_t)(wire.count + (bus.link.state == CDS_LINK_TALKING));
        cds_torque_off_abort(&torque_off);
        TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
        run_for(2000);
        TEST_ASSERT_EQUAL_UINT8(count, wire.count);
        TEST_ASSERT_NULL(bus.request);
        TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 1));
    }
}

void test_abort_after_the_end_changes_nothing(void)
{
    cds_torque_off_abort(&torque_off); // never begun
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    cds_torque_off_abort(&torque_off);
    TEST_ASSERT_EQUAL(CDS_OK, cds_torque_off_poll(&torque_off));
}

/* ---- an operation holds the bus ---- */

#define OTHER_BAUD 3

static struct cds_steps operation; // PINGs servo 1 again and again

static enum cds_result send_ping(void *context)
{
    (void)context;
    return cds_servo_ping(&bus, &requests[0], 1);
}

static void ping_ended(void *context, enum cds_result result)
{
    (void)context, (void)result;
}

static enum cds_result poll_operation(void)
{
    return cds_steps_poll(&operation, NULL, send_ping, ping_ended);
}

static void begin_operation(uint8_t baud_reg)
{
    cds_steps_begin_exclusive(&operation, &bus, &requests[0]);
    TEST_ASSERT_TRUE(cds_steps_set_baud(&operation, baud_reg));
}

void test_lock_at_the_own_rate_is_passed(void)
{
    begin_operation(CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_PENDING, poll_operation());
    run_for(20);
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(1);
    TEST_ASSERT_EQUAL(CDS_PENDING, poll_operation()); // it goes on
    TEST_ASSERT_EQUAL_PTR(&operation.lock, bus.lock);
}

void test_operation_at_another_rate_is_aborted_first(void)
{
    begin_operation(OTHER_BAUD);
    begin();
    run_for(2);
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, port_fake.bauds[0]);
    TEST_ASSERT_UINT32_WITHIN(1, port_fake.now_us, wire.log[0].us); // at once
    TEST_ASSERT_EQUAL(CDS_CANCELLED, poll_operation());
    TEST_ASSERT_NULL(bus.lock);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
}

/* The rate can be restored only when the reply has come. */
void test_packet_at_another_rate_ends_before_the_broadcasts(void)
{
    begin_operation(OTHER_BAUD);
    TEST_ASSERT_EQUAL(CDS_PENDING, poll_operation());
    run_for(20);
    TEST_ASSERT_EQUAL(CDS_LINK_TALKING, bus.link.state);
    begin();
    while (bus.baud_reg == OTHER_BAUD) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_off_poll(&torque_off));
        TEST_ASSERT_LESS_OR_EQUAL_UINT8(1, wire.count);
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(1, bus.stats.sent);
        run_for(1);
    }
    TEST_ASSERT_EQUAL(CDS_OK, requests[0].result);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_off_poll(&torque_off));
    run_for(2);
    TEST_ASSERT_UINT32_WITHIN(1, port_fake.now_us, wire.log[1].us); // at once
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(1);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, poll_operation());
}

/* An operation may change the rate between two requests of torque off. */
void test_rate_changed_between_two_reads_is_restored(void)
{
    begin_operation(CDS_BAUD_1M);
    begin();
    while (states[0].torque_off == CDS_TORQUE_OFF_UNKNOWN) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_off_poll(&torque_off));
        if (states[0].torque_off == CDS_TORQUE_OFF_UNKNOWN)
            run_for(1);
        if (wire.count == TOLD && cds_steps_set_baud(&operation, OTHER_BAUD))
            TEST_ASSERT_EQUAL_UINT8(OTHER_BAUD, bus.baud_reg);
    }
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud_reg);
    TEST_ASSERT_EQUAL_UINT8(TOLD + TORQUE_SERVOS, wire.count);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, poll_operation());
}

/* The last broadcast finds the line in use; then an operation takes the bus to another rate. */
void test_unsent_broadcast_is_sent_at_the_own_rate(void)
{
    begin();
    while (wire.count < TOLD - 2 || bus.link.state != CDS_LINK_TALKING)
        run_for(1);
    port_fake.low = true; // while the last but one is on the wire
    run_for(10000);
    port_fake.low = false;
    run_for(100);
    TEST_ASSERT_EQUAL_UINT8(TOLD - 1, wire.count);
    TEST_ASSERT_NULL(bus.request);
    begin_operation(OTHER_BAUD);
    TEST_ASSERT_EQUAL(CDS_PENDING, poll_operation());
    while (cds_torque_off_poll(&torque_off) == CDS_PENDING) {
        run_for(1);
        if (bus.request && bus.request->packet.bytes[2] == 0xFE)
            TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, port_fake.bauds[0]);
    }
    TEST_ASSERT_EQUAL(CDS_OK, torque_off.steps.result);
    TEST_ASSERT_EQUAL_UINT8(TOLD, torque_packets(0, CDS_BROADCAST_ID, CDS_WRITE));
}

/* An operation at another rate has a packet on the wire between two reads. */
void test_read_waits_for_a_packet_at_another_rate(void)
{
    begin();
    while (states[0].torque_off == CDS_TORQUE_OFF_UNKNOWN ||
           torque_off.requests[0].result == CDS_PENDING) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_off_poll(&torque_off));
        run_for(1);
    }
    begin_operation(OTHER_BAUD);
    TEST_ASSERT_EQUAL(CDS_PENDING, poll_operation());
    while (cds_torque_off_poll(&torque_off) == CDS_PENDING) {
        run_for(1);
        if (bus.request && bus.request != &requests[0])
            TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, port_fake.bauds[0]);
    }
    TEST_ASSERT_EQUAL(CDS_OK, torque_off.steps.result);
    TEST_ASSERT_EQUAL_UINT8(TOLD + 1 + TORQUE_SERVOS, wire.count);
}

void test_bus_closed_while_servos_are_read_ends_it(void)
{
    begin();
    run_for(TOLD * (BROADCAST_US + TURN_US));
    bus.state = CDS_BUS_CLOSED;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_torque_off_poll(&torque_off));
}

void test_second_begin_during_the_last_broadcast(void)
{
    begin();
    while (wire.count < TOLD - 1 || bus.link.state != CDS_LINK_TALKING)
        run_for(1);
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(TOLD);
    TEST_ASSERT_EQUAL_UINT8(2 * TOLD + TORQUE_SERVOS, wire.count);
}
