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
               "watchdog\r\nany motion has ended; servos may have torque, and none is watched: "
               "'scan' finds them\r\nhelp"));
    TEST_ASSERT_NOT_NULL(strstr(whole_banner_after(FAILSAFE_RESET_BROWN_OUT), "out\r\nany motion"));
    TEST_ASSERT_NOT_NULL(strstr(whole_banner_after(FAILSAFE_RESET_EXTERNAL), "any motion"));
    TEST_ASSERT_NULL(
        strstr(whole_banner_after(FAILSAFE_RESET_POWER | FAILSAFE_RESET_BROWN_OUT), "any motion"));
}

void test_banner_tells_that_driving_is_inhibited(void)
{
    robot_inhibit(&robot);
    TEST_ASSERT_NOT_NULL(strstr(whole_banner_after(FAILSAFE_RESET_EXTERNAL),
                                "\r\ndriving is inhibited: 'release' allows it\r\nhelp"));
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
    TEST_ASSERT_NOT_NULL(strstr(error_after_loss(FAILSAFE_SHOW), "link_loss_ms: driving goes on"));
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

/* ---- in mode person ---- */

#define TICK_US 250000ul

/* The robot has servo 7, in mode person. */
static struct cds_servo_state *begin_person(void)
{
    settings.echo = SETTINGS_ECHO_PERSON;
    cds_servos_add(&robot.servos, 7);
    robot.states[0].presence = CDS_PRESENCE_ONLINE;
    reply_to("help ping");
    return &robot.states[0];
}

static const char *said_in_ticks(uint8_t ticks)
{
    said_length = 0;
    said[0] = '\0';
    for (; ticks; ticks--) {
        port_fake.now_us += TICK_US;
        for (uint8_t i = 0; i < 100; i++) {
            console_poll(&console);
            hear_console();
        }
    }
    return said;
}

/* Servo 7 was told as offline, and is back. */
static void come_back(struct cds_servo_state *servo)
{
    failsafe.reported[0] = FAILSAFE_OFFLINE;
    report(FAILSAFE_OFFLINE);
    failsafe.reported[0] = 0;
    servo->presence = CDS_PRESENCE_ONLINE;
}

void test_servo_is_back_is_told_once(void)
{
    struct cds_servo_state *servo = begin_person();

    servo->torque = true;
    come_back(servo);
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(5));
    TEST_ASSERT_EQUAL_STRING("\rservo 7 answers again, torque on; it may be driven\r\n\r> ",
                             said_in_ticks(3));
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(20));
}

void test_servo_that_misses_again_is_not_told_as_back(void)
{
    struct cds_servo_state *servo = begin_person();

    come_back(servo);
    for (uint8_t i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_STRING("", said_in_ticks(5));
        servo->misses = 1;
        TEST_ASSERT_EQUAL_STRING("", said_in_ticks(1));
        servo->misses = 0;
    }
}

void test_servo_that_comes_and_goes_is_told_as_offline_once(void)
{
    struct cds_servo_state *servo = begin_person();

    come_back(servo);
    for (uint8_t i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_STRING("", said_in_ticks(3));
        servo->presence = CDS_PRESENCE_OFFLINE;
        failsafe.reported[0] = failsafe.alarm = FAILSAFE_OFFLINE;
        TEST_ASSERT_EQUAL_STRING("", said_in_ticks(3));
        failsafe.reported[0] = 0;
        servo->presence = CDS_PRESENCE_ONLINE;
    }
    TEST_ASSERT_NOT_NULL(strstr(said_in_ticks(8), "servo 7 answers again"));
    failsafe.reported[0] = failsafe.alarm = FAILSAFE_OFFLINE;
    TEST_ASSERT_NOT_NULL(strstr(said_in_ticks(1), "alarm of servo 7: offline"));
}

void test_autostart_that_has_not_begun_is_told_once(void)
{
    begin_person();
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(3));
    robot.moves->autostart.state = AUTOSTART_ALARM;
    TEST_ASSERT_EQUAL_STRING("\rthe sequence of the autostart does not play: 'settings autostart' "
                             "tells why\r\n\r> ",
                             said_in_ticks(3));
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(3));
    robot.moves->autostart.state = AUTOSTART_OFF;
}

void test_loss_of_a_servo_that_is_back_is_told_in_one_line(void)
{
    struct cds_servo_state *servo = begin_person();

    come_back(servo);
    servo->inhibits = CDS_INHIBIT_STATE_LOST;
    failsafe.alarm = FAILSAFE_TORQUE_LOST;
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(5));
    TEST_ASSERT_EQUAL_STRING(
        "\rservo 7 answers again, torque off; it lost its state: 'release 7', then 'teach off 7' "
        "holds it where it is, 'torque 7 on' moves it to its goal\r\n\r> ",
        said_in_ticks(3));
}

void test_servo_is_back_while_link_is_lost_names_clear(void)
{
    come_back(begin_person());
    failsafe.link_lost = true;
    console.faults_told = FAULT_LINK_LOST;
    robot_inhibit(&robot);
    TEST_ASSERT_NOT_NULL(strstr(said_in_ticks(8), "off; driving is inhibited until 'clear'\r\n"));
}

void test_forgotten_servo_is_not_told_as_back(void)
{
    come_back(begin_person());
    robot_forget(&robot);
    said_in_ticks(1);
    cds_servos_add(&robot.servos, 7);
    robot.states[0].presence = CDS_PRESENCE_ONLINE;
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(20));
}

void test_stop_that_succeeds_late_is_told_once(void)
{
    begin_person();
    robot_inhibit(&robot);
    robot.stop_begun = true;
    robot.stop.steps.result = CDS_LINE_BUSY;
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(2));
    robot.stop.steps.result = CDS_OK;
    TEST_ASSERT_EQUAL_STRING("\rstop: torque read back as off at all servos; driving is inhibited "
                             "until 'release'\r\n\r> ",
                             said_in_ticks(2));
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(20));
}

void test_release_before_late_stop_is_told_nothing(void)
{
    begin_person();
    robot.stop_begun = true;
    robot.stop.steps.result = CDS_LINE_BUSY;
    said_in_ticks(2);
    robot_allow(&robot);
    said_in_ticks(2);
    robot.stop_begun = true; // of another stop, which succeeds
    robot.stop.steps.result = CDS_OK;
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(20));
}

void test_half_typed_line_comes_again_below_an_alarm(void)
{
    begin_person();
    type_part("ping 12\x1B[D\x1B[D");
    said_in_ticks(1);
    report(CDS_ERROR_CHECKSUM);
    TEST_ASSERT_EQUAL_STRING(
        "\r\x1B[K\ralarm of servo 7: checksum; it came damaged: look for noise, then send it "
        "again\r\n\r> ping 12\b\b",
        said);
}

void test_half_typed_line_in_mode_echo_holds_back_alarms(void)
{
    begin_person();
    settings.echo = SETTINGS_ECHO_ON;
    type_part("ping 1");
    said_in_ticks(1);
    failsafe.alarm = CDS_ERROR_CHECKSUM;
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(2));
}

void test_remedy_of_next_alarm_is_told_again_later(void)
{
    begin_person();
    report(CDS_ERROR_OVERHEATING);
    TEST_ASSERT_NOT_NULL(strstr(said, "overheating; take any load off"));
    report(CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload\r\n"));
    said_in_ticks(10);
    report(CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload; take any load off"));
    reply_to("help ping");
    report(CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload; take any load off"));
}

void test_remedy_is_not_left_out_for_a_program(void)
{
    report(CDS_ERROR_OVERLOAD);
    report(CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload; take any load off"));
}

void test_instruction_error_by_noise_names_noise(void)
{
    begin_person();
    report(CDS_ERROR_INSTRUCTION);
    TEST_ASSERT_NOT_NULL(strstr(said, "instruction; the servo does not know the instruction"));
    failsafe.reported[0] = CDS_ERROR_CHECKSUM | CDS_ERROR_INSTRUCTION;
    report(CDS_ERROR_INSTRUCTION);
    TEST_ASSERT_NOT_NULL(strstr(said, "instruction; it came damaged: look for noise"));
    failsafe.reported[0] = CDS_ERROR_INSTRUCTION;
    reply_to("help ping");
    robot.servos.reserved_count = 1; // a motion is under way
    report(CDS_ERROR_INSTRUCTION);
    TEST_ASSERT_NOT_NULL(strstr(said, "instruction; it came damaged: look for noise"));
}
