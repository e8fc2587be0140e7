/* SPDX-License-Identifier: MIT */
/* Errors whose remedy depends on what is known of the servos. */
#include "console/unasked.h"
#include "console/advice_alarms.h" // advice_alarm_remedy()
#include "console/reply.h"         // REPLY_OFFLINE
#include "console_rig.h"
#include "eeprom_fake.h"

void setUp(void)
{
    begin_console();
    robot.health_pauses = true;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* Servos 1 to `count` are known, and answer. */
static void know_servos(uint8_t count)
{
    for (uint8_t id = 1; id <= count; id++) {
        robot_add(&robot, id);
        robot.states[id - 1].presence = CDS_PRESENCE_ONLINE;
    }
}

/* A PING to ID 254 that ends without a good reply. */
static const char *ping_all(void)
{
    reply_to("ping 254");
    port_fake.now_us += 100000;
    type("");
    return said;
}

void test_ping_254_with_several_servos_says_they_answer_at_once(void)
{
    know_servos(2);
    TEST_ASSERT_EQUAL_STRING("error 2: several servos answer at the same time, so "
                             "their replies mix; 'scan' asks each\r\n",
                             ping_all());
}

void test_ping_254_with_one_servo_has_the_usual_remedy(void)
{
    know_servos(1);
    TEST_ASSERT_EQUAL_STRING_LEN("error 2: no reply by the deadline; ", ping_all(), 35);
}

void test_no_reply_keeps_its_remedy_after_late_replies(void)
{
    know_servos(1);
    robot.states[0].counters.stale_replies = 3;
    reply_to("ping 1");
    port_fake.now_us += 100000;
    type("");
    TEST_ASSERT_EQUAL_STRING(
        "error 2: servo 1: no reply by the deadline; check power, wiring, ID "
        "and baud rate of the servo; replies that came late so far: 3, see 'diagnose 1'\r\n",
        said);
}

void test_no_reply_after_old_late_replies_does_not_name_them(void)
{
    know_servos(1);
    robot.states[0].counters.stale_replies = 3;
    robot.states[0].counters.timeouts = 9;
    reply_to("ping 1");
    port_fake.now_us += 100000;
    type("");
    TEST_ASSERT_EQUAL_STRING("error 2: servo 1: no reply by the deadline; check power, wiring, ID "
                             "and baud rate of the servo\r\n",
                             said);
}

/* Servo 2 of three has a new alarm: its remedy. */
static const char *remedy_of_servo_2(uint8_t condition)
{
    static const CDS_FLASH char line[] = "%s%s%s%s", nothing[] = "";
    union printer_value *values = console.printer.values;

    settings.echo = SETTINGS_ECHO_PERSON;
    failsafe.next = 1;
    failsafe.alarm_id = 2;
    said_length = 0;
    said[0] = '\0';
    values[3].text = advice_alarm_remedy(&console, condition);
    for (uint8_t i = 0; i < 3; i++)
        values[i].text = nothing;
    printer_line(&console.printer, line);
    type("");
    return said;
}

void test_offline_servo_after_clear_has_no_damaged_packets(void)
{
    know_servos(3);
    robot.states[1].counters.corrupt = 9;
    robot.states[0].alarms = robot.servos.alarms = CDS_ERROR_CHECKSUM;
    TEST_ASSERT_EQUAL_STRING("; check power, wiring, ID and baud rate of the servo; packets came "
                             "damaged since the last 'clear', by noise or a loose plug: "
                             "'diagnose 2'\r\n",
                             remedy_of_servo_2(REPLY_OFFLINE));
    failsafe_clear(&failsafe);
    TEST_ASSERT_EQUAL_STRING("; check power, wiring, ID and baud rate of the servo\r\n",
                             remedy_of_servo_2(REPLY_OFFLINE));
}

void test_alarm_has_its_remedy_after_an_alarm_with_another(void)
{
    uint8_t instruction = reply_condition(CDS_ERROR_INSTRUCTION);

    know_servos(3);
    failsafe.reported[0] = CDS_ERROR_INSTRUCTION; // before any damage
    robot.servos.alarms = CDS_ERROR_CHECKSUM;
    TEST_ASSERT_EQUAL_STRING_LEN("; bytes on the line may be damaged, ",
                                 remedy_of_servo_2(instruction), 36);
    failsafe.reported[1] = CDS_ERROR_CHECKSUM | CDS_ERROR_INSTRUCTION; // its line is above
    TEST_ASSERT_EQUAL_STRING("\r\n", remedy_of_servo_2(instruction));
    TEST_ASSERT_EQUAL_STRING_LEN("; bytes on the line may be damaged, ",
                                 remedy_of_servo_2(reply_condition(CDS_ERROR_CHECKSUM)), 36);
}

void test_lost_torque_names_what_ends_the_inhibit(void)
{
    know_servos(3);
    TEST_ASSERT_NOT_NULL(strstr(remedy_of_servo_2(REPLY_TORQUE_LOST), " heat, 'release', then "));
    failsafe.link_lost = true;
    TEST_ASSERT_NOT_NULL(strstr(remedy_of_servo_2(REPLY_TORQUE_LOST), " heat, 'clear', then "));
}

static void assert_stopped_save(uint8_t result, const char *end)
{
    eeprom_fake.slow = 100;
    store.result = SETTINGS_UNSAVED;
    reply_to("save");
    store.result = result;
    console_stop(&console);
    type("");
    TEST_ASSERT_NOT_NULL_MESSAGE(
        strstr(said, "error 54: stopped: driving is inhibited until 'release'; "), said);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, end), said);
}

void test_stop_during_a_save_says_that_it_goes_on(void)
{
    assert_stopped_save(SETTINGS_SAVING, "; the save goes on, 'settings' tells how it ends\r\n");
}

void test_stop_behind_a_save_says_that_it_has_ended(void)
{
    assert_stopped_save(SETTINGS_SAVED, "; the settings are saved all the same\r\n");
}

void test_stop_behind_a_failed_save_says_so(void)
{
    assert_stopped_save(SETTINGS_FAILED, "; the settings are not saved: 'save' again\r\n");
}

void test_servos_tells_an_endless_turn(void)
{
    know_servos(2);
    robot.states[0].held = CDS_HELD_CW_0 | CDS_HELD_CCW_0;
    robot.states[0].torque = robot.states[1].torque = true;
    TEST_ASSERT_EQUAL_STRING("servo 1: online, torque on, endless turn\r\n"
                             "servo 2: online, torque on\r\nok\r\n",
                             reply_to("servos"));
    robot.states[0].torque = false;
    robot.states[0].torque_off = CDS_TORQUE_OFF_OFF;
    TEST_ASSERT_EQUAL_STRING_LEN("servo 1: online, torque off, endless turn\r\n",
                                 reply_to("servos"), 43);
}

void test_ping_254_counts_no_servo_at_another_rate(void)
{
    know_servos(2);
    robot.states[1].baud_reg = 16;
    TEST_ASSERT_EQUAL_STRING_LEN("error 2: no reply by the deadline; ", ping_all(), 35);
}

void test_servo_that_lost_its_state_is_inhibited_with_its_remedy(void)
{
    know_servos(2);
    robot.states[1].inhibits = CDS_INHIBIT_STATE_LOST;
    assert_reply("error 12: servo 2: the servo may not be driven; it lost its state by power, plug "
                 "or an alarm: mend that, 'release 2'\r\n",
                 "set 2 TORQUE_ENABLE 1");
    command_set.unasked->alarms[1].mode = UNASKED_POSITION;
    assert_reply("error 12: servo 2: the servo may not be driven; it lost its state by power, plug "
                 "or an alarm: mend that, 'release 2', then 'torque 2 on' moves it to its goal, "
                 "'teach off 2' keeps it where it is\r\n",
                 "set 2 TORQUE_ENABLE 1");
    command_set.unasked->alarms[1].mode = UNASKED_UNKNOWN;
    robot.states[1].presence = CDS_PRESENCE_OFFLINE;
    assert_reply("error 12: servo 2: not driven, as it gives no good answer; ",
                 "set 2 TORQUE_ENABLE 1");
}

/* `id 1 5`; damaged bytes come as the replies of servo 5. */
void test_new_id_with_damaged_replies_is_not_said_to_be_taken(void)
{
    static const uint8_t damaged[] = {0xFF, 0xFF, 5, 2, 0, 0};

    reply_to("id 1 5");
    for (uint16_t i = 0; i < 100 && strstr(said, "error") == NULL; i++) {
        if (i && bus.link.state == CDS_LINK_TALKING) {
            port_fake_transmit(&bus.link, 0);
            if (port_fake.sent[2] == 5)
                port_fake_hear(&bus.link, damaged, sizeof damaged);
            else
                port_fake_answer(&bus.link, 1, 0, NULL, 0);
        }
        port_fake.now_us += 50000;
        turn();
    }
    type("");
    TEST_ASSERT_EQUAL_STRING(
        "error 50: servo 1: damaged bytes came from ID 5 at 1000000bps, so it "
        "may be taken, or there is noise; nothing was written: 'diagnose 5'\r\n",
        said);
}

void test_no_reply_after_stray_bytes_names_diagnose(void)
{
    static const uint8_t end_of_echo[] = {0xF4};

    know_servos(1);
    reply_to("get 1 3");
    port_fake_hear(&bus.link, end_of_echo, sizeof end_of_echo);
    port_fake.now_us += 100000;
    type("");
    TEST_ASSERT_EQUAL_STRING(
        "error 2: servo 1: no reply by the deadline; check power, wiring, ID "
        "and baud rate of the servo; bytes without a packet came meanwhile, of "
        "noise or echoes: 1, see 'diagnose 1'\r\n",
        said);
}
