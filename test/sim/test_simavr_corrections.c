/* SPDX-License-Identifier: MIT */
/* What the exact USART corrects. Each small firmware shows simavr's error with `--usart stock` and
 * the data sheet's behaviour with `--usart exact`. Figures are cycles and contain the time of the
 * measurement. */
#include "simulator.h"

static struct run exact;
static struct run stock;

void setUp(void)
{
}

void tearDown(void)
{
}

static void run_both(const char *firmware)
{
    simulate_firmware(&exact, firmware, "--host stdout --usart exact");
    simulate_firmware(&stock, firmware, "--host stdout --usart stock");
}

static void assert_between(int low, int high, int value)
{
    TEST_ASSERT_GREATER_OR_EQUAL_INT(low, value);
    TEST_ASSERT_LESS_OR_EQUAL_INT(high, value);
}

void test_a_byte_takes_160_cycles_not_176(void)
{
    run_both("byte_time");
    assert_between(160, 172, figure(&exact, "cycles"));
    assert_between(176, 188, figure(&stock, "cycles"));
}

void test_udr_is_free_once_its_byte_is_in_the_shift_register(void)
{
    run_both("double_buffer");
    assert_between(1, 16, figure(&exact, "first"));
    assert_between(160, 176, figure(&exact, "second"));
    assert_between(176, 188, figure(&stock, "first"));
    assert_between(352, 376, figure(&stock, "second"));
}

static void run_to_transcript(struct run *run, const char *usart)
{
    char options[128];
    snprintf(options, sizeof(options), "--echo --usart %s", usart);
    simulate_firmware(run, "full_write", options);
}

void test_a_byte_written_to_a_full_udr_is_ignored(void)
{
    run_to_transcript(&exact, "exact");
    run_to_transcript(&stock, "stock");
    assert_says(&exact, "->in: 11 22 (LEN:002)");
    assert_says(&exact, "lost-write");
    TEST_ASSERT_EQUAL_INT(1, exact.status);
    assert_says(&stock, "->in: 11 22 33 (LEN:003)");
    TEST_ASSERT_EQUAL_INT(0, stock.status);
}

void test_txc_comes_once_at_the_end_of_the_last_byte(void)
{
    run_both("one_txc");
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "interrupts"));
    assert_between(5 * 160, 5 * 160 + 40, figure(&exact, "last"));
    TEST_ASSERT_EQUAL_INT(5, figure(&stock, "interrupts"));
}

void test_the_transmitter_is_off_after_reset(void)
{
    run_both("reset_state");
    TEST_ASSERT_EQUAL_INT(0x00, figure(&exact, "ucsrb"));
    TEST_ASSERT_EQUAL_INT(0x20, figure(&exact, "ucsra"));
    TEST_ASSERT_EQUAL_INT(0x08, figure(&stock, "ucsrb"));
}

void test_txen_off_and_on_leaves_udr_writable_and_the_byte_whole(void)
{
    run_both("txen_toggle");
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "ready"));
    assert_between(160, 176, figure(&exact, "gone"));
    TEST_ASSERT_EQUAL_INT(0, exact.status);
    TEST_ASSERT_EQUAL_INT(0, figure(&stock, "ready"));
}

void test_txcie_interrupts_if_txc_is_set_already(void)
{
    run_both("txcie_late");
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "interrupts"));
    TEST_ASSERT_EQUAL_INT(0, figure(&exact, "flag")); // the entry of the handler has cleared it
    TEST_ASSERT_EQUAL_INT(0, figure(&stock, "interrupts"));
    TEST_ASSERT_EQUAL_INT(1, figure(&stock, "flag"));
}

void test_a_flag_of_a_timer_is_cleared_alone(void)
{
    run_both("timer_flags");
    TEST_ASSERT_EQUAL_HEX8(0x14, figure(&exact, "before"));
    TEST_ASSERT_EQUAL_HEX8(0x04, figure(&exact, "after"));
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "interrupts"));
    TEST_ASSERT_EQUAL_HEX8(0x14, figure(&stock, "before"));
    TEST_ASSERT_EQUAL_HEX8(0x00, figure(&stock, "after"));
    TEST_ASSERT_EQUAL_INT(0, figure(&stock, "interrupts"));
}

void test_rxc_interrupts_as_long_as_it_is_set(void)
{
    run_both("rx_level");
    assert_between(1, 40, figure(&exact, "when"));
    TEST_ASSERT_EQUAL_INT(20, figure(&exact, "entries"));
    assert_between(60, 200, figure(&stock, "when"));
    TEST_ASSERT_LESS_THAN_INT(10, figure(&stock, "entries"));
}

void test_the_receiver_holds_three_bytes_and_then_overruns(void)
{
    run_both("rx_fifo");
    TEST_ASSERT_EQUAL_INT(3, figure(&exact, "count"));
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "overrun"));
    TEST_ASSERT_EQUAL_HEX8(0xFC, figure(&exact, "last")); // the shift register was overwritten
    assert_says(&exact, "BROKEN:  overrun, 3 times");
    TEST_ASSERT_EQUAL_INT(6, figure(&stock, "count"));
    TEST_ASSERT_EQUAL_INT(0, figure(&stock, "overrun"));
    TEST_ASSERT_EQUAL_INT(0, stock.status);
}

void test_ubrr_and_u2x_count_in_any_order(void)
{
    run_both("ubrr_order");
    assert_between(160, 172, figure(&exact, "cycles"));
    assert_between(352, 364, figure(&stock, "cycles"));
}

void test_entering_a_handler_costs_4_cycles(void)
{
    run_both("interrupt_entry");
    TEST_ASSERT_EQUAL_INT(4, figure(&exact, "when") - figure(&stock, "when"));
}

void test_one_instruction_runs_after_sei(void)
{
    run_both("interrupt_entry");
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "let_in"));
    TEST_ASSERT_EQUAL_INT(0, figure(&stock, "let_in"));
}

void test_a_watchdog_reset_leaves_the_simulation_alive(void)
{
    run_both("watchdog");
    assert_between(160, 172, figure(&exact, "cycles"));
    TEST_ASSERT_EQUAL_INT(0, exact.status);
    assert_between(176, 188, figure(&stock, "cycles"));
}

void test_a_write_to_the_eeprom_takes_8500_us(void)
{
    run_both("eeprom_write");
    assert_between(8500, 8501, figure(&exact, "us"));
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "busy"));
    TEST_ASSERT_EQUAL_INT(0x5A, figure(&exact, "stored"));
    assert_between(0, 10, figure(&stock, "us"));
    TEST_ASSERT_EQUAL_INT(0, figure(&stock, "busy"));
}

void test_the_eeprom_is_locked_while_it_is_written(void)
{
    run_both("eeprom_write");
    TEST_ASSERT_EQUAL_INT(0, figure(&exact, "moved"));
    TEST_ASSERT_EQUAL_INT(1, figure(&stock, "moved"));
}

void test_write_later_than_4_cycles_after_eemwe_is_ignored(void)
{
    run_both("eeprom_write");
    TEST_ASSERT_EQUAL_INT(0, figure(&exact, "late"));
    TEST_ASSERT_EQUAL_INT(0x5A, figure(&exact, "kept"));
}

void test_the_eeprom_halts_the_cpu_4_and_2_cycles(void)
{
    run_both("eeprom_write");
    TEST_ASSERT_EQUAL_INT(4, figure(&exact, "reading") - figure(&stock, "reading"));
    TEST_ASSERT_EQUAL_INT(2, figure(&exact, "starting") - figure(&stock, "starting"));
}

void test_ee_ready_interrupts_as_long_as_no_write_goes_on(void)
{
    run_both("eeprom_write");
    TEST_ASSERT_EQUAL_INT(0, figure(&exact, "early"));
    TEST_ASSERT_EQUAL_INT(3, figure(&exact, "ready"));
    TEST_ASSERT_EQUAL_INT(0, figure(&stock, "ready"));
}

void test_the_eeprom_is_kept_in_a_file(void)
{
    const char *options = "--host stdout --eeprom build/test_eeprom.bin";
    remove("build/test_eeprom.bin");
    simulate_firmware(&exact, "eeprom_keep", options);
    TEST_ASSERT_EQUAL_INT(0, figure(&exact, "starts"));
    simulate_firmware(&exact, "eeprom_keep", options);
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "starts"));
    TEST_ASSERT_EQUAL_INT(0x42, figure(&exact, "marked")); // from the ELF file
}

/* MCUCSR: 1 power-on, 8 watchdog. Flags stay until the firmware clears them. */
void test_flags_of_resets_add_up_until_they_are_cleared(void)
{
    run_both("reset_cause");
    TEST_ASSERT_EQUAL_INT(1, figure(&exact, "first"));
    TEST_ASSERT_EQUAL_INT(1 + 8, figure(&exact, "second"));
    TEST_ASSERT_EQUAL_INT(8, figure(&exact, "third"));
}

void test_each_reset_sets_the_registers_to_their_reset_values(void)
{
    run_both("reset_cause");
    TEST_ASSERT_EQUAL_INT(0, figure(&exact, "pins"));
    TEST_ASSERT_EQUAL_INT(1 << 3, figure(&stock, "pins")); // TXEN, which simavr sets
}

void test_the_watchdog_of_an_atmega128_is_off_after_its_reset(void)
{
    run_both("reset_cause");
    TEST_ASSERT_EQUAL_INT(0, figure(&exact, "dog"));
    TEST_ASSERT_EQUAL_INT(1 << 3, figure(&stock, "dog"));
}

/* --- drivers --- */

static void assert_only_exact_rejects(const char *firmware, const char *rule)
{
    char broken[64];
    run_both(firmware);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, stock.status, stock.output);
    TEST_ASSERT_EQUAL_INT(8, figure(&stock, "whole")); // it appears to work
    TEST_ASSERT_EQUAL_INT(1, exact.status);
    snprintf(broken, sizeof(broken), "BROKEN:  %s,", rule);
    assert_says(&exact, broken);
}

void test_a_correct_driver_is_accepted_by_both(void)
{
    run_both("driver_good");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, exact.status, exact.output);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, stock.status, stock.output);
    TEST_ASSERT_EQUAL_INT(8, figure(&exact, "whole"));
    TEST_ASSERT_EQUAL_INT(8, figure(&stock, "whole"));
}

void test_mutant_that_releases_on_udre(void)
{
    assert_only_exact_rejects("mutant_release_on_udre", "early-release");
}

void test_mutant_that_turns_around_late(void)
{
    assert_only_exact_rejects("mutant_late_turnaround", "reply-lost");
}

void test_mutant_that_never_clears_txc(void)
{
    assert_only_exact_rejects("mutant_stale_txc", "early-release");
}

void test_mutant_with_a_slow_handler(void)
{
    assert_only_exact_rejects("mutant_slow_handler", "overrun");
}

void test_mutant_that_releases_late(void)
{
    run_both("mutant_late_release");
    TEST_ASSERT_EQUAL_INT(1, exact.status);
    assert_says(&exact, "BROKEN:  two-drivers,");
}
