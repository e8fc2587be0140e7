/* SPDX-License-Identifier: MIT */
/* The commands of the group "The controller", and the alarms that the console reports by itself. */
#include <stdio.h>
#include <string.h>

#include "console/console.h"
#include "eeprom_fake.h"
#include "ring_input.h"
#include "port_fake.h"
#include "unity.h"

static struct cds_bus bus;
static struct cds_ring input, output;
static struct console console;
static struct failsafe failsafe;
static struct robot robot;
static struct settings settings;
static struct settings_store store;
static char said[500];

static uint16_t damaged_stops;

void setUp(void)
{
    port_fake_reset();
    eeprom_fake_reset();
    eeprom_fake.has_more = true; // poses and sequences
    memset(&bus, 0, sizeof bus);
    memset(&console, 0, sizeof console);
    memset(&input, 0, sizeof input);
    memset(&output, 0, sizeof output);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    memset(&robot, 0, sizeof robot);
    robot_begin(&robot, &bus, 0);
    settings_load(&store, &settings);
    settings.echo = SETTINGS_ECHO_OFF; // replies alone, as programs read them
    failsafe = (struct failsafe){.settings = &settings,
                                 .store = &store,
                                 .robot = &robot,
                                 .damaged_stops = &damaged_stops,
                                 .room_bytes = 2000,
                                 .spare_bytes = 1234};
    failsafe_begin(&failsafe, FAILSAFE_RESET_POWER | FAILSAFE_RESET_BROWN_OUT);
    console_open(&console, &failsafe, &input, &output);
    robot.moves = command_set.moves;
    command_set.store->load(command_set.store->motions, &store);
    command_set.store->begin(&failsafe, command_set.store->motions);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
    TEST_ASSERT_EQUAL_UINT16(0, eeprom_fake.breaches);
}

static void turn(void)
{
    failsafe_poll(&failsafe);
    settings_save_poll(&store);
    failsafe.counts_stack = false; // as main does when it has counted
    cds_bus_poll(&bus);
    robot_poll(&robot);
    console_poll(&console);
    while (cds_ring_count(&output)) {
        size_t length = strlen(said);

        TEST_ASSERT_TRUE(length < sizeof said - 1);
        said[length] = (char)ring_peek(&output, 0);
        said[length + 1] = '\0';
        ring_drop(&output, 1);
    }
}

static void turns(uint16_t count)
{
    while (count--)
        turn();
}

/* What is said to a line. */
static const char *reply_to(const char *line)
{
    said[0] = '\0';
    for (; *line; line++)
        cds_ring_put(&input, (uint8_t)*line);
    cds_ring_put(&input, '\r');
    turns(120);
    for (uint16_t left = 400; left && console.state == CONSOLE_ENDING; left--)
        turn();
    return said;
}

static void assert_error(const char *number, const char *line)
{
    char start[16];

    sprintf(start, "error %s: ", number);
    reply_to(line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(start, said, strlen(start), line);
    turns(80); // a hint may follow
}

static void says(uint8_t id, uint8_t error)
{
    port_fake_answer(&bus.link, id, error, NULL, 0);
    turns(4);
}

/* Words and bytes of its struct, each under its name. */
void test_counters_of_servo_prints_each_counter(void)
{
    robot_add(&robot, 7);
    robot.states[0].counters = (struct cds_servo_counters){.ok = 1001,
                                                           .timeouts = 65535,
                                                           .corrupt = 1003,
                                                           .stale_replies = 104,
                                                           .duplicate_replies = 255,
                                                           .unexpected_packets = 106,
                                                           .echo_errors = 107};
    TEST_ASSERT_EQUAL_STRING(
        "since servo 7 joined the robot\r\nok 1001\r\ntimeouts 65535\r\ncorrupt 1003\r\nstale "
        "replies 104\r\n"
        "duplicate replies 255\r\nunexpected packets 106\r\necho errors 107\r\nok\r\n",
        reply_to("counters 7"));
}

void test_settings_prints_values_units_and_origin(void)
{
    reply_to("settings");
    TEST_ASSERT_EQUAL_STRING_LEN(
        "device_id = 253 ID\r\nhost_baud = 255 register, 115200bps, the board's own\r\n", said, 74);
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nbus_baud = 1 register, 1000000bps\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nrepeats = 0\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\ncycle_us = 4000 us\r\nsettings at start: defaults: "
                                      "nothing saved\r\nok\r\n"));
}

void test_a_setting_is_shown_changed_and_brought_back(void)
{
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("settings cycle_us 5000"));
    TEST_ASSERT_EQUAL_UINT16(5000, settings.cycle_us);
    TEST_ASSERT_EQUAL_STRING("cycle_us = 5000 us\r\nok\r\n", reply_to("settings cycle_us"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n\r> ", reply_to("defaults")); // mode person again
    TEST_ASSERT_EQUAL_UINT16(4000, settings.cycle_us);
}

void test_errors_of_settings_change_nothing(void)
{
    assert_error("60", "settings cycle 1");
    assert_error("60", "settings a_name_that_is_much_longer_than_any 1");
    assert_error("33", "settings repeats 3");
    assert_error("33", "settings repeats 65536");
    assert_error("32", "settings repeats one");
    assert_error("31", "settings repeats 1 1");
    TEST_ASSERT_EQUAL_UINT8(0, settings.repeats);
}

void test_save_replies_when_record_is_written(void)
{
    eeprom_fake.slow = 10;
    TEST_ASSERT_EQUAL_STRING("", reply_to("save"));
    turns(400);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_SAVED, store.result);
    TEST_ASSERT_NOT_NULL(strstr(reply_to("settings"),
                                "\r\nsaved settings: the next start has those of the last "
                                "'save'\r\nok"));
}

void test_a_save_that_fails_is_an_error(void)
{
    eeprom_fake.dead = SETTINGS_PLACE + 3;
    assert_error("62", "save");
}

void test_a_save_during_another_ones_is_an_error(void)
{
    eeprom_fake.slow = 100;
    settings_save(&store, &settings); // the virtual device's
    assert_error("63", "save");
}

void test_alarms_are_listed_by_servo_and_kind(void)
{
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("alarms"));
    for (uint8_t id = 100; id < 100 + ROBOT_SERVOS - 2; id++)
        cds_servos_add(&robot.servos, id);
    says(7, 0x24);
    says(3, 0);
    says(9, 0x41);
    says(77, 0x41); // no room: only what nobody else has is known
    says(78, 0x08);
    TEST_ASSERT_EQUAL_STRING("alarm of servo 7: overheating\r\nalarm of servo 7: overload\r\n"
                             "alarm of servo 9: input voltage\r\nalarm of servo 9: instruction\r\n"
                             "alarm of others: range\r\nok\r\n",
                             reply_to("alarms"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("clear"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("alarms"));
}

void test_clear_while_torque_off_is_under_way_is_an_error(void)
{
    says(7, 0x20);
    robot_stop(&robot);
    assert_error("64", "clear");
    TEST_ASSERT_EQUAL_HEX8(0x20, robot.servos.alarms);
}

void test_alarm_report_prints_lines_between_replies(void)
{
    settings.alarm_report = 1;
    said[0] = '\0';
    says(7, 0x24);
    turns(44);
    TEST_ASSERT_EQUAL_STRING(
        "alarm of servo 7: overheating; 'torque ID off', unload it; when cool, 'clear'\r\n"
        "alarm of servo 7: overload; 'torque ID off', unload it; when cool, 'clear'\r\n",
        said);
    eeprom_fake.slow = 3;
    reply_to("save");
    says(8, 0x01);
    turns(400);
    TEST_ASSERT_EQUAL_STRING(
        "ok\r\nalarm of servo 8: input voltage; compare PRESENT_VOLTAGE, MIN_VOLTAGE, "
        "MAX_VOLTAGE; mend supply or limits, then 'clear'\r\n",
        said);
}

void test_status_tells_all_there_is(void)
{
    cds_servos_add(&robot.servos, 7);
    says(7, 0);
    TEST_ASSERT_EQUAL_STRING("reset by power brown-out\r\n"
                             "settings at start: defaults: nothing saved\r\n"
                             "host link: not watched\r\ndriving: allowed\r\n"
                             "last stop: none\r\nCtrl-X in damaged packets: 0\r\n"
                             "bus busy: noise or others, at 1000000bps\r\nservos: 1, offline 0 "
                             "before the line was disturbed\r\n"
                             "RETURN_DELAY refused: 0; lowest 0 (0us)\r\n"
                             "poses: 0, room for 20; sequences: 0, room for 8\r\n"
                             "EEPROM: 0 saves of motion data, 0 records are damaged\r\n"
                             "stack: 1234 of 2000 bytes unused\r\nok\r\n",
                             reply_to("status"));
}

void test_status_counts_inhibited_servos_if_others_are_not(void)
{
    cds_servos_add(&robot.servos, 7);
    cds_servos_add(&robot.servos, 8);
    robot.states[1].inhibits = CDS_INHIBIT_STATE_LOST;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("status"), "driving: allowed; inhibited: 1\r\n"));
}

void test_status_prints_link_inhibit_and_last_stop(void)
{
    settings.link_loss_ms = 1;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("status"), "host link: watched\r\n"));
    failsafe.link_lost = true;
    robot_inhibit(&robot);
    for (uint8_t id = 10; id <= 10 + ROBOT_SERVOS; id++)
        says(id, 0);
    damaged_stops = 7;
    reply_to("status");
    damaged_stops = 0;
    TEST_ASSERT_NOT_NULL(strstr(said, "driving: inhibited until 'clear'\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "Ctrl-X in damaged packets: 7\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "host link: lost\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "servos: 18 and more, offline 0 "));
    robot.stop.servos = &robot.servos;
    robot.stop.steps.result = CDS_TIMEOUT;
    for (uint8_t i = 0; i < 17; i++)
        robot.states[i].torque_off = CDS_TORQUE_OFF_OFF;
    robot.states[17].torque_off = CDS_TORQUE_OFF_SILENT;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("status"), "last stop: 17 of 18 servos read back as off; "
                                                    "IDs not checked: 236\r\n"));
    robot.unlisted = 0; // a whole scan found no more
    robot.servos.is_full = false;
    TEST_ASSERT_NOT_NULL(
        strstr(reply_to("status"), "last stop: 17 of 18 servos read back as off\r\n"));
    robot.stop.steps.result = CDS_REFUSED;
    TEST_ASSERT_NOT_NULL(
        strstr(reply_to("status"), "last stop: 17 of 18 servos read back as off, some are on\r\n"));
}
