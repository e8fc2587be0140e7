/* SPDX-License-Identifier: MIT */
/* The commands of the group "The controller" but for settings, and the alarms that the console
 * reports by itself. */
#include "saving_rig.h"

void setUp(void)
{
    begin_controller();
}

void tearDown(void)
{
    end_controller();
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

#define UNLOAD "; 'torque 7 off', unload it; when cool, 'clear', 'release 7'\r\n"

void test_alarm_report_prints_lines_between_replies(void)
{
    settings.alarm_report = 1;
    said[0] = '\0';
    says(7, 0x24);
    turns(90);
    TEST_ASSERT_EQUAL_STRING(
        "alarm of servo 7: overheating" UNLOAD "alarm of servo 7: overload" UNLOAD, said);
    eeprom_fake.slow = 3;
    reply_to("save");
    says(8, 0x01);
    turns(400);
    TEST_ASSERT_EQUAL_STRING(
        "ok\r\nalarm of servo 8: input voltage; too low or too high: 'diagnose 8' "
        "tells which, and the volts; mend supply or limits, then 'clear'\r\n",
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
                             "bus busy: noise or others, at 1000000bps\r\nservos: 1, offline 0, "
                             "as last known\r\n"
                             "RETURN_DELAY refused: 0; lowest 0 (0us)\r\n"
                             "poses: 0, room for 20; sequences: 0, room for 8\r\n"
                             "EEPROM: 0 saves of motion data, 0 records are damaged\r\n"
                             "stack: 1234 of 2000 bytes unused\r\nok\r\n",
                             reply_to("status"));
}

/* A stop sets stop_begun: driving is inhibited, and no servo of the stop is left. */
void test_status_after_a_stop_and_forget_tells_the_stop(void)
{
    static const char told[] = "last stop: sent; its servos are no longer in the list\r\n";

    TEST_ASSERT_NOT_NULL(strstr(reply_to("status"), "last stop: none\r\n"));
    cds_servos_add(&robot.servos, 7);
    robot.states[0].torque_off = CDS_TORQUE_OFF_OFF;
    robot.stop_begun = true;
    robot.stop.servos = &robot.servos;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("status"), "last stop: 1 of 1 servos"));
    TEST_ASSERT_NOT_NULL(strstr(reply_to("servos forget"), "the list is empty"));
    TEST_ASSERT_NOT_NULL(strstr(reply_to("status"), told));
    robot.stop_begun = false; // as `release` does
    TEST_ASSERT_NOT_NULL(strstr(reply_to("status"), "last stop: none\r\n"));
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
    TEST_ASSERT_NOT_NULL(strstr(said, "servos: 18 and more, offline 0"));
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
