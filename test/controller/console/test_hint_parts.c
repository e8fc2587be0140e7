/* SPDX-License-Identifier: MIT */
/* Hints for a part of a name. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* The line is wrong, and the last line of the reply ends with the hint, and has one hint. */
static void assert_hints(const char *names, const char *line)
{
    char hint[120] = "; did you mean ";
    const char *found;

    reply_to(line);
    strcat(strcat(hint, names), "?\r\n");
    found = strstr(said, "; did you mean ");
    TEST_ASSERT_NOT_NULL_MESSAGE(found, said);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(hint, found, line);
}

void test_part_of_a_register_name_lists_all_that_have_it(void)
{
    assert_hints("MAX_TEMPERATURE or PRESENT_TEMPERATURE", "get 1 temp");
    assert_hints("GOAL_POSITION or PRESENT_POSITION", "get 1 Position");
    assert_hints("MIN_VOLTAGE, MAX_VOLTAGE or PRESENT_VOLTAGE", "set 1 VOLT 6");
    assert_hints("MAX_TEMPERATURE, MAX_VOLTAGE or MAX_TORQUE", "read 1 max");
    assert_hints("PRESENT_LOAD", "get 1 load");
}

void test_part_of_a_setting_or_command_is_hinted_at(void)
{
    assert_hints("host_baud or bus_baud", "settings baud");
    assert_hints("autostart", "settings auto");
    assert_hints("stop", "top");
    assert_hints("counters", "help count");
    assert_hints("forget", "servos forg");
}

void test_word_of_two_letters_lists_the_names_that_begin_so(void)
{
    assert_hints("scan", "sc");
    assert_hints("mode, move, monitor or motion", "mo 1");
    assert_hints("get", "gt 1 LED");
}

void test_word_with_a_wrong_begin_is_searched_behind_it(void)
{
    assert_hints("GOAL_POSITION or PRESENT_POSITION", "get 1 current_position");
}

void test_part_with_one_error_is_hinted_at(void)
{
    assert_hints("GOAL_POSITION or PRESENT_POSITION", "get 1 postion");
    assert_hints("MAX_TEMPERATURE or PRESENT_TEMPERATURE", "get 1 tempreature");
    assert_hints("MIN_VOLTAGE, MAX_VOLTAGE or PRESENT_VOLTAGE", "get 1 volatge");
}

void test_name_near_the_whole_word_is_the_only_hint(void)
{
    assert_hints("PRESENT_SPEED", "get 1 PRESNT_SPEED");
    assert_hints("GOAL_POSITION", "get 1 goalposition");
}

void test_word_without_a_near_name_has_no_hint(void)
{
    static const char *const lines[] = {"get 1 xyzzyq", "get 1 on", "settings colour", "help xyz"};

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        TEST_ASSERT_NULL_MESSAGE(strstr(reply_to(lines[i]), "did you mean"), lines[i]);
}

void test_tab_completes_autostart(void)
{
    settings.echo = 1;
    type("settings auto\t");
    TEST_ASSERT_EQUAL_STRING_LEN("settings autostart ", console.editor.text, 19);
    TEST_ASSERT_EQUAL_UINT8(19, console.editor.length);
}
