/* SPDX-License-Identifier: MIT */
/* The sine of a gait against the function in real numbers. */
#include <math.h>

#include "real_sine.h"
#include "robot/sine_internal.h"
#include "unity.h"

#ifdef __AVR__
#define PHASE_STEP 37 // the simulated AVR is slower
#else
#define PHASE_STEP 1
#endif

void setUp(void)
{
}

void tearDown(void)
{
}

void test_sine_of_all_phases_is_within_its_bound(void)
{
    for (uint32_t phase = 0; phase < 65536; phase += PHASE_STEP) {
        double expected = fabs(65536 * real_sine((double)phase / 65536));

        TEST_ASSERT_INT32_WITHIN(19, (int32_t)expected, cds_sine_height((uint16_t)phase));
    }
}

void test_sine_does_not_pass_1_and_ends_at_0(void)
{
    TEST_ASSERT_UINT16_WITHIN(19, 65535, cds_sine_height(CDS_SINE_QUARTER));
    TEST_ASSERT_EQUAL_UINT16(0, cds_sine_height(0));
    TEST_ASSERT_EQUAL_UINT16(0, cds_sine_height(CDS_SINE_HALF - 1));
    TEST_ASSERT_EQUAL_UINT16(0, cds_sine_height(CDS_SINE_HALF));
}
