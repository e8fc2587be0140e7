/* SPDX-License-Identifier: MIT */
/* The curves against their formulas in real numbers. */
#include <math.h>
#include <stdio.h>

#include "robot/curve_internal.h"
#include "unity.h"

#ifdef __AVR__
#define TIME_STEP  509 // the simulated AVR is slower
#define RATIO_STEP 4001
#else
#define TIME_STEP  1
#define RATIO_STEP 61
#endif
#define WAY_BOUND  5  // of 65536: 1023 steps are off by 0.08
#define RATE_BOUND 12 // of 16384

void setUp(void)
{
}

void tearDown(void)
{
}

static double share(uint32_t time)
{
    return (double)time / 65536;
}

static void assert_near(double expected, double is, double bound, uint32_t time)
{
    char text[80];

    if (fabs(expected - is) <= bound)
        return;
    snprintf(text, sizeof text, "at %lu of 65536: %ld, expected %ld", (unsigned long)time, (long)is,
             (long)expected);
    TEST_FAIL_MESSAGE(text);
}

void test_minimum_jerk_is_its_polynomial(void)
{
    struct cds_curve curve;

    cds_curve_set(&curve, CDS_MOTION_MINIMUM_JERK);
    for (uint32_t time = 0; time < 65536; time += TIME_STEP) {
        double t = share(time);

        assert_near(65536.0 * t * t * t * (10 + t * (6 * t - 15)),
                    cds_curve_progress(&curve, (uint16_t)time), WAY_BOUND, time);
        assert_near(16384.0 * 30 * t * t * (1 - t) * (1 - t),
                    cds_curve_rate(&curve, (uint16_t)time), RATE_BOUND, time);
    }
}

void test_linear_is_the_share_of_time(void)
{
    struct cds_curve curve;

    cds_curve_set(&curve, CDS_MOTION_LINEAR);
    for (uint32_t time = 0; time < 65536; time += TIME_STEP) {
        assert_near(65536 * share(time), cds_curve_progress(&curve, (uint16_t)time), 0, time);
        TEST_ASSERT_EQUAL_UINT16(16384, cds_curve_rate(&curve, (uint16_t)time));
    }
}

static double trapezoid(double ramp, double t)
{
    double rate = 1 / (1 - ramp);

    if (t < ramp)
        return rate * t * t / (2 * ramp);
    return t < 1 - ramp ? rate * (t - ramp / 2) : 1 - rate * (1 - t) * (1 - t) / (2 * ramp);
}

static double trapezoid_rate(double ramp, double t)
{
    double end = t < 0.5 ? t : 1 - t, rate = 1 / (1 - ramp);

    return end < ramp ? rate * end / ramp : rate;
}

/* 0 to 1 */
static double root_of(double square)
{
    double root = 1;

    for (uint8_t i = 0; i < 40; i++)
        root = (root + square / root) / 2;
    return root;
}

static void check_trapezoid(uint16_t ramp_ratio)
{
    double ramp = (1 - root_of(1 - 4 * share(ramp_ratio))) / 2;
    struct cds_curve curve;

    if (ramp < 1 / 64.0)
        ramp = 1 / 64.0;
    cds_curve_set_trapezoid(&curve, ramp_ratio);
    for (uint32_t time = 0; time < 65536; time += 127) {
        assert_near(65536.0 * trapezoid(ramp, share(time)),
                    cds_curve_progress(&curve, (uint16_t)time), 16, time);
        assert_near(16384 * trapezoid_rate(ramp, share(time)),
                    cds_curve_rate(&curve, (uint16_t)time), 32, time);
    }
}

void test_trapezoid_speeds_up_as_asked(void)
{
    for (uint32_t ramp_ratio = 0; ramp_ratio <= CDS_CURVE_TRIANGLE; ramp_ratio += RATIO_STEP)
        check_trapezoid((uint16_t)ramp_ratio);
    check_trapezoid(CDS_CURVE_TRIANGLE);
}

void test_braking_ends_at_rest_after_half_the_way(void)
{
    for (uint32_t time = 0; time < 65536; time += TIME_STEP) {
        double t = share(time);

        assert_near(65536 * (t - t * t * t + t * t * t * t / 2),
                    cds_curve_braking_progress((uint16_t)time), WAY_BOUND, time);
        assert_near(16384 * (1 - 3 * t * t + 2 * t * t * t), cds_curve_braking_rate((uint16_t)time),
                    RATE_BOUND, time);
    }
}

/* Passing a pose is braking the other way round: its way is what is left of this half. */
void test_braking_way_never_exceeds_its_half(void)
{
    for (uint32_t time = 0; time < 65536; time += TIME_STEP)
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(32768, cds_curve_braking_progress((uint16_t)time));
}

void test_no_curve_goes_back(void)
{
    static const uint16_t bends[] = {0, 100, 4000, 12000, CDS_CURVE_TRIANGLE};
    struct cds_curve curve;

    for (uint8_t i = 0; i < sizeof bends / sizeof *bends; i++) {
        uint16_t last = 0;

        cds_curve_set_trapezoid(&curve, bends[i]);
        for (uint32_t time = 0; time < 65536; time += TIME_STEP) {
            uint16_t way = cds_curve_progress(&curve, (uint16_t)time);

            TEST_ASSERT_GREATER_OR_EQUAL_UINT16(last, way);
            last = way;
        }
    }
}

void test_root_is_rounded_down(void)
{
    for (uint32_t root = 0; root < 65535; root += 13) {
        uint32_t next = (root + 1) * (root + 1);

        TEST_ASSERT_EQUAL_UINT16(root, cds_curve_root(root * root));
        TEST_ASSERT_EQUAL_UINT16(root, cds_curve_root(next - 1));
    }
    TEST_ASSERT_EQUAL_UINT16(65535, cds_curve_root(UINT32_MAX));
}
