/* SPDX-License-Identifier: MIT */
/* The state check: each servo once a period, those that are away found again, those that are back
 * looked at before they are driven; and never in the way of a cycle. */
#include "cds55xx/health.h"

#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "torque_fake.h"
#include "unity.h"

#define PERIOD_US 30000ul // 10 ms for each of three
#define TURN_US   20

static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state states[TORQUE_SERVOS];
static struct cds_health health;
static uint8_t buffer[16];
static struct cds_request request;

static void begin_servos(uint8_t count)
{
    bus.hooks = NULL;
    TEST_ASSERT_EQUAL(
        CDS_OK, cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                                      .queue = &queue,
                                                                      .states = states,
                                                                      .count = count,
                                                                      .capacity = TORQUE_SERVOS}));
}

static enum cds_result begin_health(uint32_t period_us)
{
    return cds_health_begin(&health,
                            &(struct cds_health_config){.servos = &servos, .period_us = period_us});
}

void setUp(void)
{
    rig_open_at_us(0, 0u - 25000u); // the clock wraps
    memset(&wire, 0, sizeof wire);
    memset(&health, 0, sizeof health);
    request = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(buffer);
    cds_bus_set_return_delay(&bus, 2);
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++)
        states[i].id = (uint8_t)(i + 1);
    begin_servos(TORQUE_SERVOS);
    TEST_ASSERT_EQUAL(CDS_OK, begin_health(PERIOD_US));
}

void tearDown(void)
{
    rig_check();
}

static void turn(void)
{
    torque_wire(&bus);
    cds_bus_poll(&bus);
    cds_health_poll(&health);
}

/* Returns how long the wire and its servos do nothing, up to `us`. */
static uint32_t quiet_us(uint32_t us)
{
    if (wire.talking || wire.answering) {
        uint32_t left_us = wire.end_us - port_fake.now_us - 1;

        return left_us < us ? left_us : us;
    }
    return bus.link.state == CDS_LINK_TALKING ? 0 : us;
}

/* The main loop turns every TURN_US, as a simulated AVR can; sooner if the wire has something. */
static void run_for(uint32_t us)
{
    while (us--) {
        uint32_t skipped_us = quiet_us(us < TURN_US ? us : TURN_US - 1);

        port_fake.now_us += skipped_us;
        us -= skipped_us;
        turn();
    }
}

static void torque_on(void)
{
    TEST_ASSERT_EQUAL(
        CDS_OK, cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1));
    run_for(300);
    TEST_ASSERT_EQUAL_UINT8(1, wire.servo[2].torque);
}

/* Its supply fails; it is there again with its RAM as after power-up. */
static void brown_out(uint8_t index, bool dead)
{
    wire.servo[index].dead = dead;
    wire.servo[index].torque = 0;
}

static enum cds_result drive(uint8_t id)
{
    enum cds_result result;

    result = cds_servo_write_word(&bus, &request, id, CDS_REG_GOAL_POSITION, 500);
    run_for(500);
    return result;
}

void test_each_servo_is_read_once_a_period_evenly(void)
{
    for (uint16_t us = 0; us < 2 * PERIOD_US - 1; us++)
        turn();
    TEST_ASSERT_EQUAL_UINT8(6, wire.count);
    for (uint8_t i = 0; i < wire.count; i++) {
        TEST_ASSERT_EQUAL_HEX8(i % 3 + 1, wire.log[i].id);
        TEST_ASSERT_EQUAL_HEX8(CDS_READ, wire.log[i].instruction);
        TEST_ASSERT_EQUAL_HEX8(0x18, wire.log[i].address);
        if (i)
            TEST_ASSERT_UINT32_WITHIN(2, PERIOD_US / 3, wire.log[i].us - wire.log[i - 1].us);
    }
}

void test_torque_lost_unseen_shows_within_a_period(void)
{
    torque_on();
    TEST_ASSERT_EQUAL(CDS_OK, drive(2));
    brown_out(1, false);
    run_for(PERIOD_US + 200);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[1].inhibits);
    TEST_ASSERT_EQUAL_HEX8(0, states[0].inhibits | states[2].inhibits);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, drive(2));
    TEST_ASSERT_EQUAL(CDS_OK, drive(3));
    cds_servos_release(&servos, &states[1]);
    TEST_ASSERT_EQUAL(CDS_OK, drive(2));
    run_for(2 * PERIOD_US);
    TEST_ASSERT_EQUAL_HEX8(0,
                           states[1].inhibits); // torque was not switched on: it is not lost again
}

/* Until it is given up: three looks, a period apart. */
static void lose(uint8_t index)
{
    brown_out(index, true);
    run_for(4 * PERIOD_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, states[index].presence);
}

void test_an_offline_servo_is_found_read_and_inhibited(void)
{
    uint8_t first;

    torque_on();
    run_for(PERIOD_US);
    lose(0);
    first = wire.count;
    run_for(CDS_HEALTH_SEEK_US + 2000);
    TEST_ASSERT_GREATER_THAN_UINT8(0, torque_packets(first, 1, CDS_PING));
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(first, 1, CDS_READ));
    wire.servo[0].dead = false;
    first = wire.count;
    while (states[0].presence == CDS_PRESENCE_OFFLINE && wire.count < first + 20)
        run_for(TURN_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_RETURNED, states[0].presence);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 1));
    run_for(200); // at once
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[0].presence);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[0].inhibits);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, drive(1));
}

void test_a_servo_that_kept_its_state_may_be_driven(void)
{
    torque_on();
    lose(2);
    wire.servo[2].torque = 1; // a plug that was loose, with the supply still there
    wire.servo[2].dead = false;
    run_for(CDS_HEALTH_SEEK_US + 2000);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[2].presence);
    TEST_ASSERT_EQUAL_HEX8(0, states[2].inhibits);
    TEST_ASSERT_EQUAL(CDS_OK, drive(3));
}

/* A period of 3 s, a servo a second. */
void test_unplugged_servo_is_offline_within_its_turn(void)
{
    uint8_t first;

    while (health.request.result == CDS_PENDING)
        run_for(TURN_US);
    TEST_ASSERT_EQUAL(CDS_OK, begin_health(100 * PERIOD_US));
    run_for(PERIOD_US);
    wire.servo[1].dead = true;
    first = wire.count;
    run_for(100 * PERIOD_US / 3 + 3 * CDS_HEALTH_AGAIN_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, states[1].presence);
    TEST_ASSERT_EQUAL_UINT8(CDS_SERVOS_MISSES, torque_packets(first, 2, CDS_READ));
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[0].presence);
}

void test_servo_whose_replies_are_all_damaged_is_offline(void)
{
    run_for(PERIOD_US);
    wire.servo[1].garbled = true;
    run_for(PERIOD_US + 3 * CDS_HEALTH_AGAIN_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, states[1].presence);
    TEST_ASSERT_EQUAL_UINT16(0, states[1].counters.timeouts);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[0].presence);
    wire.servo[1].garbled = false;
    run_for(2 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[1].presence);
}

/* A miss of a servo at another rate is not counted: such a servo is never OFFLINE. */
void test_servo_at_another_rate_leaves_the_others_their_turns(void)
{
    uint8_t first;

    run_for(PERIOD_US);
    while (health.request.result == CDS_PENDING)
        run_for(TURN_US);
    wire.servo[0].dead = true;
    states[0].baud_reg = (uint8_t)(bus.baud_reg + 2);
    first = wire.count;
    run_for(3 * PERIOD_US);
    TEST_ASSERT_INT_WITHIN(1, 3, torque_packets(first, 1, CDS_READ));
    TEST_ASSERT_INT_WITHIN(1, 3, torque_packets(first, 2, CDS_READ));
    TEST_ASSERT_INT_WITHIN(1, 3, torque_packets(first, 3, CDS_READ));
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[0].presence);
}

/* A period of 3 s: within it only OFFLINE servos are asked. */
void test_offline_servos_cost_one_ping_in_100_ms(void)
{
    uint8_t first;

    for (uint8_t i = 0; i < TORQUE_SERVOS; i++)
        wire.servo[i].dead = true;
    run_for(4 * PERIOD_US);
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++)
        TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, states[i].presence);
    while (health.request.result == CDS_PENDING)
        run_for(TURN_US);
    TEST_ASSERT_EQUAL(CDS_OK, begin_health(100 * PERIOD_US));
    run_for(5000); // rests, and the first of the looks
    first = wire.count;
    run_for(6 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_INT_WITHIN(1, 6, wire.count - first);
    for (uint8_t id = 1; id <= TORQUE_SERVOS; id++)
        TEST_ASSERT_GREATER_THAN_UINT8(0, torque_packets(first, id, CDS_PING));
    for (uint8_t i = (uint8_t)(first + 1); i < wire.count; i++)
        TEST_ASSERT_GREATER_THAN_UINT32(CDS_HEALTH_SEEK_US - 100,
                                        wire.log[i].us - wire.log[i - 1].us);
}

void test_a_servo_that_answers_no_read_is_lost_when_back(void)
{
    uint8_t first;

    states[1].status_return_level = 0;
    wire.servo[1].mute = true;
    torque_on();
    run_for(2 * PERIOD_US);
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(0, 2, CDS_READ));
    TEST_ASSERT_EQUAL_UINT8(2, torque_packets(0, 2, CDS_PING));
    TEST_ASSERT_EQUAL_HEX8(0, states[1].inhibits);
    lose(1);
    wire.servo[1].dead = false;
    first = wire.count;
    run_for(5 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[1].presence);
    TEST_ASSERT_EQUAL_UINT8(0, states[1].status_return_level);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[1].inhibits);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT8(CDS_SERVOS_MISSES, torque_packets(first, 2, CDS_READ));
    states[1].inhibits = 0; // as `release` does
    first = wire.count;
    run_for(2 * PERIOD_US);
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(first, 2, CDS_READ));
}

/* Noise has damaged three READs of servo 2, which is READ again now, with this torque. */
static void end_noise(uint8_t torque)
{
    wire.servo[1].mute = true;
    torque_on();
    lose(1);
    wire.servo[1].dead = false;
    run_for(5 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL_UINT8(0, states[1].status_return_level);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[1].inhibits);
    states[1].inhibits |= CDS_INHIBIT_STOPPED;
    wire.servo[1].mute = false;
    wire.servo[1].torque = torque & 1u;
    run_for(2 * PERIOD_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[1].presence);
    TEST_ASSERT_EQUAL_UINT8(CDS_LEVEL_UNKNOWN, states[1].status_return_level);
    TEST_ASSERT_EQUAL_UINT8(torque, states[1].torque);
}

void test_a_servo_that_noise_made_mute_has_kept_its_state(void)
{
    end_noise(1);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STOPPED, states[1].inhibits);
}

void test_a_mute_servo_whose_torque_went_off_stays_lost(void)
{
    end_noise(0);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST | CDS_INHIBIT_STOPPED, states[1].inhibits);
}

/* READs that are lost do not make a servo one that answers none. */
void test_a_servo_whose_first_reads_are_lost_keeps_its_level(void)
{
    torque_on();
    lose(1);
    wire.servo[1].torque = 1;
    wire.servo[1].dead = false;
    while (states[1].presence == CDS_PRESENCE_OFFLINE)
        run_for(TURN_US);
    wire.servo[1].mute = true;
    while (states[1].misses < CDS_SERVOS_MISSES - 1)
        run_for(TURN_US);
    wire.servo[1].mute = false;
    run_for(2 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[1].presence);
    TEST_ASSERT_NOT_EQUAL(0, states[1].status_return_level);
    TEST_ASSERT_EQUAL_HEX8(0, states[1].inhibits);
}

/* A servo that answers PING only has returned, and has missed three READs. */
static void return_mute(uint8_t index)
{
    torque_on();
    lose(index);
    wire.servo[index].torque = 1;
    wire.servo[index].dead = false;
    wire.servo[index].mute = true;
    while (states[index].presence != CDS_PRESENCE_RETURNED ||
           states[index].misses < CDS_SERVOS_MISSES)
        run_for(TURN_US);
}

/* The torque of servo 2 was off before noise damaged three READs. */
void test_a_mute_servo_without_torque_has_lost_nothing(void)
{
    states[1].torque = false;
    lose(1);
    wire.servo[1].dead = false;
    wire.servo[1].mute = true;
    run_for(5 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[1].presence);
    TEST_ASSERT_EQUAL_UINT8(0, states[1].status_return_level);
    TEST_ASSERT_EQUAL_HEX8(0, states[1].inhibits);
    wire.servo[1].mute = false;
    run_for(2 * PERIOD_US);
    TEST_ASSERT_EQUAL_UINT8(CDS_LEVEL_UNKNOWN, states[1].status_return_level);
    TEST_ASSERT_EQUAL_HEX8(0, states[1].inhibits);
}

/* Between the READs of the state check a READ of the application tells nothing of torque. */
void test_a_read_of_other_registers_leaves_a_servo_lost(void)
{
    uint8_t reply[1];
    struct cds_request read = CDS_REQUEST(buffer, reply);

    return_mute(1);
    run_for(2 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[1].inhibits);
    wire.servo[1].mute = false;
    read.ignores_servo_state = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &read, 2, CDS_REG_LED, 1));
    while (read.result == CDS_PENDING) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_OK, read.result);
    TEST_ASSERT_EQUAL_UINT8(CDS_LEVEL_UNKNOWN, states[1].status_return_level);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[1].inhibits);
}

void test_a_damaged_reply_to_ping_tells_nothing(void)
{
    return_mute(1);
    wire.servo[1].garbled = true;
    run_for(2 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_RETURNED, states[1].presence);
    TEST_ASSERT_EQUAL_HEX8(0, states[1].inhibits);
    wire.servo[1].garbled = false;
    run_for(2 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[1].presence);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[1].inhibits);
}

/* Between the PING and the next poll a READ of the application was answered. */
void test_a_read_of_others_tells_more_than_the_ping(void)
{
    uint8_t reply[1];
    struct cds_request read = CDS_REQUEST(buffer, reply);

    return_mute(1);
    while (health.request.result != CDS_PENDING || health.request.packet.bytes[4] != CDS_PING)
        run_for(1);
    while (health.request.result == CDS_PENDING) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_OK, health.request.result);
    wire.servo[1].mute = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &read, 2, CDS_REG_TORQUE_ENABLE, 1));
    while (read.result == CDS_PENDING) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
    }
    run_for(100);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[1].presence);
    TEST_ASSERT_EQUAL_HEX8(0, states[1].inhibits);
}

/* All servos were ONLINE for 40 min, more than half a wrap of the clock. */
void test_the_first_offline_servo_is_sought_at_once(void)
{
    run_for(PERIOD_US + 500);
    TEST_ASSERT_EQUAL(CDS_OK, begin_health(100 * PERIOD_US));
    run_for(500);
    health.seek_us = port_fake.now_us - 2400000000u;
    wire.servo[0].dead = true;
    for (uint8_t i = 0; i < CDS_SERVOS_MISSES; i++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1));
        run_for(3000);
    }
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, states[0].presence);
    TEST_ASSERT_EQUAL_UINT8(CDS_SERVOS_MISSES + 1, torque_packets(0, 1, CDS_PING));
}

/* It is gone again before it could be read. */
void test_a_returned_servo_that_is_gone_again_is_offline(void)
{
    torque_on();
    lose(1);
    wire.servo[1].dead = false;
    while (states[1].presence == CDS_PRESENCE_OFFLINE)
        run_for(TURN_US);
    wire.servo[1].dead = true;
    run_for(5 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, states[1].presence);
    TEST_ASSERT_EQUAL_HEX8(0, states[1].inhibits);
}

/* Every other request goes first. */
void test_nothing_is_sent_while_the_bus_is_in_use(void)
{
    for (uint16_t i = 0; i < 1000; i++) {
        if (request.result != CDS_PENDING)
            cds_servo_ping(&bus, &request, 2);
        torque_wire(&bus);
        cds_bus_poll(&bus);
        if (request.result != CDS_PENDING)
            cds_servo_ping(&bus, &request, 2);
        cds_health_poll(&health);
    }
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(0, 1, CDS_READ));
    run_for(400);
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(0, 1, CDS_READ));
}

void test_nothing_is_sent_while_the_bus_rests(void)
{
    wire.servo[0].dead = true;
    run_for(100); // its READ is out
    for (uint16_t i = 0; i < 300; i++) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, health.request.result);
    health.turn = 0; // the same one, and due
    health.look_us = port_fake.now_us;
    cds_health_poll(&health);
    TEST_ASSERT_NULL(bus.request);
    run_for(1000);
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(0, 1, CDS_READ)); // the bus rests
    run_for(1000);
    TEST_ASSERT_EQUAL_UINT8(2, torque_packets(0, 1, CDS_READ));
}

void test_missed_turns_are_not_made_up_for(void)
{
    run_for(300);
    port_fake.now_us += 5 * PERIOD_US;
    wire.count = 0;
    run_for(2 * PERIOD_US);
    TEST_ASSERT_INT_WITHIN(1, 7, wire.count);
}

void test_begin_with_a_bad_period_or_in_flight_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_health(9999));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_health(1000000001ul));
    run_for(2 * TURN_US);
    TEST_ASSERT_EQUAL(CDS_BUSY, begin_health(PERIOD_US));
    cds_bus_open(&bus, 0, CDS_BAUD_1M); // what was on its way is over
    wire.talking = false;
    begin_servos(0);
    memset(&health, 0, sizeof health);
    TEST_ASSERT_EQUAL(CDS_OK, begin_health(PERIOD_US));
    run_for(3 * PERIOD_US);
    TEST_ASSERT_EQUAL(CDS_OK, health.request.result);
    TEST_ASSERT_NULL(bus.request);
}

void test_a_servo_returned_before_begin_is_read_at_once(void)
{
    torque_on();
    lose(0);
    wire.servo[0].dead = false;
    while (health.request.result == CDS_PENDING)
        run_for(TURN_US);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1));
    while (request.result == CDS_PENDING) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_PRESENCE_RETURNED, states[0].presence);
    TEST_ASSERT_EQUAL(CDS_OK, begin_health(1000 * PERIOD_US));
    health.look_us += PERIOD_US; // not by a look that happens to be its own
    run_for(500);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[0].inhibits);
}

/* Both are plugged in again: neither waits for the other. */
void test_two_returned_servos_are_read_at_once(void)
{
    torque_on();
    lose(0);
    lose(2);
    wire.servo[0].dead = wire.servo[2].dead = false;
    while (states[0].presence == CDS_PRESENCE_OFFLINE || states[2].presence == CDS_PRESENCE_OFFLINE)
        run_for(TURN_US);
    run_for(800);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[0].inhibits);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[2].inhibits);
}

void test_a_read_is_not_retried(void)
{
    cds_queue_set_retries(&queue, 2);
    wire.servo[0].dead = true;
    run_for(5000);
    TEST_ASSERT_EQUAL_UINT8(1, torque_packets(0, 1, CDS_READ));
}

/* ---- beside a cycle ---- */

#define CYCLE_US 1000u
#define LOOKS_US 10100ul // turns come at changing moments of a period

static struct cds_cycle cycle;
static struct cds_feedback feedback[1];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(1)];
static const uint8_t cycle_ids[1] = {7}; // never answers: its READs take as long as they can

static void begin_cycle(uint16_t period_us)
{
    memset(&cycle, 0, sizeof cycle);
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_cycle_begin(&cycle, &(struct cds_cycle_config){.bus = &bus,
                                                                         .ids = cycle_ids,
                                                                         .packets = packets,
                                                                         .feedback = feedback,
                                                                         .count = 1,
                                                                         .period_us = period_us}));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 0, 500, 100));
    cds_cycle_commit(&cycle);
}

/* The cycle is polled first, and would take the bus whenever it is free. */
static void run_with_cycle(uint32_t us)
{
    while (us--) {
        wire.count = 0;
        torque_wire(&bus);
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
        cds_health_poll(&health);
    }
}

void test_beside_a_cycle_no_period_is_late(void)
{
    uint8_t waited_us;

    TEST_ASSERT_EQUAL(CDS_OK, begin_health(LOOKS_US));
    begin_cycle(CYCLE_US);
    TEST_ASSERT_EQUAL(CDS_OK, cds_health_set_cycle(&health, &cycle));
    run_with_cycle(CYCLE_US - 1);
    for (uint8_t period = 0; period < 60; period++) {
        TEST_ASSERT_EQUAL_UINT32(port_fake.now_us + 1, cycle.next_us);
        run_with_cycle(1);
        TEST_ASSERT_EQUAL_UINT32(port_fake.now_us + CYCLE_US, cycle.next_us); // begun at once
        waited_us = cds_bus_is_resting(&bus); // then the packet leaves with the next poll
        run_with_cycle(waited_us);
        TEST_ASSERT_EQUAL(CDS_LINK_TALKING, bus.link.state);
        TEST_ASSERT_EQUAL_HEX8(CDS_BROADCAST_ID, bus.request->packet.bytes[CDS_AT_ID]);
        run_with_cycle(CYCLE_US - 1 - waited_us);
    }
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_GREATER_THAN_UINT32(20, cycle.counters.reads); // unanswered: the bus rests
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++) {
        TEST_ASSERT_INT_WITHIN(1, 6, states[i].counters.ok);
        TEST_ASSERT_EQUAL_UINT16(0, states[i].counters.timeouts);
    }
}

void test_a_cycle_without_spare_time_is_refused(void)
{
    begin_cycle(130 + CDS_REPLY_MARGIN_US + 150 + 2 + CDS_REPLY_MARGIN_US + 40);
    TEST_ASSERT_EQUAL(CDS_OK, cds_health_set_cycle(&health, &cycle));
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++) {
        states[i].return_delay = 2; // 2 us more
        TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_health_set_cycle(&health, &cycle));
        states[i].return_delay = 1;
    }
    TEST_ASSERT_EQUAL(CDS_OK, cds_health_set_cycle(&health, NULL));
}

void test_a_servo_too_slow_for_the_cycle_is_passed_over(void)
{
    uint32_t reads;

    TEST_ASSERT_EQUAL(CDS_OK, begin_health(LOOKS_US));
    begin_cycle(CYCLE_US);
    TEST_ASSERT_EQUAL(CDS_OK, cds_health_set_cycle(&health, &cycle));
    states[0].return_delay = 254; // 758 us in all, and 650 are left
    run_with_cycle(30 * CYCLE_US);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(10, cycle.counters.reads); // unanswered: the bus rests
    TEST_ASSERT_EQUAL_UINT16(0, states[0].counters.ok);
    TEST_ASSERT_INT_WITHIN(1, 3, states[1].counters.ok);
    TEST_ASSERT_INT_WITHIN(1, 3, states[2].counters.ok);
    reads = cycle.counters.reads;
    for (uint16_t us = 0; us < 10 * CYCLE_US; us++) { // nor does a request for too much time
        run_with_cycle(1);
        TEST_ASSERT_FALSE(cds_cycle_yields(&cycle, CYCLE_US));
    }
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(reads + 4, cycle.counters.reads);
}

/* ---- what others do ---- */

static void abort_nothing(void *context)
{
    (void)context;
}

void test_nothing_is_sent_while_an_operation_holds_the_bus(void)
{
    static const struct cds_bus_lock lock = {abort_nothing, NULL, CDS_BAUD_1M};

    return_mute(1);
    run_for(500);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
    wire.count = 0;
    run_for(3 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_EQUAL_UINT8(0, wire.count);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_RETURNED, states[1].presence);
    cds_bus_unlock(&bus, &lock);
    run_for(PERIOD_US);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[1].presence);
}

void test_servos_forgotten_while_one_is_asked(void)
{
    return_mute(1);
    while (health.request.result != CDS_PENDING)
        run_for(1);
    cds_servos_forget(&servos);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_add(&servos, 3));
    run_for(PERIOD_US + 500);
    TEST_ASSERT_NOT_EQUAL(CDS_PRESENCE_RETURNED, health.asked);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, states[0].presence);
}

/* With a long period only the servos that are sought are asked. */
void test_a_returned_servo_goes_before_an_offline_one(void)
{
    uint8_t first;

    torque_on();
    lose(0);
    lose(2);
    while (health.request.result == CDS_PENDING)
        run_for(TURN_US);
    TEST_ASSERT_EQUAL(CDS_OK, begin_health(1000 * PERIOD_US));
    run_for(500);
    wire.servo[0].dead = false;
    wire.servo[0].mute = true;
    while (states[0].presence != CDS_PRESENCE_RETURNED)
        run_for(TURN_US);
    first = wire.count;
    while (states[0].presence == CDS_PRESENCE_RETURNED)
        run_for(TURN_US);
    TEST_ASSERT_EQUAL_UINT8(CDS_SERVOS_MISSES, torque_packets(first, 1, CDS_READ));
    TEST_ASSERT_EQUAL_UINT8(0, torque_packets(first, 3, CDS_PING));
    run_for(2 * CDS_HEALTH_SEEK_US);
    TEST_ASSERT_GREATER_THAN_UINT8(0, torque_packets(first, 3, CDS_PING));
}

/* ---- abort ---- */

void test_after_abort_nothing_is_sent_until_the_next_begin(void)
{
    uint8_t count;

    run_for(PERIOD_US + 500); // no packet is on the wire
    cds_health_abort(&health);
    count = wire.count;
    run_for(PERIOD_US);
    TEST_ASSERT_EQUAL_UINT8(count, wire.count);
    TEST_ASSERT_EQUAL(CDS_OK, begin_health(PERIOD_US));
    run_for(PERIOD_US);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT8(count + TORQUE_SERVOS, wire.count);
}

void test_abort_takes_back_a_request_that_waits(void)
{
    port_fake.low = true; // the first poll of the bus finds that out
    while (health.request.result != CDS_PENDING)
        cds_health_poll(&health);
    cds_bus_poll(&bus);
    cds_health_abort(&health);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, health.request.result);
    TEST_ASSERT_NULL(bus.request);
    cds_health_abort(&health); // again: nothing changes
    memset(&health, 0, sizeof health);
    cds_health_abort(&health); // never begun
    cds_health_poll(&health);
}
