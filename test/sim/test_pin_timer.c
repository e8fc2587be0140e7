/* SPDX-License-Identifier: MIT */
/* --mark: how long a pin is high, on the firmware marks.c. */
#include "simulator.h"

static struct run run;

void setUp(void)
{
}

void tearDown(void)
{
}

void test_mark_times_a_pin_to_the_cycle_without_handlers(void)
{
    simulate_firmware(&run, "marks", "--mark B0");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    assert_says(&run, "PB0 high ");
    assert_says(&run, "3 times, 1000 cycles at most, 1900 in all\n");
}

void test_mark_pin_high_at_the_end_counts_until_the_end(void)
{
    simulate_firmware(&run, "marks", "--mark B1");
    const char *line = strstr(run.output, "mark: ");
    unsigned long cycles = 0;
    TEST_ASSERT_NOT_NULL_MESSAGE(line, run.output);
    TEST_ASSERT_EQUAL_INT(1, sscanf(strstr(line, "at most, "), "at most, %lu", &cycles));
    TEST_ASSERT_GREATER_THAN(500 + 4000 * 4, cycles); // see end() in chip.h
    assert_says(&run, "1 times");
}

void test_without_mark_nothing_is_printed(void)
{
    simulate_firmware(&run, "marks", "");
    TEST_ASSERT_NULL_MESSAGE(strstr(run.output, "mark:"), run.output);
}

void test_mark_of_a_missing_pin_is_refused(void)
{
    static const char *const bad[] = {"H0", "B8", "B", "B00", "x"};
    for (unsigned i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        char option[32];
        snprintf(option, sizeof(option), "--mark %s", bad[i]);
        simulate_firmware(&run, "marks", option);
        TEST_ASSERT_EQUAL_INT_MESSAGE(2, run.status, bad[i]);
        assert_says(&run, "the chip has no such pin");
    }
}
