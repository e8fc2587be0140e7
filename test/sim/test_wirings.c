/* SPDX-License-Identifier: MIT */
/* The same bus on fewer pins: one enable, TXD and RXD tied to the wire, adapters; and what the
 * firmware reads from RXD. */
#include "simulator.h"

static struct run run;

void setUp(void)
{
}

void tearDown(void)
{
}

static void simulate_on(const char *board, const char *firmware)
{
    char arguments[512];
    snprintf(arguments, sizeof(arguments),
             "firmware %s/%s.elf --board test/boards/%s --servos 1 --seconds 0.5 --host stdout",
             environment("FIRMWARE", "build/firmware"), firmware, board);
    simulate(&run, arguments);
}

static void assert_breaks(const char *rule)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(1, run.status, run.output);
    assert_says(&run, rule);
}

static void assert_silent_on(const char *rule)
{
    TEST_ASSERT_NULL_MESSAGE(strstr(run.output, rule), run.output);
}

/* Clearing TXEN during a byte cuts nothing. The driver turns off in the cycle in which the servo
 * begins. */
void test_tied_pins_receive_echo_and_reply_without_return_delay(void)
{
    simulate_on("tied", "tied_good");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "whole"));
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "echo"));
    assert_says(&run, "9 packets in, 8 out, 0 damaged");
}

void test_a_tied_txd_must_not_be_an_output(void)
{
    simulate_on("tied", "tied_txd_output");
    assert_breaks("BROKEN:  txd-output");
    assert_says(&run, "a servo began while TXD drove the wire");
}

void test_with_tied_pins_a_receiver_enabled_late_loses_a_reply(void)
{
    simulate_on("tied", "tied_receiver_off");
    assert_breaks("BROKEN:  reply-lost");
    assert_says(&run, "a servo's byte began while RXEN was off");
}

void test_with_tied_pins_txen_drives_the_wire(void)
{
    simulate_on("tied", "tied_driver_kept");
    assert_breaks("BROKEN:  two-drivers");
    assert_silent_on("txd-output");
}

void test_one_enable_turns_both_buffers(void)
{
    simulate_on("one-enable", "one_enable_good");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    TEST_ASSERT_EQUAL_INT(8, figure(&run, "whole"));
    TEST_ASSERT_EQUAL_INT(0, figure(&run, "echo"));
}

void test_one_enable_kept_high_is_two_drivers_and_a_lost_reply(void)
{
    simulate_on("one-enable", "one_enable_kept");
    assert_breaks("BROKEN:  two-drivers");
    assert_breaks("BROKEN:  reply-lost");
    assert_says(&run, "a servo's byte began while the RX enable was off");
    assert_silent_on("both-enables");
}

/* --- adapters that find the direction by themselves --- */

static void assert_good(const char *board, const char *firmware, int echo)
{
    simulate_on(board, firmware);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    TEST_ASSERT_EQUAL_INT_MESSAGE(8, figure(&run, "whole"), board);
    TEST_ASSERT_EQUAL_INT_MESSAGE(echo, figure(&run, "echo"), board);
    assert_says(&run, "9 packets in, 8 out, 0 damaged");
}

void test_adapter_needs_no_enable_pin(void)
{
    assert_good("adapter", "adapter_good", 0);
    assert_good("adapter-echo", "adapter_good", 8);
}

/* The pin of a missing enable, and a receiver that is off meanwhile, have no effect. */
void test_adapter_works_with_firmware_for_one_enable(void)
{
    assert_good("adapter", "one_enable_good", 0);
    assert_good("adapter-echo", "one_enable_good", 0);
}

void test_adapter_breaks_a_reply_without_return_delay(void)
{
    simulate_on("adapter", "tied_good");
    assert_breaks("BROKEN:  two-drivers");
    assert_breaks("BROKEN:  reply-lost");
    assert_says(&run, "a servo began while the adapter held the wire");
    assert_silent_on("early-release");
    simulate_on("adapter-echo", "tied_good");
    assert_breaks("BROKEN:  two-drivers");
    assert_silent_on("reply-lost");
}

static void assert_between(int low, int high, int value)
{
    TEST_ASSERT_TRUE_MESSAGE(low <= value && value <= high, run.output);
}

/* 160 cycles a byte and 16 cycles of hold. The firmware detects the end a little later. */
void test_adapter_drives_until_1_us_after_the_stop_bit(void)
{
    char arguments[512];
    snprintf(arguments, sizeof(arguments),
             "firmware %s/adapter_release.elf --board test/boards/adapter --seconds 0.1 "
             "--host stdout --fault 'stuck low'",
             environment("FIRMWARE", "build/firmware"));
    simulate(&run, arguments);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    assert_between(176, 188, figure(&run, "one"));
    assert_between(336, 348, figure(&run, "two"));
}

void test_adapter_drives_when_txd_floats(void)
{
    simulate_on("adapter", "adapter_txd_floats");
    assert_breaks("BROKEN:  floating-txd");
    assert_silent_on("floating-rxd");
}

/* After a reset during the run all pins float until the firmware sets them. */
void test_txd_may_float_until_a_reset_chip_drives_it(void)
{
    simulate_on("adapter", "watchdog");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    assert_says(&run, "rules:   none broken");
}

void test_adapter_with_echo_and_receiver_off_loses_the_reply(void)
{
    simulate_on("adapter-echo", "tied_receiver_off");
    assert_breaks("BROKEN:  reply-lost");
    assert_says(&run, "a servo's byte began while RXEN was off");
}

/* --- the level of RXD --- */

static void assert_levels(const char *board, const char *options, int idle, int shut, int talk)
{
    char arguments[512];
    snprintf(arguments, sizeof(arguments),
             "firmware %s/pin_level.elf --board %s --servos 1 --seconds 0.5 --host stdout %s",
             environment("FIRMWARE", "build/firmware"), board, options);
    simulate(&run, arguments);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, run.status, run.output);
    TEST_ASSERT_EQUAL_INT_MESSAGE(idle, figure(&run, "idle"), board);
    TEST_ASSERT_EQUAL_INT_MESSAGE(shut, figure(&run, "shut"), board);
    TEST_ASSERT_EQUAL_INT_MESSAGE(talk, figure(&run, "talk"), board);
}

/* All five ways to read PIND agree. Behind a buffer that is off the AVR's pull-up applies. */
void test_pin_register_shows_the_level_behind_the_receive_buffer(void)
{
    assert_levels("atmega128", "", 5, 5, 5);
    assert_levels("atmega128", "--fault 'stuck low'", 0, 5, 5);
    assert_levels("test/boards/one-enable", "", 5, 5, 5);
    assert_levels("test/boards/one-enable", "--fault 'stuck low'", 0, 5, 5);
}

void test_pin_register_shows_the_wire_to_tied_pins(void)
{
    assert_levels("test/boards/tied", "", 5, 5, 0);
    assert_levels("test/boards/tied", "--fault 'stuck low'", 0, 0, 0);
    assert_levels("test/boards/tied", "--fault 'stuck high'", 5, 5, 5);
}

void test_pin_register_shows_the_receive_side_of_an_adapter(void)
{
    assert_levels("test/boards/adapter", "", 5, 5, 5);
    assert_levels("test/boards/adapter", "--fault 'stuck low'", 0, 0, 5);
    assert_levels("test/boards/adapter-echo", "", 5, 5, 0);
    assert_levels("test/boards/adapter-echo", "--fault 'stuck low'", 0, 0, 0);
}

/* FF FF 01 02 00 FC: the numbers of successive 0 bits. */
void test_pin_register_follows_every_edge_of_a_reply(void)
{
    static const int lows[] = {1, 1, 1, 7, 2, 6, 9, 3};
    char name[] = "low0";
    simulate_firmware(&run, "pin_edges", "--host stdout");
    for (unsigned i = 0; i < sizeof(lows) / sizeof(lows[0]); i++) {
        name[3] = (char)('0' + i);
        TEST_ASSERT_EQUAL_INT_MESSAGE(lows[i], figure(&run, name), run.output);
    }
}
