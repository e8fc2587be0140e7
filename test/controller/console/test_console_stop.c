/* SPDX-License-Identifier: MIT */
/* The replies to `stop`, Ctrl-X and `servos forget`, and to `teach off` after a stop. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* Waits until the packets of the stop are sent. */
static const char *stop_reply(const char *keys)
{
    said_length = 0;
    said[0] = '\0';
    type(keys);
    for (uint8_t i = 0; i < 40 && !strstr(said, "ok\r\n"); i++) {
        if (bus.link.state == CDS_LINK_TALKING)
            port_fake_transmit(&bus.link, 0);
        port_fake.now_us += 100000;
        type("");
    }
    return said;
}

void test_stop_without_servos_tells_that_none_was_read(void)
{
    static const char line[] =
        "torque off was sent to all IDs at this rate; no servo is known, torque may be on: 'scan', "
        "or 'scan all', then 'bus RATE'; driving inhibited until 'release'\r\nok\r\n";

    settings.echo = SETTINGS_ECHO_PERSON;
    TEST_ASSERT_NOT_NULL(strstr(stop_reply("stop\r"), line));
    TEST_ASSERT_NOT_NULL(strstr(stop_reply("\x18"), line));
    TEST_ASSERT_NULL(strstr(said, "robot stopped"));
}

/* The reply to `release` after a stop. */
static const char *release_reply(void)
{
    robot.stop_begun = true;
    return reply_to("release");
}

void test_release_counts_servos_that_have_not_confirmed_the_stop(void)
{
    static const char told[] = "servos that have not confirmed 'stop': 1, the first: 8; "
                               "see 'servos'\r\nok\r\n";

    settings.echo = SETTINGS_ECHO_PERSON;
    cds_servos_add(&robot.servos, 7);
    cds_servos_add(&robot.servos, 8);
    stop_reply("stop\r");
    robot.states[0].torque_off = CDS_TORQUE_OFF_OFF;
    robot.states[1].torque_off = CDS_TORQUE_OFF_SILENT;
    robot.states[1].presence = CDS_PRESENCE_OFFLINE;
    TEST_ASSERT_NOT_NULL(strstr(release_reply(), told));
    TEST_ASSERT_NULL(strstr(reply_to("release"), "confirmed")); // there is no stop any more
    robot.states[1].presence =
        CDS_PRESENCE_ONLINE; // it may not have heard the stop, at another rate
    TEST_ASSERT_NOT_NULL(strstr(release_reply(), told));
    robot.states[1].torque_off = CDS_TORQUE_OFF_UNKNOWN; // it has joined since
    TEST_ASSERT_NULL(strstr(release_reply(), "confirmed"));
    robot.states[1].torque_off = CDS_TORQUE_OFF_SILENT;
    settings.echo = SETTINGS_ECHO_ON;
    TEST_ASSERT_NULL(strstr(release_reply(), "confirmed"));
}

void test_stop_while_the_link_is_lost_names_clear(void)
{
    settings.echo = SETTINGS_ECHO_PERSON;
    failsafe.link_lost = true;
    console.faults_told = FAULT_LINK_LOST;
    robot_inhibit(&robot);
    TEST_ASSERT_NOT_NULL(
        strstr(stop_reply("stop\r"), "'bus RATE'; driving inhibited until 'clear'\r\nok\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(reply_to("release"), "\r\nerror 65: "));
    TEST_ASSERT_NOT_NULL(strstr(reply_to("clear"), "\r\nok\r\n"));
    TEST_ASSERT_FALSE(robot_is_inhibited(&robot));
}

void test_stop_answers_a_program_with_ok(void)
{
    TEST_ASSERT_NULL(strstr(stop_reply("stop\r"), "torque off"));
    TEST_ASSERT_NOT_NULL(strstr(said, "ok\r\n"));
    TEST_ASSERT_NULL(strstr(stop_reply("\x18"), "torque off"));
}

void test_teach_off_after_a_stop_names_the_stop_only(void)
{
    stop_reply("stop\r");
    assert_error(54, "teach off 1 2 3");
    TEST_ASSERT_EQUAL_PTR(strchr(said, '\n'), strrchr(said, '\n')); // no line for each servo
    stop_reply("stop\r");
    assert_error(54, "teach off 1");
}

void test_alarm_of_forgotten_servo_is_not_reported(void)
{
    type("servos for"); // while text stands there, the alarm waits
    failsafe.alarm = FAILSAFE_OFFLINE;
    failsafe.alarm_id = 6;
    TEST_ASSERT_NULL(strstr(reply_to("get"), "alarm"));
}

/* A line that is held high looks as one at rest. */
void test_bus_names_the_line_if_no_servo_answers(void)
{
    static const char told[] = "no servo answers at 1000000bps: check their supply, the cable, "
                               "and the data line, which may be held high\r\n";

    settings.echo = SETTINGS_ECHO_PERSON;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("bus"), "bus ok at 1000000bps\r\n"));
    cds_servos_add(&robot.servos, 7);
    cds_servos_add(&robot.servos, 8);
    robot.states[0].presence = CDS_PRESENCE_OFFLINE;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("bus"), "bus ok at 1000000bps\r\n"));
    robot.states[1].presence = CDS_PRESENCE_OFFLINE;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("bus"), told));
    TEST_ASSERT_NOT_NULL(strstr(reply_to("bus 500000"), "bus ok at 500000bps\r\n"));
    settings.bus_baud = bus.baud_reg;
    settings.echo = SETTINGS_ECHO_ON; // for a program: the line that it knows
    TEST_ASSERT_NOT_NULL(strstr(reply_to("bus"), "bus ok at 500000bps\r\n"));
}
