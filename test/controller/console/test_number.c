/* SPDX-License-Identifier: MIT */
/* Numbers with units, in and out. */
#include <string.h>

#include "console/errors.h"
#include "ring_input.h"
#include "console/number_format.h"
#include "console/number_parse.h"
#include "unity.h"

static struct token token;
static struct number number;
static struct cds_ring ring;
static struct printer printer;
static char text[CDS_RING_SIZE + 1];

void setUp(void)
{
    memset(&ring, 0, sizeof ring);
    printer = (struct printer){.ring = &ring};
}

void tearDown(void)
{
}

static const struct token *word(const char *from)
{
    token.length = 0;
    while (*from)
        token_add(&token, *from++);
    return &token;
}

static void assert_raw(uint16_t raw, const char *from, enum cds_unit unit)
{
    uint16_t got = 0x5A5A;

    TEST_ASSERT_EQUAL_UINT8_MESSAGE(0, number_parse(word(from), &number), from);
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(0, number_register(&number, unit, &got), from);
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(raw, got, from);
}

static void assert_error(uint8_t error, const char *from, enum cds_unit unit)
{
    uint16_t raw = 0x5A5A;
    uint8_t got = number_parse(word(from), &number);

    if (got == 0)
        got = number_register(&number, unit, &raw);
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(error, got, from);
    TEST_ASSERT_EQUAL_HEX16_MESSAGE(0x5A5A, raw, from);
}

/* Parses a time. Returns 0 or an error. */
static uint8_t parse_ms(const char *from, uint32_t *ms)
{
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(0, number_parse(word(from), &number), from);
    return number_ms(&number, UINT16_MAX, ms);
}

/* Returns what the printer has written, and empties the ring. */
static const char *printed(void)
{
    uint8_t length = 0;

    for (; cds_ring_count(&ring); ring_drop(&ring, 1))
        text[length++] = (char)ring_peek(&ring, 0);
    text[length] = '\0';
    return text;
}

static const char *written(enum cds_unit unit, uint16_t raw)
{
    number_print(&printer, unit, raw);
    return printed();
}

void test_angles(void)
{
    assert_raw(512, "150.147", CDS_UNIT_MDEG);
    assert_raw(307, "90", CDS_UNIT_MDEG);
    assert_raw(309, "90.5deg", CDS_UNIT_MDEG);
    assert_raw(309, "90500mdeg", CDS_UNIT_MDEG);
    assert_raw(309, "90.5\xC2\xB0", CDS_UNIT_MDEG); // the degree sign in UTF-8
    assert_raw(1023, "300.000DEG", CDS_UNIT_MDEG);
    assert_raw(0, "0", CDS_UNIT_MDEG);
    assert_raw(512, "512raw", CDS_UNIT_MDEG);
    assert_error(ERROR_OUT_OF_RANGE, "300.001", CDS_UNIT_MDEG);
    assert_error(ERROR_OUT_OF_RANGE, "-1", CDS_UNIT_MDEG);
}

void test_speeds_with_direction_have_sign(void)
{
    assert_raw(495, "30rpm", CDS_UNIT_MRPM);
    assert_raw(495, "30", CDS_UNIT_SIGNED_MRPM);
    assert_raw(0x400 | 330, "-20rpm", CDS_UNIT_SIGNED_MRPM);
    assert_raw(0x400 | 330, "-20000mrpm", CDS_UNIT_SIGNED_MRPM);
    assert_error(ERROR_OUT_OF_RANGE, "-20rpm", CDS_UNIT_MRPM);
    assert_error(ERROR_OUT_OF_RANGE, "62.1rpm", CDS_UNIT_MRPM);
}

void test_the_other_units(void)
{
    assert_raw(60, "6.0V", CDS_UNIT_MV);
    assert_raw(65, "6500mV", CDS_UNIT_MV);
    assert_raw(512, "50.05%", CDS_UNIT_CPCT);
    assert_raw(70, "70C", CDS_UNIT_CELSIUS);
    assert_raw(5, "10us", CDS_UNIT_US);
    assert_raw(254, "0.508ms", CDS_UNIT_US);
    assert_raw(34, "57.6kbps", CDS_UNIT_BPS);
    assert_raw(3, "500k", CDS_UNIT_BPS);
    assert_raw(1, "1M", CDS_UNIT_BPS);
    assert_raw(1, "1Mbps", CDS_UNIT_BPS);
    assert_raw(1, "1000000", CDS_UNIT_BPS);
    assert_raw(0x25, "0x25", CDS_UNIT_NUMBER);
    assert_raw(37, "37raw", CDS_UNIT_NUMBER);
}

void test_a_unit_of_another_kind_is_an_error(void)
{
    assert_error(ERROR_UNIT, "90rpm", CDS_UNIT_MDEG);
    assert_error(ERROR_UNIT, "6V", CDS_UNIT_CELSIUS);
    assert_error(ERROR_UNIT, "1deg", CDS_UNIT_NUMBER);
    assert_error(ERROR_UNIT, "1deg", CDS_UNIT_NONE);
    assert_error(ERROR_NOT_A_NUMBER, "0xZZ", CDS_UNIT_MDEG);
    assert_error(ERROR_UNIT, "0x", CDS_UNIT_MDEG);
    assert_error(ERROR_UNIT, "90degs", CDS_UNIT_MDEG);
    assert_error(ERROR_UNIT, "90de", CDS_UNIT_MDEG);
    assert_error(ERROR_UNIT, "90.5.5", CDS_UNIT_MDEG);
}

void test_a_nul_is_not_the_end_of_a_unit(void)
{
    word("1deg");
    token_add(&token, '\0');
    token_add(&token, 'r');
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNIT, number_parse(&token, &number));
}

void test_what_is_no_number(void)
{
    static const char *const words[] = {"",     "-",     ".",   ".5", "5.", "deg",
                                        "-deg", "1.deg", "--1", "+1", "a"};

    for (uint8_t i = 0; i < sizeof words / sizeof words[0]; i++)
        assert_error(ERROR_NOT_A_NUMBER, words[i], CDS_UNIT_MV);
    assert_error(ERROR_NOT_A_NUMBER, "averyveryveryverylongwordindeed", CDS_UNIT_MV);
}

void test_finer_than_the_unit_is_no_number(void)
{
    assert_error(ERROR_NOT_A_NUMBER, "90.0001", CDS_UNIT_MDEG);
    assert_error(ERROR_NOT_A_NUMBER, "0.5raw", CDS_UNIT_MDEG);
    assert_error(ERROR_NOT_A_NUMBER, "70.5C", CDS_UNIT_CELSIUS);
}

void test_numbers_beyond_31_bits_are_out_of_range(void)
{
    assert_error(ERROR_OUT_OF_RANGE, "2147483648", CDS_UNIT_NUMBER);
    assert_error(ERROR_OUT_OF_RANGE, "2147483647", CDS_UNIT_NUMBER);
    assert_error(ERROR_OUT_OF_RANGE, "99999999999999999999", CDS_UNIT_NUMBER);
    assert_error(ERROR_OUT_OF_RANGE, "0x80000000", CDS_UNIT_NUMBER);
    assert_error(ERROR_OUT_OF_RANGE, "2147484s", CDS_UNIT_US);
    assert_error(ERROR_OUT_OF_RANGE, "65536raw", CDS_UNIT_MDEG);
    assert_error(ERROR_OUT_OF_RANGE, "-2147483648", CDS_UNIT_SIGNED_MRPM);
    assert_error(ERROR_OUT_OF_RANGE, "4294967386", CDS_UNIT_NUMBER); // 2^32 + 90
    assert_raw(65535, "65535", CDS_UNIT_NUMBER);
}

void test_a_rate_that_no_register_is_near_to_is_out_of_range(void)
{
    assert_raw(16, "115200", CDS_UNIT_BPS);
    assert_error(ERROR_OUT_OF_RANGE, "1500000", CDS_UNIT_BPS);
    assert_error(ERROR_OUT_OF_RANGE, "7000", CDS_UNIT_BPS);
}

void test_whole_numbers(void)
{
    uint16_t value = 0;

    TEST_ASSERT_EQUAL_UINT8(0, number_whole(word("253"), 253, &value));
    TEST_ASSERT_EQUAL_UINT16(253, value);
    TEST_ASSERT_EQUAL_UINT8(0, number_whole(word("0xAb"), 255, &value));
    TEST_ASSERT_EQUAL_UINT16(0xAB, value);
    TEST_ASSERT_EQUAL_UINT8(0, number_whole(word("007"), 7, &value));
    TEST_ASSERT_EQUAL_UINT16(7, value);
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, number_whole(word("254"), 253, &value));
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, number_whole(word("-1"), 253, &value));
    TEST_ASSERT_EQUAL_UINT8(ERROR_NOT_A_NUMBER, number_whole(word("1raw"), 253, &value));
    TEST_ASSERT_EQUAL_UINT8(ERROR_NOT_A_NUMBER, number_whole(word("1.0"), 253, &value));
    TEST_ASSERT_EQUAL_UINT8(ERROR_NOT_A_NUMBER, number_whole(word("1,2"), 253, &value));
    TEST_ASSERT_EQUAL_UINT16(7, value);
}

void test_times(void)
{
    uint32_t ms = 0;

    TEST_ASSERT_EQUAL_UINT8(0, parse_ms("4", &ms));
    TEST_ASSERT_EQUAL_UINT32(4, ms);
    TEST_ASSERT_EQUAL_UINT8(0, parse_ms("1.5s", &ms));
    TEST_ASSERT_EQUAL_UINT32(1500, ms);
    TEST_ASSERT_EQUAL_UINT8(ERROR_NOT_A_NUMBER, parse_ms("4500us", &ms));
    TEST_ASSERT_EQUAL_UINT8(ERROR_UNIT, parse_ms("4deg", &ms));
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, parse_ms("66s", &ms));
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, parse_ms("-4", &ms));
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, parse_ms("2147.483647s", &ms));
    TEST_ASSERT_EQUAL_UINT8(0, number_parse(word("600s"), &number));
    TEST_ASSERT_EQUAL_UINT8(0, number_ms(&number, 600000, &ms));
    TEST_ASSERT_EQUAL_UINT32(600000, ms);
    TEST_ASSERT_EQUAL_UINT8(ERROR_OUT_OF_RANGE, number_ms(&number, 599999, &ms));
}

void test_writing(void)
{
    TEST_ASSERT_EQUAL_STRING("150.147deg", written(CDS_UNIT_MDEG, 512));
    TEST_ASSERT_EQUAL_STRING("0deg", written(CDS_UNIT_MDEG, 0));
    TEST_ASSERT_EQUAL_STRING("300deg", written(CDS_UNIT_MDEG, 1023));
    TEST_ASSERT_EQUAL_STRING("-20rpm", written(CDS_UNIT_SIGNED_MRPM, 0x400 | 330));
    TEST_ASSERT_EQUAL_STRING("0.061rpm", written(CDS_UNIT_MRPM, 1));
    TEST_ASSERT_EQUAL_STRING("-0.1%", written(CDS_UNIT_SIGNED_CPCT, 0x400 | 1));
    TEST_ASSERT_EQUAL_STRING("6.5V", written(CDS_UNIT_MV, 65));
    TEST_ASSERT_EQUAL_STRING("12V", written(CDS_UNIT_MV, 120));
    TEST_ASSERT_EQUAL_STRING("32C", written(CDS_UNIT_CELSIUS, 32));
    TEST_ASSERT_EQUAL_STRING("2000000bps", written(CDS_UNIT_BPS, 0));
    TEST_ASSERT_EQUAL_STRING("65535", written(CDS_UNIT_NUMBER, 65535));
    TEST_ASSERT_EQUAL_STRING("?deg", written(CDS_UNIT_MDEG, 1024));
}

void test_what_is_written_is_read_as_the_same(void)
{
    static const enum cds_unit units[] = {CDS_UNIT_MDEG, CDS_UNIT_MRPM, CDS_UNIT_SIGNED_MRPM,
                                          CDS_UNIT_CPCT};

    for (uint8_t unit = 0; unit < sizeof units / sizeof units[0]; unit++)
        for (uint16_t raw = 0; raw <= 1023; raw = (uint16_t)(raw + 31))
            assert_raw(raw, written(units[unit], raw), units[unit]);
    for (uint16_t raw = 0; raw <= 254; raw++)
        assert_raw(raw, written(CDS_UNIT_US, raw), CDS_UNIT_US);
}

void test_fixed_point(void)
{
    static const struct {
        int32_t value;
        uint8_t decimals;
        const char *text;
    } cases[] = {{0, 0, "0"},
                 {0, 3, "0"},
                 {7, 0, "7"},
                 {5, 3, "0.005"},
                 {1500, 3, "1.5"},
                 {-1500, 3, "-1.5"},
                 {-5, 1, "-0.5"},
                 {1000, 1, "100"},
                 {10010, 3, "10.01"},
                 {INT32_MAX, 0, "2147483647"},
                 {INT32_MIN, 3, "-2147483.648"}};

    for (uint8_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        printer_fixed(&printer, cases[i].value, cases[i].decimals);
        TEST_ASSERT_EQUAL_STRING(cases[i].text, printed());
    }
}

void test_a_word_longer_than_any_is_not_stored(void)
{
    struct {
        struct token token;
        char after;
    } guarded = {.after = 'z'};

    for (uint16_t i = 0; i < 1000; i++)
        token_add(&guarded.token, '1');
    TEST_ASSERT_EQUAL_UINT8(TOKEN_MAX + 1, guarded.token.length);
    TEST_ASSERT_EQUAL_CHAR('z', guarded.after);
}
