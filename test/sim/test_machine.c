/* SPDX-License-Identifier: MIT */
/* Resets of the simulated chip and what they leave. The firmware writes 5A to byte 0 of the EEPROM,
 * and A5 after 8.5 ms. */
#include "avr/machine.h"
#include "unity.h"

#include <sanitizer/lsan_interface.h>
#include <stdlib.h>

#define MS       16000 // cycles
#define MCUCSR   0x54  // of an ATmega128, in the data space
#define PORTB    0x38
#define DDRB     0x37
#define RAM      0x0800
#define EECR     0x3C
#define WDTCSR   0x60 // of an ATmega2560
#define WDE      0x08
#define EEWE     0x02
#define NO_CAUSE MACHINE_RESETS

static struct schedule schedule;
static struct machine machine;
static struct event event, end;
static enum machine_reset cause;
static unsigned resets;

static void set_off(void *context, uint64_t now)
{
    (void)context;
    (void)now;
    machine.avr->data[RAM] = 0x77;
    if (cause != NO_CAUSE) {
        machine_reset(&machine, cause);
    }
}

static void over(void *context, uint64_t now)
{
    (void)context;
    (void)now;
    machine_stop(&machine);
}

static void was_reset(void *context, uint64_t now)
{
    (void)context;
    (void)now;
    resets++;
}

void setUp(void)
{
    const char *folder = getenv("FIRMWARE");
    char path[256];
    snprintf(path, sizeof(path), "%s/eeprom_again.elf", folder ? folder : "build/firmware");
    schedule_init(&schedule);
    TEST_ASSERT_TRUE(
        machine_init(&machine, &schedule, "atmega128", "atmega128", 16000000, path, true));
    machine.on_reset = was_reset;
    resets = 0;
    event_init(&event, set_off, 0);
    event_init(&end, over, 0);
}

void tearDown(void)
{
    machine_free(&machine);
    schedule_free(&schedule);
}

/* Runs until 8 cycles after the reset, before the firmware writes again. */
static void reset_at(uint64_t time, enum machine_reset by)
{
    cause = by;
    schedule_at(&schedule, &event, time);
    schedule_at(&schedule, &end, time + 8);
    TEST_ASSERT_EQUAL_INT(MACHINE_STOPPED, machine_run(&machine));
    TEST_ASSERT_EQUAL_UINT(by != NO_CAUSE, resets);
}

static uint8_t stored(void)
{
    return machine.eeprom.registers->eeprom[0];
}

void test_the_first_start_is_by_power(void)
{
    reset_at(10 * MS, NO_CAUSE);
    TEST_ASSERT_EQUAL_HEX8(1, machine.avr->data[MCUCSR]);
    TEST_ASSERT_EQUAL_HEX8(1, machine.avr->data[PORTB]); // the second write continues
    TEST_ASSERT_EQUAL_HEX8(0x5A, stored());
}

void test_each_cause_of_reset_has_its_flag(void)
{
    reset_at(MS, MACHINE_EXTERNAL);
    TEST_ASSERT_EQUAL_HEX8(1 | 2, machine.avr->data[MCUCSR]); // the old flag stays
}

void test_a_brown_out_has_its_flag(void)
{
    machine.avr->data[MCUCSR] = 0;
    reset_at(MS, MACHINE_BROWN_OUT);
    TEST_ASSERT_EQUAL_HEX8(4, machine.avr->data[MCUCSR]);
}

void test_a_watchdog_reset_can_be_ordered(void)
{
    machine.avr->data[MCUCSR] = 0;
    reset_at(MS, MACHINE_WATCHDOG);
    TEST_ASSERT_EQUAL_HEX8(8, machine.avr->data[MCUCSR]);
}

void test_power_on_clears_the_other_flags(void)
{
    machine.avr->data[MCUCSR] = 0x0E;
    reset_at(MS, MACHINE_POWER_ON);
    TEST_ASSERT_EQUAL_HEX8(1, machine.avr->data[MCUCSR]);
}

void test_a_reset_frees_the_pins_and_keeps_the_ram(void)
{
    reset_at(10 * MS, MACHINE_EXTERNAL);
    TEST_ASSERT_EQUAL_HEX8(0, machine.avr->data[PORTB]);
    TEST_ASSERT_EQUAL_HEX8(0, machine.avr->data[DDRB]);
    TEST_ASSERT_EQUAL_HEX8(0x77, machine.avr->data[RAM]);
}

void test_loss_of_power_loses_the_ram(void)
{
    reset_at(10 * MS, MACHINE_POWER_ON);
    TEST_ASSERT_EQUAL_HEX8(0, machine.avr->data[RAM]);
}

void test_a_reset_does_not_stop_a_write_to_the_eeprom(void)
{
    reset_at(10 * MS, MACHINE_EXTERNAL);
    TEST_ASSERT_EQUAL_HEX8(EEWE, machine.avr->data[EECR] & EEWE);
    TEST_ASSERT_EQUAL_HEX8(0x5A, stored());
    machine.stop = false;
    schedule_at(&schedule, &end, 17 * MS + 2000); // after 8.5 ms + 8.5 ms
    machine_run(&machine);
    TEST_ASSERT_EQUAL_HEX8(0xA5, stored());
}

void test_power_lost_in_the_first_half_leaves_the_old_byte(void)
{
    reset_at(12 * MS, MACHINE_POWER_ON);
    TEST_ASSERT_EQUAL_HEX8(0x5A, stored());
    TEST_ASSERT_EQUAL_HEX8(0, machine.avr->data[EECR] & EEWE);
}

void test_power_lost_in_the_second_half_leaves_an_erased_byte(void)
{
    reset_at(14 * MS, MACHINE_BROWN_OUT);
    TEST_ASSERT_EQUAL_HEX8(0xFF, stored());
}

/* The second write lasts from 8.5 ms to 17 ms. */
void test_power_lost_before_the_half_leaves_a_byte_half_erased(void)
{
    reset_at(12500 * (MS / 1000), MACHINE_POWER_ON);
    TEST_ASSERT_EQUAL_HEX8(0x5F, stored());
}

void test_power_lost_before_the_end_leaves_a_byte_half_written(void)
{
    reset_at(16600 * (MS / 1000), MACHINE_POWER_ON);
    TEST_ASSERT_EQUAL_HEX8(0xF5, stored());
}

static uint64_t write_start[3];
static unsigned writes;

static void write_begins(void *context, uint64_t start, uint64_t cycles)
{
    (void)context;
    TEST_ASSERT_EQUAL_UINT64(17 * MS / 2, cycles);
    write_start[writes++ % 3] = start;
}

void test_eeprom_write_is_reported_when_it_begins(void)
{
    machine.eeprom.on_write = write_begins;
    writes = 0;
    reset_at(20 * MS, NO_CAUSE);
    TEST_ASSERT_EQUAL_UINT(2, writes);
    TEST_ASSERT_TRUE(write_start[1] - write_start[0] >= 17 * MS / 2);
}

static bool interrupts_on; // this firmware uses none

static void hang(void *context, uint64_t now)
{
    (void)context;
    (void)now;
    machine.avr->sreg[S_I] = interrupts_on;
    machine_hang(&machine);
}

void test_a_hang_lasts_until_a_reset(void)
{
    interrupts_on = true;
    event_init(&event, hang, 0);
    schedule_at(&schedule, &event, MS);
    schedule_at(&schedule, &end, 20 * MS);
    TEST_ASSERT_EQUAL_INT(MACHINE_STOPPED, machine_run(&machine));
    TEST_ASSERT_EQUAL_HEX8(0, machine.avr->data[PORTB]); // the second write was not reached
    TEST_ASSERT_EQUAL_HEX8(0x5A, stored());
    machine.stop = false;
    machine_reset(&machine, MACHINE_EXTERNAL);
    schedule_at(&schedule, &end, 30 * MS);
    TEST_ASSERT_EQUAL_INT(MACHINE_STOPPED, machine_run(&machine));
    TEST_ASSERT_EQUAL_HEX8(1, machine.avr->data[PORTB]);
}

void test_a_hang_waits_until_interrupts_are_on(void)
{
    interrupts_on = false;
    event_init(&event, hang, 0);
    schedule_at(&schedule, &event, MS);
    schedule_at(&schedule, &end, 10 * MS);
    TEST_ASSERT_EQUAL_INT(MACHINE_STOPPED, machine_run(&machine));
    TEST_ASSERT_EQUAL_HEX8(1, machine.avr->data[PORTB]);
}

void test_watchdog_of_a_newer_chip_stays_on_after_its_reset(void)
{
    const char *folder = getenv("FIRMWARE");
    char path[256];
    machine_free(&machine);
    snprintf(path, sizeof(path), "%s/three_buses.elf", folder ? folder : "build/firmware");
    __lsan_disable(); // simavr 1.6 allocates memory in each reset of this chip and never frees it
    TEST_ASSERT_TRUE(
        machine_init(&machine, &schedule, "atmega2560", "atmega2560", 16000000, path, true));
    machine.on_reset = was_reset;
    reset_at(MS, MACHINE_EXTERNAL);
    TEST_ASSERT_EQUAL_HEX8(0, machine.avr->data[WDTCSR] & WDE);
    resets = 0;
    machine.stop = false;
    reset_at(2 * MS, MACHINE_WATCHDOG);
    __lsan_enable();
    TEST_ASSERT_EQUAL_HEX8(WDE, machine.avr->data[WDTCSR] & WDE);
}
