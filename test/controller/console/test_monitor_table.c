/* SPDX-License-Identifier: MIT */
/* The table of `monitor` in place on a terminal: how a key and Ctrl-X end it. */
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
