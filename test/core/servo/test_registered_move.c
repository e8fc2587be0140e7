/* SPDX-License-Identifier: MIT */
/* The registered move: its steps byte by byte, and then every fault at every transaction, against
 * three servos of the test's own. */
#include "cds55xx/registered_move.h"

#include <string.h>

#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "cds55xx/servos.h"
#include "bus_rig.h"
#include "packets.h"
#include "unity.h"

#define PORT   0
#define SERVOS 3

static struct cds_queue queue;
static uint8_t buffer[CDS_REGISTERED_MOVE_SIZE], reply[CDS_REGISTERED_MOVE_VERIFY_REPLY];
static struct cds_request request;

static uint8_t other_buffer[8];
static struct cds_request other;
static struct cds_registered_move move;
static struct cds_goal goals[SERVOS]; // AddressSanitizer watches its ends

/* ---- three servos ---- */

enum fault {
    NONE,
    LOSE_PACKET, // no servo hears it
    LOSE_REPLY,
    SPOIL_REPLY,
    CUT_BEFORE, // power is cut before the packet is carried out
    CUT_AFTER,  // ... after it, before the reply
    REFUSE,     // with each of the four error bits of a packet
    FAULTS = REFUSE + 4,
};

static const uint8_t refusals[] = {CDS_ERROR_ANGLE, CDS_ERROR_RANGE, CDS_ERROR_CHECKSUM,
                                   CDS_ERROR_INSTRUCTION};

struct servo {
    uint8_t table[0x32];
    uint8_t kept[4]; // goal and speed that were registered
    bool moved;
    bool dead;
    bool locked;
};

static struct servo servos[SERVOS];

/* What happens at transactions `at` to `to`, counted from 1, and at `first`, if it is not 0; to the
 * servo that is spoken to, or, if that is all of them, to `victim`. */
static struct {
    uint8_t at, to;
    uint8_t fault;
    uint8_t first, first_fault;
    uint8_t victim;
    bool for_good; // power does not come back
} plan;

static uint8_t transactions, actions;

static void power_up(struct servo *servo)
{
    servo->table[0x2C] = 0;
    memset(&servo->table[0x1E], 0, 4);
    servo->dead = plan.for_good;
    servo->locked = false;
}

static void act(struct servo *servo)
{
    actions++;
    if (servo->dead || !servo->table[0x2C])
        return;
    servo->table[0x2C] = 0;
    memcpy(&servo->table[0x1E], servo->kept, 4);
    servo->moved = true;
}

/* Carries out what stands in `packet`; returns its ERROR. */
static uint8_t obey(struct servo *servo, const uint8_t *packet)
{
    if (packet[4] == 3 && servo->locked)
        return CDS_ERROR_RANGE;
    if (packet[4] == 3)
        servo->table[packet[5]] = packet[6];
    if (packet[4] == 4) {
        memcpy(servo->kept, &packet[6], 4);
        servo->table[0x2C] = 1;
    }
    return 0;
}

static uint8_t fault_now(void)
{
    transactions++;
    if (transactions == plan.first)
        return plan.first_fault;
    return transactions >= plan.at && transactions <= plan.to ? plan.fault : (uint8_t)NONE;
}

static void all_hear(uint8_t fault)
{
    for (uint8_t i = 0; i < SERVOS && fault != LOSE_PACKET; i++) {
        bool cut = i == plan.victim && (fault == CUT_BEFORE || fault == CUT_AFTER);

        if (!cut || fault == CUT_AFTER)
            act(&servos[i]);
        if (cut)
            power_up(&servos[i]);
    }
}

static void one_hears(struct servo *servo, const uint8_t *packet, uint8_t fault)
{
    uint8_t count = packet[4] == 2 ? packet[6] : 0, error = 0;

    if (fault >= REFUSE && fault < FAULTS) {
        error = refusals[fault - REFUSE];
        count = 0;
    } else if (fault != LOSE_PACKET && fault != CUT_BEFORE && !servo->dead) {
        error = obey(servo, packet);
    }
    if (fault == CUT_BEFORE || fault == CUT_AFTER)
        power_up(servo);
    if (servo->dead || (fault != NONE && fault < SPOIL_REPLY) || fault == CUT_BEFORE ||
        fault == CUT_AFTER)
        return;
    if (fault == SPOIL_REPLY)
        port_fake_hear(&bus.link, (const uint8_t *)"\xFF\xFF\x01\x02\x00\x00", 6);
    else
        port_fake_answer(&bus.link, packet[2], error, &servo->table[packet[5]], count);
}

/* One turn of the main loop but for polling. */
static void turn(void)
{
    const uint8_t *packet = port_fake.sent;

    port_fake.now_us += 60;
    if (bus.link.state != CDS_LINK_TALKING)
        return;
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    if (packet[2] == 0xFE) {
        all_hear(fault_now());
        return;
    }
    for (uint8_t i = 0; i < SERVOS; i++)
        if (goals[i].id == packet[2])
            one_hears(&servos[i], packet, fault_now());
}

/* ---- */

void setUp(void)
{
    rig_open_with_queue(PORT, &queue);
    memset(buffer, 0, sizeof buffer);
    memset(servos, 0, sizeof servos);
    memset(&plan, 0, sizeof plan);
    transactions = actions = 0;
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    other = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(other_buffer);
    goals[0] = (struct cds_goal){.id = 0, .position = 0, .speed = 0x100};
    goals[1] = (struct cds_goal){.id = 1, .position = 0x3FF, .speed = 0x200};
    goals[2] = (struct cds_goal){.id = 7, .position = 0x234, .speed = 0};
}

void tearDown(void)
{
    rig_check();
}

/* ---- step by step ---- */

static enum cds_result begin_move(uint8_t count, bool verify)
{
    return cds_registered_move_begin(
        &move,
        &(struct cds_registered_move_config){
            .bus = &bus, .request = &request, .goals = goals, .count = count, .verify = verify});
}

static void begin(uint8_t count)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin_move(count, false));
}

static void begin_verified(uint8_t count)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin_move(count, true));
}

static void poll_sends(const uint8_t *bytes, uint8_t size)
{
    for (uint8_t i = 0; i < 2 && !bus.request; i++) // a step may send nothing, but not two of them
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    rig_assert_sent(bytes, size);
}

/* The transaction in flight ends. */
static void bus_ends(void)
{
    port_fake_look(&bus);
    TEST_ASSERT_NULL(bus.request);
}

static void answered(uint8_t id, uint8_t error)
{
    port_fake_answer(&bus.link, id, error, NULL, 0);
    bus_ends();
}

static void answered_with(uint8_t id, const uint8_t *parameters, uint8_t count)
{
    port_fake_answer(&bus.link, id, 0, parameters, count);
    bus_ends();
}

static void assert_over(enum cds_result result)
{
    uint16_t packets = port_fake.packets;

    for (uint8_t i = 0; i < 3; i++)
        TEST_ASSERT_EQUAL(result, cds_registered_move_poll(&move));
    TEST_ASSERT_EQUAL_UINT16(packets, port_fake.packets);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus)); // and none is under way
}

/* REG WRITE of goal and speed, 0x1E on; READ of 0x2C, of 0x1E to 0x2C; WRITE of 0x2C = 0; ACTION:
 * computed by hand. */
static const uint8_t register_0[] = {0xFF, 0xFF, 0, 7, 4, 0x1E, 0x00, 0x00, 0x00, 0x01, 0xD5};
static const uint8_t register_1[] = {0xFF, 0xFF, 1, 7, 4, 0x1E, 0xFF, 0x03, 0x00, 0x02, 0xD1};
static const uint8_t register_7[] = {0xFF, 0xFF, 7, 7, 4, 0x1E, 0x34, 0x02, 0x00, 0x00, 0x99};
static const uint8_t read_0[] = {0xFF, 0xFF, 0, 4, 2, 0x2C, 1, 0xCC};
static const uint8_t read_1[] = {0xFF, 0xFF, 1, 4, 2, 0x2C, 1, 0xCB};
static const uint8_t outcome_0[] = {0xFF, 0xFF, 0, 4, 2, 0x1E, 15, 0xCC};
static const uint8_t clear_0[] = {0xFF, 0xFF, 0, 4, 3, 0x2C, 0x00, 0xCC};
static const uint8_t clear_1[] = {0xFF, 0xFF, 1, 4, 3, 0x2C, 0x00, 0xCB};
static const uint8_t action[] = {0xFF, 0xFF, 0xFE, 2, 5, 0xFA};

#define SENDS(bytes) poll_sends(bytes, sizeof(bytes))

void test_move_registers_each_goal_then_sends_action(void)
{
    begin(3);
    SENDS(register_0);
    answered(0, 0);
    SENDS(register_1);
    answered(1, 0);
    SENDS(register_7);
    answered(7, 0);
    SENDS(action);
    bus_ends();
    assert_over(CDS_OK);
    for (uint8_t i = 0; i < 3; i++)
        TEST_ASSERT_EQUAL(CDS_OK, goals[i].result);
}

/* Example 19 moves two servos by the same three steps; its REG WRITEs leave the speed out. */
void test_move_of_example_19_keeps_the_manuals_order(void)
{
    static const uint8_t steps[] = {30, 32, 34}; // where they stand among the manual's packets

    begin(2);
    for (uint8_t i = 0; i < sizeof steps; i++) {
        const struct manual_packet *said = &manual_packets[steps[i]];

        TEST_ASSERT_EQUAL_UINT8(19, said->example);
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
        TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
        TEST_ASSERT_EQUAL_HEX8(said->bytes[2], port_fake.sent[2]);
        TEST_ASSERT_EQUAL_HEX8(said->bytes[4], port_fake.sent[4]);
        if (i < 2) { // address and goal
            TEST_ASSERT_EQUAL_HEX8_ARRAY(said->bytes + 5, port_fake.sent + 5, 3);
            port_fake_hear(&bus.link, said[1].bytes, said[1].size);
        } else {
            rig_assert_sent(said->bytes, said->size);
        }
        bus_ends();
    }
    assert_over(CDS_OK);
}

void test_move_of_one_servo(void)
{
    static const uint8_t register_253[] = {0xFF, 0xFF, 253,  7,    4,   0x1E,
                                           0x00, 0x00, 0x00, 0x01, 0xD8};

    goals[0].id = CDS_ID_MAX; // the last there is
    begin(1);
    SENDS(register_253);
    answered(253, 0);
    SENDS(action);
    bus_ends();
    assert_over(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
}

void test_move_sends_nothing_before_its_first_poll(void)
{
    begin(2);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    TEST_ASSERT_EQUAL(CDS_PENDING, move.steps.result);
}

/* One transaction at a time: while a servo has not answered, polling the move does nothing. */
void test_move_waits_for_each_answer(void)
{
    begin(2);
    SENDS(register_0);
    for (uint8_t i = 0; i < 10; i++) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    }
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

/* A condition that merely holds does not mean that the goal was not taken. */
void test_move_goes_on_in_spite_of_conditions(void)
{
    begin(1);
    SENDS(register_0);
    answered(0, CDS_ERRORS_OF_CONDITION);
    SENDS(action);
    bus_ends();
    assert_over(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERRORS_OF_CONDITION, goals[0].error);
}

void test_move_waits_while_the_bus_is_busy(void)
{
    rig_occupy(&other);
    begin(1);
    for (uint8_t i = 0; i < 5; i++)
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
    rig_free();
    SENDS(register_0);
    answered(0, 0);
    rig_occupy(&other); // and between two steps of its own
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
    rig_free();
    SENDS(action);
    bus_ends();
    assert_over(CDS_OK);
}

void test_begin_with_a_pending_request_is_busy(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_BUSY, begin_move(1, false));
    rig_free();
    begin(1);
    SENDS(register_0);
    answered(0, 0);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
}

void test_begin_without_goals_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_move(0, false));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
}

void test_move_refused_by_the_second_servo_clears_both(void)
{
    static const uint8_t zero = 0;

    begin(3);
    SENDS(register_0);
    answered(0, 0);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
    TEST_ASSERT_EQUAL(CDS_REGISTERED_YES, goals[0].registered);
    TEST_ASSERT_EQUAL(CDS_REGISTERED_IN_DOUBT, goals[1].registered);
    SENDS(register_1);
    answered(1, CDS_ERROR_ANGLE);
    SENDS(clear_0);
    answered(0, 0);
    SENDS(read_0);
    answered_with(0, &zero, 1);
    SENDS(clear_1); // it may keep an earlier one (R21)
    answered(1, 0);
    SENDS(read_1);
    answered_with(1, &zero, 1);
    assert_over(CDS_REFUSED);
    TEST_ASSERT_FALSE(move.acted);
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
    TEST_ASSERT_EQUAL(CDS_REFUSED, goals[1].result);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_ANGLE, goals[1].error);
    TEST_ASSERT_EQUAL(CDS_PENDING, goals[2].result); // it was not asked
}

void test_verified_move_reads_before_and_after_action(void)
{
    static const uint8_t one = 1;
    static const uint8_t outcome[15] = {0x00, 0x00, 0x00, 0x01, 32, 32};

    begin_verified(1);
    SENDS(register_0);
    answered(0, 0);
    SENDS(read_0);
    answered_with(0, &one, 1);
    SENDS(action);
    bus_ends();
    SENDS(outcome_0);
    TEST_ASSERT_TRUE(move.acted);
    answered_with(0, outcome, sizeof outcome);
    assert_over(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
    TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[0].registered);
}

/* ACTION is refused late and in silence (R39), or power failed just before it: 0x2C is 0, but the
 * goal is another. Each byte of it counts. */
void test_verified_move_wants_the_goal_as_it_was_set(void)
{
    static const uint8_t one = 1;

    for (uint8_t i = 0; i < 4; i++) {
        uint8_t outcome[15] = {0x00, 0x00, 0x00, 0x01};

        outcome[i] ^= 2;
        begin_verified(1);
        SENDS(register_0);
        answered(0, 0);
        SENDS(read_0);
        answered_with(0, &one, 1);
        SENDS(action);
        bus_ends();
        SENDS(outcome_0);
        answered_with(0, outcome, sizeof outcome);
        assert_over(CDS_REFUSED);
        TEST_ASSERT_TRUE(move.acted);
        TEST_ASSERT_EQUAL(CDS_REFUSED, goals[0].result);
        TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[0].registered);
    }
}

static void assert_begin_refused(enum cds_result result, uint8_t count, bool verify)
{
    TEST_ASSERT_EQUAL(result, begin_move(count, verify));
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

/* All goals are judged before the first REG WRITE. Broadcast would be answered by none. */
void test_move_with_a_bad_goal_anywhere_sends_nothing(void)
{
    static const uint16_t wrong[][3] = {{254, 0, 0}, {255, 0, 0}, {1, 1024, 0}, {1, 0, 1024}};

    for (uint8_t at = 0; at < 3; at++) {
        struct cds_goal good = goals[at];

        for (uint8_t i = 0; i < 4; i++) {
            goals[at].id = (uint8_t)wrong[i][0];
            goals[at].position = wrong[i][1];
            goals[at].speed = wrong[i][2];
            assert_begin_refused(CDS_BAD_ARGUMENT, 3, false);
            for (uint8_t j = 0; j < 3; j++)
                TEST_ASSERT_EQUAL(j == at ? CDS_BAD_ARGUMENT : CDS_PENDING, goals[j].result);
        }
        goals[at] = good;
    }
}

void test_goals_at_the_end_of_their_range_are_sent(void)
{
    goals[0].position = goals[0].speed = CDS_VALUE_MAX;
    TEST_ASSERT_EQUAL(CDS_OK, begin_move(1, false));
    cds_registered_move_poll(&move);
    TEST_ASSERT_TRUE(cds_bus_is_busy(&bus));
}

void test_begin_with_small_buffers_is_refused(void)
{
    request.packet.capacity = CDS_REGISTERED_MOVE_SIZE - 1;
    assert_begin_refused(CDS_NO_ROOM, 2, false);
    request.packet.capacity = CDS_REGISTERED_MOVE_SIZE;
    request.reply_capacity = CDS_REGISTERED_MOVE_VERIFY_REPLY - 1;
    assert_begin_refused(CDS_NO_ROOM, 2, true);
    request.reply_capacity = 0; // clearing a goal needs a READ
    assert_begin_refused(CDS_NO_ROOM, 2, false);
    request.reply_capacity = CDS_REGISTERED_MOVE_REPLY;
    begin(2);
    SENDS(register_0);
}

void test_begin_on_a_closed_bus_is_refused(void)
{
    memset(&bus, 0, sizeof bus);
    assert_begin_refused(CDS_BAD_ARGUMENT, 2, false);
}

/* ---- every fault at every transaction ---- */

static void run(bool verified)
{
    uint16_t turns = 0;

    transactions = actions = 0;
    TEST_ASSERT_EQUAL(CDS_OK, begin_move(SERVOS, verified));
    while (cds_registered_move_poll(&move) == CDS_PENDING) {
        turn();
        cds_bus_poll(&bus);
        TEST_ASSERT_LESS_THAN(2000, turns++);
    }
    TEST_ASSERT_NULL(bus.request);
}

/* As run(), with one fault, on fresh servos. */
static void run_with(bool verified, uint8_t fault, uint8_t at, uint8_t to)
{
    memset(servos, 0, sizeof servos);
    plan.fault = fault;
    plan.at = at;
    plan.to = to;
    run(verified);
}

/* Whatever happened: what `registered` says of a servo is true. */
static void assert_truth(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        if (goals[i].registered != CDS_REGISTERED_IN_DOUBT)
            TEST_ASSERT_EQUAL(goals[i].registered == CDS_REGISTERED_YES, servos[i].table[0x2C]);
}

static void assert_moved(bool moved)
{
    TEST_ASSERT_EQUAL(moved, move.acted);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL(moved, servos[i].moved);
}

static enum cds_result result_of(uint8_t fault)
{
    if (fault >= REFUSE)
        return CDS_REFUSED;
    return fault == SPOIL_REPLY ? CDS_CORRUPT : CDS_TIMEOUT;
}

static uint8_t registered(void)
{
    return (uint8_t)(servos[0].table[0x2C] + servos[1].table[0x2C] + servos[2].table[0x2C]);
}

void test_run_without_faults(void)
{
    for (uint8_t verified = 0; verified < 2; verified++) {
        run_with(verified, NONE, 0, 0);
        TEST_ASSERT_EQUAL(CDS_OK, move.steps.result);
        TEST_ASSERT_EQUAL_UINT8(verified ? 10 : 4, transactions);
        assert_moved(true);
        assert_truth();
    }
}

/* Transaction `at` is of servo (at - 1) % 3, and no later than the last before ACTION. */
static void assert_called_off(bool verified, uint8_t fault, uint8_t at)
{
    uint8_t asked = at < SERVOS ? at : SERVOS;
    uint8_t who = (uint8_t)((at - 1) % SERVOS);

    run_with(verified, fault, at, at);
    TEST_ASSERT_EQUAL(result_of(fault), move.steps.result);
    TEST_ASSERT_EQUAL_UINT8(0, actions);
    TEST_ASSERT_EQUAL_UINT8(0, registered());
    TEST_ASSERT_EQUAL_UINT8(at + 2 * asked, transactions); // 0x2C written, and read, of each asked
    assert_moved(false);
    for (uint8_t i = 0; i < SERVOS; i++) {
        enum cds_result expected = i < asked ? CDS_OK : CDS_PENDING;

        TEST_ASSERT_EQUAL(i == who ? result_of(fault) : expected, goals[i].result);
        TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[i].registered);
    }
    if (fault >= REFUSE)
        TEST_ASSERT_EQUAL_HEX8(refusals[fault - REFUSE], goals[who].error);
}

void test_any_fault_before_action_clears_all_goals(void)
{
    for (uint8_t fault = LOSE_PACKET; fault < FAULTS; fault++) {
        for (uint8_t at = 1; at <= SERVOS; at++)
            assert_called_off(false, fault, at);
        for (uint8_t at = 1; at <= 2 * SERVOS; at++)
            assert_called_off(true, fault, at);
    }
}

/* Its power failed behind its answer: it comes back, and knows nothing. */
void test_power_lost_between_reg_write_and_the_read(void)
{
    run_with(true, CUT_AFTER, 1, 1); // with its answer lost ...
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, move.steps.result);
    memset(servos, 0, sizeof servos);
    plan.fault = NONE;
    begin_verified(SERVOS);
    for (transactions = 0; transactions < 3;) {
        cds_registered_move_poll(&move);
        turn();
        cds_bus_poll(&bus);
    }
    power_up(&servos[1]); // ... and without
    while (cds_registered_move_poll(&move) == CDS_PENDING) {
        turn();
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_REFUSED, move.steps.result);
    TEST_ASSERT_EQUAL(CDS_REFUSED, goals[1].result);
    TEST_ASSERT_EQUAL_UINT8(0, registered());
    assert_moved(false);
    TEST_ASSERT_EQUAL_UINT8(3 + 2 + 4, transactions); // 0x2C was read as 0: not cleared
}

void test_action_that_is_lost_is_seen_if_verified(void)
{
    run_with(false, LOSE_PACKET, 4, 4);
    TEST_ASSERT_EQUAL(CDS_OK, move.steps.result); // nobody can know
    TEST_ASSERT_EQUAL_UINT8(3, registered());
    run_with(true, LOSE_PACKET, 7, 7);
    TEST_ASSERT_EQUAL(CDS_REFUSED, move.steps.result);
    TEST_ASSERT_TRUE(move.acted);
    TEST_ASSERT_EQUAL_UINT8(7 + 3 + 6, transactions);
    TEST_ASSERT_EQUAL_UINT8(0, registered());
    for (uint8_t i = 0; i < SERVOS; i++) {
        TEST_ASSERT_EQUAL(CDS_REFUSED, goals[i].result);
        TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[i].registered);
    }
}

/* That a servo has the goal already proves nothing. */
void test_action_that_is_lost_on_servos_at_their_goals(void)
{
    run_with(true, NONE, 0, 0);
    plan.fault = LOSE_PACKET;
    plan.at = plan.to = 7;
    run(true);
    TEST_ASSERT_EQUAL(CDS_REFUSED, move.steps.result);
    TEST_ASSERT_EQUAL_UINT8(7 + 3 + 6, transactions);
    assert_truth();
}

/* Only one of them does not hear it: the others are under way, and it does not follow later. */
void test_a_servo_that_misses_action_is_cleared(void)
{
    for (plan.victim = 0; plan.victim < SERVOS; plan.victim++) {
        run_with(true, CUT_BEFORE, 7, 7);
        TEST_ASSERT_EQUAL(CDS_REFUSED, move.steps.result);
        TEST_ASSERT_TRUE(move.acted);
        TEST_ASSERT_EQUAL_UINT8(10, transactions);
        assert_truth();
        for (uint8_t i = 0; i < SERVOS; i++) {
            TEST_ASSERT_EQUAL(i != plan.victim, servos[i].moved);
            TEST_ASSERT_EQUAL(i == plan.victim ? CDS_REFUSED : CDS_OK, goals[i].result);
        }
    }
}

void test_any_fault_after_action_is_told_of_its_servo(void)
{
    for (uint8_t fault = LOSE_PACKET; fault < FAULTS; fault++) {
        for (uint8_t at = 8; at <= 10; at++) {
            run_with(true, fault, at, at);
            TEST_ASSERT_EQUAL(result_of(fault), move.steps.result);
            assert_moved(true);
            TEST_ASSERT_EQUAL_UINT8(10 + 2, transactions); // cleared to be sure
            for (uint8_t i = 0; i < SERVOS; i++) {
                TEST_ASSERT_EQUAL(i == at - 8 ? result_of(fault) : CDS_OK, goals[i].result);
                TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[i].registered);
            }
        }
    }
}

void test_of_two_faults_after_action_the_first_counts(void)
{
    plan.first = 8;
    plan.first_fault = LOSE_REPLY;
    run_with(true, REFUSE, 9, 9);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, move.steps.result);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, goals[0].result);
    TEST_ASSERT_EQUAL(CDS_REFUSED, goals[1].result);
}

/* ---- clearing that fails ---- */

/* Servo 1 refuses, so servo 0 is cleared: by transactions 3 and 4, WRITE and READ, tried again as 5
 * and 6, and as 7 and 8. Those from 3 to `to` fail. */
static void assert_tries(uint8_t fault, uint8_t to, uint8_t tries, enum cds_registered expected)
{
    plan.first = 2;
    plan.first_fault = REFUSE;
    run_with(false, fault, 3, to);
    TEST_ASSERT_EQUAL(CDS_REFUSED, move.steps.result);
    TEST_ASSERT_EQUAL(expected, goals[0].registered);
    TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[1].registered); // its turn comes all the same
    TEST_ASSERT_EQUAL_UINT8(2 + 2 * tries + 2, transactions);
    TEST_ASSERT_EQUAL_UINT8(0, actions);
    assert_truth();
}

void test_clearing_not_carried_out_is_tried_three_times(void)
{
    static const uint8_t faults[] = {LOSE_PACKET, REFUSE, REFUSE + 3};

    for (uint8_t i = 0; i < sizeof faults; i++) {
        assert_tries(faults[i], 2, 1, CDS_REGISTERED_NO);
        assert_tries(faults[i], 3, 2, CDS_REGISTERED_NO);
        assert_tries(faults[i], 4, 2, CDS_REGISTERED_NO);
        assert_tries(faults[i], 5, 3, CDS_REGISTERED_NO);
        assert_tries(faults[i], 6, 3, CDS_REGISTERED_NO);
        assert_tries(faults[i], 7, 3, CDS_REGISTERED_YES); // it says so in 8
        assert_tries(faults[i], 8, 3, CDS_REGISTERED_IN_DOUBT);
    }
}

/* Each has its own three. */
void test_the_next_servo_is_tried_three_times_too(void)
{
    plan.first = 2;
    plan.first_fault = REFUSE;
    run_with(false, LOSE_REPLY, 3, 12); // all tries of servo 0, two of servo 1
    TEST_ASSERT_EQUAL(CDS_REGISTERED_IN_DOUBT, goals[0].registered);
    TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[1].registered);
    TEST_ASSERT_EQUAL_UINT8(2 + 6 + 6, transactions);
}

void test_clearing_without_answers_is_tried_three_times(void)
{
    static const uint8_t faults[] = {LOSE_REPLY, SPOIL_REPLY};

    for (uint8_t i = 0; i < sizeof faults; i++) {
        assert_tries(faults[i], 2, 1, CDS_REGISTERED_NO);
        assert_tries(faults[i], 3, 1, CDS_REGISTERED_NO); // the READ tells
        assert_tries(faults[i], 4, 2, CDS_REGISTERED_NO);
        assert_tries(faults[i], 5, 2, CDS_REGISTERED_NO);
        assert_tries(faults[i], 6, 3, CDS_REGISTERED_NO);
        assert_tries(faults[i], 7, 3, CDS_REGISTERED_NO);
        assert_tries(faults[i], 8, 3, CDS_REGISTERED_IN_DOUBT);
    }
}

/* At `at` a servo's power fails for good: it stays in doubt if it was asked, and only it. */
void test_a_servo_without_power_stays_in_doubt(void)
{
    plan.for_good = true;
    for (uint8_t at = 1; at <= 2 * SERVOS; at++) {
        uint8_t asked = at < SERVOS ? at : SERVOS;

        run_with(true, CUT_AFTER, at, at);
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, move.steps.result);
        TEST_ASSERT_EQUAL_UINT8(0, actions);
        TEST_ASSERT_EQUAL_UINT8(0, registered());
        TEST_ASSERT_EQUAL_UINT8(at + 2 * (asked - 1) + 2 * 3, transactions);
        for (uint8_t i = 0; i < SERVOS; i++)
            TEST_ASSERT_EQUAL(i == (at - 1) % SERVOS ? CDS_REGISTERED_IN_DOUBT : CDS_REGISTERED_NO,
                              goals[i].registered);
        assert_moved(false);
    }
}

/* The servo takes REG WRITE but no write to 0x2C (R6). */
void test_a_locked_servo_stays_registered(void)
{
    servos[0].locked = true;
    plan.fault = REFUSE;
    plan.at = plan.to = 2;
    run(false);
    TEST_ASSERT_EQUAL(CDS_REFUSED, move.steps.result);
    TEST_ASSERT_EQUAL(CDS_REGISTERED_YES, goals[0].registered);
    TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[1].registered);
    TEST_ASSERT_EQUAL_UINT8(2 + 2 * 3 + 2, transactions);
    assert_truth();
}

/* A lost READ need not be the end of it. */
void test_retries_of_the_queue_save_a_verified_move(void)
{
    cds_queue_set_retries(&queue, 1);
    for (uint8_t at = 4; at <= 10; at++) {
        if (at == 7)
            continue; // ACTION
        run_with(true, LOSE_REPLY, at, at);
        TEST_ASSERT_EQUAL(CDS_OK, move.steps.result);
        TEST_ASSERT_EQUAL_UINT8(11, transactions);
        assert_moved(true);
    }
}

/* ---- ACTION that does not leave ---- */

/* The transmitter is dead: whether ACTION was heard is not known, so all servos are cleared. */
static void assert_action_that_never_leaves_clears_all(bool verified)
{
    uint8_t before = verified ? 2 * SERVOS : SERVOS;
    uint16_t sent_before = bus.stats.sent;

    transactions = 0;
    TEST_ASSERT_EQUAL(CDS_OK, begin_move(SERVOS, verified));
    while (cds_registered_move_poll(&move) == CDS_PENDING &&
           bus.stats.sent - sent_before <= before) {
        turn();
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL_HEX8(CDS_ACTION, buffer[4]);
    cds_bus_poll(&bus); // sets the deadline
    port_fake.now_us += 2000;
    port_fake_look(&bus);
    while (cds_registered_move_poll(&move) == CDS_PENDING) {
        turn();
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, move.steps.result);
    TEST_ASSERT_TRUE(move.acted);
    TEST_ASSERT_EQUAL_UINT8(0, registered());
    TEST_ASSERT_EQUAL_UINT8(before + 6, transactions);
    for (uint8_t i = 0; i < SERVOS; i++) {
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, goals[i].result);
        TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[i].registered);
    }
}

void test_action_that_never_leaves_clears_all(void)
{
    assert_action_that_never_leaves_clears_all(false);
    assert_action_that_never_leaves_clears_all(true);
}

/* The program takes it back while it waits for its turn: so a move can be stopped. */
void test_action_taken_back_clears_all(void)
{
    begin(1);
    SENDS(register_0);
    answered(0, 0);
    rig_occupy(&other);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
    rig_free();
    SENDS(clear_0);
    answered(0, 0);
    SENDS(read_0);
    answered_with(0, &(const uint8_t){0}, 1);
    assert_over(CDS_CANCELLED);
}

void test_move_can_be_begun_anew(void)
{
    run_with(true, LOSE_PACKET, 2, 2);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, move.steps.result);
    plan.fault = NONE;
    for (uint8_t i = 0; i < SERVOS; i++) {
        goals[i].error = 0x7F;
        goals[i].registered = CDS_REGISTERED_IN_DOUBT;
    }
    begin(SERVOS);
    for (uint8_t i = 0; i < SERVOS; i++) {
        TEST_ASSERT_EQUAL(CDS_PENDING, goals[i].result);
        TEST_ASSERT_EQUAL(0, goals[i].error);
        TEST_ASSERT_EQUAL(CDS_REGISTERED_NO, goals[i].registered);
    }
    run(true);
    TEST_ASSERT_EQUAL(CDS_OK, move.steps.result);
    assert_moved(true);
}

void test_move_on_a_bus_without_hooks(void)
{
    bus.hooks = NULL;
    run(true);
    TEST_ASSERT_EQUAL(CDS_OK, move.steps.result);
    assert_moved(true);
}

/* ---- abort ---- */

static void finish(void)
{
    while (cds_registered_move_poll(&move) == CDS_PENDING) {
        turn();
        cds_bus_poll(&bus);
    }
}

/* Until a step of the move is on the wire and `packets` packets were sent. */
static void run_until(uint16_t packets, bool verified)
{
    setUp();
    TEST_ASSERT_EQUAL(CDS_OK, begin_move(SERVOS, verified));
    while (bus.stats.sent < packets) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
        if (bus.stats.sent == packets)
            break;
        turn();
        cds_bus_poll(&bus);
    }
}

void test_abort_before_the_first_poll_sends_nothing(void)
{
    begin(SERVOS);
    cds_registered_move_abort(&move);
    assert_over(CDS_CANCELLED);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

/* Packet `at` is on the wire: it ends, no ACTION follows, and every servo asked is cleared. */
void test_abort_before_action_clears_all_goals(void)
{
    for (uint8_t at = 1; at <= 2 * SERVOS; at++) {
        run_until(at, true);
        cds_registered_move_abort(&move);
        finish();
        TEST_ASSERT_EQUAL(CDS_CANCELLED, move.steps.result);
        TEST_ASSERT_FALSE(move.acted);
        TEST_ASSERT_EQUAL_UINT8(0, actions);
        TEST_ASSERT_EQUAL_UINT8(0, registered());
        TEST_ASSERT_EQUAL_UINT8(at + 2 * (at < SERVOS ? at : SERVOS), transactions);
        assert_moved(false);
        assert_truth();
    }
}

/* Between two steps no request of the move is on its way. */
void test_abort_between_two_steps_sends_no_action(void)
{
    begin(1);
    SENDS(register_0);
    answered(0, 0);
    rig_occupy(&other);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move)); // ACTION waits
    cds_registered_move_abort(&move);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, request.result);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move)); // clearing waits
    cds_registered_move_abort(&move);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result); // and goes on
    rig_free();
    SENDS(clear_0);
    answered(0, 0);
    SENDS(read_0);
    answered_with(0, &(const uint8_t){0}, 1);
    assert_over(CDS_CANCELLED);
    TEST_ASSERT_FALSE(move.acted);
}

void test_abort_when_the_last_reply_has_come_sends_no_action(void)
{
    begin(1);
    SENDS(register_0);
    answered(0, 0);
    cds_registered_move_abort(&move); // the reply was not polled yet
    SENDS(clear_0);
    answered(0, 0);
    SENDS(read_0);
    answered_with(0, &(const uint8_t){0}, 1);
    assert_over(CDS_CANCELLED);
}

void test_abort_while_action_leaves_tells_that_it_left(void)
{
    run_until(SERVOS + 1, false);
    cds_registered_move_abort(&move);
    finish();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, move.steps.result);
    TEST_ASSERT_EQUAL_UINT8(SERVOS + 1, transactions);
    assert_moved(true);
    assert_truth();
}

/* Servos that were not read back are cleared: one may not have heard ACTION. */
void test_abort_after_action_ends_the_verification(void)
{
    run_until(2 * SERVOS + 2, true); // READ of the first servo
    cds_registered_move_abort(&move);
    finish();
    TEST_ASSERT_EQUAL(CDS_CANCELLED, move.steps.result);
    TEST_ASSERT_EQUAL_UINT8(2 * SERVOS + 2 + 2 * (SERVOS - 1), transactions);
    assert_moved(true);
    assert_truth();
}

void test_abort_after_the_end_changes_nothing(void)
{
    run_with(false, NONE, 0, 0);
    cds_registered_move_abort(&move);
    assert_over(CDS_OK);
    run_until(1, false); // nor does an abort while the goals are cleared already
    plan.fault = REFUSE;
    plan.at = plan.to = 1;
    while (move.phase < 4) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
        turn();
        cds_bus_poll(&bus);
    }
    cds_registered_move_abort(&move);
    finish();
    TEST_ASSERT_EQUAL(CDS_REFUSED, move.steps.result);
}

/* ---- servos with limits ---- */

static struct cds_servos known;
static struct cds_servo_state states[SERVOS + 1];

/* All three servos of the move are known, in position mode, and with limits. */
static void know_servos(uint8_t count)
{
    static const uint8_t ids[SERVOS + 1] = {0, 1, 7, 9};

    setUp();
    bus.hooks = NULL;
    for (uint8_t i = 0; i < count; i++)
        states[i].id = ids[i];
    TEST_ASSERT_EQUAL(
        CDS_OK, cds_servos_begin(&known, &(struct cds_servos_config){.bus = &bus,
                                                                     .queue = &queue,
                                                                     .states = states,
                                                                     .count = count,
                                                                     .capacity = SERVOS + 1}));
    for (uint8_t i = 0; i < count; i++) {
        states[i].held = CDS_HELD_CCW_SET;
        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&known, &states[i], 0, 1022, 1023));
    }
    goals[1].position = 1022;
}

static void assert_called_off_as(enum cds_result result)
{
    finish();
    TEST_ASSERT_EQUAL(result, move.steps.result);
    TEST_ASSERT_FALSE(move.acted);
    TEST_ASSERT_EQUAL_UINT8(0, actions);
    TEST_ASSERT_EQUAL_UINT8(0, registered());
    assert_moved(false);
    assert_truth();
}

static void run_until_sent(uint16_t packets)
{
    while (bus.stats.sent < packets) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_registered_move_poll(&move));
        if (bus.stats.sent == packets)
            break;
        turn();
        cds_bus_poll(&bus);
    }
}

void test_move_of_servos_with_limits(void)
{
    for (uint8_t verified = 0; verified < 2; verified++) {
        know_servos(SERVOS);
        run(verified);
        for (uint8_t i = 0; i < SERVOS; i++)
            TEST_ASSERT_EQUAL(CDS_OK, goals[i].result);
        TEST_ASSERT_EQUAL(CDS_OK, move.steps.result);
        assert_moved(true);
        assert_truth();
    }
}

void test_goal_beyond_a_limit_calls_the_move_off(void)
{
    know_servos(SERVOS);
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servos_set_limits(&known, &states[2], 0, goals[2].position - 1, 1023));
    begin(SERVOS);
    assert_called_off_as(CDS_LIMIT);
    TEST_ASSERT_EQUAL(CDS_LIMIT, goals[2].result);
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
    TEST_ASSERT_EQUAL_UINT8(2 + 4, transactions); // servo 7 was sent nothing
}

/* Even a limit that all goals keep. */
void test_change_of_a_limit_before_action_calls_it_off(void)
{
    for (uint8_t at = 1; at <= 2 * SERVOS; at++) {
        know_servos(SERVOS);
        TEST_ASSERT_EQUAL(CDS_OK, begin_move(SERVOS, true));
        run_until_sent(at);
        TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&known, &states[2], 1, 1020, 1023));
        assert_called_off_as(CDS_LIMIT);
    }
}

void test_inhibit_before_action_calls_it_off(void)
{
    for (uint8_t at = 1; at <= 2 * SERVOS; at++) {
        know_servos(SERVOS);
        TEST_ASSERT_EQUAL(CDS_OK, begin_move(SERVOS, true));
        run_until_sent(at);
        cds_servos_inhibit_all(&known);
        assert_called_off_as(CDS_INHIBITED);
    }
}

void test_reservation_before_action_calls_it_off(void)
{
    for (uint8_t at = 1; at <= 2 * SERVOS; at++) {
        know_servos(SERVOS);
        TEST_ASSERT_EQUAL(CDS_OK, begin_move(SERVOS, true));
        run_until_sent(at);
        cds_servos_reserve(&known, NULL, &states[2].id, 1);
        assert_called_off_as(CDS_RESERVED);
    }
}

void test_move_that_leaves_out_a_servo_with_limits(void)
{
    know_servos(SERVOS + 1);
    begin(SERVOS);
    assert_called_off_as(CDS_LIMIT);
    TEST_ASSERT_EQUAL_UINT8(3 + 6, transactions);
}

/* At status return level 1 REG WRITE is not answered, so nothing proves what is registered. */
void test_move_of_a_silent_servo_beside_one_with_limits(void)
{
    know_servos(SERVOS);
    states[2].status_return_level = 1;
    begin(SERVOS);
    assert_called_off_as(CDS_LIMIT);
}

void test_after_the_end_the_request_is_like_any_other(void)
{
    static const uint8_t goal[4] = {0x00, 0x01, 0x00, 0x00};

    for (uint8_t fails = 0; fails < 2; fails++) {
        know_servos(SERVOS);
        plan.fault = fails ? REFUSE : NONE;
        plan.at = plan.to = 2;
        run(false);
        TEST_ASSERT_EQUAL(fails ? CDS_REFUSED : CDS_OK, move.steps.result);
        TEST_ASSERT_EQUAL(CDS_LIMIT, cds_servo_reg_write(&bus, &request, 0, 0x1E, goal, 4));
    }
}
