/* SPDX-License-Identifier: MIT */
/* Refusals that name the values behind them; a group with a servo that is not there. */
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

void test_save_with_a_pose_names_the_line(void)
{
    static const char *const lines[][2] = {
        {"save pose up", "error 31: try 'pose save NAME'\r\n"},
        {"save sequence walk", "error 31: try 'sequence NAME new POSE "},
        {"pose up save", "error 38: 'save' where 'in' is due: try 'pose save NAME'\r\n"},
        {"pose up delete", "error 38: 'delete' where 'in' is due: try 'pose delete NAME'\r\n"},
        {"pose up show", "error 38: 'show' where 'in' is due: try 'pose show NAME'\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_help_on_errors_or_units_names_the_place(void)
{
    static const char *const lines[][2] = {
        {"units", "error 30: 'units': unknown command; try 'help units'\r\n"},
        {"errors", "error 30: 'errors': unknown command; try docs/errors.md, "},
        {"help 57", "error 30: COMMAND '57': no help on errors here; docs/errors.md lists "},
        {"help error 57", "error 30: COMMAND 'error': no help on errors here; docs/errors.md "},
    };

    ASSERT_REPLIES(lines);
}

void test_value_of_a_goal_beyond_limits_is_shown_as_angle(void)
{
    static const char *const lines[][2] = {
        {"write 1 GOAL_POSITION 100",
         "error 11: servo 1: 100 is 29.326deg, its limits are 60.117deg to 239.883deg\r\n"},
    };

    robot_add(&robot, 1);
    reply_to("limits 1 60 240");
    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_pose_beyond_limits_names_servo_and_angle(void)
{
    static const char *const lines[][2] = {
        {"pose 90 20", "error 11: servo 2: the angle, 19.941deg, is not within its limits, "
                       "60.117deg to 239.883deg\r\n"},
        {"pose 90 100 at 0", "error 11: servo 2: its limits need a SPEED above 0, up to 30rpm, as "
                             "in 'pose 90 120 at 30rpm'\r\n"},
    };

    robot_add(&robot, 1);
    robot_add(&robot, 2);
    reply_to("limits 2 60 240 30rpm");
    reply_to("group 1 2");
    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_set_of_a_second_byte_names_the_register(void)
{
    static const char text[] = "error 34: servo 1: 0x1F is the second byte of GOAL_POSITION, whose "
                               "address is 0x1E; 'read' and 'write' take single bytes\r\n";
    static const char *const lines[][2] = {{"set 1 0x1F 0", text}, {"get 1 31", text}};

    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_move_beyond_limits_of_the_servo_prints_them(void)
{
    static const uint8_t look[19] = {205, 0, 0x32, 3};

    robot_add(&robot, 1);
    reply_to("move 1 20");
    answer(1, 0, look, sizeof look);
    port_fake_transmit(&bus.link, 0);
    answer(1, CDS_ERROR_ANGLE, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("error 23: servo 1: angle limit error; CW_ANGLE_LIMIT to "
                             "CCW_ANGLE_LIMIT are 60.117deg to 239.883deg\r\n",
                             said);
}

void test_release_of_one_servo_after_a_stop_says_without_id(void)
{
    static const char text[] = "stopped: driving is inhibited; remove the cause, 'release' "
                               "without an ID\r\n";

    robot_add(&robot, 1);
    robot_add(&robot, 2);
    robot_inhibit(&robot);
    TEST_ASSERT_NOT_NULL(strstr(reply_to("release 1"), text));
    TEST_ASSERT_NOT_NULL(strstr(reply_to("release all"), text));
    TEST_ASSERT_NOT_NULL(strstr(said, "\nservo 2: stopped: driving is inhibited\r\nerror 87: "));
}

void test_group_with_a_silent_servo_says_so_after_a_scan(void)
{
    static const char note[] = "group 1 9 8 sync\r\nno answer now from servo 9 8: 'ping 9'; if not "
                               "there: 'servos forget 9', then 'group' without it\r\nok\r\n";

    settings.echo = SETTINGS_ECHO_PERSON;
    robot_add(&robot, 1);
    robot.states[0].presence = CDS_PRESENCE_ONLINE;
    TEST_ASSERT_NULL(strstr(reply_to("group 1 9"), "servo 9"));
    robot.unlisted = 0;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("group 1 9 8"), note));
    robot.states[1].presence = CDS_PRESENCE_ONLINE;
    TEST_ASSERT_NULL(strstr(reply_to("group 1 9"), "servo 9"));
}
