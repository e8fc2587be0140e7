/* SPDX-License-Identifier: MIT */
/* Registers in units, every value of each both ways, against arithmetic of the test's own. */
#include "cds55xx/units.h"

#include <string.h>

#include "cds55xx/control_table.h"
#include "unity.h"

#define UNTOUCHED 0x5A5A

/* How far apart the values are that a sweep tries: all of them on the host; the simulated AVR would
 * take minutes. The step is odd, so that it meets every remainder. */
#ifdef __AVR__
#define STEP 97
#else
#define STEP 1
#endif

/* A profile of a caller's own, as fast as one may be. */
static const struct cds_register_profile fastest = {4000000, CDS_UNIT_SIGNED_MRPM, false, 1, 1};
static const struct cds_register_profile slowest = {1023, CDS_UNIT_SIGNED_MRPM, false, 1, 1};

/* Each unit's scale, typed from the manual: register = value x of / per. */
struct unit_case {
    const struct cds_register_profile *profile;
    uint8_t unit;
    bool is_signed;
    uint16_t top; // highest register value, or magnitude
    uint16_t of;
    uint32_t per;
    int32_t highest; // value
};

static const struct unit_case cases[] = {
    {NULL, CDS_UNIT_MDEG, false, 1023, 1023, 300000, 300000},
    {NULL, CDS_UNIT_MARGIN_MDEG, false, 255, 1023, 300000, 74780},
    {&cds_profile_cds55xx, CDS_UNIT_MRPM, false, 1023, 1023, 62000, 62000},
    {&cds_profile_cds55xx, CDS_UNIT_SIGNED_MRPM, true, 1023, 1023, 62000, 62000},
    {&cds_profile_ax12, CDS_UNIT_MRPM, false, 1023, 1, 111, 113553},
    {&cds_profile_ax12, CDS_UNIT_SIGNED_MRPM, true, 1023, 1, 111, 113553},
    {&fastest, CDS_UNIT_SIGNED_MRPM, true, 1023, 1023, 4000000, 4000000},
    {&slowest, CDS_UNIT_SIGNED_MRPM, true, 1023, 1, 1, 1023},
    {NULL, CDS_UNIT_CPCT, false, 1023, 1023, 10000, 10000},
    {NULL, CDS_UNIT_SIGNED_CPCT, true, 1023, 1023, 10000, 10000},
    {NULL, CDS_UNIT_MV, false, 255, 1, 100, 25500},
    {NULL, CDS_UNIT_CELSIUS, false, 255, 1, 1, 255},
    {NULL, CDS_UNIT_US, false, 254, 1, 2, 508},
    {NULL, CDS_UNIT_NUMBER, false, 65535, 1, 1, 65535},
};
#define CASES (sizeof cases / sizeof cases[0])

static int32_t from(const struct cds_register_profile *profile, uint8_t unit, uint16_t raw)
{
    int32_t value = -1;

    TEST_ASSERT_EQUAL(CDS_OK, cds_units_from_register(profile, (enum cds_unit)unit, raw, &value));
    return value;
}

static uint16_t to(const struct cds_register_profile *profile, uint8_t unit, int32_t value)
{
    uint16_t raw = UNTOUCHED;

    TEST_ASSERT_EQUAL(CDS_OK, cds_units_to_register(profile, (enum cds_unit)unit, value, &raw));
    return raw;
}

static void assert_no_register(const struct cds_register_profile *profile, uint8_t unit,
                               int32_t value)
{
    uint16_t raw = UNTOUCHED;

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT,
                      cds_units_to_register(profile, (enum cds_unit)unit, value, &raw));
    TEST_ASSERT_EQUAL_UINT16(UNTOUCHED, raw);
}

static void assert_no_value(const struct cds_register_profile *profile, uint8_t unit, uint16_t raw)
{
    int32_t value = UNTOUCHED;

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT,
                      cds_units_from_register(profile, (enum cds_unit)unit, raw, &value));
    TEST_ASSERT_EQUAL_INT32(UNTOUCHED, value);
}

void setUp(void)
{
}

void tearDown(void)
{
}

void test_units_every_register_value_survives_the_round_trip(void)
{
    for (uint8_t i = 0; i < CASES; i++) {
        const struct unit_case *c = &cases[i];

        for (uint32_t raw = 0; raw <= c->top; raw += c->top > 1023 ? STEP : 1) {
            int32_t value = from(c->profile, c->unit, (uint16_t)raw);
            int64_t off = (int64_t)value * c->of - (int64_t)raw * c->per; // in 1/of

            if (off * 2 > c->of || off * 2 < -(int64_t)c->of ||
                to(c->profile, c->unit, value) != raw)
                TEST_FAIL_MESSAGE("not the nearest, or it did not come back");
        }
        TEST_ASSERT_EQUAL_INT32(0, from(c->profile, c->unit, 0));
        TEST_ASSERT_EQUAL_INT32(c->highest, from(c->profile, c->unit, c->top));
    }
}

void test_R35_bit_10_is_minus_and_comes_back(void)
{
    for (uint8_t i = 0; i < CASES; i++) {
        const struct unit_case *c = &cases[i];

        if (!c->is_signed)
            continue;
        for (uint16_t raw = 1; raw <= c->top; raw++) {
            int32_t value = from(c->profile, c->unit, raw | 0x400);

            if (value != -from(c->profile, c->unit, raw) ||
                to(c->profile, c->unit, value) != (raw | 0x400))
                TEST_FAIL_MESSAGE("not the same with a minus");
        }
        TEST_ASSERT_EQUAL_INT32(0, from(c->profile, c->unit, 0x400)); // as good a zero
        TEST_ASSERT_EQUAL_HEX16(0, to(c->profile, c->unit, 0));
    }
}

/* Nearest in exact arithmetic; of two as near the greater. */
static void assert_nearest(const struct unit_case *c, int32_t magnitude)
{
    uint16_t raw = to(c->profile, c->unit, magnitude);
    int64_t off = (int64_t)raw * c->per - (int64_t)magnitude * c->of; // in 1/per

    if (c->unit == CDS_UNIT_MRPM && magnitude > 0 && raw == 1)
        off = off < (int64_t)c->per ? 0 : off; // all below 1, but 0
    if (off * 2 > (int64_t)c->per || off * 2 <= -(int64_t)c->per)
        TEST_FAIL_MESSAGE("another register value is nearer");
    if (c->is_signed)
        TEST_ASSERT_EQUAL_HEX16(raw ? raw | 0x400 : 0, to(c->profile, c->unit, -magnitude));
}

void test_every_value_becomes_the_nearest_register(void)
{
    for (uint8_t i = 0; i < CASES; i++) {
        int32_t step = cases[i].highest > 300000 ? 13 * STEP : STEP;

        for (int32_t value = 0; value <= cases[i].highest; value += step)
            assert_nearest(&cases[i], value);
        assert_nearest(&cases[i], cases[i].highest);
    }
}

void test_of_two_as_near_the_greater(void)
{
    TEST_ASSERT_EQUAL_UINT16(171, to(NULL, CDS_UNIT_MDEG, 50000)); // 170.5
    TEST_ASSERT_EQUAL_UINT16(170, to(NULL, CDS_UNIT_MDEG, 49999));
    TEST_ASSERT_EQUAL_UINT16(121, to(NULL, CDS_UNIT_MV, 12050));
    TEST_ASSERT_EQUAL_UINT16(120, to(NULL, CDS_UNIT_MV, 12049));
    TEST_ASSERT_EQUAL_UINT16(2, to(NULL, CDS_UNIT_US, 3));
    TEST_ASSERT_EQUAL_HEX16(0x400 | 512, to(NULL, CDS_UNIT_SIGNED_CPCT, -5000)); // 511.5
}

void test_what_is_out_of_range_is_refused(void)
{
    for (uint8_t i = 0; i < CASES; i++) {
        const struct unit_case *c = &cases[i];
        int32_t lowest = c->is_signed ? -c->highest : 0;

        assert_no_register(c->profile, c->unit, c->highest + 1);
        assert_no_register(c->profile, c->unit, lowest - 1);
        for (int32_t far = 0x40000000; far > c->highest; far >>= 1) { // no multiple wraps round
            assert_no_register(c->profile, c->unit, far);
            assert_no_register(c->profile, c->unit, far + c->highest / 2);
            assert_no_register(c->profile, c->unit, -far);
        }
        assert_no_register(c->profile, c->unit, INT32_MAX);
        assert_no_register(c->profile, c->unit, INT32_MIN);
        if (c->top == 65535)
            continue;
        assert_no_value(c->profile, c->unit, c->is_signed ? 0x800 : c->top + 1);
        assert_no_value(c->profile, c->unit, 0xFFFF);
        if (!c->is_signed)
            assert_no_value(c->profile, c->unit, 0x401);
    }
}

void test_what_is_no_unit_is_refused(void)
{
    assert_no_register(&cds_profile_cds55xx, CDS_UNIT_NONE, 0);
    assert_no_value(&cds_profile_cds55xx, CDS_UNIT_NONE, 0);
    assert_no_register(&cds_profile_cds55xx, CDS_UNIT_BPS + 1, 0);
    assert_no_value(&cds_profile_cds55xx, CDS_UNIT_BPS + 1, 0);
}

void test_R8_R10_the_figures_of_the_manuals(void)
{
    TEST_ASSERT_EQUAL_UINT16(0x266, to(NULL, CDS_UNIT_MDEG, 180000)); // R8
    TEST_ASSERT_EQUAL_INT32(293, from(NULL, CDS_UNIT_MDEG, 1));       // R9
    TEST_ASSERT_EQUAL_INT32(61, from(&cds_profile_cds55xx, CDS_UNIT_MRPM, 1));
    TEST_ASSERT_EQUAL_INT32(33300, from(&cds_profile_ax12, CDS_UNIT_SIGNED_MRPM, 300));
    TEST_ASSERT_EQUAL_INT32(10000, from(NULL, CDS_UNIT_MV, 0x64)); // 10 V
    TEST_ASSERT_EQUAL_UINT16(2, to(NULL, CDS_UNIT_US, 4));         // example 8
    TEST_ASSERT_EQUAL_INT32(32, from(NULL, CDS_UNIT_CELSIUS, 0x20));
    TEST_ASSERT_EQUAL_INT32(4995, from(NULL, CDS_UNIT_CPCT, 0x1FF)); // example 12: half
    TEST_ASSERT_EQUAL_UINT8(1, cds_profile_cds55xx.model_number);
    TEST_ASSERT_EQUAL_UINT8(12, cds_profile_ax12.model_number);
}

void test_R10_a_slow_speed_is_not_as_fast_as_it_can(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, to(&cds_profile_cds55xx, CDS_UNIT_MRPM, 0));
    TEST_ASSERT_EQUAL_UINT16(1, to(&cds_profile_cds55xx, CDS_UNIT_MRPM, 1));
    TEST_ASSERT_EQUAL_UINT16(1, to(&cds_profile_ax12, CDS_UNIT_MRPM, 1));
    TEST_ASSERT_EQUAL_UINT16(0, to(&cds_profile_cds55xx, CDS_UNIT_SIGNED_MRPM, 1));  // it stands
    TEST_ASSERT_EQUAL_UINT16(0, to(&cds_profile_cds55xx, CDS_UNIT_SIGNED_MRPM, -1)); // still
}

void test_every_baud_register_and_back(void)
{
    for (int16_t raw = 0; raw <= 254; raw++) {
        int32_t bps = from(NULL, CDS_UNIT_BPS, (uint16_t)raw);
        int32_t off = bps * (raw + 1) - 2000000; // in 1/(raw + 1)

        TEST_ASSERT_TRUE(off * 2 <= raw + 1 && off * 2 > -(raw + 1));
        TEST_ASSERT_EQUAL_UINT16(raw, to(NULL, CDS_UNIT_BPS, bps));
    }
    assert_no_value(NULL, CDS_UNIT_BPS, 255);
    assert_no_value(NULL, CDS_UNIT_BPS, 0xFFFF);
}

/* How far the rate of `divisor` is from `bps`, times divisor: |2000000 - bps x divisor|. Against a
 * neighbour: cross-multiplied. */
static bool is_nearer(int32_t bps, uint16_t divisor, uint16_t than)
{
    int64_t off = 2000000 - (int64_t)bps * divisor;
    int64_t other = 2000000 - (int64_t)bps * than;

    off = off < 0 ? -off : off;
    other = other < 0 ? -other : other;
    return off * than < other * divisor;
}

void test_every_rate_becomes_the_nearest(void)
{
    for (int32_t bps = 7843; bps <= 2000000; bps += bps < 300000 ? STEP : 17 * STEP) {
        uint16_t divisor = (uint16_t)(to(NULL, CDS_UNIT_BPS, bps) + 1);

        if (divisor > 1 && !is_nearer(bps, divisor, divisor - 1))
            TEST_FAIL_MESSAGE("the next faster rate is as near");
        if (divisor < 255 && is_nearer(bps, divisor + 1, divisor))
            TEST_FAIL_MESSAGE("the next slower rate is nearer");
    }
    TEST_ASSERT_EQUAL_UINT16(0, to(NULL, CDS_UNIT_BPS, 1500000)); // halfway: the faster one
    TEST_ASSERT_EQUAL_UINT16(1, to(NULL, CDS_UNIT_BPS, 1499999));
}

static void assert_baud(int32_t bps, uint8_t baud, int16_t error_permille)
{
    uint8_t found = 0x5A;
    int16_t error = UNTOUCHED;

    TEST_ASSERT_EQUAL(CDS_OK, cds_units_baud(bps, &found, &error));
    TEST_ASSERT_EQUAL_UINT8(baud, found);
    TEST_ASSERT_EQUAL_INT16(error_permille, error);
}

void test_R24_the_rates_the_manual_lists_and_their_errors(void)
{
    assert_baud(1000000, 1, 0);
    assert_baud(500000, 3, 0);
    assert_baud(250000, 7, 0);
    assert_baud(115200, 16, 21); // 2.124 %
    assert_baud(57600, 34, -8);  // 0.794 %
    assert_baud(19200, 103, 2);  // 0.160 %
    assert_baud(1500000, 0, 333);
    assert_baud(1499999, 1, -333);
    assert_baud(2000000, 0, 0);
    assert_baud(7843, 254, 0);
    assert_baud(999500, 1, 1);   // 0.50025: up
    assert_baud(999501, 1, 0);   // 0.49925: down
    assert_baud(1000500, 1, 0);  // -0.49975
    assert_baud(1000501, 1, -1); // -0.50075
}

void test_rates_out_of_range_are_refused(void)
{
    static const int32_t rates[] = {7842, 0, -1, -1000000, 2000001, INT32_MAX, INT32_MIN};

    for (uint8_t i = 0; i < sizeof rates / sizeof rates[0]; i++) {
        uint8_t baud = 0x5A;
        int16_t error = UNTOUCHED;

        TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_units_baud(rates[i], &baud, &error));
        TEST_ASSERT_EQUAL_HEX8(0x5A, baud);
        TEST_ASSERT_EQUAL_INT16(UNTOUCHED, error);
        assert_no_register(NULL, CDS_UNIT_BPS, rates[i]);
    }
}

void test_R24_six_baud_registers_are_kept(void)
{
    static const uint8_t kept[] = {1, 3, 7, 16, 34, 103};

    for (int baud = 0; baud <= 255; baud++)
        TEST_ASSERT_EQUAL(memchr(kept, baud, sizeof kept) != NULL,
                          cds_units_baud_is_kept((uint8_t)baud));
}

/* The unit of each byte of a CDS55xx: one letter of `letters`, which are in the order of the enum.
 */
static const char letters[] = ".#pmsSqQVCtB";
static const char units_of_cds55xx[] = ".###Btp.p..CVVq.###.#.#."    // 0x00
                                       "##mm##p.s.##p.S.Q.VC#.###."; // 0x18

static char letter_of(const struct cds_register_profile *profile, uint8_t address)
{
    return letters[cds_units_of(profile, address)];
}

void test_each_register_has_its_unit(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        struct cds_register it;

        TEST_ASSERT_EQUAL_CHAR(units_of_cds55xx[address], letter_of(&cds_profile_cds55xx, address));
        TEST_ASSERT_TRUE(cds_register_at(address, &it));
        if (address != it.address || it.access == CDS_ACCESS_NO) // a high byte, or reserved
            TEST_ASSERT_EQUAL_CHAR('.', letter_of(&cds_profile_cds55xx, address));
    }
    TEST_ASSERT_EQUAL_CHAR('.', letter_of(&cds_profile_cds55xx, CDS_TABLE_SIZE));
    TEST_ASSERT_EQUAL_CHAR('.', letter_of(&cds_profile_cds55xx, UINT8_MAX));
}

void test_R7_an_AX12_differs_in_torque_limit_and_model_number(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        char unit = letter_of(&cds_profile_ax12, address);

        switch (address) {
        case 0x00: TEST_ASSERT_EQUAL_CHAR('#', unit); break;
        case 0x01: TEST_ASSERT_EQUAL_CHAR('.', unit); break; // the model's high byte
        case 0x22: TEST_ASSERT_EQUAL_CHAR('q', unit); break;
        case 0x23: TEST_ASSERT_EQUAL_CHAR('.', unit); break;
        default: TEST_ASSERT_EQUAL_CHAR(units_of_cds55xx[address], unit);
        }
    }
    TEST_ASSERT_EQUAL_HEX8(0x00, cds_profile_ax12.model_address);
    TEST_ASSERT_EQUAL_HEX8(0x01, cds_profile_cds55xx.model_address);
    TEST_ASSERT_EQUAL(CDS_UNIT_SIGNED_CPCT, cds_profile_ax12.turn_unit);
    TEST_ASSERT_EQUAL(CDS_UNIT_SIGNED_MRPM, cds_profile_cds55xx.turn_unit);
}

/* No value a register may hold is outside its unit; MOVING_SPEED of endless turn has another. */
void test_every_value_of_every_register_has_one_in_its_unit(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        enum cds_unit unit = cds_units_of(&cds_profile_cds55xx, address);
        struct cds_register it;

        if (unit == CDS_UNIT_NONE)
            continue;
        TEST_ASSERT_TRUE(cds_register_at(address, &it));
        if (address == CDS_REG_MOVING_SPEED)
            unit = (enum cds_unit)cds_profile_cds55xx.turn_unit;
        from(&cds_profile_cds55xx, (uint8_t)unit, it.lowest);
        from(&cds_profile_cds55xx, (uint8_t)unit, it.highest);
    }
}
