/* SPDX-License-Identifier: MIT */
/* Errors whose remedy depends on the line or on the servo. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
    robot.health_pauses = true;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_time_out_of_range_names_its_range(void)
{
    static const char *const lines[][2] = {
        {"pose 30 in 0",
         "error 56: time out of range: 1ms to 600s; a number without unit is ms\r\n"},
        {"pose 30 in 601s", "error 56: time out of range: 1ms to 600s; "},
        {"sequence w new x 0", "error 56: time out of range: 10ms to 600s, dwell 0 to 65.53s; "},
    };

    reply_to("group 1");
    ASSERT_REPLIES(lines);
}

void test_bare_time_out_of_range_is_shown_with_its_unit(void)
{
    static const char *const lines[][2] = {
        {"settings autostart w loop 5", "error 33: DELAY 5ms is out of range: 1 to 127s, whole "},
        {"monitor 1 every 9", "error 33: MS 9ms is out of range: 10 to 60000ms\r\n"},
        {"play w at 5", "error 82: PERCENT 5 is out of range: 10 to 200%\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_id_254_where_one_servo_must_reply_says_why(void)
{
    static const char *const lines[][2] = {
        {"info 254", "error 33: ID '254': 254 means all servos at once; this command takes an ID "
                     "from 0 to 253, or 'all': each in turn\r\n"},
        {"reset 254", "error 33: ID '254': 254 means all servos at once; this command takes an ID "
                      "from 0 to 253\r\n"},
        {"group 254", "error 33: ID... '254': 254 means all servos at once; "},
        {"id 254 5", "error 33: OLD '254': 254 means all servos at once; "},
        {"info 255", "error 33: ID 255 is out of range: 0 to 253\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_id_twice_where_a_word_is_due_shows_the_usage(void)
{
    static const char *const lines[][2] = {
        {"torque 1 1", "error 41: ID '1': an ID is given twice; usage: torque ID|254 on|off\r\n"},
        {"led 1 2 1", "error 41: ID '1': an ID is given twice; usage: led ID|254 on|off\r\n"},
        {"info 1 1", "error 41: ID '1': an ID is given twice; give each servo once\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_word_for_a_number_of_a_setting_names_its_range(void)
{
    static const char *const lines[][2] = {
        {"settings alarm_report on",
         "error 32: VALUE 'on': not a number; write a number from 0 to 1\r\n"},
        {"settings link_loss_ms off", "error 32: VALUE 'off': not a number; write a time: "},
    };

    ASSERT_REPLIES(lines);
}

void test_setting_in_place_of_an_id_points_to_settings(void)
{
    static const char *const lines[][2] = {
        {"set repeats 1", "error 32: ID 'repeats': a setting of the controller, not a servo; "
                          "'settings SETTING VALUE' sets it\r\n"},
        {"set repeat 1", "error 32: ID 'repeat': not a number; "},
    };

    ASSERT_REPLIES(lines);
}

void test_exit_and_quit_say_what_ends_the_terminal(void)
{
    static const char *const lines[][2] = {
        {"exit", "error 30: 'exit': unknown command; to end the terminal: in picocom Ctrl-T, then "
                 "Ctrl-Q\r\n"},
        {"quit", "error 30: 'quit': unknown command; to end the terminal: "},
        {"quite", "error 30: 'quite': unknown command; 'help' lists the commands; did "},
    };

    ASSERT_REPLIES(lines);
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
    TEST_ASSERT_EQUAL_STRING("error 2: several servos answer at the same time on one wire, so "
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
                 "or an alarm: mend that, 'release 2', then 'torque 2 on' moves it to its goal, "
                 "'teach off 2' keeps it where it is\r\n",
                 "set 2 TORQUE_ENABLE 1");
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
    TEST_ASSERT_EQUAL_STRING("error 2: servo 1: no reply by the deadline; check power, wiring, ID "
                             "and baud rate of the servo; bytes without a packet so far, of noise "
                             "or echoes: 1, see 'diagnose 1'\r\n",
                             said);
}
