/* What --times tells, on the firmware times.c, which says how long everything in it takes. */
#include "sim/simulator.h"

#define FILE_NAME "/tmp/cds55xx-test-times"

static struct run run;
static char text[4096];

void setUp(void)
{
    simulate_firmware(&run, "times", "--times " FILE_NAME " --stamp B");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    FILE *file = fopen(FILE_NAME, "r");
    TEST_ASSERT_NOT_NULL(file);
    text[fread(text, 1, sizeof(text) - 1, file)] = 0;
    fclose(file);
    remove(FILE_NAME);
}

void tearDown(void)
{
}

/* The line that begins so, its numbers into `number`; returns how many there are. */
static unsigned line(const char *start, unsigned long number[static 6])
{
    const char *at = strstr(text, start);
    TEST_ASSERT_NOT_NULL_MESSAGE(at, text);
    return (unsigned)sscanf(at + strcspn(at, " "), "%lu %lu %lu %lu %lu %lu", &number[0],
                            &number[1], &number[2], &number[3], &number[4], &number[5]);
}

void test_the_steps_of_a_pin(void)
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
    TEST_ASSERT_EQUAL_UINT(0, down[3]); // no handler yet
    TEST_ASSERT_NULL(strstr(second + 1, "pin "));
}

void test_handlers_without_those_within(void)
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

void test_the_sums_of_the_run(void)
{
    unsigned long number[6];
    TEST_ASSERT_EQUAL_UINT(3, line("run ", number));
    TEST_ASSERT_GREATER_THAN(4000 * 4, number[0]);
    TEST_ASSERT_EQUAL_UINT(72 + 31, number[1]);
}

void test_what_cannot_be_had_is_refused(void)
{
    static const char *const bad[] = {"--times /no/such/folder/x", "--stamp B",
                                      "--times " FILE_NAME " --stamp H",
                                      "--times " FILE_NAME " --stamp B0"};
    for (unsigned i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        simulate_firmware(&run, "times", bad[i]);
        TEST_ASSERT_EQUAL_INT_MESSAGE(2, run.status, bad[i]);
    }
    remove(FILE_NAME);
}
