/* SPDX-License-Identifier: MIT */
/* The modes person, echo and program: banner, prompt, echo, and lines that the console prints by
 * itself. */
#include "typing_rig.h"

void setUp(void)
{
    begin_console();
    settings.echo = 1;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void begin_for_person(void)
{
    settings.echo = SETTINGS_ECHO_PERSON;
    memset(&console, 0, sizeof console);
    console_open(&console, &failsafe, &input, &output);
}

#define BANNER                                                                                     \
    "cds55xx 0.1.0 host\r\nhelp lists the commands, Tab completes them; Ctrl-X stops all "         \
    "servos\r\n"

void test_mode_person_begins_with_banner_and_prompt(void)
{
    begin_for_person();
    type("");
    TEST_ASSERT_EQUAL_STRING(BANNER "\r> ", said);
    TEST_ASSERT_TRUE(console_idle(&console));
}

void test_mode_person_has_a_prompt_after_each_reply(void)
{
    begin_for_person();
    type("");
    TEST_ASSERT_EQUAL_STRING("version\r\ncds55xx 0.1.0 host\r\nok\r\n\r> ", reply_to("version"));
    TEST_ASSERT_EQUAL_STRING("\r\n\r> ", reply_to(""));
    TEST_ASSERT_EQUAL_STRING("pi\r\n\r> \r\n\r> ", reply_to("pi\x03"));
    TEST_ASSERT_EQUAL_STRING("torque 1 o\r\non  off  \r\n\r> torque 1 o", typed("torque 1 o\t"));
}

void test_mode_program_has_bare_replies(void)
{
    begin_for_person();
    reply_to("mode program");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said + strlen(said) - 4);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("echo off"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n\r> ", reply_to("MODE PERSON"));
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_ECHO_PERSON, settings.echo);
}

void test_packet_of_the_host_has_no_prompt_behind_it(void)
{
    char mark[] = {(char)HOST_MARK_DROPPED, '\0'};

    begin_for_person();
    type("");
    said_length = 0;
    said[0] = '\0';
    type(mark);
    type(mark);
    TEST_ASSERT_EQUAL_STRING("", said);
    TEST_ASSERT_TRUE(console_idle(&console));
    type("pin");
    type(mark);
    TEST_ASSERT_EQUAL_STRING("pin", said);
    TEST_ASSERT_TRUE(console_idle(&console));
}

void test_line_that_no_command_asked_for_overwrites_prompt(void)
{
    static const CDS_FLASH char line[] = "host link";

    begin_for_person();
    type("");
    said_length = 0;
    said[0] = '\0';
    TEST_ASSERT_TRUE(console_say(&console, line));
    type("");
    TEST_ASSERT_EQUAL_STRING("\rhost link\r\n\r> ", said);
    reply_to("mode program");
    said_length = 0;
    TEST_ASSERT_TRUE(console_say(&console, line));
    type("");
    TEST_ASSERT_EQUAL_STRING("host link\r\n", said);
}

void test_new_controller_is_in_mode_person(void)
{
    settings_default(&settings);
    memset(&console, 0, sizeof console);
    console_open(&console, &failsafe, &input, &output);
    type("");
    TEST_ASSERT_EQUAL_STRING(BANNER "\r> ", said);
}

void test_mode_echo_shows_keys_without_prompt(void)
{
    begin_for_person();
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("mode echo") + strlen(said) - 4);
    TEST_ASSERT_EQUAL_STRING("torque 1 on\r\n", reply_to("torque 1 on"));
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_ECHO_ON, settings.echo);
}

void test_alarm_overwrites_the_prompt_which_comes_again(void)
{
    begin_for_person();
    type("");
    said_length = 0;
    said[0] = '\0';
    failsafe.alarm = CDS_ERROR_OVERLOAD;
    failsafe.alarm_id = 3;
    type("");
    TEST_ASSERT_EQUAL_CHAR('\r', said[0]);
    TEST_ASSERT_NOT_NULL(strstr(said, "overload"));
    TEST_ASSERT_EQUAL_STRING("\r\n\r> ", said + strlen(said) - 5);
}
