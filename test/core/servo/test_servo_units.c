/* SPDX-License-Identifier: MIT */
/* The calls in units: what they put on the line, what they refuse, what they make of replies. */
#include "cds55xx/servo_units.h"

#include <string.h>

#include "cds55xx/control_table.h"
#include "cds55xx/packet.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

#define UNTOUCHED 0x5A5A5A5A

static uint8_t packet[CDS_PACKET_SIZE(5)], reply[11];
static struct cds_request request;

static const struct cds_register_profile *const cds = &cds_profile_cds55xx;
static const struct cds_register_profile *const ax = &cds_profile_ax12;

void setUp(void)
{
    rig_open(0);
    request = (struct cds_request)CDS_REQUEST(packet, reply);
}

void tearDown(void)
{
    rig_check();
}

/* It was accepted: `count` bytes from `address` on went to servo 7, which answers. */
static void assert_writes(enum cds_result submitted, uint8_t address, const uint8_t *data,
                          uint8_t count)
{
    TEST_ASSERT_EQUAL(CDS_OK, submitted);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    TEST_ASSERT_EQUAL_UINT16(count + 7u, port_fake.sent_size);
    TEST_ASSERT_EQUAL_UINT8(7, port_fake.sent[CDS_AT_ID]);
    TEST_ASSERT_EQUAL_HEX8(CDS_WRITE, port_fake.sent[CDS_AT_INSTRUCTION]);
    TEST_ASSERT_EQUAL_HEX8(address, port_fake.sent[CDS_AT_PARAMETERS]);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(data, &port_fake.sent[CDS_AT_PARAMETERS + 1], count);
    port_fake_answer(&bus.link, 7, 0, NULL, 0);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    port_fake_forget();
}

static void assert_writes_byte(enum cds_result submitted, uint8_t address, uint8_t value)
{
    assert_writes(submitted, address, &value, 1);
}

static void assert_writes_word(enum cds_result submitted, uint8_t address, uint16_t value)
{
    uint8_t data[2] = {(uint8_t)value, (uint8_t)(value >> 8)};

    assert_writes(submitted, address, data, 2);
}

static void assert_writes_words(enum cds_result submitted, uint8_t address, uint16_t first,
                                uint16_t second)
{
    uint8_t data[4] = {(uint8_t)first, (uint8_t)(first >> 8), (uint8_t)second,
                       (uint8_t)(second >> 8)};

    assert_writes(submitted, address, data, 4);
}

static void assert_refused(enum cds_result submitted)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, submitted);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, request.result);
}

void test_move(void)
{
    assert_writes_words(cds_servo_units_move_mdeg(&bus, &request, 7, cds, 180000, 31000), 0x1E, 614,
                        512);
    assert_writes_words(cds_servo_units_move_mdeg(&bus, &request, 7, cds, 300000, 62000), 0x1E,
                        1023, 1023);
    assert_writes_words(cds_servo_units_move_mdeg(&bus, &request, 7, ax, 0, 62000), 0x1E, 0, 559);
    assert_writes_words(cds_servo_units_move_mdeg(&bus, &request, 7, cds, 150000, 0), 0x1E, 512, 0);
    assert_writes_words(cds_servo_units_move_mdeg(&bus, &request, 7, cds, 150000, 1), 0x1E, 512, 1);
    assert_refused(cds_servo_units_move_mdeg(&bus, &request, 7, cds, 300001, 0));
    assert_refused(cds_servo_units_move_mdeg(&bus, &request, 7, cds, -1, 0));
    assert_refused(cds_servo_units_move_mdeg(&bus, &request, 7, cds, 0, 62001)); // an AX-12 would
    assert_refused(cds_servo_units_move_mdeg(&bus, &request, 7, ax, 0, 113554));
    assert_refused(cds_servo_units_move_mdeg(&bus, &request, 7, cds, 0, -1));
    assert_refused(cds_servo_units_move_mdeg(&bus, &request, 0xFF, cds, 0, 0));
}

void test_R16_turn(void)
{
    assert_writes_word(cds_servo_units_turn_mrpm(&bus, &request, 7, cds, 62000), 0x20, 0x3FF);
    assert_writes_word(cds_servo_units_turn_mrpm(&bus, &request, 7, cds, -62000), 0x20, 0x7FF);
    assert_writes_word(cds_servo_units_turn_mrpm(&bus, &request, 7, cds, 0), 0x20, 0);
    assert_refused(cds_servo_units_turn_mrpm(&bus, &request, 7, cds, 62001));
    assert_refused(cds_servo_units_turn_mrpm(&bus, &request, 7, cds, -62001));
    assert_refused(cds_servo_units_turn_mrpm(&bus, &request, 7, ax, 1000));
    assert_writes_word(cds_servo_units_turn_cpct(&bus, &request, 7, ax, -10000), 0x20, 0x7FF);
    assert_writes_word(cds_servo_units_turn_cpct(&bus, &request, 7, ax, 2500), 0x20, 256);
    assert_refused(cds_servo_units_turn_cpct(&bus, &request, 7, ax, 10001));
    assert_refused(cds_servo_units_turn_cpct(&bus, &request, 7, cds, 100));
}

void test_limits(void)
{
    assert_writes_words(cds_servo_units_limits_mdeg(&bus, &request, 7, 30000, 270000), 0x06, 102,
                        921);
    assert_writes_words(cds_servo_units_limits_mdeg(&bus, &request, 7, 0, 0), 0x06, 0, 0);
    assert_refused(cds_servo_units_limits_mdeg(&bus, &request, 7, 1000, 999));
    assert_refused(cds_servo_units_limits_mdeg(&bus, &request, 7, -1, 300000));
    assert_refused(cds_servo_units_limits_mdeg(&bus, &request, 7, 0, 300001));
}

void test_torque(void)
{
    assert_writes_byte(cds_servo_units_torque(&bus, &request, 7, true), 0x18, 1);
    assert_writes_byte(cds_servo_units_torque(&bus, &request, 7, false), 0x18, 0);
}

void test_R7_torque_limit_is_an_AX12s_and_ramps_a_CDS55xxs(void)
{
    uint8_t ramps[2] = {255, 3};

    assert_writes_word(cds_servo_units_torque_limit_cpct(&bus, &request, 7, ax, 10000), 0x22,
                       0x3FF);
    assert_refused(cds_servo_units_torque_limit_cpct(&bus, &request, 7, ax, 10001));
    assert_refused(cds_servo_units_torque_limit_cpct(&bus, &request, 7, cds, 100));
    assert_writes(cds_servo_units_ramps(&bus, &request, 7, cds, 255, 3), 0x22, ramps, 2);
    assert_refused(cds_servo_units_ramps(&bus, &request, 7, ax, 255, 3));
}

void test_write_of_any_register_in_its_unit(void)
{
    assert_writes_byte(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_MAX_VOLTAGE, 16000),
                       0x0D, 160);
    assert_writes_byte(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_RETURN_DELAY, 508),
                       0x05, 254);
    assert_writes_word(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_MAX_TORQUE, 5000),
                       0x0E, 512);
    assert_writes_byte(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_ACC, 255), 0x22, 255);
    assert_writes_word(cds_servo_units_write(&bus, &request, 7, ax, CDS_REG_ACC, 10000), 0x22,
                       0x3FF);
    assert_writes_byte(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_BAUD_RATE, 115200),
                       0x04, 16);
    assert_writes_byte(
        cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_CW_COMPLIANCE_MARGIN, 1000), 0x1A, 3);
}

void test_what_the_register_does_not_take_is_not_sent(void)
{
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_TORQUE_ENABLE, 2));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_TORQUE_ENABLE, 256));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_ID, 254));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_PUNCH, 1024));
    assert_refused(
        cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_ACC, 256)); // but an AX-12's
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_RETURN_DELAY, 510));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_GOAL_POSITION, 300001));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_MOVING_SPEED, -1000));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_PRESENT_VOLTAGE, 10000));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_RESERVED_13, 0));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_GOAL_POSITION + 1, 0));
    assert_refused(
        cds_servo_units_write(&bus, &request, 7, ax, CDS_REG_DCC, 0)); // a high byte there
    assert_refused(cds_servo_units_write(&bus, &request, 7, ax, 0x00, 12));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_TABLE_SIZE, 0));
    // between 1 Mbps and 2 Mbps, and just below: more than 3 % off
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_BAUD_RATE, 1500000));
    assert_refused(cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_BAUD_RATE, 1040000));
}

void test_a_request_on_its_way_is_left_alone(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_torque(&bus, &request, 7, true));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_units_move_mdeg(&bus, &request, 7, cds, 0, 0));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_units_turn_mrpm(&bus, &request, 7, cds, 0));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_units_write(&bus, &request, 7, cds, CDS_REG_LED, 1));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    TEST_ASSERT_EQUAL_HEX8(0x18, port_fake.sent[CDS_AT_PARAMETERS]);
}

/* The READ of 0x24 to 0x2E, and its reply: position 614, speed CW 100, load CCW 512, 11.1 V, 40
 * degrees, nothing registered, moving. */
static const uint8_t feedback[11] = {0x66, 0x02, 0x64, 0x04, 0x00, 0x02, 111, 40, 0, 0, 1};

static void read_feedback(const uint8_t *data, uint8_t count)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 7, CDS_REG_PRESENT_POSITION, 11));
    rig_transmit();
    port_fake_answer(&bus.link, 7, count ? 0 : CDS_ERROR_RANGE, data, count);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
}

static int32_t value_at(const struct cds_register_profile *profile, uint8_t address)
{
    int32_t value = UNTOUCHED;

    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servo_units_value(&request, (uint8_t)(address - CDS_REG_PRESENT_POSITION),
                                            profile, address, &value));
    return value;
}

void test_present_values(void)
{
    int32_t mdeg, mrpm, cpct, mV, celsius;

    read_feedback(feedback, sizeof feedback);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_position_mdeg(&request, 0, &mdeg));
    TEST_ASSERT_EQUAL_INT32(180059, mdeg);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_speed_mrpm(&request, 2, cds, &mrpm));
    TEST_ASSERT_EQUAL_INT32(-6061, mrpm);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_speed_mrpm(&request, 2, ax, &mrpm));
    TEST_ASSERT_EQUAL_INT32(-11100, mrpm);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_load_cpct(&request, 4, &cpct));
    TEST_ASSERT_EQUAL_INT32(5005, cpct);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_voltage_mV(&request, 6, &mV));
    TEST_ASSERT_EQUAL_INT32(11100, mV);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_temperature_celsius(&request, 7, &celsius));
    TEST_ASSERT_EQUAL_INT32(40, celsius);
}

void test_values_by_register(void)
{
    read_feedback(feedback, sizeof feedback);
    TEST_ASSERT_EQUAL_INT32(180059, value_at(cds, CDS_REG_PRESENT_POSITION));
    TEST_ASSERT_EQUAL_INT32(-6061, value_at(cds, CDS_REG_PRESENT_SPEED));
    TEST_ASSERT_EQUAL_INT32(5005, value_at(cds, CDS_REG_PRESENT_LOAD));
    TEST_ASSERT_EQUAL_INT32(11100, value_at(cds, CDS_REG_PRESENT_VOLTAGE));
    TEST_ASSERT_EQUAL_INT32(1, value_at(cds, CDS_REG_MOVING));
}

void test_an_AX12s_torque_limit_and_model_are_read_as_such(void)
{
    int32_t value;

    read_feedback(feedback, sizeof feedback); // as if it were from 0x22, or 0x00
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_value(&request, 4, ax, CDS_REG_ACC, &value));
    TEST_ASSERT_EQUAL_INT32(5005, value);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_value(&request, 0, cds, CDS_REG_ACC, &value));
    TEST_ASSERT_EQUAL_INT32(0x66, value);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_units_value(&request, 7, ax, ax->model_address, &value));
    TEST_ASSERT_EQUAL_INT32(40, value);
}

static void assert_no_value(enum cds_result reason)
{
    int32_t value = UNTOUCHED;

    TEST_ASSERT_EQUAL(reason, cds_servo_units_position_mdeg(&request, 0, &value));
    TEST_ASSERT_EQUAL(reason, cds_servo_units_speed_mrpm(&request, 0, cds, &value));
    TEST_ASSERT_EQUAL(reason, cds_servo_units_load_cpct(&request, 0, &value));
    TEST_ASSERT_EQUAL(reason,
                      cds_servo_units_value(&request, 0, cds, CDS_REG_GOAL_POSITION, &value));
    TEST_ASSERT_EQUAL_INT32(UNTOUCHED, value);
}

void test_a_failed_read_is_no_value(void)
{
    int32_t value = UNTOUCHED;

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 7, CDS_REG_PRESENT_POSITION, 11));
    assert_no_value(CDS_PENDING);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake.now_us += 100000;
    while (cds_bus_poll(&bus)) {
        port_fake.now_us += 100000;
    }
    assert_no_value(CDS_TIMEOUT);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_servo_units_voltage_mV(&request, 6, &value));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_servo_units_temperature_celsius(&request, 7, &value));
    read_feedback(NULL, 0); // it refused
    assert_no_value(CDS_REFUSED);
    read_feedback(feedback, sizeof feedback);
    TEST_ASSERT_EQUAL(CDS_REFUSED,
                      cds_servo_units_position_mdeg(&request, 10, &value)); // half of it
    TEST_ASSERT_EQUAL(CDS_REFUSED, cds_servo_units_voltage_mV(&request, 11, &value));
    TEST_ASSERT_EQUAL_INT32(UNTOUCHED, value);
}

void test_what_no_servo_holds_is_no_value(void)
{
    static const uint8_t wild[11] = {0x00, 0x08, 0, 0, 0, 0, 255, 255, 0, 0, 1};
    int32_t value = UNTOUCHED;

    read_feedback(wild, sizeof wild);
    assert_no_value(CDS_CORRUPT);
    TEST_ASSERT_EQUAL(CDS_CORRUPT,
                      cds_servo_units_value(&request, 6, cds, CDS_REG_RETURN_DELAY, &value));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servo_units_value(&request, 6, cds, 0x25, &value));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servo_units_value(&request, 6, cds, 0x32, &value));
    TEST_ASSERT_EQUAL_INT32(UNTOUCHED, value);
}
