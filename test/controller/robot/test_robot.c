/* SPDX-License-Identifier: MIT */
/* The robot's servos: which servos join, are read, are inhibited. */
#include "robot/robot.h"

#include <stddef.h>
#include <string.h>

#include "cds55xx/servo.h"
#include "torque_fake.h"
#include "unity.h"

static struct cds_bus bus;
static struct robot robot;
static uint8_t buffer[64], reply[CDS_REPLY_MAX];
static struct cds_request request;

void setUp(void)
{
    port_fake_reset();
    port_fake.now_us = UINT32_MAX - 1000; // the clock wraps in every test
    memset(&wire, 0, sizeof wire);
    memset(&bus, 0, sizeof bus);
    memset(&robot, 0, sizeof robot);
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    robot_begin(&robot, &bus, 0);
    robot.servos.grows = CDS_GROWS_ALWAYS;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

#define STEP_US 50 // of time without a byte on the line

/* The main loop for so long. */
static void run(uint32_t us)
{
    uint32_t begin_us = port_fake.now_us;

    while (port_fake.now_us - begin_us < us) {
        torque_wire(&bus);
        cds_bus_poll(&bus);
        robot_poll(&robot);
        if (!bus.request && !wire.answering)
            port_fake.now_us += STEP_US;
    }
}

static void wait_ms(uint16_t ms)
{
    run(1000ul * ms);
}

static void meet(uint8_t id)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, id));
    run(2000);
}

static enum cds_result torque_on(uint8_t id)
{
    enum cds_result result = cds_servo_write_byte(&bus, &request, id, CDS_REG_TORQUE_ENABLE, 1);

    run(2000);
    return result;
}

static enum cds_result scan_begin(struct robot *of, const void *config)
{
    return cds_scan_begin(&of->work.scan.scan, config);
}

static enum cds_result scan_poll(struct robot *of)
{
    return cds_scan_poll(&of->work.scan.scan);
}

static void scan_abort(struct robot *of)
{
    cds_scan_abort(&of->work.scan.scan);
}

static const CDS_FLASH struct robot_operation scan = {
    .begin = scan_begin, .poll = scan_poll, .abort = scan_abort, .changes_rate = true};

/* At the rate *baud_reg, or at the listed ones if it is NULL. */
static void begin_scan(const uint8_t *baud_reg)
{
    struct cds_scan_config config = {.bus = &bus,
                                     .request = &request,
                                     .found = robot.work.scan.found,
                                     .found_capacity = ROBOT_SERVOS,
                                     .last_id = CDS_ID_MAX,
                                     .baud_regs = baud_reg,
                                     .baud_count = baud_reg ? 1 : 0};

    TEST_ASSERT_EQUAL_UINT8(0, robot_start(&robot, &scan, &config));
}

static const struct cds_servo_state *known(uint8_t id)
{
    return cds_servos_find(&robot.servos, id);
}

void test_servo_that_only_replies_is_not_read(void)
{
    meet(1);
    TEST_ASSERT_NOT_NULL(known(1));
    wait_ms(1200);
    TEST_ASSERT_EQUAL_UINT8(1, wire.count); // the PING
}

void test_mute_servo_that_replies_is_read_again(void)
{
    robot.servos.grows = CDS_GROWS_ON_ALARM_OR_SETTING;
    TEST_ASSERT_TRUE(robot_add(&robot, 1));
    cds_servos_find(&robot.servos, 1)->status_return_level = 0;
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    run(100);
    TEST_ASSERT_EQUAL_UINT8(CDS_LEVEL_UNKNOWN, known(1)->status_return_level);
}

void test_servo_that_reports_mute_level_is_read_again(void)
{
    TEST_ASSERT_TRUE(robot_add(&robot, 1));
    cds_packet_read(&request.packet, 1, CDS_REG_STATUS_RETURN_LEVEL, 1); // 0, says the fake
    request.reply_parameters = 1;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
    run(2000);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL_UINT8(CDS_LEVEL_UNKNOWN, known(1)->status_return_level); // else no reply
}

void test_robot_not_open_joins_servo_by_alarm_only(void)
{
    robot.servos.grows = CDS_GROWS_ON_ALARM_OR_SETTING;
    meet(1);
    TEST_ASSERT_EQUAL(CDS_OK, torque_on(2));
    TEST_ASSERT_EQUAL_UINT8(0, robot.servos.count);
    port_fake_answer(&bus.link, 3, CDS_ERROR_OVERLOAD, NULL, 0);
    run(500);
    TEST_ASSERT_NOT_NULL(known(3));
    robot_inhibit(&robot); // no servo is driven, known or not
    TEST_ASSERT_EQUAL(CDS_INHIBITED, torque_on(2));
}

void test_named_servo_starts_check_of_all_servos(void)
{
    bool looked[TORQUE_SERVOS + 1] = {false};

    meet(1);
    TEST_ASSERT_TRUE(robot_add(&robot, 2));
    wait_ms(1200);
    for (uint8_t i = 1; i < wire.count; i++)
        looked[wire.log[i].id] = wire.log[i].address == CDS_REG_TORQUE_ENABLE;
    TEST_ASSERT_TRUE(looked[1] && looked[2]);
    TEST_ASSERT_TRUE(wire.count >= 3 && wire.count <= 4); // each once a second
}

void test_packet_of_pc_pauses_check_for_one_second(void)
{
    robot_add(&robot, 1);
    robot_add(&robot, 2);
    wire.servo[1].dead = true;
    wait_ms(3500); // 2 is away by now, and is looked for ten times a second
    TEST_ASSERT_EQUAL_UINT8(CDS_PRESENCE_OFFLINE, known(2)->presence);
    wire.count = 0;
    for (uint8_t i = 0; i < 4; i++) {
        robot_delay_health(&robot);
        wait_ms(500);
    }
    TEST_ASSERT_EQUAL_UINT8(0, wire.count);
    wait_ms(700);
    TEST_ASSERT_TRUE(wire.count > 0);
}

void test_returned_servo_is_checked_despite_pc(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, torque_on(1));
    wire.servo[0].dead = true;
    for (uint8_t i = 0; i < CDS_SERVOS_MISSES; i++)
        meet(1);
    TEST_ASSERT_EQUAL_UINT8(CDS_PRESENCE_OFFLINE, known(1)->presence);
    wire.servo[0].dead = false;
    wire.servo[0].torque = 0;
    robot_delay_health(&robot);
    meet(1); // as the PC might
    wait_ms(2);
    TEST_ASSERT_EQUAL_UINT8(CDS_PRESENCE_ONLINE, known(1)->presence);
    TEST_ASSERT_EQUAL_UINT8(CDS_INHIBIT_STATE_LOST, known(1)->inhibits);
}

void test_servo_joining_stopped_robot_is_inhibited(void)
{
    robot_stop(&robot);
    run(3000);
    meet(1);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, torque_on(1));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, torque_on(2)); // a servo without a reply so far
    TEST_ASSERT_TRUE(robot_allow(&robot));
    cds_servos_release_all(&robot.servos);
    TEST_ASSERT_EQUAL(CDS_OK, torque_on(1));
    TEST_ASSERT_EQUAL(CDS_OK, torque_on(3));
}

void test_sync_write_with_too_long_blocks_adds_no_servo(void)
{
    static const uint8_t sync[] = {0xFF, 0xFF, 0xFE, 4, CDS_SYNC_WRITE, 0x1E, 255, 0x5D};

    memcpy(buffer, sync, sizeof sync);
    request.packet.size = sizeof sync;
    request.reply_parameters = CDS_REPLY_NONE;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request)); // and it comes back
    TEST_ASSERT_EQUAL_UINT8(0, robot.servos.count);
}

void test_robot_after_forget_joins_and_inhibits_servos(void)
{
    robot_add(&robot, 1);
    robot_stop(&robot);
    run(5000);
    robot_forget(&robot);
    TEST_ASSERT_NULL(known(1));
    TEST_ASSERT_NULL(robot.stop.servos); // nothing is left of the stop
    TEST_ASSERT_EQUAL_UINT8(0, robot.servos.count);
    wire.count = 0;
    wait_ms(1200);
    TEST_ASSERT_EQUAL_UINT8(0, wire.count); // no servo is left to be read
    meet(2);
    TEST_ASSERT_NOT_NULL(known(2));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, torque_on(2));
}

void test_robot_forget_leaves_a_stop_its_servos(void)
{
    wire.servo[0].torque = 1;
    robot_add(&robot, 1);
    robot_stop(&robot);
    run(1);
    TEST_ASSERT_TRUE(robot_is_stopping(&robot));
    robot_forget(&robot);
    run(10000);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[0].torque);
}

void test_servo_joining_during_stop_is_read(void)
{
    wire.servo[0].torque = 1;
    meet(2);
    robot_stop(&robot);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1)); // behind the stop's own
    run(10000);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    TEST_ASSERT_NOT_NULL(known(1));
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, robot.stop.steps.result);
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[0].torque);
}

void test_stop_waits_until_scan_restores_rate(void)
{
    static const uint8_t elsewhere = 34;

    wire.servo[0].torque = 1;
    begin_scan(&elsewhere);
    run(3000);
    TEST_ASSERT_EQUAL_UINT8(elsewhere, bus.baud_reg);
    robot_stop(&robot);
    for (uint16_t i = 0; i < 20000 && robot_is_stopping(&robot); i++) {
        run(1);
        if (wire.talking && bus.request->priority == CDS_PRIORITY_TORQUE_OFF)
            TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud_reg);
    }
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud_reg);
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[0].torque);
}

/* ---- the inhibit and resets ---- */

void test_inhibit_survives_a_reset(void)
{
    struct reset_copy kept;

    memset(&kept, 0xA5, sizeof kept);
    robot_resume(&robot, &kept, true);
    TEST_ASSERT_FALSE(robot_is_inhibited(&robot)); // after power-on
    robot_stop(&robot);
    run(5000);
    for (uint8_t resets = 0; resets < 2; resets++) {
        setUp();
        robot_resume(&robot, &kept, false);
        TEST_ASSERT_TRUE(robot_is_inhibited(&robot));
        TEST_ASSERT_EQUAL(CDS_INHIBITED, torque_on(9));
        TEST_ASSERT_EQUAL_UINT8(0, wire.count);
    }
    TEST_ASSERT_TRUE(robot_release(&robot));
    setUp();
    robot_resume(&robot, &kept, false);
    TEST_ASSERT_FALSE(robot_is_inhibited(&robot));
    TEST_ASSERT_EQUAL(CDS_OK, torque_on(1));
}

void test_stop_that_a_reset_interrupts_begins_anew(void)
{
    struct reset_copy kept;

    robot_resume(&robot, &kept, true);
    robot_stop(&robot);
    robot_inhibit(&robot); // a lost link meanwhile
    setUp();
    wire.servo[0].torque = 1;
    robot_resume(&robot, &kept, false);
    run(5000);
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[0].torque);
    TEST_ASSERT_TRUE(robot_is_inhibited(&robot));
    setUp();
    robot_resume(&robot, &kept, false);
    run(5000);
    TEST_ASSERT_EQUAL_UINT8(0, wire.count); // it was finished
}

/* The line is held low until the stop gives up; then the host link is lost, then comes the reset.
 */
void test_stop_that_gave_up_is_kept_for_a_reset(void)
{
    struct reset_copy kept;

    robot_resume(&robot, &kept, true);
    port_fake.low = true;
    robot_stop(&robot);
    for (uint16_t i = 0; i < 3000 && robot_is_stopping(&robot); i++) {
        port_fake.now_us += 3000;
        cds_bus_poll(&bus);
        robot_poll(&robot);
    }
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, robot.stop.steps.result);
    robot_inhibit(&robot);
    TEST_ASSERT_EQUAL_HEX8(INHIBIT_STOPPING, reset_copy_state(&kept));
    TEST_ASSERT_TRUE(robot_allow(&robot));
    TEST_ASSERT_EQUAL_HEX8(INHIBIT_FREE, reset_copy_state(&kept));
}

void test_inhibit_of_a_damaged_copy_holds(void)
{
    struct reset_copy kept;

    for (uint8_t bit = 0; bit < 16; bit++) {
        kept_store(&kept.state, INHIBIT_FREE);
        kept_store(&kept.baud_reg, 3);
        TEST_ASSERT_EQUAL_HEX8(INHIBIT_FREE, reset_copy_state(&kept));
        TEST_ASSERT_TRUE(reset_copy_has_rate(&kept));
        if (bit < 8)
            kept.state.value = (uint8_t)(INHIBIT_FREE ^ 1u << bit);
        else
            kept.state.check = (uint8_t)(~INHIBIT_FREE ^ 1u << (bit - 8));
        TEST_ASSERT_EQUAL_HEX8(INHIBIT_ON, reset_copy_state(&kept));
        TEST_ASSERT_FALSE(reset_copy_has_rate(&kept));
    }
    memset(&kept, 0, sizeof kept);
    TEST_ASSERT_EQUAL_HEX8(INHIBIT_ON, reset_copy_state(&kept));
    memset(&kept, 0xFF, sizeof kept);
    TEST_ASSERT_EQUAL_HEX8(INHIBIT_ON, reset_copy_state(&kept));
}

void test_rate_of_a_damaged_copy_is_refused(void)
{
    struct reset_copy kept;

    for (uint8_t bit = 0; bit < 16; bit++) {
        kept_store(&kept.state, INHIBIT_FREE);
        kept_store(&kept.baud_reg, 3);
        if (bit < 8)
            kept.baud_reg.value = (uint8_t)(3u ^ 1u << bit);
        else
            kept.baud_reg.check = (uint8_t)(~3u ^ 1u << (bit - 8));
        TEST_ASSERT_FALSE(reset_copy_has_rate(&kept));
    }
}

void test_inhibit_holds_while_a_scan_runs(void)
{
    static uint8_t other_buffer[16];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(other_buffer);

    begin_scan(NULL);
    run(3000);
    robot_inhibit(&robot);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_write_byte(&bus, &other, 99, CDS_REG_TORQUE_ENABLE, 1));
    other.passes_lock = true;
    TEST_ASSERT_EQUAL(CDS_INHIBITED,
                      cds_servo_write_byte(&bus, &other, 99, CDS_REG_TORQUE_ENABLE, 1));
}

void test_strangers_are_all_ids_until_a_whole_scan(void)
{
    TEST_ASSERT_EQUAL_UINT8(254, robot_unlisted(&robot));
    robot_add(&robot, 1);
    TEST_ASSERT_EQUAL_UINT8(253, robot_unlisted(&robot));
    robot.unlisted = 2;
    TEST_ASSERT_EQUAL_UINT8(2, robot_unlisted(&robot));
    robot.unlisted = 0;
    TEST_ASSERT_EQUAL_UINT8(0, robot_unlisted(&robot));
    robot.servos.is_full = true;
    TEST_ASSERT_EQUAL_UINT8(1, robot_unlisted(&robot));
    robot_forget(&robot);
    TEST_ASSERT_EQUAL_UINT8(254, robot_unlisted(&robot));
}
