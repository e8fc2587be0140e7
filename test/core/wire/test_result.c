/* SPDX-License-Identifier: MIT */
/* The texts of results. */
#include "cds55xx/result.h"

#include <string.h>

#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static uint8_t count;

#define CHECK_TEXT(name, number, text_of, remedy)                                                  \
    TEST_ASSERT_EQUAL_UINT8(strlen(text_of), cds_result_text(name, text, sizeof text));            \
    TEST_ASSERT_EQUAL_STRING(text_of, text);                                                       \
    count++;

void test_result_text_of_every_result_fits_the_size(void)
{
    char text[CDS_RESULT_TEXT_SIZE];

    count = 0;
    CDS_RESULTS(CHECK_TEXT)
    TEST_ASSERT_EQUAL_UINT8(0, cds_result_text(count, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("", text);
    TEST_ASSERT_EQUAL_UINT8(0, cds_result_text(255, text, sizeof text));
}

void test_result_text_is_cut_to_the_capacity(void)
{
    char text[8] = "\x55\x55\x55\x55\x55\x55\x55";

    TEST_ASSERT_EQUAL_UINT8(5, cds_result_text(CDS_TIMEOUT, text, 6));
    TEST_ASSERT_EQUAL_STRING("no re", text);
    TEST_ASSERT_EQUAL_HEX8(0x55, text[6]);
    TEST_ASSERT_EQUAL_UINT8(0, cds_result_text(CDS_TIMEOUT, text, 1));
    TEST_ASSERT_EQUAL_STRING("", text);
}
