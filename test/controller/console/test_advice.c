/* SPDX-License-Identifier: MIT */
/* Errors whose remedy depends on the line. */
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
        {"info 254", "error 33: ID '254': 254 means all servos; this command takes an ID "
                     "from 0 to 253, or 'all': each in turn\r\n"},
        {"reset 254", "error 33: ID '254': 254 means all servos; this command takes an ID "
                      "from 0 to 253\r\n"},
        {"group 254", "error 33: ID... '254': 254 means all servos; "},
        {"id 254 5", "error 33: OLD '254': 254 means all servos; "},
        {"info 255", "error 33: ID 255 is out of range: 0 to 253\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_id_twice_where_a_word_is_due_shows_the_usage(void)
{
    static const char *const lines[][2] = {
        {"torque 1 2 1", "error 41: ID '1': an ID is given twice; usage: torque ID|254 on|off\r\n"},
        {"led 1 2 1", "error 41: ID '1': an ID is given twice; usage: led ID|254 on|off\r\n"},
        {"info 1 1", "error 41: ID '1': an ID is given twice; give each servo once\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_word_in_place_of_a_setting_value_names_the_value(void)
{
    static const char *const lines[][2] = {
        {"settings alarm_report on",
         "error 32: VALUE 'on': write 1 (in each mode): 'settings alarm_report 1'\r\n"},
        {"settings link_loss_ms off",
         "error 32: VALUE 'off': write 0 (not watched): 'settings link_loss_ms 0'\r\n"},
        {"settings device_id off",
         "error 32: VALUE 'off': write 254 (off): 'settings device_id 254'\r\n"},
        {"settings alarm_report once",
         "error 32: VALUE 'once': not a number; write 1 for on, 0 for off\r\n"},
        {"settings link_loss_ms x", "error 32: VALUE 'x': not a number; write a time: "},
    };

    ASSERT_REPLIES(lines);
}

void test_setting_in_place_of_an_id_points_to_settings(void)
{
    static const char *const lines[][2] = {
        {"set repeats 1", "error 32: ID 'repeats': a setting of the controller, not a servo; "
                          "'settings SETTING VALUE' sets it\r\n"},
        {"set repeat 1", "error 32: ID 'repeat': not a number; write IDs: "},
    };

    ASSERT_REPLIES(lines);
}

void test_exit_and_quit_say_what_ends_the_terminal(void)
{
    static const char *const lines[][2] = {
        {"exit", "error 30: 'exit': unknown command; try Ctrl-T, then Ctrl-Q in picocom\r\n"},
        {"quit", "error 30: 'quit': unknown command; try Ctrl-T, "},
        {"quite", "error 30: 'quite': unknown command; 'help' lists the commands; did "},
    };

    ASSERT_REPLIES(lines);
}
