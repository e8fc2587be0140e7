/* SPDX-License-Identifier: MIT */
/* Errors that name servo, argument, value and allowed range. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_setting_out_of_range_names_its_range(void)
{
    assert_reply("error 33: VALUE 255 is out of range: 0 to 254\r\n", "settings bus_baud 255");
    assert_reply("error 33: VALUE 3000000 is out of range: 7843 to 2000000bps\r\n",
                 "settings bus_baud 3000000");
    assert_reply("error 33: VALUE 70000 is out of range: 0 to 65535\r\n",
                 "settings link_loss_ms 70000");
}

void test_settings_bus_baud_takes_bits_per_second(void)
{
    reply_to("settings bus_baud 500000");
    TEST_ASSERT_EQUAL_UINT8(3, settings.bus_baud);
    reply_to("settings bus_baud 250kbps");
    TEST_ASSERT_EQUAL_UINT8(7, settings.bus_baud);
    reply_to("settings bus_baud 16");
    TEST_ASSERT_EQUAL_UINT8(16, settings.bus_baud);
    reply_to("settings host_baud 115200");
    TEST_ASSERT_EQUAL_UINT8(16, settings.host_baud);
}

void test_id_out_of_range_names_no_servo(void)
{
    assert_reply("error 33: ID 255 is out of range: 0 to 253\r\n", "info 255");
    assert_reply("error 33: ID|254 255 is out of range: 0 to 254\r\n", "ping 255");
    assert_reply("error 33: ID... 300 is out of range: 0 to 253\r\n", "group 1 300");
    assert_reply("error 33: servo 1: NEW 254 is out of range: 0 to 253\r\n", "id 1 254");
}

void test_wrong_word_names_the_words_of_all_rows(void)
{
    assert_reply("error 38: 'begin' where 'wait|off|at' is due: unknown word; 'help motion' shows",
                 "motion begin");
    assert_reply("error 38: 'app' where 'new|add|show|set|insert|delete' is due: unknown word; ",
                 "sequence s app");
    assert_reply("error 38: 'quick' where 'at|times|loop' is due: unknown word; ", "play s quick");
    assert_reply("error 38: 'maybe' where 'on|off' is due: unknown word; ", "teach maybe");
}

void test_wrong_word_is_quoted(void)
{
    assert_reply("error 30: 'frob': unknown command; ", "frob 1 2");
    assert_reply("error 32: servo 1: ANGLE 'x': not a number; ", "move 1 x 30rpm");
    assert_reply("error 34: servo 1: REG 'GOAL': unknown register; ", "get 1 GOAL");
    assert_reply("error 34: servo 1: REG '=LED': unknown register; ", "get 1 =LED");
    assert_reply("error 38: servo 1: 'maybe' where 'on|off' is due: unknown word; ", "led 1 maybe");
    assert_reply("error 38: 'often' where 'every|as plot' is due: unknown word; ",
                 "monitor 1 often 9");
    assert_reply("error 60: SETTING 'colour': unknown setting; ", "settings colour 1");
    assert_reply("error 41: ID... '1': an ID is given twice; ", "group 1 2 1");
    assert_reply("error 41: ID '1': an ID is given twice; ", "torque 1 1 on");
    assert_reply("error 33: ID 300 is out of range: 0 to 253", "torque 1 300 on");
    assert_reply("error 31: wrong number of arguments; ", "cycle off 3");
    assert_reply("error 32: ID|254 'off': try 'torque 1 off', 'torque all off'\r\n", "torque off");
    assert_reply("error 30: 'a?b': unknown command; ", "a\x07"
                                                       "b c");
}

void test_wrong_unit_names_number(void)
{
    assert_reply("error 39: servo 1: ANGLE 90rpm: wrong unit; ", "move 1 90rpm");
    assert_reply("error 39: servo 1: VALUE 6C: wrong unit; ", "set 1 MIN_VOLTAGE 6C");
}

void test_error_of_servo_names_servo(void)
{
    reply_to("ping 9");
    port_fake.now_us += 1000000;
    type("");
    TEST_ASSERT_EQUAL_STRING_LEN("error 2: servo 9: no reply by the deadline; ", said, 44);
    assert_reply("error 48: servo 9: not one of the robot's servos; ", "release 9");
}

void test_refusal_names_servo_in_place_of_word_servo(void)
{
    reply_to("write 1 LED 1");
    answer(1, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL_STRING_LEN("error 21: servo 1: range error; ", said, 32);
}

void test_error_without_servo_stays_as_it_is(void)
{
    assert_reply("error 31: wrong number of arguments; ", "ping");
    assert_reply("error 45: no group chosen; ", "pose 90");
    assert_reply("error 40: too many servos; at most 8\r\n", "monitor 1-9");
    assert_reply("error 37: malformed block; ", "sync LED 1 1:1,2");
}

void test_word_of_earlier_line_is_not_named(void)
{
    assert_reply("error 32: servo 1: ANGLE 'x': not a number; ", "move 1 x");
    assert_reply("error 31: wrong number of arguments; ", "move 1");
    TEST_ASSERT_EQUAL_STRING("cds55xx 0.1.0 host\r\nok\r\n", reply_to("version"));
}
