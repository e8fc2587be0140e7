/* Words and numbers of a console line. */
#include <string.h>

#include "token.h"
#include "unity.h"

static struct token token;
static uint16_t value;
static bool too_large;

void setUp(void)
{
    token.length = 0;
    value = 0x5A5A;
    too_large = false;
}

void tearDown(void)
{
}

static bool number(const char *text)
{
    token.length = 0;
    while (*text)
        token_add(&token, *text++);
    return token_number(&token, &value, &too_large);
}

void test_decimal(void)
{
    TEST_ASSERT_TRUE(number("0"));
    TEST_ASSERT_EQUAL_UINT16(0, value);
    TEST_ASSERT_TRUE(number("1023"));
    TEST_ASSERT_EQUAL_UINT16(1023, value);
    TEST_ASSERT_TRUE(number("007"));
    TEST_ASSERT_EQUAL_UINT16(7, value);
}

void test_hexadecimal_in_either_case(void)
{
    TEST_ASSERT_TRUE(number("0x3ff"));
    TEST_ASSERT_EQUAL_UINT16(0x3FF, value);
    TEST_ASSERT_TRUE(number("0XAB"));
    TEST_ASSERT_EQUAL_UINT16(0xAB, value);
}

void test_highest_number_is_not_too_large(void)
{
    TEST_ASSERT_TRUE(number("65535"));
    TEST_ASSERT_EQUAL_UINT16(65535, value);
    TEST_ASSERT_FALSE(too_large);
    TEST_ASSERT_TRUE(number("0xFFFF"));
    TEST_ASSERT_FALSE(too_large);
}

void test_too_large_is_said_and_saturates(void)
{
    static const char *const large[] = {"65536",
                                        "0x10000",
                                        "4294967296",
                                        "4294967297",
                                        "99999999999999999999",
                                        "0xFFFFFFFFFFFFFFFF"};

    for (uint8_t i = 0; i < sizeof large / sizeof large[0]; i++) {
        TEST_ASSERT_TRUE(number(large[i]));
        TEST_ASSERT_TRUE(too_large);
        TEST_ASSERT_EQUAL_UINT16(65535, value);
    }
}

void test_not_numbers(void)
{
    static const char *const words[] = {"",   "x",   "0x",  "12a", "-1",
                                        "+1", "0xG", "1.5", "a",   "0x-1"};

    for (uint8_t i = 0; i < sizeof words / sizeof words[0]; i++)
        TEST_ASSERT_FALSE_MESSAGE(number(words[i]), words[i]);
    TEST_ASSERT_EQUAL_HEX16(0x5A5A, value);
}

void test_a_word_longer_than_any_is_no_number_and_is_not_stored(void)
{
    struct {
        struct token token;
        char after;
    } guarded = {.after = 'z'};

    for (uint16_t i = 0; i < 1000; i++)
        token_add(&guarded.token, '1');
    TEST_ASSERT_EQUAL_UINT8(TOKEN_MAX + 1, guarded.token.length);
    TEST_ASSERT_EQUAL_CHAR('z', guarded.after);
    TEST_ASSERT_FALSE(token_number(&guarded.token, &value, &too_large));
}
