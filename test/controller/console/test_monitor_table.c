/* SPDX-License-Identifier: MIT */
/* The table of `monitor` in place on a terminal, and lines for a plot: how a key and Ctrl-X end
 * them. */
#include "console_rig.h"

#define ROW_1  "servo 1: 0deg 0rpm 0% 0V 0C\x1B[K\r\n"
#define ABSENT ": absent\x1B[K\r\n"
#define TABLE  ROW_1 "servo 8" ABSENT "servo 9" ABSENT

void setUp(void)
{
    begin_console();
    settings.echo = SETTINGS_ECHO_ON;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* Servo 1 answers the packet that leaves. The deadline of the others passes. */
static void go_on(void)
{
    static const uint8_t zero[11];

    if (bus.link.state == CDS_LINK_TALKING) {
        port_fake_transmit(&bus.link, 0);
        if (port_fake.sent[2] == 1)
            port_fake_answer(&bus.link, 1, 0, zero, sizeof zero);
    }
    port_fake.now_us += 20000;
    for (uint8_t i = 0; i < 50; i++)
        turn();
}

static void go_on_until(const char *end)
{
    for (uint8_t i = 0; i < 200; i++) {
        if (said_length >= strlen(end) && strcmp(said + said_length - strlen(end), end) == 0)
            return;
        go_on();
    }
    TEST_FAIL_MESSAGE(said);
}

/* Up to the second table, of which servo 9 is still asked. */
static void draw_within_second_table(void)
{
    type_part("monitor 1 8 9\r");
    go_on_until(TABLE "\x1B[3A" ROW_1 "servo 8" ABSENT);
}

void test_key_within_table_ends_monitor_below_table(void)
{
    draw_within_second_table();
    type_part("p");
    go_on_until("servo 9" ABSENT "2 lines, 4 answers missing\r\nok\r\np");
    TEST_ASSERT_NOT_NULL(strstr(said, TABLE "\x1B[3A" TABLE "2 lines"));
}

void test_ctrl_x_within_table_prints_below_table(void)
{
    draw_within_second_table();
    type_part("\x18");
    for (uint8_t i = 0; i < 100; i++)
        go_on();
    TEST_ASSERT_NOT_NULL(strstr(said, "\x1B[3A" ROW_1 "servo 8" ABSENT "\x1B[1B\rerror 54: "));
}

void test_ctrl_x_in_first_table_moves_no_line(void)
{
    type_part("monitor 1 8 9\r");
    go_on_until(ROW_1 "servo 8" ABSENT);
    type_part("\x18");
    for (uint8_t i = 0; i < 100; i++)
        go_on();
    TEST_ASSERT_NOT_NULL(strstr(said, ROW_1 "servo 8" ABSENT "error 54: "));
}

void test_alarm_between_tables_stands_above_the_next_one(void)
{
    settings.echo = SETTINGS_ECHO_PERSON;
    type_part("monitor 1 8 9\r");
    go_on_until(TABLE);
    failsafe.alarm_id = 1;
    failsafe.alarm = CDS_ERROR_OVERHEATING;
    go_on_until("\x1B[3A\x1B[J\ralarm of servo 1: overheating; 'torque 1 off', unload it; "
                "when cool, 'clear', 'release 1'\r\n" TABLE);
    go_on_until(TABLE "\x1B[3A" TABLE);
}

void test_alarm_within_a_slow_table_does_not_wait_for_the_period(void)
{
    settings.echo = SETTINGS_ECHO_PERSON;
    type_part("monitor 1 every 60s\r");
    go_on_until(ROW_1);
    failsafe.alarm_id = 1;
    failsafe.alarm = CDS_ERROR_CHECKSUM;
    for (uint8_t i = 0; i < 3; i++)
        go_on();
    TEST_ASSERT_NOT_NULL(strstr(said, "\x1B[1A\x1B[J\ralarm of servo 1: checksum"));
    TEST_ASSERT_NOT_NULL(strstr(said, "send it again\r\n" ROW_1));
}

void test_alarm_before_the_first_table_clears_nothing(void)
{
    settings.echo = SETTINGS_ECHO_PERSON;
    failsafe.alarm_id = 1;
    type_part("monitor 1 8 9\r");
    while (console.state == CONSOLE_READING)
        turn();
    failsafe.alarm = CDS_ERROR_CHECKSUM;
    go_on_until(TABLE);
    TEST_ASSERT_NOT_NULL(strstr(said, "9\r\n\ralarm of servo 1: checksum"));
    TEST_ASSERT_NULL(strstr(said, "\x1B[J"));
}

void test_alarm_during_lines_for_a_plot_waits_for_the_end(void)
{
    settings.echo = SETTINGS_ECHO_PERSON;
    type_part("monitor 1 8 9 as plot\r");
    go_on_until("8:absent,9:absent\r\n");
    failsafe.alarm_id = 1;
    failsafe.alarm = CDS_ERROR_CHECKSUM;
    for (uint8_t i = 0; i < 20; i++)
        go_on();
    TEST_ASSERT_NULL(strstr(said, "alarm"));
    type_part("\r");
    for (uint8_t i = 0; i < 20; i++)
        go_on();
    TEST_ASSERT_NOT_NULL(strstr(said, "missing\r\nok\r\n\ralarm of servo 1: checksum"));
}

void test_key_within_a_line_for_a_plot_ends_behind_its_last_value(void)
{
    type_part("monitor 1 8 9 as plot\r");
    go_on_until("9:absent\r\n1deg:0,1rpm:0,1%:0,1V:0,1C:0,8:absent");
    type_part("p");
    go_on_until("8:absent,9:absent\r\n2 lines, 4 answers missing\r\nok\r\np");
}
