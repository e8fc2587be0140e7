/* SPDX-License-Identifier: MIT */
#include "unity.h"
#include "wire/net.h"

static struct net net;
static struct driver a, b;
static struct listener listener;
static unsigned levels, drivers;
static uint64_t when;
static bool level;
static struct driver *who;

static void on_level(void *context, uint64_t time, bool now)
{
    TEST_ASSERT_EQUAL_PTR(&net, context);
    levels++;
    when = time;
    level = now;
}

static void on_driver(void *context, uint64_t time, struct driver *driver)
{
    TEST_ASSERT_EQUAL_PTR(&net, context);
    (void)time;
    drivers++;
    who = driver;
}

void setUp(void)
{
    levels = drivers = 0;
    net_init(&net);
    driver_init(&a, &net);
    driver_init(&b, &net);
    listener = (struct listener){.context = &net, .on_level = on_level, .on_driver = on_driver};
    net_listen(&net, &listener);
}

void tearDown(void)
{
}

void test_the_pull_up_holds_an_undriven_net_high(void)
{
    TEST_ASSERT_TRUE(net.level);
    driver_level(&a, 1, false);
    TEST_ASSERT_TRUE(net.level);
    TEST_ASSERT_EQUAL_UINT(0, levels);
}

void test_the_level_is_the_and_of_the_drivers(void)
{
    driver_set(&a, 1, true, true);
    driver_set(&b, 2, true, false);
    TEST_ASSERT_FALSE(net.level);
    driver_level(&a, 3, false);
    driver_level(&b, 4, true);
    TEST_ASSERT_FALSE(net.level);
    driver_level(&a, 5, true);
    TEST_ASSERT_TRUE(net.level);
    TEST_ASSERT_EQUAL_UINT(2, levels);
    TEST_ASSERT_EQUAL_UINT64(5, when);
    TEST_ASSERT_TRUE(level);
}

void test_disabled_driver_leaves_the_net_to_the_others(void)
{
    driver_set(&a, 1, true, false);
    driver_set(&b, 1, true, true);
    driver_enable(&a, 9, false);
    TEST_ASSERT_TRUE(net.level);
    TEST_ASSERT_EQUAL_UINT64(9, net.time);
    TEST_ASSERT_EQUAL_UINT(1, net.enabled);
}

void test_listeners_are_called_when_drivers_are_enabled(void)
{
    driver_enable(&a, 1, true);
    driver_enable(&a, 2, true);
    driver_level(&a, 3, false);
    TEST_ASSERT_EQUAL_UINT(1, drivers);
    driver_enable(&b, 4, true);
    TEST_ASSERT_EQUAL_PTR(&b, who);
    driver_enable(&b, 5, false);
    TEST_ASSERT_EQUAL_UINT(3, drivers);
    TEST_ASSERT_EQUAL_UINT(1, net.enabled);
    TEST_ASSERT_EQUAL_UINT(1, net.low);
}

static enum net_override present;
static uint64_t asked;

static enum net_override ask(void *context, uint64_t time)
{
    TEST_ASSERT_EQUAL_PTR(&net, context);
    asked = time;
    return present;
}

static void override(uint64_t time, enum net_override what)
{
    net.context = &net;
    net.get_override = ask;
    present = what;
    net_update(&net, time);
}

void test_an_override_stands_above_the_drivers(void)
{
    static const struct {
        enum net_override override;
        bool low, high; // the level when the drivers give low; when they give high
    } rows[] = {{NET_AS_DRIVEN, false, true},
                {NET_INVERTED, true, false},
                {NET_HIGH, true, true},
                {NET_LOW, false, false}};
    driver_set(&a, 1, true, true);
    for (unsigned i = 0; i < 4; i++) {
        override(10 * i + 2, rows[i].override);
        TEST_ASSERT_EQUAL(rows[i].high, net.level);
        driver_level(&a, 10 * i + 3, false);
        TEST_ASSERT_EQUAL_UINT64(10 * i + 3, asked);
        TEST_ASSERT_EQUAL(rows[i].low, net.level);
        driver_level(&a, 10 * i + 4, true);
        TEST_ASSERT_EQUAL(rows[i].high, net.level);
    }
    TEST_ASSERT_EQUAL_UINT(0, net.low);
    TEST_ASSERT_EQUAL_UINT(1, net.enabled);
}

void test_listeners_are_called_when_an_override_changes_the_level(void)
{
    override(5, NET_HIGH);
    TEST_ASSERT_EQUAL_UINT(0, levels);
    override(6, NET_LOW);
    TEST_ASSERT_EQUAL_UINT(1, levels);
    TEST_ASSERT_EQUAL_UINT64(6, when);
    TEST_ASSERT_FALSE(level);
    TEST_ASSERT_EQUAL_UINT64(6, net.time);
    driver_set(&a, 7, true, false);
    TEST_ASSERT_EQUAL_UINT(1, levels);
    override(8, NET_AS_DRIVEN);
    TEST_ASSERT_EQUAL_UINT(1, levels);
    driver_enable(&a, 9, false);
    TEST_ASSERT_EQUAL_UINT(2, levels);
}

void test_net_counts_exempt_drivers(void)
{
    driver_exempt(&a, true);
    TEST_ASSERT_EQUAL_UINT(0, net.exempt);
    driver_enable(&a, 1, true);
    driver_enable(&b, 1, true);
    TEST_ASSERT_EQUAL_UINT(1, net.exempt);
    driver_exempt(&b, true);
    driver_exempt(&b, true);
    TEST_ASSERT_EQUAL_UINT(2, net.exempt);
    driver_exempt(&a, false);
    driver_enable(&a, 2, false);
    TEST_ASSERT_EQUAL_UINT(1, net.exempt);
    driver_enable(&b, 2, false);
    TEST_ASSERT_EQUAL_UINT(0, net.exempt);
}
