/* The cycle on a bus with a roster: who is held is left out, and nobody else notices. */
#include <string.h>

#include "cds55xx/cycle.h"
#include "cds55xx/servos.h"
#include "cds55xx/servo.h"
#include "port_fake.h"
#include "unity.h"

#define SERVOS    3
#define PERIOD_US 2000
#define SIZE      (8 + 5 * SERVOS) // of the goals' packet
#define SPEED     0x123
#define STEP_US   10

static struct cds_bus bus;
static struct cds_servos roster;
static struct cds_servo_state servos[SERVOS];
static struct cds_cycle cycle;
static struct cds_feedback feedback[SERVOS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];
static const uint8_t ids[SERVOS] = {4, 2, 9};

static uint8_t goals[SIZE];    // the last ones on the wire
static uint16_t goals_sent;    // how many
static uint8_t dead;           // ID of one that does not answer, 0: none
static bool all_dead;          // nobody answers a READ
static uint8_t torque_of_read; // what READ of TORQUE_ENABLE is answered with
static uint32_t busy_until_us; // a packet is on the wire

static uint8_t buffer[16];
static struct cds_request request;

void setUp(void)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    memset(&cycle, 0, sizeof cycle);
    memset(feedback, 0, sizeof feedback);
    memset(goals, 0, sizeof goals);
    goals_sent = 0;
    dead = 0;
    all_dead = false;
    torque_of_read = 1;
    busy_until_us = 0;
    request = (struct cds_request)CDS_REQUEST(buffer);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, 2);
    for (uint8_t i = 0; i < SERVOS; i++)
        servos[i].id = ids[i];
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_begin(&roster, &bus, servos, SERVOS));
    for (uint8_t i = 0; i < SERVOS; i++)
        servos[i].ccw_limit = CDS_ANGLE_SET;
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_cycle_begin(&cycle, &bus, ids, SERVOS, packets, feedback, PERIOD_US));
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
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
        if (sent[CDS_AT_PARAMETERS] == CDS_REG_TORQUE_ENABLE)
            port_fake_answer(&bus.link, sent[CDS_AT_ID], 0, &torque_of_read, 1);
        else
            port_fake_answer(&bus.link, sent[CDS_AT_ID], 0, registers, sizeof registers);
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
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
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
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
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

void test_one_that_is_held_is_left_out_and_the_others_go_on(void)
{
    for (uint8_t held = 0; held < SERVOS; held++) {
        setUp();
        begin();
        assert_told(500, 501, 502);
        cds_servos_hold(&roster, &servos[held], CDS_INHIBIT_STOPPED);
        run_periods(3);
        assert_told(held == 0 ? -1 : 500, held == 1 ? -1 : 501, held == 2 ? -1 : 502);
        for (uint8_t i = 0; i < SERVOS; i++)
            TEST_ASSERT_EQUAL(i == held, cds_cycle_is_dropped(&cycle, i));
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
    cds_servos_hold(&roster, &servos[1], CDS_INHIBIT_STATE_LOST);
    run_periods(1);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 600));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, set(1, 601));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(600, -1, 502);
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

/* Some goals are set, and not committed, when it happens. */
void test_goals_being_filled_are_left_out_too(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, set(2, 700));
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 701));
    cds_servos_hold(&roster, &servos[2], CDS_INHIBIT_STATE_LOST);
    run_periods(1);
    assert_told(500, 501, -1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(701, 501, -1);
    TEST_ASSERT_TRUE(cds_cycle_is_dropped(&cycle, 2));
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

/* Held after the commit, before the period begins. */
void test_goals_committed_but_not_sent_yet_are_judged_once_more(void)
{
    begin();
    set_all(700);
    cds_servos_hold(&roster, &servos[0], CDS_INHIBIT_STATE_LOST);
    run_periods(1);
    assert_told(-1, 701, 702);
}

/* Held, and at once the others' goals are set and committed: that judges nobody else. */
void test_a_commit_right_after_a_hold_does_not_let_it_through(void)
{
    begin();
    cds_servos_hold(&roster, &servos[0], CDS_INHIBIT_STATE_LOST);
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 700));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(-1, 700, 502);
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

/* Goals are being filled all the time; two servos are held, one after the other and both at once.
 */
void test_two_that_are_held_are_both_left_out(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 700));
    cds_servos_hold(&roster, &servos[0], CDS_INHIBIT_STATE_LOST);
    cds_servos_hold(&roster, &servos[2], CDS_INHIBIT_STATE_LOST);
    run_periods(1);
    assert_told(-1, 501, -1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(-1, 700, -1);

    setUp();
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 700));
    cds_servos_hold(&roster, &servos[2], CDS_INHIBIT_STATE_LOST);
    run_periods(1);
    cds_servos_hold(&roster, &servos[1], CDS_INHIBIT_STATE_LOST);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(500, -1, -1);
    TEST_ASSERT_EQUAL_UINT16(2, cycle.counters.dropped);
}

/* The limit is the filled goal's own: the one that is being sent lies within. */
void test_a_filled_goal_beyond_a_new_limit_is_left_out_when_committed(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 700));
    cds_servos_set_limits(&roster, &servos[0], 0, 600, 1023);
    run_periods(1);
    assert_told(500, 501, 502);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(-1, 501, 502);
}

void test_release_alone_brings_none_back_a_goal_does(void)
{
    begin();
    cds_servos_hold(&roster, &servos[1], CDS_INHIBIT_STATE_LOST);
    run_periods(1);
    cds_servos_release(&roster, &servos[1]);
    run_periods(2);
    assert_told(500, -1, 502);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 600));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(600, -1, 502);
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 610));
    run_periods(1);
    assert_told(600, -1, 502); // set, but not committed
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(600, 610, 502);
    TEST_ASSERT_FALSE(cds_cycle_is_dropped(&cycle, 1));
}

void test_a_goal_that_was_to_bring_it_back_does_not_outlive_a_second_hold(void)
{
    begin();
    cds_servos_hold(&roster, &servos[1], CDS_INHIBIT_STATE_LOST);
    run_periods(1);
    cds_servos_release(&roster, &servos[1]);
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 610));
    run_periods(1);
    cds_servos_hold(&roster, &servos[1], CDS_INHIBIT_STOPPED);
    run_periods(1);
    cds_servos_release(&roster, &servos[1]);
    run_periods(1);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 600));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(600, -1, 502);
    TEST_ASSERT_TRUE(cds_cycle_is_dropped(&cycle, 1));
    TEST_ASSERT_EQUAL_UINT16(1, cycle.counters.dropped);
}

void test_when_all_are_held_nothing_is_sent_and_periods_pass(void)
{
    begin();
    cds_servos_hold(&roster, NULL, CDS_INHIBIT_STOPPED);
    run_periods(3);
    TEST_ASSERT_EQUAL_UINT16(2, goals_sent);
    TEST_ASSERT_EQUAL_UINT32(5, cycle.counters.periods);
    TEST_ASSERT_EQUAL_UINT32(3, cycle.counters.unsent);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_EQUAL_UINT16(SERVOS, cycle.counters.dropped);
    cds_servos_release(&roster, NULL);
    run_periods(1);
    TEST_ASSERT_EQUAL_UINT16(2, goals_sent);
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 300));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(-1, 300, -1);
    TEST_ASSERT_EQUAL_UINT16(3, goals_sent);
}

void test_one_held_from_the_beginning_is_not_waited_for(void)
{
    cds_servos_hold(&roster, &servos[2], CDS_INHIBIT_STATE_LOST);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 500));
    TEST_ASSERT_EQUAL(CDS_OK, set(1, 501));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_cycle_commit(&cycle)); // nothing was said of it
    TEST_ASSERT_EQUAL(CDS_INHIBITED, set(2, 502));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_into_the_second();
    assert_told(500, 501, -1);
    cds_servos_release(&roster, NULL);
    TEST_ASSERT_EQUAL(CDS_OK, set(2, 502));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(500, 501, 502);
}

void test_a_goal_beyond_a_limit_is_not_taken_and_the_old_one_stays(void)
{
    cds_servos_set_limits(&roster, &servos[0], 100, 600, 0x200);
    begin();
    TEST_ASSERT_EQUAL(CDS_LIMIT, set(0, 601));
    TEST_ASSERT_EQUAL(CDS_LIMIT, set(0, 99));
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_cycle_goal(&cycle, 0, 500, 0x201));
    TEST_ASSERT_EQUAL(CDS_LIMIT, cds_cycle_goal(&cycle, 0, 500, 0)); // as fast as it can
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(500, 501, 502);
    TEST_ASSERT_EQUAL(CDS_OK, set(0, 600));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(600, 501, 502);
    TEST_ASSERT_EQUAL_UINT16(0, cycle.counters.dropped);
}

void test_one_whose_limit_is_drawn_closer_than_its_goal_is_left_out(void)
{
    begin();
    cds_servos_set_limits(&roster, &servos[2], 0, 501, 1023);
    run_periods(1);
    assert_told(500, 501, -1);
    TEST_ASSERT_EQUAL(CDS_LIMIT, set(2, 502));
    TEST_ASSERT_EQUAL(CDS_OK, set(2, 400));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_commit(&cycle));
    run_periods(1);
    assert_told(500, 501, 400);
}

/* An exchange of the application's holds up the goals, and shows that a servo lost its state. */
void test_goals_refused_in_the_queue_go_out_in_the_same_period(void)
{
    TEST_ASSERT_EQUAL(
        CDS_OK, cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1));
    while (bus.request)
        turn();
    TEST_ASSERT_TRUE(servos[1].torque);
    begin();
    run_periods(1);
    while ((int32_t)(cycle.next_us - port_fake.now_us) > 50)
        turn();
    TEST_ASSERT_NULL(bus.request);
    torque_of_read = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 2, CDS_REG_TORQUE_ENABLE, 1));
    goals_sent = 0;
    for (uint8_t i = 0; i < 7; i++)
        turn();
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.goals.result);
    run_periods(1);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, servos[1].held);
    TEST_ASSERT_EQUAL_UINT16(1, goals_sent);
    assert_told(500, -1, 502);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.unsent);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
}

/* Held while it waits behind something that lasts nearly as long as the period. */
void test_goals_refused_so_late_that_they_would_hold_up_the_next_ones_are_not_sent(void)
{
    begin();
    run_periods(1);
    while ((int32_t)(cycle.next_us - port_fake.now_us) > 20)
        turn();
    while (cycle.reading)
        turn();
    goals_sent = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 77));
    port_fake.us_per_reading = 0;
    dead = 77;
    for (uint8_t i = 0; i < 8; i++)
        turn();
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.goals.result);
    cds_servos_hold(&roster, &servos[0], CDS_INHIBIT_STATE_LOST);
    port_fake.now_us += PERIOD_US - 250; // the main loop is away
    turn();
    turn();
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.unsent);
    TEST_ASSERT_EQUAL_UINT16(0, goals_sent);
    run_periods(1);
    assert_told(-1, 501, 502);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
}

/* One that is away is not held: what is said to all goes on. */
void test_one_that_is_away_stays_in_and_is_left_out_when_it_is_back(void)
{
    begin();
    dead = 9;
    for (uint8_t i = 0; i < 40 && servos[2].presence != CDS_PRESENCE_OFFLINE; i++)
        run_periods(1);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, servos[2].presence);
    assert_told(500, 501, 502);
    dead = 0;
    for (uint8_t i = 0; i < 40 && servos[2].presence == CDS_PRESENCE_OFFLINE; i++)
        run_periods(1);
    run_periods(1);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_RETURNED, servos[2].presence);
    assert_told(500, 501, -1);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.unsent);
}

/* The bus waits 508 us, and each of these 0: a READ in vain takes 350 us, and the bus rests for
 * 1900 us behind it: four READs in five periods of 2 ms. */
void test_a_read_in_vain_is_on_the_wire_for_as_long_as_it_was_waited_for(void)
{
    cds_bus_set_return_delay(&bus, CDS_RETURN_DELAY_MAX_US);
    for (uint8_t i = 0; i < SERVOS; i++)
        servos[i].return_delay = 0;
    all_dead = true;
    begin();
    run_periods(20);
    TEST_ASSERT_EQUAL_UINT32(cycle.counters.reads, cycle.counters.failed);
    TEST_ASSERT_UINT16_WITHIN(30, (10 * SIZE + 4 * 350 / 5) * 1000ul / PERIOD_US,
                              cds_cycle_utilisation_permille(&cycle));
}

void test_goals_of_before_a_roster_begun_anew_are_not_sent(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_begin(&roster, &bus, servos, SERVOS));
    for (uint8_t i = 0; i < SERVOS; i++)
        servos[i].ccw_limit = CDS_ANGLE_SET;
    for (uint8_t i = 0; i < 5; i++) // as many changes as there were
        cds_servos_set_limits(&roster, &servos[1], 0, 400, 1023);
    run_periods(2);
    assert_told(500, -1, 502);
}
