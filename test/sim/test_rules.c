/* Whole runs of the simulator that must fail, and say why: rules of the wire, crashes, bad input.
 */
#include "sim/simulator.h"

static struct run run;

void setUp(void)
{
}

void tearDown(void)
{
}

static void assert_broken(const char *rule)
{
    char text[64];
    snprintf(text, sizeof(text), "BROKEN:  %s, 1 times:", rule);
    assert_says(&run, text);
}

void test_each_breach_is_named(void)
{
    simulate_firmware(&run, "breaches", "");
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_broken("both-enables");
    assert_broken("floating-rxd");
    assert_broken("floating-txd");
    assert_broken("transmitter-off");
    assert_broken("driver-off");
    assert_broken("frame-format");
    assert_broken("early-release");
}

void test_two_servos_with_one_id_collide(void)
{
    FILE *script = fopen("build/collision.txt", "w");
    TEST_ASSERT_NOT_NULL(script);
    fputs("@servos 1,1\n@wait 5\n", script);
    fclose(script);
    simulate_firmware(&run, "collision", "--script build/collision.txt");
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_broken("collision");
}

/* Whether the script is over when the run is. The firmware listens, and never says a word. */
void test_a_script_that_does_not_end_fails_the_run(void)
{
    FILE *script = fopen("build/unfinished.txt", "w");
    TEST_ASSERT_NOT_NULL(script);
    fputs("ping 1\n", script);
    fclose(script);
    simulate_firmware(&run, "collision", "--script build/unfinished.txt");
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_broken("script-unfinished");
    assert_says(&run, "build/unfinished.txt:1: --seconds were over");
}

void test_a_bad_script_is_refused_with_file_and_line(void)
{
    FILE *script = fopen("build/bad.txt", "w");
    TEST_ASSERT_NOT_NULL(script);
    fputs("# first\n@fly\n", script);
    fclose(script);
    simulate_firmware(&run, "byte_time", "--script build/bad.txt");
    TEST_ASSERT_EQUAL_INT(2, run.status);
    assert_says(&run, "build/bad.txt:2: unknown @ command");
}

void test_an_interrupt_without_handler_is_a_crash(void)
{
    simulate_firmware(&run, "crash_vector", "");
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_says(&run, "crash: interrupt vector 31 has no handler");
}

void test_a_null_function_pointer_is_a_crash(void)
{
    simulate_firmware(&run, "crash_jump", "");
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_says(&run, "crash: jump to 0");
}

void test_a_jump_out_of_the_code_is_a_crash(void)
{
    simulate_firmware(&run, "crash_wild", "");
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_says(&run, "crash: jump out of the code");
}

/* --- bad input: one line, exit 2 -----------------------------------------------------------------
 */

static void assert_refused(const char *arguments, const char *why)
{
    simulate(&run, arguments);
    TEST_ASSERT_EQUAL_INT_MESSAGE(2, run.status, run.output);
    assert_says(&run, why);
    const char *end = strchr(run.output, '\n');
    TEST_ASSERT_TRUE_MESSAGE(end && end[1] == 0, run.output);
}

void test_bad_usage_is_refused(void)
{
    assert_refused("", "the first word must be");
    assert_refused("firmware", "an ELF file and --board");
    assert_refused("firmware a.elf --board", "a value is missing behind: --board");
    assert_refused("firmware a.elf --board x --colour", "unknown option: --colour");
    assert_refused("firmware a.elf --board x --servos 1-300", "IDs are 0 to 253");
    assert_refused("firmware a.elf --board x --servos 1,1", "an ID occurs twice");
    assert_refused("firmware a.elf --board x --seconds -1", "positive number");
    assert_refused("firmware a.elf --board x", "--seconds is wanted");
}

void test_an_unknown_board_is_refused_with_a_list(void)
{
    assert_refused("firmware a.elf --board toaster --seconds 1",
                   "there are: arduino-mega atmega128");
}

void test_a_missing_elf_is_refused(void)
{
    assert_refused("firmware no-such.elf --board atmega128 --seconds 1",
                   "no-such.elf: No such file");
}

void test_a_file_that_is_no_elf_is_refused(void)
{
    assert_refused("firmware /dev/null --board atmega128 --seconds 1", "not an ELF file");
}

void test_an_elf_for_another_chip_is_refused(void)
{
    char arguments[256];
    snprintf(arguments, sizeof(arguments),
             "firmware %s/byte_time.elf --board arduino-mega --seconds 1",
             environment("FIRMWARE", "build/firmware"));
    assert_refused(arguments, "built for atmega128, the board has an atmega2560");
}

void test_help_is_no_error(void)
{
    simulate(&run, "--help");
    TEST_ASSERT_EQUAL_INT(0, run.status);
    assert_says(&run, "--usart exact");
}
