/* SPDX-License-Identifier: MIT */
/* The cycle on a bus with a permit: a servo that is refused is left out, and the others go on. The
 * permit is a fake that checks every block of a SYNC WRITE, as the real one does. */
#include <string.h>

#include "cds55xx/cycle.h"
#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

#define SERVOS         3
#define PERIOD_US      2000
#define SIZE           (8 + 5 * SERVOS) // of the goals' packet
#define SPEED          0x123
#define STEP_US        10
#define TURNS_PER_STEP 4 // of the main loop: a poll of the bus does one thing

static struct cds_queue queue;
static struct cds_bus_hooks hooks;
static struct cds_cycle cycle;
static struct cds_feedback feedback[SERVOS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];
static const uint8_t ids[SERVOS] = {4, 2, 9};

/* What the fake permit knows of each servo, in the order of `ids`. */
static struct {
    bool inhibited;
    uint16_t lowest, highest, fastest; // limits of goal and speed
} servos[SERVOS];
static uint16_t epoch;           // counts changes of `servos`
static uint8_t changed_id;       // servo of the last change, or CDS_BROADCAST_ID
static uint16_t checks;          // calls of permit_goal()
static uint16_t hint_misses;     // calls whose hint was wrong
static bool is_read_muted;       // READ of no servo is answered
static uint16_t return_delay_us; // of every servo, as the permit knows it
static bool request_shows_loss;  // the end of `request` shows that servo 1 lost its state

static uint8_t goals[SIZE];    // the last ones on the wire
static uint16_t goals_sent;    // how many
static uint8_t dead;           // ID of one that does not answer, 0: none
static bool all_dead;          // nobody answers a READ
static uint32_t busy_until_us; // a packet is on the wire

static uint8_t packet[CDS_PACKET_SIZE(2)];
static uint8_t reply[2];
static struct cds_request request;

static void change(uint8_t id)
{
    epoch++;
    changed_id = id;
}

static void inhibit(uint8_t i)
{
    servos[i].inhibited = true;
    change(ids[i]);
}

static void release(uint8_t i)
{
    servos[i].inhibited = false;
    change(ids[i]);
}

static void set_inhibits(bool inhibited)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        servos[i].inhibited = inhibited;
    change(CDS_BROADCAST_ID);
}

static void set_limits(uint8_t i, uint16_t lowest, uint16_t highest, uint16_t fastest)
{
    servos[i].lowest = lowest;
    servos[i].highest = highest;
    servos[i].fastest = fastest;
    change(ids[i]);
}

static enum cds_result permit_goal(void *context, uint8_t id, uint8_t *index, const uint8_t *goal)
{
    uint16_t position = (uint16_t)(goal[0] | goal[1] << 8),
             speed = (uint16_t)(goal[2] | goal[3] << 8);
    uint8_t i = 0;

    TEST_ASSERT_EQUAL_PTR(&queue, context);
    while (ids[i] != id)
        TEST_ASSERT_LESS_THAN(SERVOS, ++i);
    checks++;
    if (*index != i)
        hint_misses++;
    *index = i;
    if (servos[i].inhibited)
        return CDS_INHIBITED;
    if (position < servos[i].lowest || position > servos[i].highest || speed > servos[i].fastest ||
        (speed == 0 && servos[i].fastest < CDS_VALUE_MAX))
        return CDS_LIMIT;
    return CDS_OK;
}

static uint8_t changed_since(void *context, uint16_t *since)
{
    uint16_t changes = (uint16_t)(epoch - *since);

    TEST_ASSERT_EQUAL_PTR(&queue, context);
    *since = epoch;
    return changes == 0 ? CDS_NO_ID : changes == 1 ? changed_id : CDS_BROADCAST_ID;
}

/* The fake permit learns nothing from what is sent or comes. */
static bool on_sending(void *context, struct cds_request *request)
{
    (void)context, (void)request;
    return false;
}

static void on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    (void)context, (void)event, (void)id, (void)error;
}

/* As permit.h: a packet that was checked in this epoch passes, of any other each block is checked.
 */
static enum cds_result permit(void *context, struct cds_request *asked)
{
    const uint8_t *bytes = asked->packet.bytes;
    enum cds_result result = CDS_OK;
    uint8_t index = 0;

    asked->return_delay_us = return_delay_us;
    asked->is_muted = false;
    if (bytes[CDS_AT_INSTRUCTION] == CDS_READ && is_read_muted)
        return CDS_NO_REPLY_DUE;
    if (bytes[CDS_AT_INSTRUCTION] != CDS_SYNC_WRITE || asked->permit_epoch == epoch)
        return CDS_OK;
    for (uint8_t i = 0; i < SERVOS && result == CDS_OK; i++)
        result = permit_goal(context, bytes[7 + 5 * i], &index, bytes + 8 + 5 * i);
    if (result == CDS_OK)
        asked->permit_epoch = epoch;
    return result;
}

static enum cds_result permit_all(void *context, struct cds_request *asked)
{
    (void)context;
    asked->return_delay_us = return_delay_us;
    asked->is_muted = false;
    return CDS_OK;
}

static enum cds_result on_end(void *context, struct cds_request *ended, enum cds_result result)
{
    if (ended == &request && request_shows_loss)
        inhibit(1);
    return queue.hooks.request_ended(context, ended, result);
}

static enum cds_result begin_cycle(void)
{
    struct cds_cycle_config config = {.bus = &bus,
                                      .ids = ids,
                                      .packets = packets,
                                      .feedback = feedback,
                                      .count = SERVOS,
                                      .period_us = PERIOD_US};

    return cds_cycle_begin(&cycle, &config);
}

void setUp(void)
{
    rig_open(0);
    memset(&cycle, 0, sizeof cycle);
    memset(feedback, 0, sizeof feedback);
    memset(goals, 0, sizeof goals);
    goals_sent = 0;
    dead = 0;
    all_dead = false;
    busy_until_us = 0;
    request = (struct cds_request)CDS_REQUEST(packet, reply);
    cds_bus_set_return_delay(&bus, 2);
    cds_queue_begin(&queue, &bus);
    hooks = queue.hooks;
    hooks.permit = permit;
    hooks.on_sending = on_sending;
    hooks.on_packet = on_packet;
    hooks.request_ended = on_end;
    hooks.permit_goal = permit_goal;
    hooks.changed_since = changed_since;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, &hooks));
    epoch = 1;
    is_read_muted = request_shows_loss = false;
    return_delay_us = 2;
    checks = hint_misses = 0;
    for (uint8_t i = 0; i < SERVOS; i++) {
        servos[i].inhibited = false;
        set_limits(i, 0, CDS_VALUE_MAX, CDS_VALUE_MAX);
    }
    TEST_ASSERT_EQUAL(CDS_OK, begin_cycle());
}

void tearDown(void)
{
    rig_check();
}

/* The packet on the wire, whole now, meets the servos; their answer is there at once. */
static void hear(void)
{
    static const uint8_t registers[CDS_FEEDBACK_SIZE] = {1, 2, 3};
    const uint8_t *sent = port_fake.sent;

    port_fake_transmit(&bus.link, 0);
    if (sent[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE) {
        TEST_ASSERT_EQUAL_UINT16(SIZE, port_fake.sent_size);
        memcpy(goals, sent, SIZE);
        goals_sent++;
    } else if (sent[CDS_AT_ID] == dead || all_dead) {
        return;
    } else if (sent[CDS_AT_INSTRUCTION] == CDS_READ) {
        port_fake_answer(&bus.link, sent[CDS_AT_ID], 0, registers, sent[CDS_AT_PARAMETERS + 1]);
    } else if (sent[CDS_AT_ID] != CDS_BROADCAST_ID) {
        port_fake_answer(&bus.link, sent[CDS_AT_ID], 0, NULL, 0);
    }
}

static void turn(void)
{
    port_fake.now_us += STEP_US;
    if (bus.link.state == CDS_LINK_TALKING && !busy_until_us)
        busy_until_us = port_fake.now_us + 10u * bus.request->packet.size;
    if (busy_until_us && (int32_t)(port_fake.now_us - busy_until_us) >= 0) {
        busy_until_us = 0;
        hear();
    }
    for (uint8_t i = 0; i < TURNS_PER_STEP; i++) {
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
    }
}

static void run_periods(uint8_t count)
{
    for (uint16_t i = 0; i < count * (PERIOD_US / STEP_US); i++)
        turn();
}

static enum cds_result set(uint8_t index, uint16_t position)
{
    return cds_cycle_goal(&cycle, index, position, SPEED);
}

static void set_all(uint16_t position)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL(CDS_OK, set(i, (uint16_t)(position + i)));
    cds_cycle_commit(&cycle);
}

/* Two periods begin, and some of the second passes. */
static void run_into_the_second(void)
{
    run_periods(1);
    for (uint8_t i = 0; i < 50; i++)
        turn();
    TEST_ASSERT_EQUAL_UINT16(2, goals_sent);
}

static void begin(void)
{
    set_all(500);
    run_into_the_second();
}

/* The position that servo `index` is told by the goals sent last, or -1 if it is told nothing. The
 * last block of an ID wins (R22). */
static int16_t told(uint8_t index)
{
    int16_t position = -1;

    for (uint8_t i = 0; i < SERVOS; i++)
        if (goals[7 + 5 * i] == ids[index])
            position = (int16_t)(goals[8 + 5 * i] | goals[9 + 5 * i] << 8);
    return position;
}

static void assert_told(int16_t first, int16_t second, int16_t third)
{
    uint8_t sum = 0;

    TEST_ASSERT_EQUAL_INT16(first, told(0));
    TEST_ASSERT_EQUAL_INT16(second, told(1));
    TEST_ASSERT_EQUAL_INT16(third, told(2));
    for (uint8_t i = 2; i < SIZE; i++)
        sum = (uint8_t)(sum + goals[i]);
    TEST_ASSERT_EQUAL_HEX8(0xFF, sum); // the checksum is right
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL_HEX16(SPEED, goals[10 + 5 * i] | goals[11 + 5 * i] << 8);
}

void test_servo_inhibited_is_left_out_and_the_others_go_on(void)
{
    for (uint8_t out = 0; out < SERVOS; out++) {
        setUp();
        begin();
        assert_told(500, 501, 502);
        inhibit(out);
        run_periods(3);
        assert_told(out == 0 ? -1 : 500, out == 1 ? -1 : 501, out == 2 ? -1 : 502);
        for (uint8_t i = 0; i < SERVOS; i++)
            TEST_ASSERT_EQUAL(i == out, cds_cycle_is_dropped(&cycle, i));
        TEST_ASSERT_EQUAL_UINT16(5, goals_sent);
        TEST_ASSERT_EQUAL_UINT32(5, cycle.counters.periods);
        TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
        TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.unsent);
        TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
    }
}

void test_goals_of_the_others_can_be_set_and_are_whole(void)
{
    begin();
    inhibit(1);
    run_periods(1);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 600));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, set(1, 601));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(600, -1, 502);
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

/* Some goals are set, and not committed, when it happens. */
void test_goal_not_committed_is_left_out_too(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, set(2, 700));
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 701));
    inhibit(2);
    run_periods(1);
    assert_told(500, 501, -1);
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(701, 501, -1);
    TEST_ASSERT_TRUE(cds_cycle_is_dropped(&cycle, 2));
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

/* Held after the commit, before the period begins. */
void test_goals_committed_and_not_sent_are_checked_again(void)
{
    begin();
    set_all(700);
    inhibit(0);
    run_periods(1);
    assert_told(-1, 701, 702);
}

/* Held, and at once the others' goals are set and committed: that judges nobody else. */
void test_commit_right_after_an_inhibit_lets_no_goal_pass(void)
{
    begin();
    inhibit(0);
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 700));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(-1, 700, 502);
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

/* Goals are being filled all the time; two servos are held, one after the other and both at once.
 */
void test_two_servos_inhibited_are_both_left_out(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 700));
    inhibit(0);
    inhibit(2);
    run_periods(1);
    assert_told(-1, 501, -1);
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(-1, 700, -1);

    setUp();
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 700));
    inhibit(2);
    run_periods(1);
    inhibit(1);
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(500, -1, -1);
    TEST_ASSERT_EQUAL_UINT16(2, cycle.counters.dropped);
}

/* The limit is the filled goal's own: the one that is being sent lies within. */
void test_goal_not_committed_beyond_a_new_limit_is_left_out(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 700));
    set_limits(0, 0, 600, 1023);
    run_periods(1);
    assert_told(500, 501, 502);
    TEST_ASSERT_EQUAL_UINT16(0, cycle.counters.dropped);
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(-1, 501, 502);
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

void test_release_revives_nothing_and_a_goal_does(void)
{
    begin();
    inhibit(1);
    run_periods(1);
    release(1);
    run_periods(2);
    assert_told(500, -1, 502);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 600));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(600, -1, 502);
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 610));
    run_periods(1);
    assert_told(600, -1, 502); // set, but not committed
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(600, 610, 502);
    TEST_ASSERT_FALSE(cds_cycle_is_dropped(&cycle, 1));
}

void test_goal_not_committed_does_not_outlive_an_inhibit(void)
{
    begin();
    inhibit(1);
    run_periods(1);
    release(1);
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 610));
    run_periods(1);
    inhibit(1);
    run_periods(1);
    release(1);
    run_periods(1);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 600));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(600, -1, 502);
    TEST_ASSERT_TRUE(cds_cycle_is_dropped(&cycle, 1));
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

void test_all_servos_inhibited_nothing_is_sent(void)
{
    begin();
    set_inhibits(true);
    run_periods(3);
    TEST_ASSERT_EQUAL_UINT16(2, goals_sent);
    TEST_ASSERT_EQUAL_UINT32(5, cycle.counters.periods);
    TEST_ASSERT_EQUAL_UINT32(3, cycle.counters.unsent);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_EQUAL_UINT16(SERVOS, cycle.counters.dropped);
    set_inhibits(false);
    run_periods(1);
    TEST_ASSERT_EQUAL_UINT16(2, goals_sent);
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 300));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(-1, 300, -1);
    TEST_ASSERT_EQUAL_UINT16(3, goals_sent);
}

/* Each block holds the goal of another servo before that servo is left out too. */
void test_all_servos_inhibited_one_by_one_nothing_is_sent(void)
{
    for (uint8_t first = 0; first < SERVOS; first++) {
        setUp();
        begin();
        for (uint8_t i = 0; i < SERVOS; i++) {
            inhibit((uint8_t)((first + i) % SERVOS));
            run_periods(1);
        }
        TEST_ASSERT_EQUAL_UINT16(2 + SERVOS - 1, goals_sent);
        TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.unsent);
    }
}

/* The goals are on the wire meanwhile, and must not be changed. */
void test_two_servos_inhibited_while_goals_are_sent_are_left_out(void)
{
    begin();
    while (cycle.goals.result != CDS_PENDING)
        turn();
    inhibit(0);
    turn();
    inhibit(2);
    turn();
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.goals.result);
    run_periods(2);
    assert_told(-1, 501, -1);
}

void test_servo_without_a_goal_is_left_out_until_it_has_one(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 500));
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 501));
    cds_cycle_commit(&cycle);
    run_into_the_second();
    assert_told(500, 501, -1);
    TEST_ASSERT_TRUE(cds_cycle_is_dropped(&cycle, 2));
    TEST_ASSERT_EQUAL_UINT16(0, cycle.counters.dropped);
    TEST_ASSERT_EQUAL(CDS_OK, set(2, 502));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(500, 501, 502);
    TEST_ASSERT_FALSE(cds_cycle_is_dropped(&cycle, 2));
}

void test_first_goals_after_a_change_of_the_permit_are_sent(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 500));
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 501));
    change(CDS_BROADCAST_ID);
    run_periods(1);
    set_all(500);
    run_into_the_second();
    assert_told(500, 501, 502);
}

void test_servo_inhibited_at_first_is_not_waited_for(void)
{
    inhibit(2);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 500));
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 501));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, set(2, 502));
    cds_cycle_commit(&cycle);
    run_into_the_second();
    assert_told(500, 501, -1);
    set_inhibits(false);
    TEST_ASSERT_EQUAL(CDS_OK, set(2, 502));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(500, 501, 502);
}

void test_goal_beyond_a_limit_is_refused_and_the_old_one_stays(void)
{
    set_limits(0, 100, 600, 0x200);
    begin();
    TEST_ASSERT_EQUAL(CDS_LIMIT, set(0, 601));
    TEST_ASSERT_EQUAL(CDS_LIMIT, set(0, 99));
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_cycle_goal(&cycle, 0, 500, 0x201));
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_cycle_goal(&cycle, 0, 500, 0)); // as fast as it can
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(500, 501, 502);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 600));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(600, 501, 502);
    TEST_ASSERT_EQUAL_UINT16(0, cycle.counters.dropped);
}

void test_servo_with_a_limit_closer_than_its_goal_is_left_out(void)
{
    begin();
    set_limits(2, 0, 501, 1023);
    run_periods(1);
    assert_told(500, 501, -1);
    TEST_ASSERT_EQUAL(CDS_LIMIT, set(2, 502));
    TEST_ASSERT_EQUAL(CDS_OK, set(2, 400));
    cds_cycle_commit(&cycle);
    run_periods(1);
    assert_told(500, 501, 400);
}

/* A transaction of the application holds up the goals, and shows that a servo lost its state. */
void test_goals_refused_in_the_queue_leave_in_the_same_period(void)
{
    begin();
    run_periods(1);
    while ((int32_t)(cycle.next_us - port_fake.now_us) > 50)
        turn();
    TEST_ASSERT_NULL(bus.request);
    request_shows_loss = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 2, CDS_REG_TORQUE_ENABLE, 1));
    goals_sent = 0;
    for (uint8_t i = 0; i < 7; i++)
        turn();
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.goals.result);
    run_periods(1);
    TEST_ASSERT_TRUE(servos[1].inhibited);
    TEST_ASSERT_EQUAL_UINT16(1, goals_sent);
    assert_told(500, -1, 502);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.unsent);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
}

/* A transaction of the application is in flight when the goals become due, and they wait in the
 * queue behind it. */
static void run_until_goals_wait(void)
{
    begin();
    run_periods(1);
    while ((int32_t)(cycle.next_us - port_fake.now_us) > 50)
        turn();
    TEST_ASSERT_NULL(bus.request);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 2, CDS_REG_TORQUE_ENABLE, 1));
    goals_sent = 0;
    for (uint8_t i = 0; i < 7; i++)
        turn();
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.goals.result);
}

void test_goals_beyond_a_new_limit_leave_the_queue_without_it(void)
{
    run_until_goals_wait();
    set_limits(1, 0, 400, CDS_VALUE_MAX);
    run_periods(1);
    TEST_ASSERT_EQUAL_UINT16(1, goals_sent);
    assert_told(500, -1, 502);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.unsent);
}

void test_change_while_goals_wait_checks_one_goal(void)
{
    run_until_goals_wait();
    checks = 0;
    set_limits(1, 0, 900, CDS_VALUE_MAX);
    run_periods(1);
    TEST_ASSERT_EQUAL_UINT16(1, goals_sent);
    TEST_ASSERT_EQUAL_UINT16(1, checks);
    assert_told(500, 501, 502);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.unsent);
}

void test_goals_of_servos_all_inhibited_in_the_queue_are_unsent(void)
{
    run_until_goals_wait();
    set_inhibits(true);
    while ((int32_t)(cycle.next_us - port_fake.now_us) > 50)
        turn();
    TEST_ASSERT_EQUAL_UINT16(0, goals_sent);
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.unsent);
    TEST_ASSERT_EQUAL_UINT16(SERVOS, cycle.counters.dropped);
}

void test_permit_without_goals_lets_all_goals_pass(void)
{
    hooks.permit_goal = NULL;
    hooks.permit = permit_all;
    set_inhibits(true);
    begin();
    inhibit(1);
    run_periods(1);
    assert_told(500, 501, 502);
    TEST_ASSERT_EQUAL_UINT16(0, checks);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
}

void test_servo_that_changes_twice_is_the_only_one_checked(void)
{
    begin();
    while (bus.request)
        turn();
    checks = 0;
    inhibit(1);
    cds_cycle_poll(&cycle);
    TEST_ASSERT_TRUE(cycle.is_checking);
    set_limits(1, 0, 400, CDS_VALUE_MAX);
    while (cycle.is_checking)
        cds_cycle_poll(&cycle);
    TEST_ASSERT_EQUAL_UINT16(1, checks); // no goal is left of it for a second check
    inhibit(0);
    cds_cycle_poll(&cycle);
    inhibit(2); // another one: all of them
    while (cycle.is_checking)
        cds_cycle_poll(&cycle);
    TEST_ASSERT_EQUAL_UINT16(1 + 1 + 1, checks);
    run_periods(1);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_TRUE(cds_cycle_is_dropped(&cycle, i));
    TEST_ASSERT_FALSE(cds_cycle_is_dropped(&cycle, SERVOS));
}

/* Held while it waits behind something that lasts nearly as long as the period. */
void test_goals_refused_too_late_in_the_period_are_not_sent(void)
{
    begin();
    run_periods(1);
    while ((int32_t)(cycle.next_us - port_fake.now_us) > 20)
        turn();
    while (cycle.is_reading)
        turn();
    goals_sent = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 77));
    port_fake.us_per_reading = 0;
    dead = 77;
    for (uint8_t i = 0; i < 8; i++)
        turn();
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.goals.result);
    inhibit(0);
    port_fake.now_us += PERIOD_US - 250; // the main loop is away
    while (cycle.goals.result == CDS_PENDING)
        turn();
    turn();
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.unsent);
    TEST_ASSERT_EQUAL_UINT16(0, goals_sent);
    run_periods(1);
    assert_told(-1, 501, 502);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
}

/* The permit refuses no servo that is offline. */
void test_servo_that_does_not_answer_stays_in(void)
{
    begin();
    dead = 9;
    run_periods(40);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, feedback[2].result);
    assert_told(500, 501, 502);
    dead = 0;
    inhibit(2); // it has returned
    run_periods(2);
    assert_told(500, 501, -1);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.unsent);
}

/* The bus waits 508 us, and each of these 0: a READ in vain takes 350 us, and the bus rests for
 * 1900 us behind it: four READs in five periods of 2 ms. */
void test_read_unanswered_counts_as_wire_time_as_long_as_it_took(void)
{
    cds_bus_set_return_delay(&bus, CDS_RETURN_DELAY_MAX_US);
    return_delay_us = 0;
    all_dead = true;
    begin();
    run_periods(20);
    TEST_ASSERT_EQUAL_UINT32(cycle.counters.reads, cycle.counters.failed);
    TEST_ASSERT_UINT16_WITHIN(30, (10 * SIZE + 4 * 350 / 5) * 1000ul / PERIOD_US,
                              cds_cycle_utilisation_permille(&cycle));
}

void test_goals_set_before_the_hooks_are_attached_are_checked(void)
{
    bus.hooks = NULL;
    memset(&cycle, 0, sizeof cycle);
    TEST_ASSERT_EQUAL(CDS_OK, begin_cycle());
    set_limits(1, 0, 400, CDS_VALUE_MAX);
    set_all(500);
    TEST_ASSERT_EQUAL_UINT16(0, checks);
    epoch = 1;
    changed_id = ids[0]; // the last change concerns another servo
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, &hooks));
    run_periods(2);
    assert_told(500, -1, 502);
    TEST_ASSERT_EQUAL_UINT16(SERVOS, checks);
}

void test_goals_of_a_permit_that_never_changed_are_checked(void)
{
    bus.hooks = NULL;
    memset(&cycle, 0, sizeof cycle);
    TEST_ASSERT_EQUAL(CDS_OK, begin_cycle());
    set_limits(1, 0, 400, CDS_VALUE_MAX);
    set_all(500);
    epoch = 1;
    changed_id = CDS_NO_ID; // no servo has changed since the permit began
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, &hooks));
    run_periods(2);
    assert_told(500, -1, 502);
    TEST_ASSERT_EQUAL_UINT16(SERVOS, checks);
}

void test_goals_with_only_a_queue_are_sent_unchecked(void)
{
    bus.hooks = NULL;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, &queue.hooks));
    set_inhibits(true);
    begin();
    assert_told(500, 501, 502);
    TEST_ASSERT_EQUAL_UINT16(0, checks);
}

/* The goals of a period without a change carry the epoch of their check. */
void test_goals_unchanged_are_checked_once(void)
{
    begin();
    run_periods(5);
    TEST_ASSERT_EQUAL_UINT16(SERVOS, checks);
    TEST_ASSERT_EQUAL_UINT16(epoch, cycle.goals.permit_epoch);
    inhibit(1);
    run_periods(1);
    TEST_ASSERT_EQUAL_UINT16(SERVOS + 1, checks);
    change(CDS_BROADCAST_ID);
    run_periods(1);
    TEST_ASSERT_EQUAL_UINT16(SERVOS + 1 + 2, checks); // the servo left out has no goal
}

void test_index_hint_in_the_order_of_the_ids_is_right(void)
{
    begin();
    run_periods(1);
    for (uint8_t i = SERVOS; i--;)
        TEST_ASSERT_EQUAL(CDS_OK, set(i, 600));
    change(CDS_BROADCAST_ID);
    run_periods(1);
    TEST_ASSERT_EQUAL_UINT16(0, hint_misses);
    TEST_ASSERT_EQUAL_UINT8(cycle.turn, cycle.read.servo_index);
}

void test_read_of_a_muted_servo_lets_the_others_go_on(void)
{
    is_read_muted = true;
    begin();
    run_periods(1);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL(CDS_NO_REPLY_DUE, feedback[i].result);
    assert_told(500, 501, 502);
}
