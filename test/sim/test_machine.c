/* Resets of the simulated chip and what they leave; a firmware that writes 5A to byte 0 of the
 * EEPROM, and then A5, from 8.5 ms on. */
#include "machine.h"
#include "unity.h"

#include <stdlib.h>

#define MS       16000 // cycles
#define MCUCSR   0x54  // of an ATmega128, in the data space
#define PORTB    0x38
#define DDRB     0x37
#define RAM      0x0800
#define EECR     0x3C
#define EEWE     0x02
#define NO_CAUSE MACHINE_RESETS

static struct schedule schedule;
static struct machine machine;
static struct event event, end;
static enum machine_reset cause;
static unsigned resets;

static void set_off(void *owner, uint64_t now)
{
    (void)owner;
    (void)now;
    machine.avr->data[RAM] = 0x77;
    if (cause != NO_CAUSE) {
        machine_reset(&machine, cause);
    }
}

static void over(void *owner, uint64_t now)
{
    (void)owner;
    (void)now;
    machine_stop(&machine);
}

static void was_reset(void *owner, uint64_t now)
{
    (void)owner;
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

/* Runs until shortly after the reset, 8 cycles, in which nothing is written anew. */
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
    TEST_ASSERT_EQUAL_HEX8(1, machine.avr->data[PORTB]); // the second write goes on
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

void test_power_lost_in_the_first_half_of_a_write_leaves_the_old_byte(void)
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
