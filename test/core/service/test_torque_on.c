/* SPDX-License-Identifier: MIT */
/* Torque on of servo 1, which stands at 500 and has another goal. Servo 2 is never written to. */
#include "cds55xx/torque_on.h"

#include "bus_rig.h"
#include "permit_fake.h"
#include "servos_fake.h"
#include "unity.h"

#define POSITION 500

static uint8_t buffer[CDS_TORQUE_ON_PACKET_SIZE], reply[CDS_TORQUE_ON_READ_SIZE];
static struct cds_request request;
static struct cds_torque_on_config config;
static struct cds_torque_on on;
static uint16_t turns;      // steps that the servo is turned by after each packet, modulo 65536
static uint8_t spoils_goal; // packet after which the servo has another goal; 0: none

static uint8_t *const table = servos.servo[0].table;

static void put_word(uint8_t reg, uint16_t word)
{
    table[reg] = (uint8_t)word;
    table[reg + 1] = (uint8_t)(word >> 8);
}

static uint16_t word_at(uint8_t reg)
{
    return (uint16_t)(table[reg] | table[reg + 1] << 8);
}

void setUp(void)
{
    memset(&servos, 0, sizeof servos);
    rig_open(0);
    cds_bus_set_return_delay(&bus, 10);
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    config = (struct cds_torque_on_config){
        .bus = &bus, .request = &request, .id = 1, .last = CDS_TORQUE_ON_SWITCH};
    turns = 0;
    spoils_goal = 0;
    servo_fake_put(0, 1, CDS_BAUD_1M);
    servo_fake_put(1, 2, CDS_BAUD_1M);
    put_word(CDS_REG_CCW_ANGLE_LIMIT, 1023);
    put_word(CDS_REG_GOAL_POSITION, 300);
    put_word(CDS_REG_MOVING_SPEED, 77);
    put_word(CDS_REG_PRESENT_POSITION, POSITION);
    table[CDS_REG_MIN_VOLTAGE] = 60;
    table[CDS_REG_MAX_VOLTAGE] = 160;
    table[CDS_REG_PRESENT_VOLTAGE] = 120;
}

void tearDown(void)
{
    rig_check();
    TEST_ASSERT_EQUAL_UINT8(0, servos.servo[1].table[CDS_REG_TORQUE_ENABLE]);
}

static void begin(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_torque_on_begin(&on, &config));
}

/* Torque goes on only where the servo is. */
static void turn(void)
{
    uint16_t packets = servos.packets;
    uint8_t torque = table[CDS_REG_TORQUE_ENABLE];

    servos_turn(&bus);
    cds_bus_poll(&bus);
    if (servos.packets == packets)
        return;
    if (table[CDS_REG_TORQUE_ENABLE] && !torque && config.first == CDS_TORQUE_ON_CHECK)
        TEST_ASSERT_UINT16_WITHIN(CDS_TORQUE_ON_NEAR_STEPS, word_at(CDS_REG_PRESENT_POSITION),
                                  word_at(CDS_REG_GOAL_POSITION));
    put_word(CDS_REG_PRESENT_POSITION, (uint16_t)(word_at(CDS_REG_PRESENT_POSITION) + turns));
    if (servos.packets == spoils_goal)
        put_word(CDS_REG_GOAL_POSITION, POSITION + 1);
}

static enum cds_result run(void)
{
    enum cds_result result;

    begin();
    while ((result = cds_torque_on_poll(&on)) == CDS_PENDING)
        turn();
    TEST_ASSERT_EQUAL(result, on.steps.result);
    TEST_ASSERT_EQUAL(result == CDS_OK, on.reason == CDS_REASON_NONE);
    return result;
}

/* The operation fails for this reason, and the servo gets no torque. */
static void assert_failed(enum cds_result result, uint8_t reason)
{
    TEST_ASSERT_EQUAL(result, run());
    TEST_ASSERT_EQUAL_UINT8(reason, on.reason);
    TEST_ASSERT_EQUAL_UINT8(0, table[CDS_REG_TORQUE_ENABLE]);
}

/* The check fails before anything is written. */
static void assert_not_well(uint8_t reason)
{
    assert_failed(CDS_REFUSED, reason);
    TEST_ASSERT_EQUAL_UINT16(1, servos.packets);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

/* ---- what is written ---- */

void test_position_becomes_the_goal_before_torque_on(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(1, table[CDS_REG_TORQUE_ENABLE]);
    TEST_ASSERT_EQUAL_UINT16(POSITION, word_at(CDS_REG_GOAL_POSITION));
    TEST_ASSERT_EQUAL_UINT16(77, word_at(CDS_REG_MOVING_SPEED));
    TEST_ASSERT_EQUAL_UINT16(POSITION, on.goal);
    TEST_ASSERT_EQUAL_UINT16(4, servos.packets);
    TEST_ASSERT_EQUAL_UINT16(2, servos.writes);
}

void test_speed_is_written_with_the_goal(void)
{
    config.speed = 512;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(POSITION, word_at(CDS_REG_GOAL_POSITION));
    TEST_ASSERT_EQUAL_UINT16(512, word_at(CDS_REG_MOVING_SPEED));
}

void test_servo_with_torque_on_stays_as_it_is(void)
{
    table[CDS_REG_TORQUE_ENABLE] = 1;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
    TEST_ASSERT_EQUAL_UINT16(300, word_at(CDS_REG_GOAL_POSITION));
}

/* ---- parts ---- */

void test_check_alone_only_reads(void)
{
    config.last = CDS_TORQUE_ON_CHECK;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(1, servos.packets);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(table + CDS_TORQUE_ON_READ_FROM, reply, CDS_TORQUE_ON_READ_SIZE);
}

void test_goal_alone_leaves_torque_as_it_is(void)
{
    for (uint8_t torque = 0; torque < 2; torque++) {
        setUp();
        config.first = config.last = CDS_TORQUE_ON_GOAL;
        table[CDS_REG_TORQUE_ENABLE] = torque;
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL_UINT8(torque, table[CDS_REG_TORQUE_ENABLE]);
        TEST_ASSERT_EQUAL_UINT16(POSITION, word_at(CDS_REG_GOAL_POSITION));
        TEST_ASSERT_EQUAL_UINT16(1, servos.writes);
    }
}

void test_switch_alone_only_writes_torque(void)
{
    config.first = config.last = CDS_TORQUE_ON_SWITCH;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(1, table[CDS_REG_TORQUE_ENABLE]);
    TEST_ASSERT_EQUAL_UINT16(1, servos.packets);
    TEST_ASSERT_EQUAL_UINT16(300, word_at(CDS_REG_GOAL_POSITION));
}

/* ---- the check ---- */

void test_endless_turn_is_refused(void)
{
    put_word(CDS_REG_CCW_ANGLE_LIMIT, 0);
    assert_not_well(CDS_REASON_MODE);
    setUp();
    put_word(CDS_REG_CCW_ANGLE_LIMIT, 0);
    put_word(CDS_REG_CW_ANGLE_LIMIT, 256); // a low byte of 0
    TEST_ASSERT_EQUAL(CDS_OK, run());
}

/* The servo reports no alarm: only the registers tell. */
void test_voltage_below_min_voltage_is_refused(void)
{
    config.checks_condition = true;
    table[CDS_REG_MIN_VOLTAGE] = 121;
    assert_not_well(CDS_REASON_VOLTAGE);
    setUp();
    config.checks_condition = true;
    table[CDS_REG_MIN_VOLTAGE] = 120;
    TEST_ASSERT_EQUAL(CDS_OK, run());
}

void test_voltage_above_max_voltage_is_refused(void)
{
    config.checks_condition = true;
    table[CDS_REG_MAX_VOLTAGE] = 119;
    assert_not_well(CDS_REASON_VOLTAGE);
    setUp();
    config.checks_condition = true;
    table[CDS_REG_MAX_VOLTAGE] = 120;
    TEST_ASSERT_EQUAL(CDS_OK, run());
}

void test_alarm_is_refused(void)
{
    config.checks_condition = true;
    servos.servo[0].error = CDS_ERROR_OVERHEATING;
    assert_not_well(CDS_REASON_ALARM);
}

void test_alarm_and_voltage_are_ignored_unless_asked_for(void)
{
    servos.servo[0].error = CDS_ERROR_OVERHEATING;
    table[CDS_REG_MIN_VOLTAGE] = 121;
    TEST_ASSERT_EQUAL(CDS_OK, run());
}

/* ---- the goal ---- */

void test_goal_that_reads_back_as_another_one_is_refused(void)
{
    spoils_goal = 2;
    assert_failed(CDS_REFUSED, CDS_REASON_REFUSED);
    TEST_ASSERT_EQUAL_UINT16(3, servos.packets);
    TEST_ASSERT_EQUAL_HEX8(0, request.error);
    setUp();
    spoils_goal = 2;
    config.last = CDS_TORQUE_ON_GOAL;
    assert_failed(CDS_REFUSED, CDS_REASON_REFUSED);
}

/* Two packets lie between the READ of the position and its READ back. */
void test_servo_that_is_turned_a_little_gets_torque(void)
{
    turns = 1;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(4, servos.packets);
    setUp();
    turns = (uint16_t)-1;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(4, servos.packets);
}

void test_servo_that_was_turned_gets_another_goal(void)
{
    begin();
    turns = 2;
    while (servos.packets < 2) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_on_poll(&on));
        turn();
    }
    turns = 0;
    while (cds_torque_on_poll(&on) == CDS_PENDING)
        turn();
    TEST_ASSERT_EQUAL(CDS_OK, on.steps.result);
    TEST_ASSERT_EQUAL_UINT16(POSITION + 4, word_at(CDS_REG_GOAL_POSITION));
    TEST_ASSERT_EQUAL_UINT16(POSITION + 4, on.goal);
    TEST_ASSERT_EQUAL_UINT16(6, servos.packets);
}

void test_servo_that_is_being_turned_is_refused(void)
{
    turns = (uint16_t)-2;
    assert_failed(CDS_REFUSED, CDS_REASON_REFUSED);
    TEST_ASSERT_EQUAL_UINT16(CDS_TORQUE_ON_GOALS, servos.writes);
    setUp();
    turns = (uint16_t)-2;
    config.last = CDS_TORQUE_ON_GOAL; // torque is not the next step
    TEST_ASSERT_EQUAL(CDS_OK, run());
}

/* ---- transactions that fail ---- */

void test_silent_servo_has_not_replied(void)
{
    servos.servo[0].there = false;
    assert_failed(CDS_TIMEOUT, CDS_REASON_NO_REPLY);
}

void test_servo_that_refuses_a_write_is_refused(void)
{
    table[CDS_REG_LOCK] = 1; // the fake then refuses any WRITE
    assert_failed(CDS_REFUSED, CDS_REASON_REFUSED);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, request.error);
}

/* What the permit answers to a WRITE. */
static enum cds_result answer;

static enum cds_result permit(struct cds_request *asked)
{
    return asked->packet.bytes[CDS_AT_INSTRUCTION] == CDS_WRITE ? answer : CDS_OK;
}

void test_permit_that_refuses_is_told(void)
{
    static const uint8_t cases[][2] = {{CDS_INHIBITED, CDS_REASON_INHIBITED},
                                       {CDS_RESERVED, CDS_REASON_INHIBITED},
                                       {CDS_LIMIT, CDS_REASON_POSITION}};

    for (uint8_t i = 0; i < 3; i++) {
        setUp();
        permit_fake_attach(&bus, permit);
        answer = (enum cds_result)cases[i][0];
        assert_failed(answer, cases[i][1]);
        TEST_ASSERT_EQUAL_UINT16(1, servos.packets);
    }
}

/* Whatever is lost: torque goes on only where the servo is (turn()), and CDS_OK is true. */
void test_fault_at_any_packet_gives_no_torque_elsewhere(void)
{
    for (uint8_t fault = LOSE_PACKET; fault < FAULTS; fault++)
        for (uint8_t at = 1; at <= 4; at++) {
            setUp();
            servos.plan[0] = (struct servos_plan){.at = at, .fault = fault, .absent = 1};
            if (run() == CDS_OK)
                TEST_ASSERT_EQUAL_UINT8(1, table[CDS_REG_TORQUE_ENABLE]);
            else
                TEST_ASSERT_EQUAL_UINT8(CDS_REASON_NO_REPLY, on.reason);
        }
}

/* ---- begin and abort ---- */

void test_abort_after_any_packet_sends_nothing_more(void)
{
    for (uint8_t at = 0; at < 4; at++) {
        setUp();
        begin();
        while (servos.packets < at) {
            TEST_ASSERT_EQUAL(CDS_PENDING, cds_torque_on_poll(&on));
            turn();
        }
        cds_torque_on_abort(&on);
        while (cds_torque_on_poll(&on) == CDS_PENDING)
            turn();
        TEST_ASSERT_EQUAL(CDS_CANCELLED, on.steps.result);
        TEST_ASSERT_EQUAL_UINT16(at, servos.packets);
    }
}

static enum cds_result begin_changed(uint8_t id, uint8_t first, uint8_t last, uint16_t speed)
{
    struct cds_torque_on_config changed = config;

    changed.id = id;
    changed.first = first;
    changed.last = last;
    changed.speed = speed;
    return cds_torque_on_begin(&on, &changed);
}

void test_begin_checks_its_arguments(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin_changed(253, 1, 2, 1023));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_changed(254, 0, 2, 0));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_changed(1, 2, 1, 0));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_changed(1, 0, 3, 0));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_changed(1, 0, 2, 1024));
    request.reply_capacity--;
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_torque_on_begin(&on, &config));
    request.reply_capacity++;
    request.packet.capacity--;
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_torque_on_begin(&on, &config));
    request.packet.capacity++;
    request.result = CDS_PENDING;
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_torque_on_begin(&on, &config));
}
