/* SPDX-License-Identifier: MIT */
/* `help` with words of a heading. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void assert_heading(const char *heading, const char *line)
{
    char begin[40];

    sprintf(begin, "%s:\r\n  ", heading);
    reply_to(line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(begin, said, strlen(begin), line);
}

void test_help_of_a_heading_takes_its_words(void)
{
    static const char *const cases[][2] = {
        {"One servo", "help one servo"},
        {"One servo", "help One"},
        {"Many servos", "help many servos"},
        {"Set-up of servos", "help set-up of servos"},
        {"The bus", "help the bus"},
        {"Instructions of the manual", "help instructions of the manual"},
        {"Instructions of the manual", "help manual"},
        {"The controller", "help the controller"},
        {"The console", "help the console"},
        {"Without a PC", "help without a pc"},
        {"Safety", "help safety"},
    };

    for (uint8_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        assert_heading(cases[i][0], cases[i][1]);
    assert_reply("error 31: wrong number of arguments; usage: help ", "help one foo");
    assert_reply("error 31: wrong number of arguments; usage: help ", "help move servo");
    assert_reply("error 30: COMMAND 'serv': unknown command; ", "help serv");
    reply_to("help bus");
    TEST_ASSERT_NOT_NULL(strstr(said, "Example: bus "));
    TEST_ASSERT_NOT_NULL(strstr(said, "The bus:\r\n"));
    TEST_ASSERT_NULL(strstr(said, "Instructions"));
}

void test_help_of_words_of_two_headings_is_refused(void)
{
    static const char *const lines[] = {"help safety bus", "help the safety bus",
                                        "help the bus safety"};

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_reply("error 31: wrong number of arguments; usage: help ", lines[i]);
}
