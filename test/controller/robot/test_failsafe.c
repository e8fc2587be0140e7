/* SPDX-License-Identifier: MIT */
/* The failsafe: loss of the host link, torque off, alarms; and the servos that robot.h adds. */
#include "robot/failsafe.h"

#include <string.h>

#include "cds55xx/sync_write.h"
#include "cds55xx/servo.h"
#include "port_fake.h"
#include "torque_fake.h"
#include "unity.h"

#define LIMIT_MS 3

static struct cds_bus bus;
static struct robot robot;
static struct failsafe failsafe;
static struct settings settings;
static struct settings_store store;
static uint8_t buffer[64], reply[CDS_REPLY_MAX];
static struct cds_request request;

void setUp(void)
{
    port_fake_reset();
    port_fake.now_us = UINT32_MAX - 1000; // the clock wraps in every test
    memset(&wire, 0, sizeof wire);
    memset(&bus, 0, sizeof bus);
    memset(&robot, 0, sizeof robot);
    memset(&request, 0, sizeof request);
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    robot_begin(&robot, &bus, 0);
    robot.servos.grows = CDS_GROWS_ALWAYS;
    settings_default(&settings);
    settings.link_loss_ms = LIMIT_MS;
    failsafe = (struct failsafe){.settings = &settings, .store = &store, .robot = &robot};
    failsafe_begin(&failsafe, FAILSAFE_RESET_WATCHDOG);
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++)
        wire.servo[i].torque = 1;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* The main loop, for so long. */
static void run(uint32_t us)
{
    while (us--) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
        robot_poll(&robot);
        failsafe_poll(&failsafe);
    }
}

static void lose_link(uint8_t action)
{
    settings.link_loss_action = action;
    failsafe_heard(&failsafe);
    run(LIMIT_MS * 1000ul + 1);
    TEST_ASSERT_TRUE(failsafe.link_lost);
}

static enum cds_result goal(uint8_t id)
{
    return cds_servo_write_word(&bus, &request, id, CDS_REG_GOAL_POSITION, 512);
}

static void meet(uint8_t id)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, id));
    run(2000);
}

/* A servo says this, unasked for. */
static void says(uint8_t id, uint8_t error)
{
    port_fake_answer(&bus.link, id, error, NULL, 0);
    run(2);
}

static const struct cds_servo_state *known(uint8_t id)
{
    return cds_servos_find(&robot.servos, id);
}

/* ---- the host link ---- */

void test_nothing_is_watched_before_the_host_was_heard(void)
{
    run(3 * LIMIT_MS * 1000ul);
    TEST_ASSERT_FALSE(failsafe.link_lost);
}

void test_nothing_is_watched_if_the_time_is_0(void)
{
    settings.link_loss_ms = 0;
    failsafe_heard(&failsafe);
    run(3 * LIMIT_MS * 1000ul);
    TEST_ASSERT_FALSE(failsafe.link_lost);
}

/* The byte that ends the line may be noted before the line is carried out. */
void test_the_watch_begins_when_the_time_is_set(void)
{
    settings.link_loss_ms = 0;
    failsafe_heard(&failsafe);
    run(10);
    settings.link_loss_ms = LIMIT_MS;
    run(LIMIT_MS * 1000ul - 11);
    TEST_ASSERT_FALSE(failsafe.link_lost);
    run(1);
    TEST_ASSERT_TRUE(failsafe.link_lost);
}

void test_link_is_lost_at_end_of_time(void)
{
    failsafe_heard(&failsafe);
    for (uint8_t i = 0; i < 3; i++) {
        run(LIMIT_MS * 1000ul - 1);
        TEST_ASSERT_FALSE(failsafe.link_lost);
        failsafe_heard(&failsafe);
    }
    run(LIMIT_MS * 1000ul - 1);
    TEST_ASSERT_FALSE(failsafe.link_lost);
    run(1);
    TEST_ASSERT_TRUE(failsafe.link_lost);
}

void test_loss_stays_until_clear_when_host_returns(void)
{
    lose_link(FAILSAFE_INHIBIT);
    failsafe_heard(&failsafe);
    run(10);
    TEST_ASSERT_TRUE(failsafe.link_lost);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, goal(2));
    TEST_ASSERT_TRUE(failsafe_clear(&failsafe));
    TEST_ASSERT_FALSE(failsafe.link_lost);
    TEST_ASSERT_EQUAL(CDS_OK, goal(2));
    run(1000);
    TEST_ASSERT_EQUAL(CDS_OK, goal(3)); // who is met now is held no more than the others
}

void test_a_host_that_falls_silent_again_is_lost_only_once(void)
{
    uint8_t packets;

    lose_link(FAILSAFE_TORQUE_OFF);
    run(3000);
    packets = wire.count;
    failsafe_heard(&failsafe);
    run(2 * LIMIT_MS * 1000ul);
    TEST_ASSERT_EQUAL_UINT8(packets, wire.count);
}

void test_after_a_clear_the_watch_begins_anew(void)
{
    lose_link(FAILSAFE_INHIBIT);
    failsafe_heard(&failsafe); // it is the host who clears
    failsafe_clear(&failsafe);
    run(LIMIT_MS * 1000ul - 1);
    TEST_ASSERT_FALSE(failsafe.link_lost);
    run(1);
    TEST_ASSERT_TRUE(failsafe.link_lost);
}

void test_loss_shown_only_inhibits_and_sends_nothing(void)
{
    meet(1);
    lose_link(FAILSAFE_SHOW);
    TEST_ASSERT_EQUAL_UINT8(1, wire.count); // the PING
    TEST_ASSERT_EQUAL(CDS_OK, goal(1));
}

void test_inhibit_on_loss_refuses_goals_of_all_ids(void)
{
    meet(1);
    lose_link(FAILSAFE_INHIBIT);
    TEST_ASSERT_EQUAL_UINT8(1, wire.count);
    TEST_ASSERT_EQUAL(1, wire.servo[0].torque);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, goal(1));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, goal(3));
    cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 2);
    cds_sync_write_add(&request, 2, (const uint8_t[]){0, 2});
    TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_sync_write_send(&bus, &request));
    run(1000);
    TEST_ASSERT_EQUAL_UINT8(1, wire.count);
}

void test_torque_off_on_loss_is_sent_three_times_and_read(void)
{
    meet(1);
    meet(2);
    lose_link(FAILSAFE_TORQUE_OFF);
    TEST_ASSERT_TRUE(robot_is_stopping(&robot));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, goal(2));
    run(3000);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, robot.stop.steps.result);
    TEST_ASSERT_EQUAL_UINT8(2 + CDS_TORQUE_OFF_BROADCASTS + CDS_TORQUE_OFF_CLEARS + 2, wire.count);
    for (uint8_t i = 2; i < 5; i++) {
        TEST_ASSERT_EQUAL_HEX8(CDS_BROADCAST_ID, wire.log[i].id);
        TEST_ASSERT_EQUAL_HEX8(CDS_REG_TORQUE_ENABLE, wire.log[i].address);
        TEST_ASSERT_EQUAL_HEX8(0, wire.log[i].data);
    }
    for (uint8_t i = 0; i < TORQUE_SERVOS; i++)
        TEST_ASSERT_EQUAL_UINT8(0, wire.servo[i].torque);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, goal(2));
}

void test_nothing_is_cleared_while_torque_off_is_under_way(void)
{
    meet(1);
    lose_link(FAILSAFE_TORQUE_OFF);
    TEST_ASSERT_FALSE(failsafe_clear(&failsafe));
    TEST_ASSERT_TRUE(failsafe.link_lost);
    run(3000);
    TEST_ASSERT_TRUE(failsafe_clear(&failsafe));
    TEST_ASSERT_EQUAL(CDS_OK, goal(1));
}

void test_clear_keeps_inhibit_of_other_reasons(void)
{
    meet(1);
    meet(2);
    lose_link(FAILSAFE_INHIBIT);
    cds_servos_inhibit(&robot.servos, cds_servos_find(&robot.servos, 1), CDS_INHIBIT_STATE_LOST);
    failsafe_clear(&failsafe);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, goal(1));
    TEST_ASSERT_EQUAL(CDS_OK, goal(2));
}

/* The servo is READ again first: the replies may have been lost in noise. */
void test_lost_state_of_a_servo_that_answers_ping_is_told_late(void)
{
    struct cds_servo_state *servo;

    settings.link_loss_ms = 0;
    settings.alarm_report = 1;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_add(&robot.servos, 1));
    servo = &robot.states[0];
    servo->presence = CDS_PRESENCE_ONLINE;
    servo->status_return_level = 0;
    servo->misses = 0;
    servo->inhibits = CDS_INHIBIT_STATE_LOST;
    failsafe_poll(&failsafe);
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
    servo->misses = 1;
    failsafe_poll(&failsafe);
    TEST_ASSERT_EQUAL_HEX8(FAILSAFE_TORQUE_LOST, failsafe.alarm);
}

void test_torque_off_waits_until_low_line_is_free(void)
{
    meet(1);
    port_fake.low = true;
    lose_link(FAILSAFE_TORQUE_OFF);
    for (uint16_t i = 0; i < 3000; i++) { // more than CDS_TORQUE_OFF_LINE_WAIT
        port_fake.now_us += 3000;
        run(1);
    }
    TEST_ASSERT_EQUAL_UINT8(1, wire.servo[0].torque);
    port_fake.low = false;
    run(10000);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, robot.stop.steps.result);
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[0].torque);
}

/* ---- servos join ---- */

void test_servo_joins_by_reply_not_by_request(void)
{
    wire.servo[1].dead = true;
    meet(1);
    meet(2);
    TEST_ASSERT_NOT_NULL(known(1));
    TEST_ASSERT_NULL(known(2));
    TEST_ASSERT_EQUAL_UINT8(1, robot.servos.count);
    meet(1);
    TEST_ASSERT_EQUAL_UINT8(1, robot.servos.count);
}

void test_servo_joins_when_written_to(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, goal(77));
    run(3000);
    TEST_ASSERT_NOT_NULL(known(77));
    cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 2);
    cds_sync_write_add(&request, 5, (const uint8_t[]){0, 2});
    cds_sync_write_add(&request, 6, (const uint8_t[]){0, 2});
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    run(1000);
    TEST_ASSERT_NOT_NULL(known(5));
    TEST_ASSERT_NOT_NULL(known(6));
    TEST_ASSERT_EQUAL_UINT8(3, robot.servos.count);
    TEST_ASSERT_EQUAL_UINT16(CDS_VALUE_MAX, known(6)->highest);
    run(1000);
}

void test_servo_without_room_sets_is_full(void)
{
    for (uint8_t id = 10; id < 10 + ROBOT_SERVOS; id++)
        says(id, 0);
    TEST_ASSERT_FALSE(robot.servos.is_full);
    says(10, 0);
    TEST_ASSERT_FALSE(robot.servos.is_full);
    says(99, CDS_ERROR_OVERLOAD);
    TEST_ASSERT_TRUE(robot.servos.is_full);
    TEST_ASSERT_EQUAL_UINT8(ROBOT_SERVOS, robot.servos.count);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_OVERLOAD, robot.servos.alarms);
}

void test_mute_servo_that_replies_is_awaited_again(void)
{
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servo_write_byte(&bus, &request, 1, CDS_REG_STATUS_RETURN_LEVEL, 0));
    run(1000);
    TEST_ASSERT_EQUAL_UINT8(0, known(1)->status_return_level);
    goal(1);
    TEST_ASSERT_TRUE(request.is_muted);
    run(1000); // it answers all the same
    TEST_ASSERT_EQUAL_UINT8(CDS_LEVEL_UNKNOWN, known(1)->status_return_level);
    goal(1);
    TEST_ASSERT_FALSE(request.is_muted);
    run(1000);
}

/* ---- alarms ---- */

void test_each_alarm_is_latched_and_reported_until_clear(void)
{
    settings.alarm_report = 1;
    for (uint8_t bit = 1; bit < 0x80; bit = (uint8_t)(bit << 1)) {
        for (uint8_t again = 0; again < 2; again++) {
            says(3, bit);
            TEST_ASSERT_EQUAL_HEX8(bit, failsafe.alarm);
            TEST_ASSERT_EQUAL_UINT8(3, failsafe.alarm_id);
            failsafe.alarm = 0;
            says(3, bit);
            says(3, 0);
            run(10);
            TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
            TEST_ASSERT_EQUAL_HEX8(bit, known(3)->alarms);
            failsafe_clear(&failsafe);
            TEST_ASSERT_EQUAL_HEX8(0, known(3)->alarms);
            TEST_ASSERT_EQUAL_HEX8(0, robot.servos.alarms);
            run(10);
        }
    }
}

void test_further_alarm_is_reported_alone(void)
{
    settings.alarm_report = 1;
    says(3, CDS_ERROR_VOLTAGE);
    failsafe.alarm = 0;
    says(3, CDS_ERROR_OVERLOAD | CDS_ERROR_VOLTAGE);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_OVERLOAD, failsafe.alarm);
}

void test_alarms_of_several_servos_wait_for_one_another(void)
{
    settings.alarm_report = 1;
    says(1, CDS_ERROR_OVERLOAD);
    says(2, CDS_ERROR_VOLTAGE);
    run(10);
    TEST_ASSERT_EQUAL_UINT8(1, failsafe.alarm_id);
    failsafe.alarm = 0;
    run(10);
    TEST_ASSERT_EQUAL_UINT8(2, failsafe.alarm_id);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_VOLTAGE, failsafe.alarm);
}

/* Servos at the new rate have not heard the stop. */
void test_stop_without_known_servos_begins_again_at_new_rate(void)
{
    uint8_t packets;

    settings.link_loss_ms = 0;
    robot_stop(&robot);
    run(3000);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    packets = wire.count;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, 3));
    run(1);
    TEST_ASSERT_TRUE(robot_is_stopping(&robot));
    run(3000);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    TEST_ASSERT_EQUAL_UINT8(2 * packets, wire.count);
    settings.bus_baud = CDS_BAUD_1M; // by `settings` or a packet
    TEST_ASSERT_TRUE(failsafe_apply_settings(&failsafe));
    TEST_ASSERT_TRUE(robot_is_stopping(&robot));
}

void test_stop_that_is_released_does_not_begin_again_at_new_rate(void)
{
    settings.link_loss_ms = 0;
    robot_stop(&robot);
    run(3000);
    TEST_ASSERT_TRUE(robot_release(&robot));
    cds_bus_set_baud(&bus, 3);
    run(10);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
}

/* A servo of the list would be told as silent, at a rate that is not its own. */
void test_stop_of_known_servos_does_not_begin_again_at_new_rate(void)
{
    settings.link_loss_ms = 0;
    robot_add(&robot, 1);
    robot_stop(&robot);
    run(3000);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    TEST_ASSERT_EQUAL(CDS_TORQUE_OFF_OFF, known(1)->torque_off);
    cds_bus_set_baud(&bus, 3);
    run(10);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
}

void test_alarms_are_latched_without_report_by_default(void)
{
    says(3, CDS_ERROR_OVERLOAD);
    run(10);
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_OVERLOAD, known(3)->alarms);
}

/* Servo 3 has answered, and now misses three transactions in a row. */
static void lose_servo_3(void)
{
    says(3, 0);
    robot_add(&robot, 3);
    for (uint8_t misses = CDS_SERVOS_MISSES; misses; misses--) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 3));
        run(3000);
    }
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, known(3)->presence);
}

void test_offline_servo_is_reported_once_to_a_host_that_types(void)
{
    failsafe.host_types = true;
    wire.servo[2].dead = true;
    lose_servo_3();
    TEST_ASSERT_EQUAL_HEX8(FAILSAFE_OFFLINE, failsafe.alarm);
    TEST_ASSERT_EQUAL_UINT8(3, failsafe.alarm_id);
    failsafe.alarm = 0;
    run(10);
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
}

void test_offline_servo_is_not_reported_to_a_host_of_packets(void)
{
    wire.servo[2].dead = true;
    lose_servo_3();
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
}

void test_offline_servo_is_not_reported_in_mode_program(void)
{
    failsafe.host_types = true;
    settings.echo = 0;
    wire.servo[2].dead = true;
    lose_servo_3();
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
}

/* ---- torque that goes off by itself ---- */

/* The torque of servo 3 is read, as the state check does. */
static void read_torque(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 3, CDS_REG_TORQUE_ENABLE, 1));
    run(5000); // the state check may be before it
}

/* Servo 3 has torque, then the servo restarts. */
static void restart_servo_3(void)
{
    wire.servo[2].torque = 1;
    read_torque();
    wire.servo[2].torque = 0;
    read_torque();
}

/* Asserts that the loss of torque of servo 3 is reported, as if it were printed, and only once. */
static void assert_loss_reported(void)
{
    TEST_ASSERT_EQUAL_HEX8(FAILSAFE_TORQUE_LOST, failsafe.alarm);
    TEST_ASSERT_BITS_LOW(FAILSAFE_OFFLINE, failsafe.reported[failsafe.next]);
    TEST_ASSERT_EQUAL_UINT8(3, failsafe.alarm_id);
    failsafe.alarm = 0;
    read_torque();
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
}

void test_lost_torque_is_reported_once_each_time(void)
{
    settings.alarm_report = 1;
    restart_servo_3();
    assert_loss_reported();
    failsafe_clear(&failsafe);
    read_torque();
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm); // still inhibited, but no new loss
    robot_release(&robot);
    restart_servo_3();
    assert_loss_reported();
}

void test_lost_torque_is_reported_after_the_alarms(void)
{
    settings.alarm_report = 1;
    restart_servo_3();
    failsafe.alarm = 0;
    robot_release(&robot);
    says(3, CDS_ERROR_OVERLOAD);
    restart_servo_3();
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_OVERLOAD, failsafe.alarm);
    failsafe.alarm = 0;
    run(10);
    assert_loss_reported();
}

void test_lost_torque_is_reported_when_the_servo_is_back(void)
{
    settings.alarm_report = 1;
    wire.servo[2].torque = 1;
    read_torque();
    wire.servo[2].dead = true;
    lose_servo_3();
    TEST_ASSERT_EQUAL_HEX8(FAILSAFE_OFFLINE, failsafe.alarm);
    TEST_ASSERT_BITS_HIGH(FAILSAFE_OFFLINE, failsafe.reported[failsafe.next]);
    failsafe.alarm = 0;
    wire.servo[2].dead = false;
    wire.servo[2].torque = 0;
    read_torque();
    assert_loss_reported();
    wire.servo[2].dead = true;
    lose_servo_3();
    TEST_ASSERT_EQUAL_HEX8(FAILSAFE_OFFLINE, failsafe.alarm);
}

void test_torque_that_is_switched_off_is_not_reported(void)
{
    settings.alarm_report = 1;
    wire.servo[2].torque = 1;
    read_torque();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &request, 3, CDS_REG_TORQUE_ENABLE, 0));
    run(1000);
    read_torque();
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
    wire.servo[2].torque = 1;
    read_torque();
    robot_stop(&robot);
    run(5000);
    read_torque();
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
}
