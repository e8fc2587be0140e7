/* SPDX-License-Identifier: MIT */
/* What the console prints without a command: the banner, and lost torque; and `alarms`, which lists
 * the latter. */
#include "console_rig.h"

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
    failsafe.reported[0] = CDS_ERROR_OVERLOAD;
    report(FAILSAFE_TORQUE_LOST);
    TEST_ASSERT_NOT_NULL(strstr(said, "alarm 7: torque went off by itself; 'servos' tells why"));
}

void test_offline_is_told_with_its_remedy(void)
{
    failsafe.reported[0] = FAILSAFE_OFFLINE;
    report(FAILSAFE_OFFLINE);
    TEST_ASSERT_NOT_NULL(strstr(said, "alarm 7: offline; check power"));
}

void test_lost_state_is_listed_with_the_alarms(void)
{
    cds_servos_add(&robot.servos, 7);
    robot.states[0].alarms = CDS_ERROR_OVERHEATING;
    robot.states[0].inhibits = CDS_INHIBIT_STATE_LOST;
    TEST_ASSERT_EQUAL_STRING("alarm 7: overheating\r\nalarm 7: torque went off by itself\r\nok\r\n",
                             reply_to("alarms"));
    reply_to("release");
    TEST_ASSERT_EQUAL_STRING("alarm 7: overheating\r\nok\r\n", reply_to("alarms"));
}

/* Returns the first line of the banner after a reset with these flags. */
static const char *banner_after(uint8_t cause)
{
    said_length = 0;
    settings.echo = SETTINGS_ECHO_PERSON;
    memset(&console, 0, sizeof console);
    failsafe_begin(&failsafe, cause);
    console_open(&console, &failsafe, &input, &output);
    type("");
    *strchr(said, '\r') = '\0';
    return said;
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
