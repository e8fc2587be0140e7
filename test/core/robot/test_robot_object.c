/* SPDX-License-Identifier: MIT */
/* A robot of three joints. Servo 3 has no joint. The clock moves on while nothing is sent. */
#include "cds55xx/robot.h"

#include <string.h>

#include "cds55xx/motion.h"
#include "cds55xx/units.h"
#include "port_fake.h"
#include "servos_fake.h"
#include "unity.h"

#define JOINTS    2
#define DELAY     5   // register 0x05 that the robot sets
#define FASTEST   512 // register value of 31 RPM
#define SPEED_LOW (FASTEST & 0xFF)

CDS_JOINTS(joints) = {
    CDS_JOINT(1, CDS_FORWARD, 150000, -90000, 60000, 31000, CDS_JOINT_CDS55XX, "hip"),
    CDS_JOINT(2, CDS_REVERSED, 100000, -90000, 60000, 31000, CDS_JOINT_CDS55XX, "12345678"),
};
CDS_ROBOT(robot, joints);

/* What the line has seen since begin(). */
static struct {
    uint16_t drives;                // packets that can move a servo
    uint16_t torque_on, torque_off; // WRITEs of TORQUE_ENABLE
    uint16_t delays;                // WRITEs of RETURN_DELAY
    uint16_t syncs;                 // SYNC WRITEs of goals
    uint16_t goals[JOINTS];         // of the last one
    uint8_t first_goals;            // WRITEs of goal and speed
    uint8_t looks;                  // READs of servo 2 by a start
} seen;

static struct {
    struct cds_robot_event events[8];
    uint8_t count;
} told;

static uint16_t stop_at; // packet of the servos after which the robot is stopped; 0: none
static uint16_t turn_us; // time between two polls
static bool restarts, stops, returns_at_ping; // servo 1 returns

static void on_event(struct cds_robot *it)
{
    if (told.count < 8)
        told.events[told.count++] = it->event;
    if (stops && it->event.kind == CDS_ROBOT_EVENT_START_FAILED)
        cds_robot_stop(it);
    if (restarts && it->event.kind == CDS_ROBOT_EVENT_STOPPED) {
        restarts = false;
        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(it));
    }
}

static void put_word(uint8_t *bytes, uint16_t word)
{
    bytes[0] = (uint8_t)word;
    bytes[1] = (uint8_t)(word >> 8);
}

static uint8_t *table_of(uint8_t joint)
{
    return servos.servo[joint].table;
}

static void put_servo(uint8_t index, uint8_t id, uint16_t position)
{
    uint8_t *table = table_of(index);

    servo_fake_put(index, id, CDS_BAUD_1M);
    table[CDS_REG_RETURN_DELAY] = DELAY;
    put_word(table + CDS_REG_CCW_ANGLE_LIMIT, 1023);
    table[CDS_REG_MIN_VOLTAGE] = 60;
    table[CDS_REG_MAX_VOLTAGE] = 160;
    table[CDS_REG_PRESENT_VOLTAGE] = 120;
    put_word(table + CDS_REG_PRESENT_POSITION, position);
}

void setUp(void)
{
    port_fake_reset();
    memset(&robot, 0, sizeof robot);
    memset(robot_feedback, 0, sizeof robot_feedback);
    memset(&servos, 0, sizeof servos);
    memset(&seen, 0, sizeof seen);
    memset(&told, 0, sizeof told);
    stop_at = 0;
    turn_us = 20;
    restarts = stops = returns_at_ping = false;
    put_servo(0, 1, 500);
    put_servo(1, 2, 400);
    put_servo(2, 3, 300);
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M));
    robot.on_event = on_event;
    port_fake_forget();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void take_goals(const uint8_t *packet)
{
    seen.syncs++;
    for (uint8_t i = 0; i < JOINTS; i++) {
        const uint8_t *block = packet + 7 + 5 * i;

        seen.goals[i] = (uint16_t)(block[1] | block[2] << 8);
        if (*block == i + 1u && table_of(i)[CDS_REG_TORQUE_ENABLE])
            memcpy(table_of(i) + CDS_REG_PRESENT_POSITION, block + 1, 2);
    }
}

/* A servo gets torque only if its goal is where it is. */
static void check_torque_on(uint8_t joint)
{
    TEST_ASSERT_LESS_THAN_UINT8(JOINTS, joint);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(table_of(joint) + CDS_REG_PRESENT_POSITION,
                                 table_of(joint) + CDS_REG_GOAL_POSITION, 2);
    TEST_ASSERT_EQUAL_UINT8(SPEED_LOW, table_of(joint)[CDS_REG_MOVING_SPEED]);
}

/* Notes what the packet on the line does. */
static void note(const uint8_t *packet)
{
    if (packet[4] == 1 && returns_at_ping)
        servos.servo[0].there = true;
    if (packet[4] == 0x83) {
        seen.drives++;
        take_goals(packet);
    }
    if (packet[4] == 2 && packet[2] == 2 && packet[5] == CDS_REG_RETURN_DELAY)
        seen.looks++;
    if (packet[4] != 3)
        return;
    if (packet[5] == CDS_REG_RETURN_DELAY)
        seen.delays++;
    if (packet[5] == CDS_REG_GOAL_POSITION) {
        seen.drives++;
        seen.first_goals++;
    }
    if (packet[5] == CDS_REG_TORQUE_ENABLE && packet[6]) {
        seen.drives++;
        seen.torque_on++;
        check_torque_on((uint8_t)(packet[2] - 1));
    }
    if (packet[5] == CDS_REG_TORQUE_ENABLE && !packet[6])
        seen.torque_off++;
}

/* One turn of the main loop. */
static void turn(void)
{
    struct cds_bus *bus = &robot.bus;
    bool is_resting = cds_bus_is_resting(bus) && bus->state == CDS_BUS_WAITING_FOR_LINE;

    cds_robot_poll(&robot);
    port_fake.now_us += is_resting && turn_us < 200 ? 200 : turn_us;
    if (bus->link.state != CDS_LINK_TALKING || !port_fake_transmit(&bus->link, 0))
        return;
    port_fake.now_us += port_fake.sent_size * 10u;
    note(port_fake.sent);
    servos_hear(bus);
    port_fake_forget();
    if (stop_at && servos.packets == stop_at)
        cds_robot_stop(&robot);
}

static void run_until(uint8_t state)
{
    for (uint32_t turns = 0; robot.state != state; turns++) {
        TEST_ASSERT_LESS_THAN_UINT32(200000, turns);
        turn();
    }
}

static void pass_ms(uint16_t ms)
{
    uint32_t end_us = port_fake.now_us + (uint32_t)ms * 1000u;

    while (port_fake.now_us < end_us)
        turn();
}

static void start(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
    run_until(CDS_ROBOT_RUNNING);
}

/* A start that fails: nothing has driven a servo, and torque is off. */
static void fail_to_start(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
    run_until(CDS_ROBOT_STOPPED);
    TEST_ASSERT_EQUAL_UINT16(0, seen.torque_on);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(3, seen.torque_off);
    TEST_ASSERT_TRUE(robot.servos.all_inhibited);
}

static void assert_told(uint8_t index, uint8_t kind, uint8_t joint, uint8_t why)
{
    TEST_ASSERT_LESS_THAN_UINT8(told.count, index);
    TEST_ASSERT_EQUAL_UINT8(kind, told.events[index].kind);
    TEST_ASSERT_EQUAL_UINT8(joint, told.events[index].joint);
    TEST_ASSERT_EQUAL_UINT8(why, told.events[index].why);
}

/* ---- table and units ---- */

CDS_JOINTS(whole) = {
    CDS_JOINT(1, CDS_FORWARD, 0, 0, 300000, 62000, CDS_JOINT_CDS55XX, ""),
    CDS_JOINT(2, CDS_REVERSED, 300000, 0, 300000, 113553, CDS_JOINT_AX12, ""),
};
static const struct cds_robot_config whole_config CDS_IN_FLASH = {
    whole, robot_states, robot_feedback, robot_ids, robot_reported, robot_packets, JOINTS};

void test_position_of_every_angle_is_that_of_units(void)
{
    uint16_t expected, position;

    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_open(&robot, &whole_config, 0, CDS_BAUD_1M));
    for (int32_t mdeg = 0; mdeg <= 300000; mdeg += 13) {
        cds_units_to_register(NULL, CDS_UNIT_MDEG, mdeg, &expected);
        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_to_position(&robot, 0, mdeg, &position));
        TEST_ASSERT_EQUAL_UINT16(expected, position);
        cds_units_to_register(NULL, CDS_UNIT_MDEG, 300000 - mdeg, &expected);
        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_to_position(&robot, 1, mdeg, &position));
        TEST_ASSERT_EQUAL_UINT16(expected, position);
    }
    for (uint16_t at = 0; at < 1024; at++) {
        int32_t converted, mdeg;

        for (uint8_t i = 0; i < JOINTS; i++)
            robot_feedback[i] = (struct cds_feedback){.known = true, .position = at};
        cds_units_from_register(NULL, CDS_UNIT_MDEG, at, &converted);
        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_position_mdeg(&robot, 0, &mdeg));
        TEST_ASSERT_EQUAL_INT32(converted, mdeg);
        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_position_mdeg(&robot, 1, &mdeg));
        TEST_ASSERT_EQUAL_INT32(300000 - converted, mdeg);
    }
}

void test_position_of_an_angle_beyond_the_limits_is_none(void)
{
    uint16_t position = 512;

    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_open(&robot, &whole_config, 0, CDS_BAUD_1M));
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_robot_to_position(&robot, 0, 300001, &position));
    TEST_ASSERT_EQUAL_UINT16(CDS_POSE_NONE, position);
    position = 512;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_to_position(&robot, JOINTS, 0, &position));
    TEST_ASSERT_EQUAL_UINT16(CDS_POSE_NONE, position);
}

void test_robot_that_was_never_opened_has_no_joint(void)
{
    static struct cds_robot closed;
    uint16_t position;
    int32_t mdeg;

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_to_position(&closed, 0, 0, &position));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_position_mdeg(&closed, 0, &mdeg));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_set_goal_mdeg(&closed, 0, 0));
}

void test_limits_of_the_table_are_soft_limits_of_the_servos(void)
{
    TEST_ASSERT_EQUAL_UINT16(205, robot_states[0].lowest); // 60 degrees
    TEST_ASSERT_EQUAL_UINT16(716, robot_states[0].highest);
    TEST_ASSERT_EQUAL_UINT16(136, robot_states[1].lowest); // 40 degrees, joint at 60
    TEST_ASSERT_EQUAL_UINT16(648, robot_states[1].highest);
    TEST_ASSERT_EQUAL_UINT16(FASTEST, robot_states[1].fastest);
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_open(&robot, &whole_config, 0, CDS_BAUD_1M));
    TEST_ASSERT_EQUAL_UINT16(1023, robot_states[0].fastest);
    TEST_ASSERT_EQUAL_UINT16(1023, robot_states[1].fastest);
    TEST_ASSERT_EQUAL_UINT16(1023, robot_states[1].highest);
}

void test_row_of_the_table_is_copied(void)
{
    struct cds_joint row;

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_joint(&robot, 2, &row));
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_joint(&robot, 1, &row));
    TEST_ASSERT_EQUAL_UINT8(2, row.id);
    TEST_ASSERT_EQUAL_STRING("12345678", row.name);
}

#define GOOD CDS_JOINT(1, CDS_FORWARD, 150000, -90000, 60000, 31000, CDS_JOINT_CDS55XX, "")
#define BAD(id, direction, offset, lowest, highest, fastest, profile)                              \
    {                                                                                              \
        GOOD, CDS_JOINT(id, direction, offset, lowest, highest, fastest, profile, "")              \
    }
static const struct cds_joint bad[][JOINTS] CDS_IN_FLASH = {
    BAD(254, 1, 150000, -90000, 60000, 31000, CDS_JOINT_CDS55XX),
    BAD(1, 1, 150000, -90000, 60000, 31000, CDS_JOINT_CDS55XX),
    BAD(2, 1, 150000, 60001, 60000, 31000, CDS_JOINT_CDS55XX),
    BAD(2, 1, 150000, -150001, 60000, 31000, CDS_JOINT_CDS55XX),
    BAD(2, 1, 150000, -90000, 150001, 31000, CDS_JOINT_CDS55XX),
    BAD(2, -1, 150000, -150001, 60000, 31000, CDS_JOINT_CDS55XX),
    BAD(2, -1, 150000, INT32_MIN, 60000, 31000, CDS_JOINT_CDS55XX),
    BAD(2, 1, 150000, -90000, 60000, 0, CDS_JOINT_CDS55XX),
    BAD(2, 1, 150000, -90000, 60000, 62001, CDS_JOINT_CDS55XX),
    BAD(2, 1, 150000, -90000, 60000, 113554, CDS_JOINT_AX12),
    BAD(2, 0, 150000, -90000, 60000, 31000, CDS_JOINT_CDS55XX),
    BAD(2, 1, 150000, -90000, 60000, 31000, 2),
    BAD(2, 1, -1, 10, 60000, 31000, CDS_JOINT_CDS55XX),
    BAD(2, -1, 300001, 10, 60000, 31000, CDS_JOINT_CDS55XX),
};
#define BAD_ROWS (sizeof bad / sizeof bad[0])
#define BAD_CONFIG(i)                                                                              \
    {                                                                                              \
        bad[i], robot_states, robot_feedback, robot_ids, robot_reported, robot_packets, JOINTS     \
    }
static const struct cds_robot_config bad_configs[] CDS_IN_FLASH = {
    BAD_CONFIG(0),  BAD_CONFIG(1),  BAD_CONFIG(2),  BAD_CONFIG(3),  BAD_CONFIG(4),
    BAD_CONFIG(5),  BAD_CONFIG(6),  BAD_CONFIG(7),  BAD_CONFIG(8),  BAD_CONFIG(9),
    BAD_CONFIG(10), BAD_CONFIG(11), BAD_CONFIG(12), BAD_CONFIG(13),
};

void test_open_with_a_bad_row_is_refused(void)
{
    for (uint8_t i = 0; i < BAD_ROWS; i++) {
        TEST_ASSERT_EQUAL_MESSAGE(CDS_BAD_ARGUMENT,
                                  cds_robot_open(&robot, &bad_configs[i], 0, CDS_BAUD_1M), "open");
        if (i > 1) // else the ID is bad
            TEST_ASSERT_EQUAL_UINT8(1, robot.event.joint);
        TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_start(&robot));
        TEST_ASSERT_EQUAL(CDS_ROBOT_STOPPED, cds_robot_poll(&robot));
        cds_robot_stop(&robot);
        TEST_ASSERT_EQUAL(CDS_ROBOT_STOPPED, cds_robot_poll(&robot));
    }
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M));
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
}

void test_start_that_is_refused_leaves_the_robot_stopped(void)
{
    memset(&robot, 0, sizeof robot);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_start(&robot)); // not open
    TEST_ASSERT_EQUAL(CDS_ROBOT_STOPPED, cds_robot_poll(&robot));
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M));
    robot.period_us = 100;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_start(&robot));
    TEST_ASSERT_EQUAL(CDS_ROBOT_STOPPED, cds_robot_poll(&robot));
}

/* ---- start ---- */

void test_start_sets_positions_as_goals_before_torque_on(void)
{
    int32_t mdeg;

    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_robot_position_mdeg(&robot, 0, &mdeg));
    start();
    assert_told(0, CDS_ROBOT_EVENT_STARTED, 0, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_UINT8(2, seen.first_goals);
    TEST_ASSERT_EQUAL_UINT16(2, seen.torque_on);
    TEST_ASSERT_EQUAL_UINT16(4, seen.drives);
    TEST_ASSERT_EQUAL_UINT8(0, table_of(2)[CDS_REG_TORQUE_ENABLE]); // no joint of the table
    for (uint8_t i = 0; i < JOINTS; i++) {
        TEST_ASSERT_EQUAL_HEX8_ARRAY(table_of(i) + CDS_REG_PRESENT_POSITION,
                                     table_of(i) + CDS_REG_GOAL_POSITION, 2);
        TEST_ASSERT_EQUAL_UINT8(SPEED_LOW, table_of(i)[CDS_REG_MOVING_SPEED]);
        TEST_ASSERT_EQUAL_UINT8(1, table_of(i)[CDS_REG_TORQUE_ENABLE]);
    }
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_position_mdeg(&robot, 0, &mdeg));
    TEST_ASSERT_EQUAL_INT32(146628 - 150000, mdeg);
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_position_mdeg(&robot, 1, &mdeg));
    TEST_ASSERT_EQUAL_INT32(100000 - 117302, mdeg);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_position_mdeg(&robot, 2, &mdeg));
    pass_ms(10);
    TEST_ASSERT_EQUAL_UINT16(500, seen.goals[0]);
    TEST_ASSERT_EQUAL_UINT16(400, seen.goals[1]);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_robot_start(&robot));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M));
}

void test_start_writes_only_a_return_delay_that_differs(void)
{
    start();
    TEST_ASSERT_EQUAL_UINT16(0, seen.delays);
    cds_robot_stop(&robot);
    run_until(CDS_ROBOT_STOPPED);
    table_of(0)[CDS_REG_RETURN_DELAY] = 0;
    table_of(1)[CDS_REG_RETURN_DELAY] = 250;
    start();
    TEST_ASSERT_EQUAL_UINT16(2, seen.delays);
    TEST_ASSERT_EQUAL_UINT8(DELAY, table_of(0)[CDS_REG_RETURN_DELAY]);
    TEST_ASSERT_EQUAL_UINT8(DELAY, table_of(1)[CDS_REG_RETURN_DELAY]);
    TEST_ASSERT_EQUAL_UINT16(2 * DELAY, robot.bus.return_delay_us);
}

void test_start_waits_for_a_servo_that_starts_up(void)
{
    servos.dark = 200; // 2 s have 400 of its READs
    start();
    TEST_ASSERT_EQUAL_UINT16(3, seen.delays);
    TEST_ASSERT_EQUAL_UINT8(1, told.count);
}

void test_start_without_a_servo_tells_which(void)
{
    servos.servo[0].there = false;
    fail_to_start();
    TEST_ASSERT_UINT32_WITHIN(300000, CDS_ROBOT_START_TIMEOUT_US, port_fake.now_us);
    assert_told(0, CDS_ROBOT_EVENT_START_FAILED, 0, CDS_REASON_NO_REPLY);
    TEST_ASSERT_EQUAL_UINT8(CDS_TIMEOUT, told.events[0].result);
    TEST_ASSERT_EQUAL_UINT16(0, seen.drives);
    TEST_ASSERT_EQUAL_UINT16(6, seen.delays); // two and their retries, in case it answers too soon
    assert_told(1, CDS_ROBOT_EVENT_STOPPED, 0, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_UINT8(CDS_TIMEOUT, told.events[1].result);
    TEST_ASSERT_EQUAL_UINT8(2, told.count);
}

void test_start_tells_of_each_servo_that_is_not_well(void)
{
    put_word(table_of(0) + CDS_REG_CCW_ANGLE_LIMIT, 0);
    table_of(1)[CDS_REG_PRESENT_VOLTAGE] = 59;
    fail_to_start();
    assert_told(0, CDS_ROBOT_EVENT_START_FAILED, 0, CDS_REASON_MODE);
    assert_told(1, CDS_ROBOT_EVENT_START_FAILED, 1, CDS_REASON_VOLTAGE);
    TEST_ASSERT_EQUAL_UINT16(0, seen.drives);
    TEST_ASSERT_EQUAL_UINT8(3, told.count);
}

/* The start fails because of joint 1. */
static void assert_reason(uint8_t why, uint8_t alarms)
{
    fail_to_start();
    assert_told(0, CDS_ROBOT_EVENT_START_FAILED, 1, why);
    TEST_ASSERT_EQUAL_HEX8(alarms, told.events[0].alarms);
    TEST_ASSERT_EQUAL_UINT16(0, seen.drives);
    TEST_ASSERT_EQUAL_UINT8(2, told.count);
}

void test_start_with_too_high_a_voltage_fails(void)
{
    table_of(1)[CDS_REG_PRESENT_VOLTAGE] = 161;
    assert_reason(CDS_REASON_VOLTAGE, 0);
}

void test_start_below_the_limits_fails(void)
{
    put_word(table_of(1) + CDS_REG_PRESENT_POSITION, 135);
    assert_reason(CDS_REASON_POSITION, 0);
}

void test_start_above_the_limits_fails(void)
{
    put_word(table_of(1) + CDS_REG_PRESENT_POSITION, 649);
    assert_reason(CDS_REASON_POSITION, 0);
}

void test_start_with_an_alarm_fails(void)
{
    servos.servo[1].error = CDS_ERROR_OVERHEATING;
    assert_reason(CDS_REASON_ALARM, CDS_ERROR_OVERHEATING);
}

void test_start_with_a_locked_return_delay_fails(void)
{
    table_of(1)[CDS_REG_RETURN_DELAY] = 250;
    table_of(1)[CDS_REG_LOCK] = 1;
    assert_reason(CDS_REASON_RETURN_DELAY, 0);
}

/* Runs a start until servo 1 has its first goal: all servos were found to be well. */
static void start_until_first_goal(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
    while (!seen.first_goals)
        turn();
}

void test_start_with_a_servo_that_refuses_its_goal_fails(void)
{
    start_until_first_goal();
    table_of(1)[CDS_REG_LOCK] = 1; // the fake then refuses any WRITE
    run_until(CDS_ROBOT_STOPPED);
    assert_told(0, CDS_ROBOT_EVENT_START_FAILED, 1, CDS_REASON_REFUSED);
    TEST_ASSERT_EQUAL_UINT16(0, seen.torque_on);
}

void test_start_of_a_joint_that_leaves_its_limits_fails(void)
{
    start_until_first_goal();
    put_word(table_of(1) + CDS_REG_PRESENT_POSITION, 649);
    run_until(CDS_ROBOT_STOPPED);
    assert_told(0, CDS_ROBOT_EVENT_START_FAILED, 1, CDS_REASON_POSITION);
    TEST_ASSERT_EQUAL_UINT8(CDS_LIMIT, told.events[0].result);
    TEST_ASSERT_EQUAL_UINT8(1, seen.first_goals);
    TEST_ASSERT_EQUAL_UINT16(0, seen.torque_on);
}

void test_start_that_the_program_inhibits_fails(void)
{
    start_until_first_goal();
    cds_servos_inhibit_all(&robot.servos);
    run_until(CDS_ROBOT_STOPPED);
    assert_told(0, CDS_ROBOT_EVENT_START_FAILED, 1, CDS_REASON_INHIBITED);
    TEST_ASSERT_EQUAL_UINT16(1, seen.drives);
}

void test_start_with_a_reserved_servo_fails(void)
{
    start_until_first_goal();
    cds_servos_reserve(&robot.servos, NULL, robot_ids, JOINTS);
    run_until(CDS_ROBOT_STOPPED);
    assert_told(0, CDS_ROBOT_EVENT_START_FAILED, 1, CDS_REASON_INHIBITED);
    TEST_ASSERT_EQUAL_UINT8(CDS_RESERVED, told.events[0].result);
}

void test_start_with_a_servo_that_dies_fails(void)
{
    start_until_first_goal();
    servos.servo[0].there = false;
    run_until(CDS_ROBOT_STOPPED);
    assert_told(0, CDS_ROBOT_EVENT_START_FAILED, 0, CDS_REASON_NO_REPLY);
    TEST_ASSERT_EQUAL_UINT16(0, seen.torque_on);
    TEST_ASSERT_EQUAL_UINT8(1, seen.looks); // the start ends at once
}

void test_start_inhibits_driving_until_all_servos_are_well(void)
{
    cds_servos_release_all(&robot.servos);
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
    TEST_ASSERT_TRUE(robot.servos.all_inhibited);
    run_until(CDS_ROBOT_RUNNING);
    TEST_ASSERT_FALSE(robot.servos.all_inhibited);
}

void test_start_with_too_long_a_return_delay_is_refused(void)
{
    robot.return_delay_us = CDS_RETURN_DELAY_MAX_US + 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_start(&robot));
}

void test_goals_that_do_not_fit_the_period_are_refused(void)
{
    robot.period_us = 200;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_start(&robot));
    TEST_ASSERT_EQUAL(CDS_ROBOT_STOPPED, cds_robot_poll(&robot));
}

/* Starts with a fault of servo 1, or of the line, at packet `at`. The robot then runs with torque
 * on, or has stopped with torque off. */
static void start_with_fault(uint8_t fault, uint8_t at, uint8_t absent)
{
    uint8_t torque;

    setUp();
    servos.plan[0] = (struct servos_plan){.at = at, .fault = fault, .absent = absent};
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
    while (robot.state != CDS_ROBOT_RUNNING && robot.state != CDS_ROBOT_STOPPED)
        turn();
    torque = robot.state == CDS_ROBOT_RUNNING;
    for (uint8_t i = 0; i < JOINTS; i++)
        TEST_ASSERT_EQUAL_UINT8(torque, table_of(i)[CDS_REG_TORQUE_ENABLE]);
}

void test_start_with_a_fault_at_any_packet_runs_or_stops(void)
{
    for (uint8_t fault = LOSE_PACKET; fault < FAULTS; fault++)
        for (uint8_t at = 1; at < 16; at++) {
            start_with_fault(fault, at, 1);
            if (fault >= CUT_BEFORE) // longer than all retries last
                start_with_fault(fault, at, 9);
        }
}

/* ---- goals ---- */

void test_goal_honours_direction_offset_and_limits(void)
{
    TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_robot_set_goal_mdeg(&robot, 0, 0));
    start();
    pass_ms(10);
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_set_goal_mdeg(&robot, 0, -90000));
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_set_goal_mdeg(&robot, 1, -90000));
    pass_ms(10);
    TEST_ASSERT_EQUAL_UINT16(205, seen.goals[0]);
    TEST_ASSERT_EQUAL_UINT16(648, seen.goals[1]);
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_robot_set_goal_mdeg(&robot, 0, -90001));
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_robot_set_goal_mdeg(&robot, 1, 60001));
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_robot_set_goal_mdeg(&robot, 1, INT32_MIN));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_robot_set_goal_mdeg(&robot, 2, 0));
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_set_goal_mdeg(&robot, 1, 60000));
    pass_ms(10);
    TEST_ASSERT_EQUAL_UINT16(205, seen.goals[0]);
    TEST_ASSERT_EQUAL_UINT16(136, seen.goals[1]);
}

void test_goals_of_every_turn_are_taken_and_leave_together(void)
{
    uint16_t periods = 0;

    start();
    for (uint16_t i = 0; i < 2000; i++) {
        int32_t mdeg = (i % 100) * 293;

        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_set_goal_mdeg(&robot, 0, mdeg));
        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_set_goal_mdeg(&robot, 1, -mdeg));
        turn();
        if (seen.syncs != periods && seen.syncs > 2) // both have gone as far since the offsets
            TEST_ASSERT_UINT16_WITHIN(1, seen.goals[0] - 512, seen.goals[1] - 341);
        periods = seen.syncs;
    }
    TEST_ASSERT_GREATER_THAN_UINT16(10, periods);
    TEST_ASSERT_EQUAL_UINT32(0, robot.cycle.counters.missed);
}

void test_while_inhibited_no_goal_is_taken_or_sent(void)
{
    uint16_t drives;

    start();
    pass_ms(10);
    cds_servos_inhibit_all(&robot.servos);
    drives = seen.drives;
    TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_robot_set_goal_mdeg(&robot, 0, 1000));
    pass_ms(20);
    TEST_ASSERT_EQUAL_UINT16(drives, seen.drives);
}

/* ---- events ---- */

void test_alarm_stops_the_robot(void)
{
    start();
    servos.servo[1].error = CDS_ERROR_OVERLOAD;
    run_until(CDS_ROBOT_STOPPED);
    assert_told(1, CDS_ROBOT_EVENT_ALARM, 1, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_OVERLOAD, told.events[1].alarms);
    assert_told(2, CDS_ROBOT_EVENT_STOPPED, 0, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, told.events[2].result);
    TEST_ASSERT_EQUAL_UINT8(0, table_of(0)[CDS_REG_TORQUE_ENABLE]);
    servos.servo[1].error = 0;
    start();
    pass_ms(50);
    TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
}

void test_tolerated_alarm_is_told_once_until_acknowledged(void)
{
    start();
    robot.tolerates = 1 << CDS_ROBOT_EVENT_ALARM;
    servos.servo[1].error = CDS_ERROR_OVERLOAD;
    pass_ms(50);
    TEST_ASSERT_EQUAL_UINT8(2, told.count);
    servos.servo[0].error = CDS_ERROR_OVERHEATING;
    pass_ms(50);
    assert_told(2, CDS_ROBOT_EVENT_ALARM, 0, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_UINT8(3, told.count);
    cds_servos_acknowledge(&robot.servos, &robot.servos.states[1]);
    pass_ms(50);
    assert_told(3, CDS_ROBOT_EVENT_ALARM, 1, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_UINT8(4, told.count);
    TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
}

void test_lost_torque_with_a_tolerated_alarm_stops_the_robot(void)
{
    start();
    robot.tolerates = 1 << CDS_ROBOT_EVENT_ALARM;
    servos.servo[1].error = CDS_ERROR_OVERLOAD;
    table_of(1)[CDS_REG_TORQUE_ENABLE] = 0;
    run_until(CDS_ROBOT_STOPPED);
    assert_told(1, CDS_ROBOT_EVENT_ALARM, 1, CDS_REASON_NONE);
    assert_told(2, CDS_ROBOT_EVENT_STATE_LOST, 1, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_UINT8(4, told.count);
}

void test_servo_that_does_not_answer_stops_the_robot(void)
{
    start();
    servos.servo[0].there = false;
    run_until(CDS_ROBOT_STOPPED);
    assert_told(1, CDS_ROBOT_EVENT_OFFLINE, 0, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_UINT8(3, told.count);
}

void test_tolerated_offline_servo_that_returns_is_told_once(void)
{
    start();
    robot.tolerates = 1 << CDS_ROBOT_EVENT_OFFLINE;
    servos.servo[0].there = false;
    pass_ms(700);
    assert_told(1, CDS_ROBOT_EVENT_OFFLINE, 0, CDS_REASON_NONE);
    returns_at_ping = true; // the state check hears it first; its feedback is old
    pass_ms(300);
    TEST_ASSERT_TRUE(servos.servo[0].there);
    TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
    TEST_ASSERT_EQUAL_UINT8(2, told.count);
    returns_at_ping = false;
    servos.servo[0].there = false;
    pass_ms(200);
    assert_told(2, CDS_ROBOT_EVENT_OFFLINE, 0, CDS_REASON_NONE);
}

/* A period is 4 ms long. */
void test_slow_main_loop_finds_a_servo_offline(void)
{
    start();
    turn_us = 2500;
    pass_ms(2000);
    TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
    TEST_ASSERT_EQUAL_UINT32(0, robot.cycle.counters.missed);
    servos.servo[0].there = false;
    run_until(CDS_ROBOT_STOPPED);
    assert_told(1, CDS_ROBOT_EVENT_OFFLINE, 0, CDS_REASON_NONE);
    TEST_ASSERT_EQUAL_UINT8(0, table_of(1)[CDS_REG_TORQUE_ENABLE]);
}

void test_slow_main_loop_finds_lost_torque(void)
{
    start();
    turn_us = 2500;
    pass_ms(100);
    table_of(1)[CDS_REG_TORQUE_ENABLE] = 0;
    pass_ms(1100);
    assert_told(1, CDS_ROBOT_EVENT_STATE_LOST, 1, CDS_REASON_NONE);
}

void test_main_loop_too_slow_for_feedback_stops_the_robot(void)
{
    for (uint16_t us = 4000; us < 40000; us += 7300) {
        int32_t mdeg;

        setUp();
        start();
        turn_us = us;
        pass_ms(400);
        TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_position_mdeg(&robot, 0, &mdeg));
        pass_ms(300);
        TEST_ASSERT_EQUAL_UINT8(CDS_ROBOT_EVENT_FEEDBACK_OLD, told.events[1].kind);
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_robot_position_mdeg(&robot, 0, &mdeg));
        run_until(CDS_ROBOT_STOPPED);
        TEST_ASSERT_EQUAL_UINT8(0, table_of(0)[CDS_REG_TORQUE_ENABLE]);
        TEST_ASSERT_EQUAL_UINT8(0, table_of(1)[CDS_REG_TORQUE_ENABLE]);
    }
}

void test_feedback_grows_old_from_the_end_of_a_slow_start_on(void)
{
    turn_us = 60000; // torque on for both joints takes longer than 500 ms
    start();
    turn_us = 20;
    pass_ms(300);
    TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
}

void test_tolerated_old_feedback_is_told_once_a_joint(void)
{
    start();
    robot.tolerates = 1 << CDS_ROBOT_EVENT_FEEDBACK_OLD;
    turn_us = 5000;
    pass_ms(2000);
    TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
    TEST_ASSERT_EQUAL_UINT8(1 + JOINTS, told.count);
}

/* The line is low for 5 s: longer than one torque off tries. */
void test_low_line_stops_the_robot_when_the_line_is_free(void)
{
    start();
    pass_ms(100);
    while ((port_fake.now_us + 499900) % 65536 > 100)
        turn(); // feedback is checked just before the line has been low for 500 ms
    port_fake.low = true;
    pass_ms(5000);
    TEST_ASSERT_EQUAL_UINT8(2, told.count);
    TEST_ASSERT_EQUAL(CDS_ROBOT_STOPPING, robot.state);
    assert_told((uint8_t)(told.count - 1), CDS_ROBOT_EVENT_LINE_BUSY, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(1, table_of(0)[CDS_REG_TORQUE_ENABLE]);
    seen.drives = 0;
    port_fake.low = false;
    run_until(CDS_ROBOT_STOPPED);
    TEST_ASSERT_EQUAL_UINT16(0, seen.drives);
    TEST_ASSERT_EQUAL_UINT8(0, table_of(0)[CDS_REG_TORQUE_ENABLE]);
    TEST_ASSERT_EQUAL_UINT8(0, table_of(1)[CDS_REG_TORQUE_ENABLE]);
}

void test_line_low_for_a_moment_does_not_stop_the_robot(void)
{
    start();
    for (uint8_t again = 0; again < 3; again++) {
        port_fake.low = true;
        pass_ms(400);
        port_fake.low = false;
        pass_ms(50);
    }
    TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
}

void test_lost_torque_stops_the_robot(void)
{
    start();
    table_of(1)[CDS_REG_TORQUE_ENABLE] = 0;
    run_until(CDS_ROBOT_STOPPED);
    assert_told(1, CDS_ROBOT_EVENT_STATE_LOST, 1, CDS_REASON_NONE);
}

/* ---- stop ---- */

void test_stop_at_any_packet_lets_nothing_drive_after_it(void)
{
    for (uint16_t at = 1; at < 60; at++) {
        uint16_t drives;

        setUp();
        stop_at = at;
        TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
        while (robot.state != CDS_ROBOT_STOPPING)
            turn();
        drives = seen.drives;
        run_until(CDS_ROBOT_STOPPED);
        pass_ms(10);
        TEST_ASSERT_EQUAL_UINT16(drives, seen.drives);
        TEST_ASSERT_EQUAL_UINT8(0, table_of(0)[CDS_REG_TORQUE_ENABLE]);
        TEST_ASSERT_EQUAL_UINT8(0, table_of(1)[CDS_REG_TORQUE_ENABLE]);
        TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_robot_set_goal_mdeg(&robot, 0, 0));
        stop_at = 0;
        start();
    }
}

void test_start_after_a_stop_takes_the_new_positions(void)
{
    start();
    pass_ms(10);
    cds_robot_stop(&robot);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_robot_start(&robot));
    run_until(CDS_ROBOT_STOPPED);
    put_word(table_of(0) + CDS_REG_PRESENT_POSITION, 555); // moved by hand
    table_of(1)[CDS_REG_RETURN_DELAY] = 100;               // another servo
    seen.syncs = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
    turn();
    TEST_ASSERT_EQUAL_UINT16(CDS_RETURN_DELAY_MAX_US, robot.request.return_delay_us);
    run_until(CDS_ROBOT_RUNNING);
    TEST_ASSERT_EQUAL_UINT16(0, seen.syncs);
    pass_ms(10);
    TEST_ASSERT_EQUAL_UINT16(555, seen.goals[0]);
    TEST_ASSERT_EQUAL_UINT16(1, seen.delays);
}

void test_start_after_a_servo_was_offline(void)
{
    start();
    servos.servo[0].there = false;
    run_until(CDS_ROBOT_STOPPED);
    servos.servo[0].there = true;
    table_of(0)[CDS_REG_TORQUE_ENABLE] = 0;
    start();
    TEST_ASSERT_EQUAL_UINT8(1, table_of(0)[CDS_REG_TORQUE_ENABLE]);
    pass_ms(2000);
    TEST_ASSERT_EQUAL(CDS_ROBOT_RUNNING, robot.state);
}

void test_on_event_may_stop_and_start(void)
{
    stops = restarts = true;
    servos.servo[0].there = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_start(&robot));
    while (told.count < 2)
        turn();
    TEST_ASSERT_EQUAL(CDS_ROBOT_STARTING, robot.state);
    servos.servo[0].there = true;
    run_until(CDS_ROBOT_RUNNING);
}

void test_stop_from_on_event_ends_the_start(void)
{
    stops = true;
    put_word(table_of(0) + CDS_REG_CCW_ANGLE_LIMIT, 0);
    fail_to_start();
    TEST_ASSERT_EQUAL_UINT8(0, seen.looks);
}

void test_stop_without_a_start_switches_torque_off(void)
{
    table_of(2)[CDS_REG_TORQUE_ENABLE] = 1;
    cds_robot_stop(&robot);
    run_until(CDS_ROBOT_STOPPED);
    TEST_ASSERT_EQUAL_UINT8(0, table_of(2)[CDS_REG_TORQUE_ENABLE]);
}

/* ---- timed moves ---- */

static struct cds_motion motion;
static struct cds_motion_joint motion_joints[JOINTS];

void test_motion_is_polled_and_ends_with_the_robot(void)
{
    uint16_t pose[JOINTS];
    struct cds_move move = {.pose = pose, .time_ms = 500};

    TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_robot_begin_motion(&robot, &motion, motion_joints, NULL));
    start();
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_begin_motion(&robot, &motion, motion_joints, NULL));
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_to_position(&robot, 0, -20000, &pose[0]));
    TEST_ASSERT_EQUAL(CDS_OK, cds_robot_to_position(&robot, 1, 10000, &pose[1]));
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &move));
    pass_ms(600);
    TEST_ASSERT_EQUAL(CDS_OK, motion.result);
    TEST_ASSERT_EQUAL_UINT16(pose[0], seen.goals[0]);
    TEST_ASSERT_EQUAL_UINT16(pose[1], seen.goals[1]);
    pose[0] = 500;
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &move));
    pass_ms(200);
    TEST_ASSERT_EQUAL(CDS_PENDING, motion.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_motion_move(&motion, &move));
    cds_robot_stop(&robot);
    run_until(CDS_ROBOT_STOPPED);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.result);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, motion.move_result);
    start();
    pass_ms(100);
    TEST_ASSERT_EQUAL_UINT8(table_of(0)[CDS_REG_GOAL_POSITION], (uint8_t)seen.goals[0]);
}
