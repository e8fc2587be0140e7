/* SPDX-License-Identifier: MIT */
/* Lines that are nearly right: the error names the line to type. */
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

void test_word_before_the_id_shows_the_order(void)
{
    static const char *const lines[][2] = {
        {"torque on 1", "error 32: ID|254 'on': the ID comes first: 'torque 1 on'\r\n"},
        {"group sync 1", "error 32: ID... 'sync': the ID comes first: 'group 1 2 3 action'\r\n"},
        {"info on", "error 32: ID 'on': not a number; write IDs: "},
    };

    ASSERT_REPLIES(lines);
}

void test_number_in_place_of_a_word_shows_a_line(void)
{
    static const char *const lines[][2] = {
        {"teach 1 on",
         "error 38: '1' where 'on|off' is due: no number here, as in 'teach on 1 2 3'\r\n"},
        {"cycle 4ms",
         "error 38: '4ms' where 'every|off' is due: no number here, as in 'cycle every 4ms'\r\n"},
        {"pose w 2s",
         "error 38: '2s' where 'in' is due: a time stands behind 'in': 'pose NAME in 2s'\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_on_as_value_of_a_switch_names_the_command(void)
{
    static const char *const lines[][2] = {
        {"set 1 LED on", "error 32: servo 1: VALUE 'on': 1 is on, 0 is off; or 'led 1 on'\r\n"},
        {"write 2 TORQUE_ENABLE off",
         "error 32: servo 2: VALUE... 'off': 1 is on, 0 is off; or 'torque 2 off'\r\n"},
        {"set 1,2 LED on", "error 32: VALUE 'on': not a number; "},
        {"set 1 MOVING_SPEED on", "error 32: servo 1: VALUE 'on': not a number; "},
    };

    ASSERT_REPLIES(lines);
}

void test_comma_behind_an_angle_is_named(void)
{
    static const char *const lines[][2] = {
        {"pose 90, 120", "error 39: ANGLE... '90,': a space, no comma: 90 120\r\n"},
        {"move 1 90deg, 20", "error 39: servo 1: ANGLE '90deg,': a space, no comma: 90 120\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_bare_time_with_decimals_names_seconds(void)
{
    static const char *const lines[][2] = {
        {"pose a in 0.5", "error 32: TIME 0.5ms: has too many decimals of ms; seconds: 0.5s\r\n"},
        {"sequence w new a 1s dwell 0.2", "error 32: TIME 0.2ms: has too many decimals of ms; "},
        {"play w times 1.5", "error 32: N 1.5: has too many decimals\r\n"},
    };

    ASSERT_REPLIES(lines);
}

void test_word_value_for_a_byte_names_the_line_of_both(void)
{
    static const char *const lines[][2] = {
        {"write 1 0x1E 512",
         "error 33: servo 1: VALUE... '512': a byte: 0 to 255; both: 'set 1 30 512raw'\r\n"},
        {"write 1 0x1F 512", "error 33: servo 1: VALUE... 512 is out of range: 0 to 255\r\n"},
        {"write 1 0x1E 5000", "error 33: servo 1: VALUE... 5000 is out of range: 0 to 255\r\n"},
        {"write 1 0x1E 0 512", "error 33: servo 1: VALUE... 512 is out of range: 0 to 255\r\n"},
        {"write 254 0x1E 512", "error 33: VALUE... 512 is out of range: 0 to 255\r\n"},
    };

    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_supply_alarm_names_the_supply_first(void)
{
    robot_add(&robot, 1);
    robot.states[0].presence = CDS_PRESENCE_ONLINE;
    robot.states[0].inhibits = CDS_INHIBIT_STATE_LOST;
    robot.states[0].alarms = CDS_ERROR_VOLTAGE;
    assert_reply("error 12: servo 1: the servo may not be driven; its input voltage is an alarm: "
                 "mend the supply, 'clear', 'release 1'",
                 "set 1 TORQUE_ENABLE 1");
}
