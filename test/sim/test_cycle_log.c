/* SPDX-License-Identifier: MIT */
/* The file of --times, on the firmware times.c, which prints how long its parts take. */
#include <unistd.h>

#include "simulator.h"

static struct run run;
static char text[4096];
static char path[64];
static char more[48]; // options

static void times_of(const char *firmware)
{
    char options[192];
    snprintf(path, sizeof(path), "/tmp/cds55xx-times-%d", (int)getpid());
    snprintf(options, sizeof(options), "--rules warn --times %s --stamp B%s", path, more);
    simulate_firmware(&run, firmware, options);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    FILE *file = fopen(path, "r");
    TEST_ASSERT_NOT_NULL(file);
    text[fread(text, 1, sizeof(text) - 1, file)] = 0;
    fclose(file);
    remove(path);
}

void setUp(void)
{
    more[0] = 0;
    times_of("times");
}

void tearDown(void)
{
}

/* Reads the numbers of the line that begins with `start`. Returns how many there are. */
static unsigned line(const char *start, unsigned long number[static 6])
{
    const char *at = strstr(text, start);
    TEST_ASSERT_NOT_NULL_MESSAGE(at, text);
    return (unsigned)sscanf(at + strcspn(at, " "), "%lu %lu %lu %lu %lu %lu", &number[0],
                            &number[1], &number[2], &number[3], &number[4], &number[5]);
}

void test_stamp_records_each_change_of_a_pin(void)
{
    unsigned long up[6], down[6];
    TEST_ASSERT_EQUAL_UINT(4, line("pin ", up));
    TEST_ASSERT_EQUAL_UINT(0, up[1]);
    TEST_ASSERT_EQUAL_UINT(1, up[2]);
    const char *first = strstr(text, "pin ");
    const char *second = strstr(first + 1, "pin ");
    TEST_ASSERT_NOT_NULL(second);
    TEST_ASSERT_EQUAL_INT(
        4, sscanf(second, "pin %lu %lu %lu %lu", &down[0], &down[1], &down[2], &down[3]));
    TEST_ASSERT_EQUAL_UINT(102, down[0] - up[0]);
    TEST_ASSERT_EQUAL_UINT(0, down[2]);
    TEST_ASSERT_EQUAL_UINT(0, down[3]); // before any handler
    TEST_ASSERT_NULL(strstr(second + 1, "pin "));
}

/* SBI takes two cycles. The instruction after it is in the file too, and none from `to` on. */
void test_steps_records_each_instruction_of_a_span(void)
{
    unsigned long up[6], step[6], then[6];
    TEST_ASSERT_NULL(strstr(text, "step "));
    line("pin ", up);
    snprintf(more, sizeof(more), " --steps %lu-%lu", up[0], up[0] + 3);
    times_of("times");
    TEST_ASSERT_EQUAL_UINT(2, line("step ", step));
    TEST_ASSERT_EQUAL_UINT(up[0], step[0]);
    const char *second = strstr(strstr(text, "step ") + 1, "step ");
    TEST_ASSERT_NOT_NULL(second);
    TEST_ASSERT_EQUAL_INT(2, sscanf(second, "step %lu %lu", &then[0], &then[1]));
    TEST_ASSERT_EQUAL_UINT(up[0] + 2, then[0]);
    TEST_ASSERT_EQUAL_UINT(step[1] + 2, then[1]);
    TEST_ASSERT_NULL(strstr(second + 1, "step "));
}

void test_handler_cycles_exclude_nested_handlers(void)
{
    unsigned long number[6];
    TEST_ASSERT_EQUAL_UINT(4, line("handler 12 ", number)); // TIMER1_COMPA
    TEST_ASSERT_EQUAL_UINT(1, number[1]);
    TEST_ASSERT_EQUAL_UINT(72, number[2]);
    TEST_ASSERT_EQUAL_UINT(72, number[3]);
    TEST_ASSERT_EQUAL_UINT(4, line("handler 13 ", number));
    TEST_ASSERT_EQUAL_UINT(31, number[3]);
}

void test_the_longest_time_with_interrupts_off(void)
{
    unsigned long number[6];
    TEST_ASSERT_EQUAL_UINT(2, line("off ", number));
    TEST_ASSERT_EQUAL_UINT(299, number[0]);
}

void test_a_transmission_its_idle_time_and_the_turnaround(void)
{
    unsigned long number[6];
    TEST_ASSERT_EQUAL_UINT(6, line("sent ", number));
    TEST_ASSERT_EQUAL_UINT(0, number[0]);
    TEST_ASSERT_EQUAL_UINT(460, number[2] - number[1]);
    TEST_ASSERT_EQUAL_UINT(2, number[3]);
    TEST_ASSERT_EQUAL_UINT(140, number[4]);
    TEST_ASSERT_EQUAL_UINT(41, number[5]);
}

void test_turnaround_ends_with_driver_off_and_receiver_on(void)
{
    const char *second = strstr(strstr(text, "sent ") + 1, "sent ");
    unsigned bytes = 0, idle = 0, turned = 0;
    TEST_ASSERT_NOT_NULL_MESSAGE(second, text);
    TEST_ASSERT_EQUAL_INT(3, sscanf(second, "sent 0 %*u %*u %u %u %u", &bytes, &idle, &turned));
    TEST_ASSERT_EQUAL_UINT(1, bytes);
    TEST_ASSERT_EQUAL_UINT(0, idle);
    TEST_ASSERT_EQUAL_UINT(90, turned);
}

void test_interrupts_are_off_from_the_entry_of_a_handler(void)
{
    unsigned long number[6], off[6];
    times_of("marks");
    TEST_ASSERT_EQUAL_UINT(4, line("handler 12 ", number));
    TEST_ASSERT_EQUAL_UINT(2, line("off ", off));
    TEST_ASSERT_GREATER_THAN(100, number[3]);
    TEST_ASSERT_EQUAL_UINT(number[3], off[0]);
}

void test_nested_handlers_each_count_once(void)
{
    unsigned long handler[6], sums[6];
    times_of("nested");
    TEST_ASSERT_EQUAL_UINT(4, line("handler 19 ", handler)); // USART0_UDRE
    TEST_ASSERT_EQUAL_UINT(3, line("run ", sums));
    TEST_ASSERT_EQUAL_UINT(10 + 40, handler[1]);
    TEST_ASSERT_EQUAL_UINT(sums[1], handler[2]);
    TEST_ASSERT_EQUAL_UINT(43, handler[3]); // the innermost, which turns UDRIE off
}

void test_interrupts_off_to_the_end_in_a_handler_count(void)
{
    unsigned long off[6], sums[6];
    times_of("nested");
    TEST_ASSERT_EQUAL_UINT(2, line("off ", off));
    TEST_ASSERT_EQUAL_UINT(3, line("run ", sums));
    TEST_ASSERT_EQUAL_UINT(sums[0], off[1] + off[0]);
    TEST_ASSERT_GREATER_THAN(4000 * 4, off[0]);
}

void test_interrupts_off_to_a_reset_in_a_handler_count(void)
{
    unsigned long off[6], sums[6];
    times_of("hung_handler");
    TEST_ASSERT_EQUAL_UINT(2, line("off ", off));
    TEST_ASSERT_EQUAL_UINT(3, line("run ", sums));
    TEST_ASSERT_UINT_WITHIN(3 * 16000, 16 * 16000, off[0]);
    TEST_ASSERT_LESS_THAN(sums[0], off[1] + off[0]);
    TEST_ASSERT_NULL(strstr(text, "handler 12 ")); // it has not come to its RETI
}

void test_last_line_has_the_sums_of_the_run(void)
{
    unsigned long number[6];
    TEST_ASSERT_EQUAL_UINT(3, line("run ", number));
    TEST_ASSERT_GREATER_THAN(4000 * 4, number[0]);
    TEST_ASSERT_EQUAL_UINT(72 + 31, number[1]);
}

void test_wrong_option_values_are_refused(void)
{
    static const char *const bad[] = {
        "--times /no/such/folder/x",     "--stamp B",   "--times /dev/null --stamp H",
        "--times /dev/null --stamp B0",  "--steps 1-2", "--times /dev/null --steps 5",
        "--times /dev/null --steps 1-2x"};
    for (unsigned i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        simulate_firmware(&run, "times", bad[i]);
        TEST_ASSERT_EQUAL_INT_MESSAGE(2, run.status, bad[i]);
    }
}
