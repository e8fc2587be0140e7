/* SPDX-License-Identifier: MIT */
/* Completion by Tab behind a number, a name or a list. */
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

void test_tab_behind_a_number_offers_the_next_word(void)
{
    static const char *const cases[][2] = {
        {"monitor 1 every 50 as plot ", "monitor 1 every 50 \t\t"},
        {"monitor 1,2 every 50ms as ", "monitor 1,2 every 50ms a\t"},
        {"monitor 1 as plot every ", "monitor 1 as plot \t"},
        {"monitor 1 every ", "monitor 1 e\t"},
        {"factory 1 force ", "factory 1 \t"},
        {"play walk times 3 at ", "play walk times 3 \t"},
        {"sequence walk add near 500 dwell ", "sequence walk add near 500 d\t"},
        {"sequence walk add near 500 pass ", "sequence walk add near 500 p\t"},
        {"pose 90 45 at ", "pose 90 45 a\t"},
        {"group 1 2 sync ", "group 1 2 s\t"},
        {"servos forget ", "servos \t"},
        {"settings autostart walk loop ", "settings autostart walk \t"},
    };

    for (uint8_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        assert_line(cases[i][0], cases[i][1]);
    TEST_ASSERT_EQUAL_STRING("monitor 1 \r\nevery  as  \r\nmonitor 1 ", typed("monitor 1 \t"));
}
