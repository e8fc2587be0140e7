/* SPDX-License-Identifier: MIT */
/* Errors that name what is right: the usage, the limits of a servo. Settings with their units. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_setting_is_taken_and_shown_with_its_unit(void)
{
    static const char *const lines[][2] = {
        {"settings link_loss_ms 0.5s", "ok\r\n"},
        {"settings link_loss_ms", "link_loss_ms = 500 ms\r\nok\r\n"},
        {"settings cycle_us 5000us", "ok\r\n"},
        {"settings cycle_us", "cycle_us = 5000 us\r\nok\r\n"},
        {"settings cycle_us 4.5ms", "ok\r\n"},
        {"settings cycle_us", "cycle_us = 4500 us\r\nok\r\n"},
        {"settings cycle_us 65535us", "ok\r\n"},
        {"settings cycle_us", "cycle_us = 65535 us\r\nok\r\n"},
        {"settings return_delay 4us", "ok\r\n"},
        {"settings return_delay", "return_delay = 2 x 2us\r\nok\r\n"},
    };

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        TEST_ASSERT_EQUAL_STRING(lines[i][1], reply_to(lines[i][0]));
    assert_reply("error 33: VALUE 66s is out of range: 0 to 65535ms\r\n",
                 "settings link_loss_ms 66s");
    assert_reply("error 33: VALUE 1ms is out of range: 2000 to 65535us\r\n",
                 "settings cycle_us 1ms");
    assert_reply("error 33: VALUE 70ms is out of range: 2000 to 65535us\r\n",
                 "settings cycle_us 70ms");
    assert_reply("error 33: VALUE 1000 is out of range: 2000 to 65535\r\n",
                 "settings cycle_us 1000");
    assert_reply("error 33: VALUE 300 is out of range: 0 to 254\r\n", "settings device_id 300");
    assert_reply("error 33: VALUE 70000 is out of range: 0 to 65535\r\n",
                 "settings link_loss_ms 70000");
    assert_reply("error 33: VALUE 600us is out of range: 0 to 508us\r\n",
                 "settings return_delay 600us");
}

void test_change_of_host_rate_warns_a_person_only(void)
{
    static const char warning[] =
        "the host link has the new rate after 'ok'; without 'save' a reset undoes it\r\n";

    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("settings host_baud 255"));
    settings.echo = SETTINGS_ECHO_PERSON;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("settings host_baud 254"), warning));
}

void test_change_of_bus_rate_tells_a_person_of_servos(void)
{
    static const char lines[] = "the bus changed to this rate, 'save' keeps it over power-off; "
                                "servos of the list here: 0; at the "
                                "old rate: 2, until 'bus 1000000bps'\r\nok\r\n";
    static const char none_left[] = "servos of the list here: 0; 'scan' looks for others\r\nok\r\n";

    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("settings bus_baud 500000"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("settings bus_baud 1"));
    robot.health_pauses = true;
    for (uint8_t id = 1; id <= 3; id++)
        robot_add(&robot, id);
    robot.states[0].presence = robot.states[1].presence = CDS_PRESENCE_ONLINE;
    robot.states[2].presence = CDS_PRESENCE_OFFLINE; // answers at no rate
    settings.echo = SETTINGS_ECHO_PERSON;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("settings bus_baud 500000"), lines));
    TEST_ASSERT_NULL(strstr(reply_to("settings bus_baud 500000"), "rate;"));
    TEST_ASSERT_NOT_NULL(strstr(reply_to("bus 250000"), none_left));
}

void test_register_value_out_of_range_names_register_values(void)
{
    assert_reply("error 33: servo 1: ANGLE 2000raw is out of range: 0 to 1023raw\r\n",
                 "move 1 2000raw");
    assert_reply("error 33: servo 1: SPEED 3000raw is out of range: 0 to 2047raw\r\n",
                 "turn 1 3000raw");
    assert_reply("error 33: servo 1: RATE 255raw is out of range: 0 to 254raw\r\n",
                 "baud 1 255raw");
}

void test_wrong_number_of_arguments_shows_usage(void)
{
    assert_reply("error 31: wrong number of arguments; usage: baud ID RATE\r\n", "baud 4");
    assert_reply("error 31: wrong number of arguments; usage: move ID|254 ANGLE [SPEED]\r\n",
                 "move 1");
    assert_reply("error 31: wrong number of arguments; usage: move ID|254 ANGLE [SPEED]; a list of "
                 "servos is one word: 1,2\r\n",
                 "move 2 3 100 20");
}

void test_refusal_of_limits_in_a_list_names_them(void)
{
    const uint8_t registers[28] = {[2] = 0xFF, [3] = 3}; // position mode, off, goal and speed 0

    robot_add(&robot, 4);
    robot_add(&robot, 5);
    reply_to("limits 4 60 200 30rpm");
    reply_to("torque 4 5 on");
    answer(4, 0, registers, sizeof registers);
    TEST_ASSERT_NOT_NULL(strstr(said,
                                "servo 4: its goal is beyond its limits, 60.117deg to 200deg: "
                                "'move 4 ANGLE SPEED' gives it another, "));
}

void test_refusal_of_limits_names_them(void)
{
    robot_add(&robot, 4);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("limits 4 60 200 30rpm"));
    assert_reply("error 11: servo 4: its limits are 60.117deg to 200deg and 3",
                 "write 4 MOVING_SPEED 1000");
    TEST_ASSERT_NOT_NULL(strstr(said, "rpm; 'turn': set no limits; 'torque on': its goal is beyond "
                                      "them, or not read: 'info 4'\r\n"));
    reply_to("servos");
    TEST_ASSERT_NOT_NULL(strstr(said, ", limits 60.117deg to 200deg and 3"));
}
