/* SPDX-License-Identifier: MIT */
/* What the console tells a person without a command (unasked.h): that a fault is over, alarms above
 * a line that is half typed, and remedies that are not repeated. */
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
        "holds it where it is, unless it is in endless turn\r\n\r> ",
        said_in_ticks(3));
}

/* A servo that is back has lost its state: its alarm is due, and failsafe.c has noted it as told.
 */
static struct cds_servo_state *lose_state(void)
{
    struct cds_servo_state *servo = begin_person();

    come_back(servo);
    servo->inhibits = CDS_INHIBIT_STATE_LOST;
    servo->held |= CDS_HELD_LOSS_TOLD;
    failsafe.alarm = FAILSAFE_TORQUE_LOST;
    return servo;
}

static const char lost_alarm[] = "alarm of servo 7: torque went off by itself";

/* Lets the failsafe look at the only servo. Returns what is said then. */
static const char *said_after_watch(void)
{
    settings.alarm_report = 1;
    failsafe_poll(&failsafe);
    return said_in_ticks(1);
}

void test_lost_state_of_a_servo_that_is_back_is_told_once(void)
{
    lose_state();
    TEST_ASSERT_NOT_NULL(strstr(said_in_ticks(8), "it lost its state"));
    TEST_ASSERT_EQUAL_STRING("", said_after_watch());
}

void test_lost_state_behind_an_inhibit_is_told_by_its_alarm(void)
{
    lose_state();
    robot_inhibit(&robot);
    TEST_ASSERT_NOT_NULL(strstr(said_in_ticks(8), "driving is inhibited until 'release'"));
    TEST_ASSERT_NOT_NULL(strstr(said_after_watch(), lost_alarm));
    TEST_ASSERT_EQUAL_STRING("", said_after_watch());
}

/* Noise has eaten the replies to the stop: the torque that is off is not lost. */
void test_lost_state_behind_a_stop_is_not_told(void)
{
    struct cds_servo_state *servo = begin_person();

    servo->inhibits = CDS_INHIBIT_STATE_LOST;
    robot.stop_begun = true;
    TEST_ASSERT_EQUAL_STRING("", said_after_watch());
    TEST_ASSERT_EQUAL_STRING("", said_after_watch());
}

void test_lost_state_is_told_to_a_host_of_packets(void)
{
    lose_state();
    failsafe.host_types = false;
    TEST_ASSERT_NOT_NULL(strstr(said_in_ticks(1), lost_alarm));
}

void test_lost_state_is_told_when_a_program_takes_over(void)
{
    lose_state();
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(2));
    TEST_ASSERT_EQUAL_STRING("", said_after_watch());
    settings.echo = SETTINGS_ECHO_OFF;
    TEST_ASSERT_NOT_NULL(strstr(said_after_watch(), lost_alarm));
}

void test_lost_state_is_told_when_packets_take_over(void)
{
    lose_state();
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(2));
    failsafe.host_types = false;
    TEST_ASSERT_NOT_NULL(strstr(said_after_watch(), lost_alarm));
}

void test_servo_is_back_at_level_0_is_told_to_answer_first(void)
{
    struct cds_servo_state *servo = begin_person();

    servo->status_return_level = 0;
    servo->torque = true; // not read
    come_back(servo);
    TEST_ASSERT_EQUAL_STRING("\rservo 7 answers again, torque unknown; it answers no READ: 'set 7 "
                             "STATUS_RETURN_LEVEL 1' first\r\n\r> ",
                             said_in_ticks(8));
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

void test_servos_forget_drops_the_return_for_the_next_list(void)
{
    come_back(begin_person());
    said_in_ticks(3);
    reply_to("servos forget");
    reply_to("group 9");
    TEST_ASSERT_EQUAL_UINT8(1, robot.servos.count);
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
                             "until 'release'; other IDs are not checked\r\n\r> ",
                             said_in_ticks(2));
    TEST_ASSERT_EQUAL_STRING("", said_in_ticks(20));
}

/* A stop has failed, and then succeeds. Returns what is said of it. */
static const char *said_of_late_stop(void)
{
    robot_inhibit(&robot);
    robot.stop_begun = true;
    robot.stop.steps.result = CDS_LINE_BUSY;
    said_in_ticks(2);
    robot.stop.steps.result = CDS_OK;
    return said_in_ticks(2);
}

void test_late_stop_of_a_scanned_bus_names_no_ids(void)
{
    begin_person();
    robot.unlisted = 0;
    TEST_ASSERT_NOT_NULL(strstr(said_of_late_stop(), "at all servos; driving is inhibited until "
                                                     "'release'\r\n"));
}

void test_late_stop_without_known_servos_claims_nothing(void)
{
    begin_person();
    robot_forget(&robot);
    TEST_ASSERT_EQUAL_STRING("\rstop: sent; no servo is known, so none was read back: 'scan' finds "
                             "servos; driving is inhibited until 'release'\r\n\r> ",
                             said_of_late_stop());
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
    TEST_ASSERT_NOT_NULL(strstr(said, "overheating; 'torque 7 off', unload it"));
    report(CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload\r\n"));
    said_in_ticks(10);
    report(CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload; 'torque 7 off', unload it"));
    reply_to("help ping");
    report(CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload; 'torque 7 off', unload it"));
}

void test_remedy_of_a_reply_is_not_told_again_by_an_alarm(void)
{
    begin_person();
    reply_to("ping 9");
    for (uint8_t i = 0; i < 4 && strstr(said, "error") == NULL; i++) {
        port_fake.now_us += TICK_US;
        type("");
    }
    TEST_ASSERT_NOT_NULL(strstr(said, "no reply by the deadline; check power"));
    failsafe.reported[0] = FAILSAFE_OFFLINE;
    report(FAILSAFE_OFFLINE);
    TEST_ASSERT_NOT_NULL(strstr(said, "alarm of servo 7: offline\r\n"));
}

void test_remedy_is_not_left_out_for_a_program(void)
{
    report(CDS_ERROR_OVERLOAD);
    report(CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload; 'torque 7 off', unload it"));
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
