/* SPDX-License-Identifier: MIT */
/* What the console prints without a command: the banner, and lost torque; and `alarms`, which lists
 * the latter. */
#include "console_rig.h"
#include "robot/moves.h" // struct moves

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* The console reports `bit` of servo 7. */
static void report(uint8_t bit)
{
    said_length = 0;
    failsafe.alarm = bit;
    failsafe.alarm_id = 7;
    type("");
    TEST_ASSERT_EQUAL_HEX8(0, failsafe.alarm);
}

void test_lost_torque_is_told_with_its_remedy(void)
{
    cds_servos_add(&robot.servos, 7);
    failsafe.reported[0] = CDS_ERROR_OVERLOAD;
    report(FAILSAFE_TORQUE_LOST);
    TEST_ASSERT_NOT_NULL(
        strstr(said, "alarm of servo 7: torque went off by itself; 'servos' tells why"));
}

void test_offline_is_told_with_its_remedy(void)
{
    failsafe.reported[0] = FAILSAFE_OFFLINE;
    report(FAILSAFE_OFFLINE);
    TEST_ASSERT_NOT_NULL(strstr(said, "alarm of servo 7: offline; check power"));
}

void test_lost_state_is_listed_with_the_alarms(void)
{
    cds_servos_add(&robot.servos, 7);
    robot.states[0].alarms = CDS_ERROR_OVERHEATING;
    robot.states[0].inhibits = CDS_INHIBIT_STATE_LOST;
    TEST_ASSERT_EQUAL_STRING(
        "alarm of servo 7: overheating\r\nalarm of servo 7: torque went off by itself\r\nok\r\n",
        reply_to("alarms"));
    reply_to("release");
    TEST_ASSERT_EQUAL_STRING("alarm of servo 7: overheating\r\nok\r\n", reply_to("alarms"));
}

/* Its torque was not read as off: it answered PING and no READ, as in noise. */
void test_servo_that_was_not_read_has_an_unknown_state(void)
{
    static const char told[] =
        "alarm of servo 7: its replies were lost, its state is unknown\r\nok\r\n";

    cds_servos_add(&robot.servos, 7);
    robot.states[0].inhibits = CDS_INHIBIT_STATE_LOST;
    robot.states[0].torque = true;
    TEST_ASSERT_EQUAL_STRING(told, reply_to("alarms"));
    robot.states[0].torque = false;
    robot.states[0].status_return_level = 0;
    TEST_ASSERT_EQUAL_STRING(told, reply_to("alarms"));
}

void test_offline_servo_is_listed_with_the_alarms(void)
{
    static const char told[] =
        "alarm of servo 7: overheating\r\nalarm of servo 7: offline\r\nok\r\n";

    cds_servos_add(&robot.servos, 7);
    robot.states[0].alarms = CDS_ERROR_OVERHEATING;
    robot.states[0].presence = CDS_PRESENCE_OFFLINE;
    TEST_ASSERT_EQUAL_STRING(told, reply_to("alarms"));
    robot.states[0].inhibits = CDS_INHIBIT_STATE_LOST;
    TEST_ASSERT_EQUAL_STRING(told, reply_to("alarms"));
    robot.states[0].presence = CDS_PRESENCE_ONLINE;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("alarms"), "torque went off by itself"));
}

/* Returns the banner after a reset with these flags. */
static const char *whole_banner_after(uint8_t cause)
{
    said_length = 0;
    settings.echo = SETTINGS_ECHO_PERSON;
    memset(&console, 0, sizeof console);
    failsafe_begin(&failsafe, cause);
    console_open(&console, &failsafe, &input, &output);
    type("");
    return said;
}

/* Returns its first line. */
static const char *banner_after(uint8_t cause)
{
    whole_banner_after(cause);
    *strchr(said, '\r') = '\0';
    return said;
}

void test_banner_tells_what_an_unwanted_reset_means(void)
{
    TEST_ASSERT_NOT_NULL(
        strstr(whole_banner_after(FAILSAFE_RESET_WATCHDOG),
               "watchdog\r\nservos may be moving, and none is watched: Ctrl-X stops those at "
               "1000000bps, 'scan' finds them\r\nhelp"));
    TEST_ASSERT_NOT_NULL(
        strstr(whole_banner_after(FAILSAFE_RESET_BROWN_OUT), "out\r\nservos may be"));
    TEST_ASSERT_NOT_NULL(strstr(whole_banner_after(FAILSAFE_RESET_EXTERNAL), "servos may be"));
    TEST_ASSERT_NULL(strstr(whole_banner_after(FAILSAFE_RESET_POWER | FAILSAFE_RESET_BROWN_OUT),
                            "servos may be"));
}

void test_banner_tells_that_driving_is_inhibited(void)
{
    robot_inhibit(&robot);
    TEST_ASSERT_NOT_NULL(strstr(whole_banner_after(FAILSAFE_RESET_EXTERNAL),
                                "\r\ndriving is inhibited: 'release' allows it\r\nservos may be"));
    robot_allow(&robot);
    TEST_ASSERT_NULL(strstr(whole_banner_after(FAILSAFE_RESET_EXTERNAL), "inhibited"));
}

/* Returns the reply of `release` after the loss of the link with this action. */
static const char *error_after_loss(uint8_t action)
{
    settings.link_loss_action = action;
    failsafe.link_lost = true;
    return reply_to("release");
}

void test_error_of_lost_link_names_what_was_done(void)
{
    TEST_ASSERT_EQUAL_STRING("ok\r\n", error_after_loss(FAILSAFE_SHOW)); // nothing is inhibited
    robot_inhibit(&robot);
    TEST_ASSERT_NOT_NULL(strstr(error_after_loss(FAILSAFE_INHIBIT), "ms: driving is inhibited"));
    robot.stop_begun = true;
    TEST_ASSERT_NOT_NULL(
        strstr(error_after_loss(FAILSAFE_TORQUE_OFF), "ms: torque off, driving is inhibited"));
}

void test_banner_tells_a_reset_that_no_user_wanted(void)
{
    TEST_ASSERT_NOT_NULL(strstr(banner_after(FAILSAFE_RESET_WATCHDOG), "; reset by watchdog"));
    TEST_ASSERT_NOT_NULL(strstr(banner_after(FAILSAFE_RESET_BROWN_OUT), "; reset by brown-out"));
}

void test_banner_does_not_tell_a_wanted_reset(void)
{
    TEST_ASSERT_NULL(strchr(banner_after(FAILSAFE_RESET_POWER | FAILSAFE_RESET_BROWN_OUT), ';'));
    TEST_ASSERT_NULL(strchr(banner_after(FAILSAFE_RESET_EXTERNAL), ';'));
    TEST_ASSERT_NULL(strchr(banner_after(0), ';'));
}
