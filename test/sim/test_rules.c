/* SPDX-License-Identifier: MIT */
/* Whole runs that must fail with a message: rules of the wire, crashes, bad input. */
#include "wire/rules.h"
#include "simulator.h"

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

void test_a_release_is_early_to_the_cycle(void)
{
    simulate_firmware(&run, "release_edge", "--host stdout");
    assert_says(&run, "BROKEN:  early-release, 5 times:"); // after 159 down to 155 of 160 cycles
    assert_says(&run, "byte 55 was cut 1 cycles before");
    assert_says(&run, "byte 55 was cut 2 cycles before");
}

void test_receiver_off_within_a_reply_is_a_lost_reply(void)
{
    simulate_firmware(&run, "shut_in_reply", "--host stdout");
    assert_says(&run, "reply-lost: the receiver was shut ");
    assert_says(&run, "; harmless only while 'diagnose', 'new', 'ping 254' or a scan at other "
                      "rates runs");
    /* Two breaches: the byte that is cut, and the two bytes that begin after it. */
    assert_says(&run, "BROKEN:  reply-lost, 6 times:");
}

static void collide(const char *line, const char *options)
{
    FILE *script = fopen("build/collision.txt", "w");
    TEST_ASSERT_NOT_NULL(script);
    fprintf(script, "%s\n@wait 5\n", line);
    fclose(script);
    char arguments[120];
    snprintf(arguments, sizeof(arguments), "--script build/collision.txt %s", options);
    simulate_firmware(&run, "collision", arguments);
}

void test_two_replies_at_once_are_a_collision(void)
{
    collide("@servos 1,2", "");
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_broken("collision");
    collide("@servos 1,2", "--allow-duplicates"); // collisions are allowed here
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_broken("collision");
}

void test_servos_of_same_id_need_allow_duplicates(void)
{
    collide("@servos 1,1", "");
    TEST_ASSERT_EQUAL_INT(2, run.status);
    assert_says(&run, "build/collision.txt:1: an ID occurs twice");
    collide("@servos 1,1", "--allow-duplicates");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    assert_says(&run, "rules:   none broken");
}

/* Pings while a servo never stops sending: the controller cannot know. */
void test_collision_with_a_fault_is_no_breach(void)
{
    collide("@fault babble 0", "");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    assert_says(&run, "rules:   none broken");
    assert_says(&run, "faults:  acted 1 times; 0 of 1 orders came to nothing");
}

/* The run ends before or after the script. The firmware listens and never replies. */
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

/* --- bad input: one line, exit 2 --- */

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
    assert_refused("firmware a.elf --board x --fault fly", "--fault: a fault is wanted: flip");
    assert_refused("firmware a.elf --board x --fault 'cut out 1'", "--fault: cut out PACKET BYTES");
    assert_refused("bus --servos 1 --seconds 1 --mark B0", "a bus has no firmware");
    assert_refused("firmware a.elf --board x --seed 4294967296", "--seed wants");
    assert_refused("firmware a.elf --board x --seed -1", "--seed wants");
    assert_refused("firmware a.elf --board x --slow 0", "--slow wants 1 to 100");
    assert_refused("firmware a.elf --board x --slow 101", "--slow wants 1 to 100");
    assert_refused("firmware a.elf --board x --seconds 1 --slow 2", "--slow is for a run in real");
    assert_refused("firmware a.elf --board x --seconds -1", "positive number");
    assert_refused("firmware a.elf --board x", "--seconds is wanted");
}

void test_an_unknown_board_is_refused_with_a_list(void)
{
    assert_refused("firmware a.elf --board toaster --seconds 1", "there are: arbotix ");
    assert_refused("firmware a.elf --board toaster --seconds 1", " arduino-uno atmega128 ");
}

void test_a_missing_elf_is_refused(void)
{
    assert_refused("firmware no-such.elf --board atmega128 --seconds 1",
                   "no-such.elf: No such file or directory; build it with make first");
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
    assert_refused(arguments,
                   "built for atmega128, the board has an atmega2560; --board is to name the board "
                   "of the program");
}

/* A board with an ATmega2561, simulated as an ATmega2560, accepts only ELF files for the
 * ATmega2561. */
void test_elf_must_be_for_the_boards_chip_not_the_simulated_one(void)
{
    assert_refused("firmware build/arduino-mega/controller.elf --board cm510 --seconds 1",
                   "built for atmega2560, the board has an atmega2561");
    assert_refused("firmware build/cm510/controller.elf --board arduino-mega --seconds 1",
                   "built for atmega2561, the board has an atmega2560");
}

void test_an_elf_for_a_bigger_chip_is_refused(void)
{
    assert_refused("firmware build/arduino-mega/controller.elf --board atmega128 --seconds 1",
                   "built for atmega2560, the board has an atmega128");
}

/* Without the note of avr-libc's start-up code the family in the ELF header decides. */
void test_elf_without_a_note_is_checked_by_its_family(void)
{
    TEST_ASSERT_EQUAL_INT(0, system("avr-objcopy -R .note.gnu.avr.deviceinfo "
                                    "build/arduino-mega/controller.elf build/no_note.elf"));
    assert_refused("firmware build/no_note.elf --board atmega128 --seconds 1",
                   "built for a chip of avr-gcc's family avr6, the board's atmega128 is avr51");
}

void test_bad_values_of_options_are_refused(void)
{
    assert_refused("firmware a.elf --board x --seconds 1 --rules maybe", "--rules is fail or warn");
    assert_refused("firmware a.elf --board x --seconds 1 --gdb 65536", "--gdb wants a port");
    assert_refused("firmware a.elf --board x --seconds 1 --servos 7:1", "buses are 0 to 2");
    simulate_firmware(&run, "byte_time", "--servos 1:5");
    TEST_ASSERT_EQUAL_INT(2, run.status);
    assert_says(&run, "atmega128 has 1 bus, counted from 0");
}

void test_an_eeprom_file_of_another_size_is_refused(void)
{
    FILE *file = fopen("build/short_eeprom.bin", "w");
    TEST_ASSERT_NOT_NULL(file);
    fputs("short", file);
    fclose(file);
    simulate_firmware(&run, "byte_time", "--eeprom build/short_eeprom.bin");
    TEST_ASSERT_EQUAL_INT(2, run.status);
    assert_says(&run, "build/short_eeprom.bin: holds 5 bytes, the EEPROM of an atmega128 has 4096");
}

/* --- told, but not failed --- */

void test_rules_warn_prints_breaches_and_the_run_is_good(void)
{
    simulate_firmware(&run, "breaches", "--rules warn");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    assert_says(&run, "both-enables: the controller hears itself");
    assert_says(&run, "WARNING: early-release, 1 times:");
}

void test_with_rules_warn_a_crash_still_fails_the_run(void)
{
    simulate_firmware(&run, "crash_wild", "--rules warn");
    TEST_ASSERT_EQUAL_INT(1, run.status);
    assert_says(&run, "BROKEN:  crash, 1 times:");
}

/* --- several buses --- */

static void simulate_three_buses(const char *options)
{
    char arguments[512];
    snprintf(arguments, sizeof(arguments),
             "firmware %s/three_buses.elf --board arduino-mega --seconds 0.5 "
             "--host stdout %s",
             environment("FIRMWARE", "build/firmware"), options);
    simulate(&run, arguments);
}

void test_three_buses_send_at_once(void)
{
    simulate_three_buses("--servos 1-3 --servos 1:1,5 --servos 2:1 --echo");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "bus0"));
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "bus1"));
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "bus2"));
    assert_says(&run, " bus2 <-out: FF FF 01 02 00 FC (LEN:006)");
}

void test_each_bus_has_its_own_servos(void)
{
    simulate_three_buses("--servos 0:1 --servos 2:2");
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "bus0"));
    TEST_ASSERT_EQUAL_INT(0, figure(&run, "bus1"));
    TEST_ASSERT_EQUAL_INT(0, figure(&run, "bus2"));
}

void test_a_fault_may_be_on_any_bus(void)
{
    simulate_three_buses("--servos 1 --servos 1:1 --servos 2:1 --fault '1:lose out 3 0'");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "bus0"));
    TEST_ASSERT_EQUAL_INT(7, figure(&run, "bus1"));
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "bus2"));
    assert_says(&run, "faults:  bus 1: acted 1 times; 0 of 1 orders came to nothing");
    simulate_three_buses("--fault '3:lose out 1 0'");
    TEST_ASSERT_EQUAL_INT(2, run.status);
    assert_says(&run, "the board has no such bus");
}

void test_breach_names_its_bus_and_fails_the_run(void)
{
    struct rules all;
    struct rules bus;
    char *text = 0;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    rules_init(&all, 16000000, out);
    rules_init_bus(&bus, &all, "bus 1: ");
    rules_record_breach(&bus, RULE_OVERRUN, 16000, "three bytes");
    fclose(out);
    TEST_ASSERT_EQUAL_STRING("rule broken at 16000 (1.000 ms): bus 1: overrun: three bytes\n",
                             text);
    TEST_ASSERT_EQUAL_UINT32(1, rules_broken(&all));
    TEST_ASSERT_TRUE(rules_failed(&all));
    free(text);
}

void test_breach_amid_a_line_begins_a_line_of_its_own(void)
{
    struct rules rules;
    char *text = 0;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    rules_init(&rules, 16000000, out);
    fputs("> pi", out);
    rules.line_is_open = true;
    rules_record_breach(&rules, RULE_OVERRUN, 16000, "three bytes");
    rules_record_breach(&rules, RULE_OVERRUN, 16000, "four bytes");
    fclose(out);
    TEST_ASSERT_EQUAL_STRING("> pi\nrule broken at 16000 (1.000 ms): overrun: three bytes\n"
                             "rule broken at 16000 (1.000 ms): overrun: four bytes\n",
                             text);
    free(text);
}

void test_help_is_no_error(void)
{
    simulate(&run, "--help");
    TEST_ASSERT_EQUAL_INT(0, run.status);
    assert_says(&run, "--usart exact");
}
