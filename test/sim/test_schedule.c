/* SPDX-License-Identifier: MIT */
#include "unity.h"
#include "wire/schedule.h"

#include <stdlib.h>

#define MANY 200

struct probe {
    struct event event;
    struct schedule *schedule;
    char name;
    uint64_t again; // period in cycles; 0: once
    unsigned runs;
    uint64_t ran; // time of the latest run
};

static struct schedule schedule;
static char order[MANY + 1];
static unsigned ran;
static uint64_t earliest; // latest value from on_earlier
static unsigned told;

static void probe_run(void *context, uint64_t now)
{
    struct probe *probe = context;
    order[ran++] = probe->name;
    order[ran] = 0;
    probe->runs++;
    probe->ran = now;
    if (probe->again && probe->runs < 3) {
        schedule_at(probe->schedule, &probe->event, now + probe->again);
    }
}

static void probe_init(struct probe *probe, char name)
{
    *probe = (struct probe){.schedule = &schedule, .name = name};
    event_init(&probe->event, probe_run, probe);
}

static void moved(void *context, uint64_t time)
{
    TEST_ASSERT_EQUAL_PTR(&schedule, context);
    earliest = time;
    told++;
}

void setUp(void)
{
    schedule_init(&schedule);
    ran = 0;
    told = 0;
    order[0] = 0;
}

void tearDown(void)
{
    schedule_free(&schedule);
}

void test_an_empty_schedule_has_no_next_event(void)
{
    TEST_ASSERT_EQUAL_UINT64(SCHEDULE_NEVER, schedule_next(&schedule));
    schedule_run_until(&schedule, 100);
    TEST_ASSERT_EQUAL_UINT64(100, schedule.now);
}

void test_events_run_in_the_order_of_their_times(void)
{
    struct probe a, b, c;
    probe_init(&a, 'a');
    probe_init(&b, 'b');
    probe_init(&c, 'c');
    schedule_at(&schedule, &c.event, 30);
    schedule_at(&schedule, &a.event, 10);
    schedule_at(&schedule, &b.event, 20);
    TEST_ASSERT_EQUAL_UINT64(10, schedule_next(&schedule));
    schedule_run_until(&schedule, 25);
    TEST_ASSERT_EQUAL_STRING("ab", order);
    TEST_ASSERT_TRUE(event_armed(&c.event));
    schedule_run_until(&schedule, 30);
    TEST_ASSERT_EQUAL_STRING("abc", order);
    TEST_ASSERT_EQUAL_UINT64(30, c.ran);
    TEST_ASSERT_FALSE(event_armed(&c.event));
}

void test_events_of_one_cycle_run_in_the_order_of_arming(void)
{
    struct probe probes[20];
    for (unsigned i = 0; i < 20; i++) {
        probe_init(&probes[i], (char)('a' + i));
        schedule_at(&schedule, &probes[i].event, 7);
    }
    schedule_run_until(&schedule, 7);
    TEST_ASSERT_EQUAL_STRING("abcdefghijklmnopqrst", order);
}

void test_arming_again_moves_an_event_after_equal_ones(void)
{
    struct probe a, b;
    probe_init(&a, 'a');
    probe_init(&b, 'b');
    schedule_at(&schedule, &a.event, 5);
    schedule_at(&schedule, &b.event, 5);
    schedule_at(&schedule, &a.event, 5);
    schedule_run_until(&schedule, 5);
    TEST_ASSERT_EQUAL_STRING("ba", order);
}

void test_a_cancelled_event_does_not_run(void)
{
    struct probe a, b;
    probe_init(&a, 'a');
    probe_init(&b, 'b');
    schedule_at(&schedule, &a.event, 5);
    schedule_at(&schedule, &b.event, 6);
    schedule_cancel(&schedule, &a.event);
    schedule_cancel(&schedule, &a.event);
    schedule_run_until(&schedule, 10);
    TEST_ASSERT_EQUAL_STRING("b", order);
}

void test_an_event_may_arm_itself_within_the_run(void)
{
    struct probe a;
    probe_init(&a, 'a');
    a.again = 4;
    schedule_at(&schedule, &a.event, 1);
    schedule_run_until(&schedule, 9);
    TEST_ASSERT_EQUAL_STRING("aaa", order);
    TEST_ASSERT_EQUAL_UINT64(9, a.ran);
}

void test_a_time_in_the_past_means_now(void)
{
    struct probe a;
    probe_init(&a, 'a');
    schedule_run_until(&schedule, 50);
    schedule_at(&schedule, &a.event, 10);
    TEST_ASSERT_EQUAL_UINT64(50, schedule_next(&schedule));
}

void test_on_earlier_is_called_when_the_next_event_is_earlier(void)
{
    struct probe a, b, c;
    schedule.on_earlier = moved;
    schedule.context = &schedule;
    probe_init(&a, 'a');
    probe_init(&b, 'b');
    probe_init(&c, 'c');
    schedule_at(&schedule, &a.event, 20);
    schedule_at(&schedule, &b.event, 30);
    TEST_ASSERT_EQUAL_UINT(1, told);
    schedule_at(&schedule, &c.event, 10);
    TEST_ASSERT_EQUAL_UINT(2, told);
    TEST_ASSERT_EQUAL_UINT64(10, earliest);
}

void test_many_events_armed_moved_and_cancelled_stay_in_order(void)
{
    static struct probe probes[MANY];
    srand(1);
    for (unsigned i = 0; i < MANY; i++) {
        probe_init(&probes[i], 'x');
        schedule_at(&schedule, &probes[i].event, (uint64_t)rand() % 1000);
    }
    for (unsigned i = 0; i < MANY; i += 3) {
        schedule_at(&schedule, &probes[i].event, (uint64_t)rand() % 1000);
    }
    for (unsigned i = 1; i < MANY; i += 3) {
        schedule_cancel(&schedule, &probes[i].event);
    }
    uint64_t last = 0;
    while (schedule_next(&schedule) != SCHEDULE_NEVER) {
        uint64_t next = schedule_next(&schedule);
        TEST_ASSERT_TRUE(next >= last);
        last = next;
        schedule_run_until(&schedule, next);
    }
    for (unsigned i = 0; i < MANY; i++) {
        TEST_ASSERT_EQUAL_UINT(i % 3 == 1 ? 0 : 1, probes[i].runs);
    }
}

void test_ranks_come_before_the_order_of_arming(void)
{
    static struct probe last, first, other;
    probe_init(&last, 'c');
    probe_init(&first, 'a');
    probe_init(&other, 'b');
    last.event.rank = 2;
    other.event.rank = 1;
    schedule_at(&schedule, &last.event, 10);
    schedule_at(&schedule, &other.event, 10);
    schedule_at(&schedule, &first.event, 10);
    schedule_run_until(&schedule, 20);
    TEST_ASSERT_EQUAL_STRING("abc", order);
}

/* --- events that meddle with others while they run --- */

#define CROWD 60

struct member {
    struct event event;
    uint64_t due; // latest time for which it was armed
    unsigned turn;
};

static struct member crowd[CROWD];
static uint32_t dice;
static unsigned turns;

static unsigned roll(unsigned sides)
{
    dice = dice * 1664525u + 1013904223u;
    return (dice >> 16) % sides;
}

static void arm(struct member *member, uint64_t now)
{
    member->due = now + roll(50);
    member->turn = turns++;
    schedule_at(&schedule, &member->event, member->due);
}

/* An event that was armed before `member` for the same time, or for an earlier time, should have
 * run first. */
static void check_that_it_was_the_next(const struct member *member)
{
    for (unsigned i = 0; i < CROWD; i++) {
        const struct member *other = &crowd[i];
        bool sooner =
            other->due < member->due || (other->due == member->due && other->turn < member->turn);
        TEST_ASSERT_FALSE(other != member && event_armed(&other->event) && sooner);
    }
}

static void meddle(void *context, uint64_t now)
{
    struct member *member = context;
    TEST_ASSERT_EQUAL_UINT64(member->due, now);
    TEST_ASSERT_FALSE(event_armed(&member->event));
    check_that_it_was_the_next(member);
    ran++;
    for (unsigned i = roll(4); i > 0; i--) {
        struct member *other = roll(3) ? &crowd[roll(CROWD)] : member;
        if (roll(4)) {
            arm(other, now);
        } else {
            schedule_cancel(&schedule, &other->event);
        }
        if (!roll(8)) {
            TEST_ASSERT_TRUE(schedule_next(&schedule) >= now);
        }
    }
}

void test_running_events_that_arm_and_cancel_keep_the_order(void)
{
    dice = 1;
    turns = 0;
    for (unsigned i = 0; i < CROWD; i++) {
        event_init(&crowd[i].event, meddle, &crowd[i]);
    }
    for (uint64_t round = 0; round < 200; round++) {
        for (unsigned i = 0; i < CROWD; i++) {
            arm(&crowd[i], schedule.now);
        }
        schedule_run_until(&schedule, schedule.now + 100);
    }
    TEST_ASSERT_TRUE(ran > 10000);
}
