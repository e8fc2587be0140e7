/* SPDX-License-Identifier: MIT */
/* What the CPU reads from a pin that is connected to a net: every instruction that can read PINx,
 * on low and high ports of several chips. */
#include "avr/machine.h" // machine_free() frees what simavr does not
#include "avr/pins.h"
#include "unity.h"

#include <simavr/sim_io.h>

#define X 26 // of the data space: r26, r27

enum { BY_IN = 16, BY_LDS, BY_LD, BY_SBIC, BY_SBIS }; // the registers that get the values read

static avr_t *avr;
static uint16_t words;
static struct net net, other_net;
static struct driver driver, other_driver;
static struct pin pin, other_pin;
static struct pin_input input, other_input;

void setUp(void)
{
    net_init(&net);
    net_init(&other_net);
    driver_init(&driver, &net);
    driver_init(&other_driver, &other_net);
}

void tearDown(void)
{
    struct machine machine = {.avr = avr};
    machine_free(&machine);
}

static void put(unsigned word)
{
    avr->flash[2 * words] = (uint8_t)word;
    avr->flash[2 * words + 1] = (uint8_t)(word >> 8);
    words++;
}

/* Writes a loop that reads the register with each instruction that can address it. */
static void write_program(unsigned address, unsigned bit)
{
    unsigned io = address - 0x20;
    words = 0;
    put(0x9000 | BY_LDS << 4);
    put(address);
    avr->data[X] = (uint8_t)address;
    avr->data[X + 1] = (uint8_t)(address >> 8);
    put(0x900C | BY_LD << 4);
    if (io < 0x40) {
        put(0xB000 | (io & 0x30) << 5 | BY_IN << 4 | (io & 0xF));
    }
    if (io < 0x20) {
        put(0xE000 | (BY_SBIC - 16) << 4); // ldi 0
        put(0x9900 | io << 3 | bit);
        put(0xEF0F | (BY_SBIC - 16) << 4); // ldi 255
        put(0xEF0F | (BY_SBIS - 16) << 4);
        put(0x9B00 | io << 3 | bit);
        put(0xE000 | (BY_SBIS - 16) << 4);
    }
    put(0xCFFF); // rjmp to itself
}

static void start(const char *chip, char port, unsigned bit)
{
    avr = avr_make_mcu_by_name(chip);
    TEST_ASSERT_NOT_NULL_MESSAGE(avr, chip);
    avr_init(avr);
    avr->frequency = 16000000;
    TEST_ASSERT_TRUE_MESSAGE(pin_find(&pin, avr, port, bit), chip);
    pin_connect_input(&input, &pin, &net);
    write_program(pin.port->r_pin, bit);
}

static void run(void)
{
    avr->pc = 0;
    while (avr->pc != 2u * words - 2) {
        avr_run(avr);
    }
}

static void assert_read(const char *chip, bool level)
{
    unsigned io = pin.port->r_pin - 0x20u;
    unsigned last = io < 0x20 ? BY_SBIS : BY_LD;
    run();
    for (unsigned by = io < 0x40 ? BY_IN : BY_LDS; by <= last; by++) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(level, avr->data[by] >> pin.bit & 1, chip);
    }
}

static void assert_follows(const char *chip, char port, unsigned bit)
{
    start(chip, port, bit);
    assert_read(chip, true);
    driver_set(&driver, 1, true, false);
    assert_read(chip, false);
    avr->data[pin.port->r_port] = (uint8_t)(1u << bit); // a pull-up against a driver
    assert_read(chip, false);
    driver_enable(&driver, 2, false);
    assert_read(chip, true);
}

void test_PD2_of_an_atmega128(void)
{
    assert_follows("atmega128", 'D', 2);
}

void test_PF0_of_an_atmega128_with_separate_registers(void)
{
    assert_follows("atmega128", 'F', 0);
    TEST_ASSERT_EQUAL_HEX(0x20, pin.port->r_pin); // DDRF and PORTF are 0x61 and 0x62
}

void test_PE0_of_an_atmega128(void)
{
    assert_follows("atmega128", 'E', 0);
}

void test_PH0_of_an_atmega2560(void)
{
    assert_follows("atmega2560", 'H', 0);
    TEST_ASSERT_EQUAL_HEX(0x100, pin.port->r_pin);
}

void test_PJ0_of_an_atmega2560(void)
{
    assert_follows("atmega2560", 'J', 0);
}

void test_PD0_of_an_atmega644p(void)
{
    assert_follows("atmega644", 'D', 0);
}

void test_PD0_of_an_atmega328p(void)
{
    assert_follows("atmega328p", 'D', 0);
}

void test_two_pins_of_one_port_each_have_their_net(void)
{
    start("atmega128", 'D', 2);
    TEST_ASSERT_TRUE(pin_find(&other_pin, avr, 'D', 7));
    pin_connect_input(&other_input, &other_pin, &other_net);
    driver_set(&driver, 1, true, false);
    run();
    TEST_ASSERT_EQUAL_HEX8(0x80, avr->data[BY_IN] & 0x84);
    driver_set(&driver, 2, true, true);
    driver_set(&other_driver, 2, true, false);
    run();
    TEST_ASSERT_EQUAL_HEX8(0x04, avr->data[BY_IN] & 0x84);
}

void test_an_output_reads_as_its_port(void)
{
    start("atmega128", 'D', 2);
    avr->data[pin.port->r_ddr] = 1 << 2;
    assert_read("low", false);
    driver_set(&driver, 1, true, false);
    avr->data[pin.port->r_port] = 1 << 2;
    assert_read("high", true);
}

void test_other_bits_of_the_port_keep_the_value_of_simavr(void)
{
    start("atmega128", 'D', 2);
    avr->data[pin.port->r_ddr] = 0xF0;
    avr->data[pin.port->r_port] = 0xA0;
    run();
    TEST_ASSERT_EQUAL_HEX8(0xA4, avr->data[BY_IN]);
}
