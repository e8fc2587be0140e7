/* Torque off for all, on a wire that takes its time: nothing that drives goes out any more, three
 * broadcasts, and each servo looked at until it is known. */
#include "cds55xx/torque_off.h"

#include "cds55xx/sync_write.h"
#include "cds55xx/servo.h"
#include "port_fake.h"
#include "torque_fake.h"
#include "unity.h"

#define BROADCAST_US 80 // on the wire
#define READ_US      (80 + 2 + 80)
#define TOLD         (CDS_TORQUE_OFF_BROADCASTS + CDS_TORQUE_OFF_CLEARS) // packets
#define TURN_US      10 // from the end of one to the beginning of the next, polled every microsecond

static struct cds_bus bus;
static struct cds_servos roster;
static struct cds_servo_state servos[TORQUE_SERVOS];
static struct cds_torque_off stop;
static uint8_t buffers[4][32];
static struct cds_request requests[4];

void setUp(void)
{
    port_fake_reset();
    memset(&wire, 0, sizeof wire);
    memset(&bus, 0, sizeof bus);
    memset(&stop, 0, sizeof stop);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_queue(&bus, true);
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++) {
        servos[i].id = (uint8_t)(i + 1);
        wire.servo[i].torque = 1;
    }
    for (uint8_t i = 0; i < 4; i++)
        requests[i] = (struct cds_request){.packet = {.bytes = buffers[i], .room = 32}};
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_begin(&roster, &bus, servos, TORQUE_SERVOS));
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void begin(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_torque_off_begin(&stop, &roster));
}

/* Until it is over, at most 30 ms. */
static enum cds_result run(void)
{
    for (uint16_t i = 0; i < 60000 && cds_torque_off_poll(&stop) == CDS_PENDING; i++) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
    }
    return cds_torque_off_poll(&stop);
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
static void assert_all_told(uint8_t first)
{
    for (uint8_t i = first; i < first + TOLD; i++) {
        TEST_ASSERT_EQUAL_HEX8(CDS_BROADCAST_ID, wire.log[i].id);
        TEST_ASSERT_EQUAL_HEX8(CDS_WRITE, wire.log[i].instruction);
        TEST_ASSERT_EQUAL_HEX8(i < first + 3 ? 0x18 : 0x2C, wire.log[i].address);
        TEST_ASSERT_EQUAL_HEX8(0, wire.log[i].data);
    }
    TEST_ASSERT_EQUAL_UINT8(3, stop.broadcasts);
    TEST_ASSERT_EQUAL_UINT8(3, stop.clears);
}

void test_stop_broadcasts_then_reads_each_servo(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    TEST_ASSERT_EQUAL_UINT8(TOLD + TORQUE_SERVOS, wire.count);
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++) {
        TEST_ASSERT_EQUAL_HEX8(i + 1, wire.log[TOLD + i].id);
        TEST_ASSERT_EQUAL_HEX8(CDS_READ, wire.log[TOLD + i].instruction);
        TEST_ASSERT_EQUAL_HEX8(0x18, wire.log[TOLD + i].address);
        TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, servos[i].stopped);
        TEST_ASSERT_EQUAL_UINT8(0, wire.servo[i].torque);
        TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STOPPED, servos[i].held);
    }
}

/* What was admitted before must not go out behind the torque off. */
void test_what_waits_in_the_queue_and_drives_is_never_sent(void)
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
    TEST_ASSERT_EQUAL(CDS_OK, requests[3].result); // drives nobody
    TEST_ASSERT_EQUAL_UINT8(TOLD, torque_packets(0, CDS_BROADCAST_ID, CDS_WRITE));
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(0, 2, CDS_WRITE));
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[0].torque);
    TEST_ASSERT_EQUAL_UINT16(wire.count, bus.counters.sent);
    TEST_ASSERT_EQUAL_UINT16(0, bus.counters.unsent);
}

/* Two that are urgent and were there before: one that drives, and one that does not. */
void test_urgent_ones_submitted_before_go_behind(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 1));
    requests[1].urgent = requests[2].urgent = 1;
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

void test_the_first_broadcast_is_at_most_one_exchange_late(void)
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

/* The broadcasts are on their way already: nobody need poll the stop for them to go out. */
void test_all_are_told_even_if_nobody_polls_the_stop(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 1));
    begin();
    run_for(TOLD * (BROADCAST_US + TURN_US) + READ_US);
    TEST_ASSERT_EQUAL_UINT8(1 + TOLD, wire.count);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_off_poll(&stop));
    assert_all_told(1);
    TEST_ASSERT_EQUAL(CDS_OK, run());
}

/* Its first try got no answer; it must not drive a second time behind the hold. */
void test_what_is_in_flight_is_not_repeated(void)
{
    wire.servo[1].dead = true;
    cds_bus_set_repeats(&bus, 2);
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servo_write_word(&bus, &requests[0], 2, CDS_REG_GOAL_POSITION, 100));
    run_for(20);
    begin();
    run();
    run_for(3000); // the bus rests behind the first try
    TEST_ASSERT_EQUAL(CDS_INHIBITED, requests[0].result);
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
    cds_servos_release(&roster, NULL);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID,
                                                   CDS_REG_TORQUE_ENABLE, 1));
    run_for(200);
    TEST_ASSERT_EQUAL_UINT8(1, wire.servo[2].torque);
}

void test_one_that_heard_no_broadcast_is_told_by_itself(void)
{
    wire.servo[1].deaf = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(TOLD + TORQUE_SERVOS, 2, CDS_WRITE));
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(TOLD + TORQUE_SERVOS, 2, CDS_READ));
    TEST_ASSERT_EQUAL_UINT8(TOLD + TORQUE_SERVOS + 2, wire.count);
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[1].torque);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, servos[1].stopped);
}

void test_one_that_stays_on_is_told_twice_and_reported(void)
{
    wire.servo[0].deaf = wire.servo[0].stubborn = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_ON, servos[0].stopped);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, servos[1].stopped);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, servos[2].stopped);
    TEST_ASSERT_EQUAL_UINT8(2, torque_packets(0, 1, CDS_WRITE));
    TEST_ASSERT_EQUAL_UINT8(3, torque_packets(0, 1, CDS_READ));
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(0, 3, CDS_READ));
}

void test_one_that_is_silent_does_not_hold_up_the_others(void)
{
    wire.servo[0].dead = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_SILENT, servos[0].stopped);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, servos[2].stopped);
    TEST_ASSERT_EQUAL_HEX8(3, wire.log[TOLD + 2].id);
    TEST_ASSERT_EQUAL_UINT8(3, torque_packets(0, 1, CDS_READ));
}

void test_one_that_answers_no_read_is_told_and_reported(void)
{
    servos[1].status_return_level = 0;
    wire.servo[1].mute = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_NO_REPLY_DUE, run());
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_MUTE, servos[1].stopped);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, servos[2].stopped);
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

void test_without_servos_all_are_told_all_the_same(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_begin(&roster, &bus, NULL, 0));
    TEST_ASSERT_EQUAL(CDS_OK, cds_torque_off_begin(&stop, &roster));
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    TEST_ASSERT_EQUAL_UINT8(TOLD, wire.count);
}

/* Somebody holds the line. The clock moves on by more than a request waits in each turn. */
static uint16_t turns_until_given_up(uint16_t released_at)
{
    uint16_t turns = 0;

    port_fake.low = true;
    begin();
    while (cds_torque_off_poll(&stop) == CDS_PENDING && turns < 3 * CDS_TORQUE_OFF_TRIES &&
           port_fake.low) {
        port_fake.now_us += 2000;
        cds_bus_poll(&bus);
        if (++turns == released_at)
            port_fake.low = false;
    }
    return turns;
}

void test_a_line_in_use_is_tried_a_thousand_times(void)
{
    cds_bus_poll(&bus);
    port_fake.low = true;
    cds_bus_poll(&bus); // seen
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(2 * CDS_TORQUE_OFF_TRIES + 2, turns_until_given_up(0));
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, cds_torque_off_poll(&stop));
    TEST_ASSERT_EQUAL_UINT16(CDS_TORQUE_OFF_TRIES, stop.tries);
    TEST_ASSERT_EQUAL_UINT16(CDS_TORQUE_OFF_TRIES, bus.counters.unsent);
    TEST_ASSERT_EQUAL_UINT8(0, stop.broadcasts);
    TEST_ASSERT_EQUAL_UINT8(0, wire.count);
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_UNKNOWN, servos[0].stopped);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&roster, 1));
    TEST_ASSERT_NULL(bus.request); // nothing comes after all when the line is free
    port_fake.low = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_torque_off_begin(&stop, &roster));
    TEST_ASSERT_EQUAL_UINT16(0, stop.tries);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    begin();
    TEST_ASSERT_EQUAL_UINT8(0, stop.broadcasts);
}

/* The line is used by somebody, or the bus is opened anew, while one is looked at. */
void test_a_look_that_came_to_nothing_is_made_again(void)
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
        cds_torque_off_poll(&stop);
        cds_torque_off_poll(&stop);
        TEST_ASSERT_EQUAL(CDS_PENDING, stop.requests[0].result);
        if (reopened)
            cds_bus_open(&bus, 0, CDS_BAUD_1M);
        for (uint8_t i = 0; i < 2; i++) { // the last look is one of its own
            port_fake.now_us += 5000;
            cds_bus_poll(&bus);
        }
        TEST_ASSERT_EQUAL(reopened ? CDS_CANCELLED : CDS_LINE_BUSY, stop.requests[0].result);
        port_fake.low = false;
        memset(&wire.talking, 0, sizeof wire.talking);
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL_UINT16(1, stop.tries);
        TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, servos[0].stopped);
    }
}

void test_a_line_that_is_free_again_is_used(void)
{
    port_fake.low = true;
    cds_bus_poll(&bus);
    turns_until_given_up(300);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_GREATER_THAN_UINT16(100, stop.tries);
    assert_all_told(0);
}

/* Released and driven again while the first stop still looks: the second one looks at all of it. */
void test_a_second_stop_begins_anew(void)
{
    begin();
    while (servos[1].stopped == CDS_TORQUE_OFF_UNKNOWN) {
        cds_torque_off_poll(&stop);
        run_for(1);
    }
    cds_torque_off_poll(&stop);
    TEST_ASSERT_EQUAL_UINT8(TOLD + 2, wire.count);
    cds_servos_release(&roster, NULL);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID,
                                                   CDS_REG_TORQUE_ENABLE, 1));
    run_for(READ_US + BROADCAST_US + TURN_US);
    TEST_ASSERT_EQUAL_UINT8(1, wire.servo[0].torque);
    wire.servo[0].deaf = true;
    begin();
    TEST_ASSERT_FALSE(cds_servos_may_drive(&roster, 1));
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_UNKNOWN, servos[0].stopped);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(TOLD + 4); // behind the look that was under way, and the torque on
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++)
        TEST_ASSERT_EQUAL_UINT8(0, wire.servo[i].torque);
}

/* A broadcast of the first stop that is still to go out is one of the second's. */
void test_a_second_stop_while_all_are_told_tells_three_times_from_then_on(void)
{
    begin();
    run_for(BROADCAST_US + TURN_US + 20); // the second one is in flight
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(1);
    TEST_ASSERT_EQUAL_UINT8(1 + TOLD + TORQUE_SERVOS, wire.count);
    begin(); // and again when it is over
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(1 + 2 * (TOLD + TORQUE_SERVOS), wire.count);
}

void test_a_second_stop_takes_back_a_look_that_waits(void)
{
    begin();
    run_for(TOLD * (BROADCAST_US + TURN_US));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 3));
    cds_torque_off_poll(&stop);
    TEST_ASSERT_EQUAL(CDS_PENDING, stop.requests[0].result);
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    TEST_ASSERT_EQUAL_HEX8(CDS_PING, wire.log[TOLD].instruction);
    assert_all_told(TOLD + 1);
    TEST_ASSERT_EQUAL_UINT8(TOLD + 1 + TOLD + TORQUE_SERVOS, wire.count);
}

/* What it has looked for is of no interest any more, and no broadcast. */
void test_a_second_stop_goes_right_behind_a_look_in_flight(void)
{
    begin();
    while (wire.count < TOLD || stop.requests[0].id == CDS_BROADCAST_ID) {
        run_for(1);
        cds_torque_off_poll(&stop);
    }
    run_for(20);
    TEST_ASSERT_EQUAL(CDS_PENDING, stop.requests[0].result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &requests[0], 3));
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run());
    run_for(READ_US);
    TEST_ASSERT_EQUAL_HEX8(CDS_READ, wire.log[TOLD].instruction);
    assert_all_told(TOLD + 1);
    TEST_ASSERT_EQUAL_HEX8(CDS_PING, wire.log[2 * TOLD + 1].instruction);
    TEST_ASSERT_EQUAL_UINT8(TOLD + 1 + TOLD + 1 + TORQUE_SERVOS, wire.count);
}

void test_one_that_was_given_up_sends_no_more(void)
{
    begin();
    run_for(20);
    stop.tries = CDS_TORQUE_OFF_TRIES - 1;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &stop.requests[1]));
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, cds_torque_off_poll(&stop));
    run_for(1000);
    TEST_ASSERT_EQUAL_UINT8(1, wire.count);
    TEST_ASSERT_NULL(bus.request);
}

void test_a_bus_opened_anew_meanwhile_is_told_again(void)
{
    begin();
    run_for(BROADCAST_US / 2);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_queue(&bus, true);
    memset(&wire.talking, 0, sizeof wire.talking);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    assert_all_told(0);
    TEST_ASSERT_EQUAL_UINT16(2, stop.tries);
}

void test_a_closed_bus_is_refused(void)
{
    bus.flight = CDS_BUS_CLOSED;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_torque_off_begin(&stop, &roster));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_torque_off_poll(&stop));
    TEST_ASSERT_FALSE(cds_servos_may_drive(&roster, 2)); // held all the same
}
