/* SPDX-License-Identifier: MIT */
/* What struct cds_servos learns from the packets of the bus, and which packets it refuses. */
#include "cds55xx/servos.h"

#include <string.h>

#include "cds55xx/control_table.h"
#include "cds55xx/sync_write.h"
#include "cds55xx/servo.h"
#include "bus/bus_internal.h" // cds_bus_submit_prechecked()
#include "bus_rig.h"
#include "unity.h"

#define PORT 1

static struct cds_servos servos;
static struct cds_queue queue;
static struct cds_servo_state states[4];
static struct cds_servo_state *const one = &states[0], *const two = &states[1];
static uint8_t buffer[CDS_PACKET_SIZE(CDS_REPLY_MAX)], reply[CDS_REPLY_MAX];
static struct cds_request request;

static enum cds_result begin(uint8_t count)
{
    return cds_servos_begin(
        &servos,
        &(struct cds_servos_config){
            .bus = &bus, .queue = &queue, .states = states, .count = count, .capacity = 4});
}

static enum cds_result permit_goal(uint8_t id, const uint8_t *goal)
{
    uint8_t index = 0;

    return bus.hooks->permit_goal(bus.hooks->context, id, &index, goal);
}

void setUp(void)
{
    rig_open(PORT);
    memset(&servos, 0, sizeof servos);
    memset(states, 0, sizeof states);
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    states[0].id = 1;
    states[1].id = 2;
    states[2].id = 30;
    TEST_ASSERT_EQUAL(CDS_OK, begin(3));
}

void tearDown(void)
{
    rig_check();
}

static uint16_t sent(void)
{
    struct cds_stats count;

    cds_bus_stats(&bus, &count);
    return count.sent;
}

/* Polls while the clock stands still: each does one thing. */
static void look(void)
{
    for (uint8_t i = 0; i < 14; i++)
        cds_bus_poll(&bus);
}

/* The packet submitted goes out and is answered. */
static void answer(enum cds_result submitted, uint8_t id, uint8_t error)
{
    TEST_ASSERT_EQUAL(CDS_OK, submitted);
    rig_transmit();
    if (request.reply_parameters != CDS_REPLY_NONE)
        port_fake_answer(&bus.link, id, error, NULL, 0);
    look();
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
}

static void silence(enum cds_result submitted)
{
    TEST_ASSERT_EQUAL(CDS_OK, submitted);
    rig_transmit();
    port_fake.now_us += 5000;
    look();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

static enum cds_result write_byte(uint8_t id, uint8_t address, uint8_t value)
{
    return cds_servo_write_byte(&bus, &request, id, address, value);
}

static enum cds_result write_word(uint8_t id, uint8_t address, uint16_t value)
{
    return cds_servo_write_word(&bus, &request, id, address, value);
}

static void wrote_byte(uint8_t id, uint8_t address, uint8_t value)
{
    answer(write_byte(id, address, value), id, 0);
}

static void wrote_word(uint8_t id, uint8_t address, uint16_t value)
{
    answer(write_word(id, address, value), id, 0);
}

static void read_gives(uint8_t id, uint8_t address, const uint8_t *data, uint8_t length)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, id, address, length));
    rig_transmit();
    port_fake_answer(&bus.link, id, 0, data, length);
    look();
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
}

static void read_byte_gives(uint8_t id, uint8_t address, uint8_t value)
{
    read_gives(id, address, &value, 1);
}

static void in_position_mode(uint8_t id)
{
    static const uint8_t limits[] = {100, 0, 0xFF, 3};

    read_gives(id, CDS_REG_CW_ANGLE_LIMIT, limits, 4);
}

static void assert_refused(enum cds_result why, enum cds_result submitted)
{
    uint16_t before = sent();

    if (request.packet.bytes[CDS_AT_ID] == CDS_BROADCAST_ID && submitted == CDS_OK) {
        look(); // what reaches many servos is checked while it waits
        submitted = (enum cds_result)request.result;
    }
    TEST_ASSERT_EQUAL(why, submitted);
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, request.result);
    look();
    TEST_ASSERT_EQUAL_UINT16(before, sent());
}

static enum cds_result goal(uint8_t id, uint16_t position)
{
    return write_word(id, CDS_REG_GOAL_POSITION, position);
}

static enum cds_result speed(uint8_t id, uint16_t value)
{
    return write_word(id, CDS_REG_MOVING_SPEED, value);
}

static enum cds_result goal_and_speed(uint8_t id, uint16_t position, uint16_t value)
{
    const uint8_t data[4] = {(uint8_t)position, (uint8_t)(position >> 8), (uint8_t)value,
                             (uint8_t)(value >> 8)};

    return cds_servo_write(&bus, &request, id, CDS_REG_GOAL_POSITION, data, 4);
}

/* The servo is read to hold this. */
static void holds(uint8_t id, uint16_t position, uint16_t value)
{
    const uint8_t data[4] = {(uint8_t)position, (uint8_t)(position >> 8), (uint8_t)value,
                             (uint8_t)(value >> 8)};

    read_gives(id, CDS_REG_GOAL_POSITION, data, 4);
}

/* The request was permitted: answers it, so that the bus is free again. */
static void assert_admitted(enum cds_result submitted)
{
    answer(submitted, request.packet.bytes[CDS_AT_ID], 0);
}

static enum cds_result sync_goals(uint16_t first, uint16_t second)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_sync_write_add_goal(&request, 1, first, 100);
    cds_sync_write_add_goal(&request, 2, second, 100);
    return cds_sync_write_send(&bus, &request);
}

/* ---- struct cds_servos ---- */

void test_ids_that_stand_twice_or_do_not_exist_are_refused(void)
{
    states[2].id = 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin(3));
    states[2].id = CDS_BROADCAST_ID;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin(3));
    TEST_ASSERT_EQUAL(CDS_OK, begin(0));
}

void test_servos_are_found_in_any_order(void)
{
    static const uint8_t ids[] = {30, 1, 2, 30, 30, 2, 1};

    for (uint8_t i = 0; i < sizeof ids; i++)
        TEST_ASSERT_EQUAL_UINT8(ids[i], cds_servos_find(&servos, ids[i])->id);
    TEST_ASSERT_NULL(cds_servos_find(&servos, 3));
}

void test_opening_the_bus_again_keeps_the_roster(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 100, 200, 1023));
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    assert_refused(CDS_LIMIT, goal(1, 300));
}

/* ---- return delay, status return level (F18, R2, R3) ---- */

void test_the_deadline_is_the_servo_s_own_once_its_delay_is_known(void)
{
    wrote_byte(1, CDS_REG_RETURN_DELAY, 50);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1));
    rig_transmit();
    port_fake.now_us += 12 * 10 + 100 + 100 - 1;
    look();
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    port_fake.now_us++;
    look();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

void test_delay_is_learnt_from_read_broadcast_and_sync_write(void)
{
    static const uint8_t three[] = {1, 7, 60}; // ID, baud rate, return delay

    read_gives(1, CDS_REG_ID, three, 3);
    TEST_ASSERT_EQUAL_UINT8(60, one->return_delay);
    TEST_ASSERT_EQUAL_UINT8(CDS_SERVOS_UNKNOWN, two->return_delay);
    wrote_byte(CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY, 9);
    TEST_ASSERT_EQUAL_UINT8(9, one->return_delay);
    TEST_ASSERT_EQUAL_UINT8(9, two->return_delay);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_RETURN_DELAY, 1));
    cds_sync_write_add(&request, 2, &three[1]);
    answer(cds_sync_write_send(&bus, &request), 0, 0);
    TEST_ASSERT_EQUAL_UINT8(9, one->return_delay);
    TEST_ASSERT_EQUAL_UINT8(7, two->return_delay);
}

void test_what_a_servo_refused_is_not_learnt(void)
{
    answer(write_byte(1, CDS_REG_RETURN_DELAY, 40), 1, CDS_ERROR_RANGE);
    TEST_ASSERT_EQUAL_UINT8(CDS_SERVOS_UNKNOWN, one->return_delay);
}

void test_of_a_write_without_answer_the_longer_delay_is_taken(void)
{
    wrote_byte(1, CDS_REG_RETURN_DELAY, 50);
    silence(write_byte(1, CDS_REG_RETURN_DELAY, 10));
    TEST_ASSERT_EQUAL_UINT8(50, one->return_delay);
    silence(write_byte(1, CDS_REG_RETURN_DELAY, 90));
    TEST_ASSERT_EQUAL_UINT8(90, one->return_delay);
}

void test_level_write_unanswered_higher_level_is_taken(void)
{
    silence(write_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 0));
    TEST_ASSERT_EQUAL_UINT8(2, one->status_return_level);
}

void test_level_0_answers_ping_only(void)
{
    wrote_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 0);
    assert_refused(CDS_NO_REPLY_DUE,
                   cds_servo_read(&bus, &request, 1, CDS_REG_PRESENT_POSITION, 2));
    TEST_ASSERT_EQUAL(CDS_OK, write_byte(1, CDS_REG_LED, 1));
    rig_transmit();
    look(); // over with the packet, and no answer was waited for
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1));
    TEST_ASSERT_EQUAL_UINT8(0, request.reply_parameters);
    rig_transmit();
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    look();
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL_UINT16(2, one->counters.ok); // the WRITE of the level, and PING
}

void test_level_1_answers_ping_and_read(void)
{
    wrote_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 1);
    read_byte_gives(1, CDS_REG_LED, 0);
    TEST_ASSERT_EQUAL(CDS_OK, write_byte(1, CDS_REG_LED, 1));
    TEST_ASSERT_TRUE(request.is_muted);
}

/* No servo should have one above 2. */
void test_a_level_that_is_none_answers_all(void)
{
    for (uint8_t level = 3; level < 6; level++) {
        wrote_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 1);
        TEST_ASSERT_EQUAL_UINT8(1, one->status_return_level);
        read_byte_gives(1, CDS_REG_STATUS_RETURN_LEVEL, level);
        TEST_ASSERT_EQUAL_UINT8(2, one->status_return_level);
    }
}

/* R2: the level that held when the packet arrived decides. */
void test_the_write_that_forbids_answers_is_answered(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, write_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 0));
    TEST_ASSERT_EQUAL_UINT8(0, request.reply_parameters);
}

/* ---- a change of ID, and RESET ---- */

void test_a_servo_is_known_by_its_new_id(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 100, 200, 1023));
    wrote_byte(1, CDS_REG_ID, 9);
    TEST_ASSERT_EQUAL_PTR(one, cds_servos_find(&servos, 9));
    assert_refused(CDS_LIMIT, goal(9, 300));
}

void test_reset_leaves_factory_settings(void)
{
    wrote_byte(1, CDS_REG_ID, 7); // no other known servo has ID 1
    wrote_byte(30, CDS_REG_TORQUE_ENABLE, 1);
    answer(cds_servo_reset(&bus, &request, 30), 30, 0);
    TEST_ASSERT_EQUAL_UINT8(1, states[2].id);
    TEST_ASSERT_EQUAL_UINT8(1, states[2].return_delay);
    TEST_ASSERT_EQUAL_UINT8(2, states[2].status_return_level);
    TEST_ASSERT_FALSE(states[2].torque);
}

/* Rule 5: two servos with one ID could not be told apart. */
void test_a_change_to_an_id_already_known_is_refused(void)
{
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_ID, 2));
    assert_refused(CDS_LIMIT, write_byte(77, CDS_REG_ID, 2)); // of a servo that is not known
    assert_refused(CDS_LIMIT, cds_servo_reset(&bus, &request, 2));
    assert_admitted(write_byte(1, CDS_REG_ID, 1)); // its own
    assert_admitted(cds_servo_reset(&bus, &request, 1));
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
}

void test_a_change_of_id_by_broadcast_or_sync_write_is_refused(void)
{
    static const uint8_t id = 9;

    assert_refused(CDS_LIMIT, write_byte(CDS_BROADCAST_ID, CDS_REG_ID, 9));
    assert_refused(CDS_LIMIT, cds_servo_reset(&bus, &request, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_ID, 1));
    cds_sync_write_add(&request, 77, &id);
    assert_refused(CDS_LIMIT, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_OK, begin(0)); // with no known servo it concerns none
    assert_admitted(write_byte(CDS_BROADCAST_ID, CDS_REG_ID, 9));
}

static void go_unheard(uint8_t id)
{
    for (uint8_t i = 0; i < CDS_SERVOS_MISSES; i++)
        silence(cds_servo_ping(&bus, &request, id));
}

void test_id_write_unanswered_servo_is_known_by_both_ids(void)
{
    static const uint8_t goal_of_9[4] = {0, 1, 100, 0};

    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STATE_LOST);
    silence(write_byte(2, CDS_REG_ID, 9));
    TEST_ASSERT_EQUAL_UINT8(4, servos.count);
    go_unheard(2);
    assert_refused(CDS_INHIBITED, goal(2, 500));
    assert_refused(CDS_INHIBITED, goal(9, 500));
    assert_refused(CDS_LIMIT, write_byte(2, CDS_REG_ID, 12)); // a third one
    assert_refused(CDS_LIMIT, cds_servo_reset(&bus, &request, 9));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, permit_goal(9, goal_of_9));
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_ID, 3)); // no room for one more
    answer(cds_servo_ping(&bus, &request, 9), 9, 0);         // a PING tells nothing of a level of 2
    assert_refused(CDS_INHIBITED, goal(2, 500));
    read_byte_gives(9, CDS_REG_LED, 0);
    TEST_ASSERT_EQUAL_UINT8(9, two->id);
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
    TEST_ASSERT_NULL(cds_servos_find(&servos, 2));
    assert_refused(CDS_INHIBITED, goal(9, 500));
    assert_admitted(goal(2, 500));
}

void test_limits_set_in_doubt_apply_under_both_ids(void)
{
    silence(write_byte(1, CDS_REG_ID, 9));
    cds_servos_set_limits(&servos, cds_servos_find(&servos, 9), 200, 800, 1023);
    assert_refused(CDS_LIMIT, goal(1, 900));
    assert_refused(CDS_LIMIT, goal(9, 900));
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    assert_refused(CDS_INHIBITED, goal(9, 500));
    cds_servos_release(&servos, cds_servos_find(&servos, 9));
    assert_admitted(goal(1, 500));
}

void test_two_ids_that_both_answer_a_read_are_two_servos(void)
{
    cds_servos_set_limits(&servos, one, 200, 800, 1023);
    silence(write_byte(1, CDS_REG_ID, 9));
    read_byte_gives(1, CDS_REG_LED, 0);
    TEST_ASSERT_EQUAL_UINT8(4, servos.count); // 9 has not missed three
    read_byte_gives(9, CDS_REG_LED, 0);
    assert_refused(CDS_LIMIT, goal(1, 900));
    assert_refused(CDS_LIMIT, goal(9, 900));
    go_unheard(9);
    TEST_ASSERT_EQUAL_UINT8(4, servos.count);
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, one->second);
}

void test_an_id_in_doubt_at_level_0_is_settled_by_ping(void)
{
    wrote_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 0);
    assert_admitted(write_byte(1, CDS_REG_ID, 9)); // muted
    TEST_ASSERT_EQUAL_UINT8(4, servos.count);
    answer(cds_servo_ping(&bus, &request, 9), 9, 0);
    go_unheard(1);
    TEST_ASSERT_EQUAL_UINT8(9, one->id);
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
}

void test_no_id_is_settled_while_driving_is_inhibited(void)
{
    silence(write_byte(1, CDS_REG_ID, 9));
    cds_servos_inhibit_all(&servos);
    read_byte_gives(9, CDS_REG_LED, 0);
    go_unheard(1);
    TEST_ASSERT_EQUAL_UINT8(4, servos.count);
    cds_servos_release_all(&servos);
    read_byte_gives(9, CDS_REG_LED, 0);
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
}

void test_mode_of_an_id_in_doubt_is_what_both_entries_say(void)
{
    static const uint8_t endless[4] = {0};

    in_position_mode(1);
    silence(write_byte(1, CDS_REG_ID, 9));
    read_gives(9, CDS_REG_CW_ANGLE_LIMIT, endless, 4);
    silence(write_byte(9, CDS_REG_ID, 1));
    TEST_ASSERT_EQUAL_HEX8(0, one->held & (CDS_HELD_CW_SET | CDS_HELD_CCW_SET));
}

void test_no_servo_joins_in_place_of_an_id_in_doubt(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, write_byte(1, CDS_REG_ID, 9));
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_servos_add(&servos, 50));
    TEST_ASSERT_TRUE(servos.is_full);
    rig_transmit();
    port_fake.now_us += 5000;
    look();
    TEST_ASSERT_NOT_NULL(cds_servos_find(&servos, 9));
}

void test_a_change_of_id_that_was_not_heard_is_none(void)
{
    silence(write_byte(1, CDS_REG_ID, 9));
    silence(write_byte(1, CDS_REG_ID, 9)); // the same once more
    read_byte_gives(1, CDS_REG_LED, 0);
    go_unheard(9);
    TEST_ASSERT_EQUAL_UINT8(1, one->id);
    TEST_ASSERT_NULL(cds_servos_find(&servos, 9));
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, one->second);
}

void test_a_reset_that_was_not_answered_may_have_been_carried_out(void)
{
    cds_servos_set_limits(&servos, two, 200, 700, 300);
    in_position_mode(2);
    wrote_byte(2, CDS_REG_STATUS_RETURN_LEVEL, 1);
    wrote_byte(1, CDS_REG_ID, 7); // no other known servo has ID 1
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_reset(&bus, &request, 2));
    rig_transmit();
    look(); // no answer is due
    look();
    assert_refused(CDS_LIMIT, goal_and_speed(2, 800, 100));
    assert_refused(CDS_LIMIT, goal_and_speed(1, 800, 100));
    TEST_ASSERT_EQUAL_UINT8(1, two->status_return_level);
    TEST_ASSERT_EQUAL_UINT8(2, cds_servos_find(&servos, 1)->status_return_level);
    read_byte_gives(1, CDS_REG_LED, 0);
    go_unheard(2);
    TEST_ASSERT_EQUAL_UINT8(1, two->id);
    assert_refused(CDS_LIMIT, goal_and_speed(1, 800, 100));
    assert_admitted(goal(2, 800)); // not known any more
}

void test_reset_of_all_leaves_servos_inhibited_and_unknown(void)
{
    in_position_mode(1);
    cds_servos_allow_reset(&servos, true);
    answer(cds_servo_reset(&bus, &request, CDS_BROADCAST_ID), 0, 0);
    cds_servos_allow_reset(&servos, false);
    for (uint8_t i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, states[i].inhibits);
        TEST_ASSERT_EQUAL(CDS_PRESENCE_UNKNOWN, states[i].presence);
        TEST_ASSERT_FALSE(states[i].held & (CDS_HELD_CCW_SET | CDS_HELD_CCW_0));
    }
    assert_refused(CDS_LIMIT, cds_servo_reset(&bus, &request, CDS_BROADCAST_ID));
}

/* ---- counters and alarms ---- */

void test_counters_are_each_servo_s_own(void)
{
    uint8_t noise[] = {0xFF, 0xFF, 1, 2, 0, 0};

    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    look();
    silence(cds_servo_ping(&bus, &request, 2));
    port_fake_answer(&bus.link, 2, 0, NULL, 0);
    port_fake_answer(&bus.link, 30, 0, NULL, 0);
    look();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1));
    rig_transmit();
    port_fake_hear(&bus.link, noise, sizeof noise);
    port_fake.now_us += 5000;
    look();
    TEST_ASSERT_EQUAL(CDS_CORRUPT, request.result);
    TEST_ASSERT_EQUAL_UINT16(1, one->counters.ok);
    TEST_ASSERT_EQUAL_UINT16(1, one->counters.duplicate_replies);
    TEST_ASSERT_EQUAL_UINT16(1, one->counters.corrupt);
    TEST_ASSERT_EQUAL_UINT16(0, one->counters.timeouts);
    TEST_ASSERT_EQUAL_UINT16(1, two->counters.timeouts);
    TEST_ASSERT_EQUAL_UINT16(1, two->counters.stale_replies);
    TEST_ASSERT_EQUAL_UINT16(1, states[2].counters.unexpected_packets);
}

/* A damaged reply to a READ of `address`. */
static void read_damaged(uint8_t address)
{
    uint8_t noise[] = {0xFF, 0xFF, 1, 3, 0, 0, 0};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 1, address, 1));
    rig_transmit();
    port_fake_hear(&bus.link, noise, sizeof noise);
    port_fake.now_us += 5000;
    look();
    TEST_ASSERT_EQUAL(CDS_CORRUPT, request.result);
}

void test_damaged_reply_is_a_miss_only_of_a_state_check(void)
{
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    for (uint8_t i = 0; i < CDS_SERVOS_MISSES; i++)
        read_damaged(CDS_REG_PRESENT_POSITION);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, one->presence);
    for (uint8_t i = 0; i < CDS_SERVOS_MISSES; i++)
        read_damaged(CDS_REG_TORQUE_ENABLE);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, one->presence);
    TEST_ASSERT_EQUAL_UINT16(2 * CDS_SERVOS_MISSES, one->counters.corrupt);
}

void test_what_should_never_be_is_counted_to_255(void)
{
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    for (uint16_t i = 1; i <= 300; i++) {
        port_fake_answer(&bus.link, 1, 0, NULL, 0);
        look();
        TEST_ASSERT_EQUAL_UINT8(i < 255 ? i : 255, one->counters.duplicate_replies);
    }
    TEST_ASSERT_EQUAL_UINT16(300, bus.stats.not_due[CDS_EVENT_DUPLICATE_REPLY]);
    TEST_ASSERT_EQUAL_UINT8(0, one->counters.unexpected_packets);
}

void test_alarms_stay_until_acknowledged(void)
{
    answer(cds_servo_ping(&bus, &request, 1), 1, CDS_ERROR_VOLTAGE);
    answer(cds_servo_ping(&bus, &request, 1), 1, CDS_ERROR_OVERLOAD);
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    answer(cds_servo_ping(&bus, &request, 2), 2, CDS_ERROR_OVERHEATING);
    TEST_ASSERT_EQUAL_HEX8(0x21, one->alarms);
    TEST_ASSERT_EQUAL_HEX8(0x25, servos.alarms);
    TEST_ASSERT_EQUAL_HEX8(0x21, cds_servos_acknowledge(&servos, one));
    TEST_ASSERT_EQUAL_HEX8(0, one->alarms);
    TEST_ASSERT_EQUAL_HEX8(0x04, servos.alarms);
    TEST_ASSERT_EQUAL_HEX8(0x04, cds_servos_acknowledge(&servos, NULL));
    TEST_ASSERT_EQUAL_HEX8(0, two->alarms);
}

void test_alarms_of_strangers_and_of_undue_packets_count_too(void)
{
    answer(cds_servo_ping(&bus, &request, 77), 77, CDS_ERROR_VOLTAGE);
    port_fake_answer(&bus.link, 2, CDS_ERROR_OVERHEATING, NULL, 0);
    look();
    TEST_ASSERT_EQUAL_HEX8(0x05, servos.alarms);
    TEST_ASSERT_EQUAL_HEX8(0x04, two->alarms);
}

/* ---- presence (F8) ---- */

static void go_away(uint8_t id)
{
    for (uint8_t i = 0; i < CDS_SERVOS_MISSES; i++)
        silence(cds_servo_ping(&bus, &request, id));
}

void test_three_misses_in_a_row_are_absence(void)
{
    TEST_ASSERT_EQUAL(CDS_PRESENCE_UNKNOWN, one->presence);
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, one->presence);
    silence(cds_servo_ping(&bus, &request, 1));
    silence(cds_servo_ping(&bus, &request, 1));
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    silence(cds_servo_ping(&bus, &request, 1));
    silence(cds_servo_ping(&bus, &request, 1));
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, one->presence);
    silence(cds_servo_ping(&bus, &request, 1));
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, one->presence);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 1));
    TEST_ASSERT_TRUE(cds_servos_may_drive(&servos, CDS_BROADCAST_ID)); // it stops no other
}

/* A scan, say: at another rate nobody hears, and at its own nothing has happened. */
void test_silence_at_another_rate_is_no_absence(void)
{
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, 3));
    go_away(1);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, one->presence);
    TEST_ASSERT_EQUAL_UINT8(0, one->misses);
    TEST_ASSERT_EQUAL_UINT16(CDS_SERVOS_MISSES, one->counters.timeouts);
    answer(cds_servo_ping(&bus, &request, 1), 1, 0); // it has been set to this one
    go_away(1);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, one->presence);
}

void test_a_servo_is_looked_for_where_its_new_rate_is(void)
{
    wrote_byte(1, CDS_REG_BAUD_RATE, 3);
    go_away(1); // it has gone to the new one
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, one->presence);
    silence(write_byte(2, CDS_REG_BAUD_RATE, 3));
    two->misses = 0;
    go_away(2); // or not
    TEST_ASSERT_EQUAL(CDS_PRESENCE_UNKNOWN, two->presence);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, 3));
    go_away(2);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_UNKNOWN, two->presence);
    go_away(1);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, one->presence);
}

void test_a_servo_that_was_away_is_held_until_its_torque_was_read(void)
{
    go_away(1);
    assert_refused(CDS_INHIBITED, goal(1, 500));
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_RETURNED, one->presence);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 1));
    assert_refused(CDS_INHIBITED, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    read_byte_gives(1, CDS_REG_TORQUE_ENABLE, 0); // as it was
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, one->presence);
    TEST_ASSERT_EQUAL_HEX8(0, one->inhibits);
    assert_admitted(goal(1, 500));
}

void test_a_servo_whose_torque_went_off_is_held_until_released(void)
{
    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 1);
    go_away(1);
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    read_byte_gives(1, CDS_REG_TORQUE_ENABLE, 0);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, one->inhibits);
    assert_refused(CDS_INHIBITED, goal(1, 500));
    assert_refused(CDS_INHIBITED, speed(1, 5));
    assert_refused(CDS_INHIBITED, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 0));
    assert_admitted(write_byte(1, CDS_REG_LED, 1));
    cds_servos_release(&servos, one);
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
}

void test_a_drop_between_transactions_shows_when_torque_is_read(void)
{
    static const uint8_t torque_and_led[] = {0, 0};

    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 1);
    read_gives(1, CDS_REG_TORQUE_ENABLE, torque_and_led, 2);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, one->inhibits);
}

void test_torque_switched_on_without_an_answer_counts_as_on(void)
{
    silence(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    read_byte_gives(1, CDS_REG_TORQUE_ENABLE, 0);
    TEST_ASSERT_EQUAL_HEX8(CDS_INHIBIT_STATE_LOST, one->inhibits);
}

/* Its torque was off before, so nothing shows; but its RAM area may be what it is at power-up. */
void test_of_a_servo_that_returned_nothing_is_known(void)
{
    in_position_mode(1);
    cds_servos_set_limits(&servos, one, 0, 1023, 200);
    holds(1, 500, 100);
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 0);
    wrote_byte(1, CDS_REG_RETURN_DELAY, 10);
    go_away(1);
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    TEST_ASSERT_EQUAL_UINT8(CDS_SERVOS_UNKNOWN, one->return_delay);
    TEST_ASSERT_EQUAL_UINT8(CDS_LEVEL_UNKNOWN, one->status_return_level);
    read_byte_gives(1, CDS_REG_TORQUE_ENABLE, 0);
    TEST_ASSERT_EQUAL_HEX8(0, one->inhibits);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    in_position_mode(1);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    holds(1, 500, 201);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    holds(1, 500, 200);
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    go_away(1);
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    read_byte_gives(1, CDS_REG_TORQUE_ENABLE, 1); // it had its power all the time
    TEST_ASSERT_EQUAL_HEX8(0, one->inhibits);
    TEST_ASSERT_FALSE(one->held & (CDS_HELD_CCW_SET | CDS_HELD_CCW_0));
    assert_admitted(goal_and_speed(1, 500, 200));
}

/* An unknown level is settled by what the servo answers. */
void test_misses_of_a_write_at_an_unknown_level_are_no_absence(void)
{
    go_away(1);
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    for (uint8_t i = 0; i < 4; i++) {
        silence(write_byte(1, CDS_REG_LED, 1));
        silence(cds_servo_read(&bus, &request, 1, CDS_REG_TORQUE_ENABLE, 1));
    }
    TEST_ASSERT_EQUAL(CDS_PRESENCE_RETURNED, one->presence);
    wrote_byte(1, CDS_REG_LED, 1);
    TEST_ASSERT_EQUAL_UINT8(2, one->status_return_level);
    go_away(1);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_OFFLINE, one->presence);
}

void test_torque_switched_off_is_no_loss(void)
{
    wrote_byte(CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    TEST_ASSERT_TRUE(two->torque);
    wrote_byte(CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 0);
    read_byte_gives(2, CDS_REG_TORQUE_ENABLE, 0);
    TEST_ASSERT_EQUAL_HEX8(0, two->inhibits);
}

/* ---- holds ---- */

void test_one_held_servo_refuses_what_goes_to_all(void)
{
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    assert_refused(CDS_INHIBITED, write_byte(CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1));
    TEST_ASSERT_EQUAL_UINT8(2, servos.refused_id);
    assert_refused(CDS_INHIBITED, sync_goals(100, 100));
    TEST_ASSERT_EQUAL_UINT8(2, servos.refused_id);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, CDS_BROADCAST_ID));
    assert_admitted(write_byte(CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 0));
    assert_admitted(goal(1, 100));
    cds_servos_release_all(&servos);
    assert_admitted(sync_goals(100, 100));
}

void test_one_that_is_away_does_not(void)
{
    go_away(2);
    assert_admitted(sync_goals(100, 100));
    assert_admitted(write_byte(CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1));
}

static enum cds_result register_byte(uint8_t id, uint8_t address, uint8_t value)
{
    return cds_servo_reg_write(&bus, &request, id, address, &value, 1);
}

static enum cds_result action(uint8_t id)
{
    return cds_servo_action(&bus, &request, id);
}

/* Rule 4: whether it has a registered write or not. */
void test_action_that_reaches_an_inhibited_servo_is_refused(void)
{
    static const uint8_t data[] = {0, 2};

    answer(cds_servo_reg_write(&bus, &request, 2, CDS_REG_GOAL_POSITION, data, 2), 2, 0);
    assert_admitted(action(CDS_BROADCAST_ID));
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    assert_refused(CDS_INHIBITED, action(CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL_UINT8(2, servos.refused_id);
    assert_refused(CDS_INHIBITED, action(2));
    assert_admitted(action(1));
    wrote_byte(2, CDS_REG_REGISTERED_INSTRUCTION, 0);
    assert_refused(CDS_INHIBITED, action(CDS_BROADCAST_ID));
    cds_servos_release(&servos, two);
    assert_admitted(action(CDS_BROADCAST_ID));
}

void test_action_that_reaches_a_servo_with_limits_is_refused(void)
{
    cds_servos_set_limits(&servos, two, 0, 1023, 300);
    assert_refused(CDS_LIMIT, action(CDS_BROADCAST_ID));
    assert_refused(CDS_LIMIT, action(2));
    assert_admitted(action(1));
}

void test_reg_write_to_a_servo_with_limits_is_refused(void)
{
    cds_servos_set_limits(&servos, two, 0, 1023, 300);
    assert_refused(CDS_LIMIT, register_byte(2, CDS_REG_LED, 1));
    assert_refused(CDS_LIMIT, register_byte(CDS_BROADCAST_ID, CDS_REG_LED, 1));
    TEST_ASSERT_EQUAL_UINT8(2, servos.refused_id);
    assert_admitted(register_byte(1, CDS_REG_LED, 1));
}

void test_torque_that_an_action_has_switched_on_is_known_to_be_on(void)
{
    assert_admitted(register_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    TEST_ASSERT_FALSE(one->torque);
    assert_admitted(action(CDS_BROADCAST_ID));
    TEST_ASSERT_TRUE(one->torque);
    TEST_ASSERT_FALSE(two->torque);
}

void test_reg_write_of_unknown_outcome_is_refused(void)
{
    for (uint8_t address = CDS_REG_ID; address <= CDS_REG_CCW_ANGLE_LIMIT + 1; address++)
        assert_refused(CDS_LIMIT, register_byte(1, address, 1));
    assert_refused(CDS_LIMIT, register_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 1));
    assert_refused(CDS_LIMIT, register_byte(CDS_BROADCAST_ID, CDS_REG_ID, 1));
    assert_admitted(register_byte(1, CDS_REG_LED, 1));
    assert_admitted(register_byte(77, CDS_REG_ID, 78));
}

/* Torque off always passes, but not with a goal behind it in the same packet. */
void test_torque_off_does_not_hide_a_goal(void)
{
    static const uint8_t data[8] = {0, 0, 32, 32, 0, 0, 0xF4, 1}; // from 0x18 to 0x1F

    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    assert_refused(CDS_INHIBITED,
                   cds_servo_write(&bus, &request, 1, CDS_REG_TORQUE_ENABLE, data, 8));
}

void test_torque_off_of_one_is_its_own(void)
{
    wrote_byte(CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 0);
    TEST_ASSERT_FALSE(one->torque);
    TEST_ASSERT_TRUE(two->torque);
}

/* ---- what has waited ---- */

static uint8_t waiting_buffers[3][16], waiting_replies[3][8];
static struct cds_request waiting[3];

/* A PING of servo 30 is in flight; a goal, a READ and torque off wait behind it. */
static void let_wait(void)
{
    static const uint8_t position[] = {0xF4, 1}; // 500

    for (uint8_t i = 0; i < 3; i++)
        waiting[i] = (struct cds_request)CDS_REQUEST(waiting_buffers[i], waiting_replies[i]);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 30));
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servo_write(&bus, &waiting[0], 1, CDS_REG_GOAL_POSITION, position, 2));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &waiting[1], 1, CDS_REG_PRESENT_POSITION, 2));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &waiting[2], 1, CDS_REG_TORQUE_ENABLE, 0));
}

/* Everything goes out, unanswered. */
static void see_through(void)
{
    for (uint8_t i = 0; i < 20 && bus.request; i++) {
        if (bus.link.state == CDS_LINK_TALKING)
            port_fake_transmit(&bus.link, PORT);
        port_fake.now_us += 800;
        look();
    }
    TEST_ASSERT_NULL(bus.request);
}

void test_a_goal_that_waits_is_not_sent_once_its_servo_is_held(void)
{
    let_wait();
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    see_through();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, waiting[0].result);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, waiting[1].result); // looking, and
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, waiting[2].result); // torque off are as good as before
    TEST_ASSERT_EQUAL_UINT16(3, sent());
}

void test_a_goal_that_waits_is_not_sent_beyond_a_new_limit(void)
{
    let_wait();
    cds_servos_set_limits(&servos, one, 501, 1023, 1023);
    see_through();
    TEST_ASSERT_EQUAL(CDS_LIMIT, waiting[0].result);
    TEST_ASSERT_EQUAL_UINT16(3, sent());
}

void test_goal_waits_change_of_another_servo_goal_is_sent(void)
{
    let_wait();
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    see_through();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, waiting[0].result);
    TEST_ASSERT_EQUAL_UINT16(4, sent());
}

void test_a_goal_is_not_repeated_once_its_servo_is_held(void)
{
    cds_queue_set_retries(&queue, 2);
    TEST_ASSERT_EQUAL(CDS_OK, goal(1, 500));
    rig_transmit();
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    see_through();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result); // not CDS_INHIBITED: the goal was sent once
    TEST_ASSERT_EQUAL_UINT16(1, sent());
}

/* Everything goes out, and is answered. */
static void see_answered(void)
{
    for (uint8_t i = 0; i < 20 && bus.request; i++) {
        const struct cds_request *first;

        port_fake_settle(&bus);
        if (!port_fake_is_in_flight(&bus)) // the last was refused
            break;
        first = bus.request;
        rig_transmit();
        if (first->reply_parameters != CDS_REPLY_NONE && !first->is_muted)
            port_fake_answer(&bus.link, port_fake.sent[CDS_AT_ID], 0, NULL, 0);
        look();
        look();
    }
    TEST_ASSERT_NULL(bus.request);
}

static struct cds_request *wait_with(uint8_t i)
{
    waiting[i] = (struct cds_request)CDS_REQUEST(waiting_buffers[i], waiting_replies[i]);
    return &waiting[i];
}

static void word_waits(uint8_t i, uint8_t id, uint8_t address, uint16_t value)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_word(&bus, wait_with(i), id, address, value));
}

static void byte_waits(uint8_t i, uint8_t id, uint8_t address, uint8_t value)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, wait_with(i), id, address, value));
}

void test_a_mode_is_judged_by_what_was_written_before_it(void)
{
    in_position_mode(1);
    cds_servos_set_limits(&servos, one, 400, 600, 1023);
    wrote_word(1, CDS_REG_GOAL_POSITION, 500);
    word_waits(0, 1, CDS_REG_CW_ANGLE_LIMIT, 0);
    word_waits(1, 1, CDS_REG_CCW_ANGLE_LIMIT, 0);
    word_waits(2, 1, CDS_REG_MOVING_SPEED, 500);
    see_answered();
    TEST_ASSERT_EQUAL(CDS_OK, waiting[0].result);
    TEST_ASSERT_EQUAL(CDS_LIMIT, waiting[1].result);
    TEST_ASSERT_EQUAL(CDS_OK, waiting[2].result); // it is in position mode still
}

void test_a_goal_is_judged_by_whose_the_id_is_at_its_turn(void)
{
    cds_servos_set_limits(&servos, one, 200, 800, 1023);
    byte_waits(0, 1, CDS_REG_ID, 5);
    word_waits(1, 5, CDS_REG_GOAL_POSITION, 1000);
    see_answered();
    TEST_ASSERT_EQUAL(CDS_LIMIT, waiting[1].result);
}

void test_torque_on_is_judged_by_the_goal_written_before_it(void)
{
    in_position_mode(1);
    holds(1, 500, 100);
    byte_waits(0, 2, CDS_REG_LED, 1);
    byte_waits(1, 1, CDS_REG_TORQUE_ENABLE, 1);
    cds_servos_set_limits(&servos, one, 501, 1023, 1023);
    see_answered();
    TEST_ASSERT_EQUAL(CDS_LIMIT, waiting[1].result);
}

/* Somebody else has set the goal that a READ finds. */
void test_torque_on_is_judged_by_the_goal_read_before_it(void)
{
    in_position_mode(1);
    cds_servos_set_limits(&servos, one, 200, 800, 1023);
    holds(1, 500, 100);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 1, CDS_REG_GOAL_POSITION, 2));
    byte_waits(1, 1, CDS_REG_TORQUE_ENABLE, 1);
    rig_transmit();
    port_fake_answer(&bus.link, 1, 0, (const uint8_t[]){0xE8, 3}, 2);
    look();
    see_answered();
    TEST_ASSERT_EQUAL(CDS_LIMIT, waiting[1].result);
}

void test_a_reply_is_due_as_the_level_says_at_its_turn(void)
{
    wrote_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 1);
    byte_waits(0, 1, CDS_REG_STATUS_RETURN_LEVEL, 2);
    byte_waits(1, 1, CDS_REG_LED, 1);
    TEST_ASSERT_TRUE(waiting[1].is_muted);
    see_answered();
    TEST_ASSERT_FALSE(waiting[1].is_muted);
    byte_waits(0, 1, CDS_REG_STATUS_RETURN_LEVEL, 0);
    byte_waits(1, 1, CDS_REG_LED, 1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, wait_with(2), 1, CDS_REG_LED, 1));
    see_answered();
    TEST_ASSERT_TRUE(waiting[1].is_muted);
    TEST_ASSERT_EQUAL(CDS_NO_REPLY_DUE, waiting[2].result);
}

void test_the_delay_is_the_one_of_its_turn(void)
{
    wrote_byte(1, CDS_REG_RETURN_DELAY, 0);
    byte_waits(0, 1, CDS_REG_RETURN_DELAY, 254);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, wait_with(1), 1));
    TEST_ASSERT_EQUAL_UINT16(0, waiting[1].return_delay_us);
    see_answered();
    TEST_ASSERT_EQUAL_UINT16(508, waiting[1].return_delay_us);
}

/* That no reply is due was the servos's word, not the caller's: it is gone with what it was of. */
void test_a_request_used_again_is_not_what_the_roster_made_of_it(void)
{
    wrote_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 1);
    wrote_byte(1, CDS_REG_LED, 1);
    request.reply_parameters = CDS_REPLY_NONE; // by the caller's own wish
    wrote_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 2);
    cds_packet_write(&request.packet, 1, CDS_REG_LED, (const uint8_t[]){1}, 1);
    request.reply_parameters = CDS_REPLY_NONE;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
    TEST_ASSERT_EQUAL_UINT8(CDS_REPLY_NONE, request.reply_parameters);
}

/* A cycle is judged anew whenever the epoch counts on, so it must not without need. */
void test_the_epoch_counts_what_concerns_goals_and_no_more(void)
{
    uint16_t epoch;

    in_position_mode(1);
    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 1);
    epoch = servos.epoch;
    in_position_mode(1);
    wrote_word(1, CDS_REG_GOAL_POSITION, 500);
    wrote_word(1, CDS_REG_MOVING_SPEED, 500);
    read_byte_gives(1, CDS_REG_TORQUE_ENABLE, 1);
    TEST_ASSERT_EQUAL_UINT16(epoch, servos.epoch);
    wrote_word(1, CDS_REG_CW_ANGLE_LIMIT, 0);
    TEST_ASSERT_EQUAL_UINT16(epoch + 1, servos.epoch);
    TEST_ASSERT_EQUAL_UINT8(1, servos.changed_id);
}

/* A cycle still holds what the servos said before it was begun anew. */
void test_servos_begun_anew_go_on_counting(void)
{
    uint16_t epoch = servos.epoch;

    TEST_ASSERT_EQUAL(CDS_OK, begin(3));
    TEST_ASSERT_TRUE((uint16_t)(servos.epoch - epoch) > 1);
    TEST_ASSERT_EQUAL_UINT8(CDS_BROADCAST_ID, servos.hooks.changed_since(&servos, &epoch));
    TEST_ASSERT_EQUAL_UINT16(servos.epoch, epoch);
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, servos.hooks.changed_since(&servos, &epoch));
}

/* What is vetted when it is submitted is not vetted for ever. */
void test_a_prechecked_goal_is_checked_at_its_turn(void)
{
    waiting[0] = (struct cds_request)CDS_REQUEST(waiting_buffers[0], waiting_replies[0]);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &waiting[0], 30));
    cds_packet_write(&request.packet, 1, CDS_REG_GOAL_POSITION, (const uint8_t[]){0xF4, 1}, 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit_prechecked(&bus, &request, servos.epoch));
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    see_through();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, request.result);
    assert_refused(CDS_INHIBITED, goal(1, 500));
}

/* ---- soft limits ---- */

void test_goals_beyond_the_limits_are_not_sent(void)
{
    static const uint8_t data[] = {0xC9, 0};

    in_position_mode(1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 100, 200, 1023));
    assert_refused(CDS_LIMIT, goal(1, 99));
    assert_admitted(goal(1, 100));
    assert_admitted(goal(1, 200));
    assert_refused(CDS_LIMIT, goal(1, 201));
    assert_refused(CDS_LIMIT, goal(CDS_BROADCAST_ID, 201));
    assert_refused(CDS_LIMIT, sync_goals(201, 201));
    assert_admitted(sync_goals(200, 201));
    assert_refused(CDS_LIMIT,
                   cds_servo_reg_write(&bus, &request, 1, CDS_REG_GOAL_POSITION, data, 2));
    assert_admitted(goal(2, 1023));
}

void test_half_a_goal_cannot_be_judged(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 100, 1023, 1023));
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_GOAL_POSITION, 150));
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_GOAL_POSITION + 1, 1));
    assert_refused(CDS_LIMIT, write_word(1, CDS_REG_GOAL_POSITION - 1, 0x9600));
    assert_admitted(write_byte(2, CDS_REG_GOAL_POSITION, 150));
}

void test_speed_has_a_limit_in_position_mode(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 0, 1023, 300));
    assert_refused(CDS_LIMIT, goal(1, 500)); // at which speed?
    assert_refused(CDS_LIMIT, speed(1, 0));  // as fast as it can
    assert_refused(CDS_LIMIT, speed(1, 301));
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_MOVING_SPEED, 10));
    wrote_word(1, CDS_REG_MOVING_SPEED, 300);
    assert_refused(CDS_LIMIT, goal(1, 500)); // rule 6: its power may have been gone since
    assert_admitted(goal_and_speed(1, 500, 300));
    assert_refused(CDS_LIMIT, goal_and_speed(1, 500, 0));
}

void test_goal_and_speed_in_one_write_are_judged_together(void)
{
    uint8_t data[] = {0xF4, 0x01, 0x2C, 0x01};

    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 0, 1023, 300));
    assert_admitted(cds_servo_write(&bus, &request, 1, CDS_REG_GOAL_POSITION, data, 4));
    data[2]++;
    assert_refused(CDS_LIMIT, cds_servo_write(&bus, &request, 1, CDS_REG_GOAL_POSITION, data, 4));
}

void test_what_was_forgotten_with_the_power_must_be_read_again(void)
{
    in_position_mode(1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 0, 1023, 300));
    holds(1, 500, 300);
    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 1);
    read_byte_gives(1, CDS_REG_TORQUE_ENABLE, 0);
    cds_servos_release(&servos, one);
    wrote_word(1, CDS_REG_MOVING_SPEED, 300);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1)); // written is not read
    holds(1, 500, 300);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1)); // in which mode?
    in_position_mode(1);
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
}

void test_one_long_read_tells_all_that_torque_on_needs(void)
{
    uint8_t data[CDS_REG_MOVING_SPEED + 2 - CDS_REG_RETURN_DELAY] = {10, 0, 0, 0xFF, 3};

    data[CDS_REG_STATUS_RETURN_LEVEL - CDS_REG_RETURN_DELAY] = 1;
    data[CDS_REG_GOAL_POSITION + 1 - CDS_REG_RETURN_DELAY] = 2; // 512
    data[CDS_REG_MOVING_SPEED - CDS_REG_RETURN_DELAY] = 100;
    cds_servos_set_limits(&servos, one, 200, 800, 300);
    wrote_byte(2, CDS_REG_TORQUE_ENABLE, 1);
    go_away(1);
    answer(cds_servo_ping(&bus, &request, 1), 1, 0);
    read_gives(1, CDS_REG_RETURN_DELAY, data, sizeof data);
    TEST_ASSERT_EQUAL_UINT8(10, one->return_delay);
    TEST_ASSERT_EQUAL_UINT8(1, one->status_return_level);
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
}

void test_a_new_limit_of_speed_forgets_the_speed_held(void)
{
    in_position_mode(1);
    holds(1, 500, 300);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 0, 1023, 200));
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
}

void test_a_limit_drawn_closer_forgets_what_was_within_it(void)
{
    in_position_mode(1);
    cds_servos_set_limits(&servos, one, 200, 800, 300);
    holds(1, 500, 200);
    cds_servos_set_limits(&servos, one, 200, 800, 300);
    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 1); // the same are no closer
    cds_servos_set_limits(&servos, one, 501, 800, 300);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    holds(1, 510, 200);
    cds_servos_set_limits(&servos, one, 501, 509, 300);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    holds(1, 505, 200);
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    cds_servos_set_limits(&servos, one, 501, 509, 199);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
}

static void endless_turn(uint8_t id)
{
    static const uint8_t zeros[4];

    answer(cds_servo_write(&bus, &request, id, CDS_REG_CW_ANGLE_LIMIT, zeros, 4), id, 0);
    read_gives(id, CDS_REG_CW_ANGLE_LIMIT, zeros, 4);
}

void test_speed_has_a_limit_in_endless_turn_both_ways(void)
{
    endless_turn(1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 0, 1023, 300));
    assert_admitted(speed(1, 0)); // stands still
    assert_admitted(speed(1, 300));
    assert_admitted(speed(1, 0x400 + 300));
    assert_refused(CDS_LIMIT, speed(1, 301));
    assert_refused(CDS_LIMIT, speed(1, 0x400 + 301));
}

void test_endless_turn_servo_with_goal_limit_is_refused(void)
{
    static const uint8_t zeros[4];

    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 100, 1023, 1023));
    assert_refused(CDS_LIMIT, cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, zeros, 4));
    in_position_mode(1);
    wrote_word(1, CDS_REG_CW_ANGLE_LIMIT, 0);
    assert_refused(CDS_LIMIT, write_word(1, CDS_REG_CCW_ANGLE_LIMIT, 0));
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_CCW_ANGLE_LIMIT, 0));
    assert_admitted(write_word(1, CDS_REG_CCW_ANGLE_LIMIT, 500));
    read_gives(1, CDS_REG_CW_ANGLE_LIMIT, zeros, 4); // somebody else has done it
    assert_refused(CDS_LIMIT, speed(1, 1));
    assert_admitted(speed(1, 0));
}

/* Speed 0 stands still in one mode and is as fast as it can in the other. */
void test_endless_turn_is_not_left_with_speed_0(void)
{
    static const uint8_t position[] = {0, 0, 0xFF, 3};

    endless_turn(1);
    cds_servos_set_limits(&servos, one, 0, 1023, 300);
    holds(1, 500, 0);
    assert_refused(CDS_LIMIT,
                   cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, position, 4));
    wrote_word(1, CDS_REG_MOVING_SPEED, 100);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_sync_write_add_goal(&request, 1, 0, 0);
    answer(cds_sync_write_send(&bus, &request), 0, 0);
    assert_refused(CDS_LIMIT,
                   cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, position, 4));
    wrote_word(1, CDS_REG_MOVING_SPEED, 100);
    assert_admitted(cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, position, 4));
    assert_admitted(goal_and_speed(1, 500, 100));
}

/* Neither mode can be taken for granted: not before it was read, not by half, not unconfirmed. */
void test_a_speed_needs_a_known_mode(void)
{
    static const uint8_t zeros[4];

    cds_servos_set_limits(&servos, one, 200, 800, 1023);
    assert_refused(CDS_LIMIT, speed(1, 500));
    assert_refused(CDS_LIMIT, sync_goals(500, 500));
    assert_admitted(goal(1, 500)); // endless turn has no use for it
    in_position_mode(1);
    assert_admitted(speed(1, 500));
    assert_admitted(sync_goals(500, 500));
    cds_servos_set_limits(&servos, one, 0, 1023, 1023);
    silence(cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, zeros, 4));
    cds_servos_set_limits(&servos, one, 200, 800, 1023);
    assert_refused(CDS_LIMIT, speed(1, 500));
    in_position_mode(1);
    assert_admitted(speed(1, 500));
}

void test_a_mode_set_by_halves_or_by_a_sync_write_is_not_known(void)
{
    static const uint8_t refused_by_the_servo[] = {0, 4, 0, 4}, zeros[4];

    in_position_mode(1);
    for (uint8_t i = 0; i < 4; i++)
        wrote_byte(1, (uint8_t)(CDS_REG_CW_ANGLE_LIMIT + i), 0);
    cds_servos_set_limits(&servos, one, 200, 800, 1023);
    assert_refused(CDS_LIMIT, speed(1, 500));
    read_gives(2, CDS_REG_CW_ANGLE_LIMIT, zeros, 4);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_CW_ANGLE_LIMIT, 4));
    cds_sync_write_add(&request, 2, refused_by_the_servo);
    answer(cds_sync_write_send(&bus, &request), 0, 0);
    cds_servos_set_limits(&servos, two, 200, 800, 1023);
    assert_refused(CDS_LIMIT, speed(2, 500));
}

/* What a mode is not known after, one may not go to with a speed that suits one of them only. */
void test_half_a_change_of_mode_needs_a_speed_for_both(void)
{
    static const uint8_t set[] = {0, 1, 0, 1};

    endless_turn(1);
    cds_servos_set_limits(&servos, one, 0, 1023, 300);
    holds(1, 500, 0);
    TEST_ASSERT_BITS(CDS_HELD_CW_SET | CDS_HELD_CW_0, CDS_HELD_CW_0, one->held);
    read_gives(1, CDS_REG_CW_ANGLE_LIMIT, set, 4);
    read_byte_gives(1, CDS_REG_CW_ANGLE_LIMIT + 1, 0);
    TEST_ASSERT_FALSE(one->held & (CDS_HELD_CW_SET | CDS_HELD_CW_0)); // its low byte was 0, or not
    read_byte_gives(1, CDS_REG_CCW_ANGLE_LIMIT + 1, 0);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_CW_ANGLE_LIMIT + 1, 0));
    wrote_word(1, CDS_REG_MOVING_SPEED, 300);
    assert_admitted(write_byte(1, CDS_REG_CW_ANGLE_LIMIT + 1, 0));
}

/* A speed of 0 that no servo acknowledges may be held all the same. */
void test_endless_turn_speed_of_sync_write_does_not_end_it(void)
{
    static const uint8_t position[] = {0, 0, 0xFF, 3};

    endless_turn(1);
    cds_servos_set_limits(&servos, one, 0, 1023, 300);
    holds(1, 500, 100);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_MOVING_SPEED, 2));
    cds_sync_write_add(&request, 1, (const uint8_t[]){0, 0});
    answer(cds_sync_write_send(&bus, &request), 0, 0);
    assert_refused(CDS_LIMIT,
                   cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, position, 4));
    holds(1, 500, 100);
    assert_admitted(cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, position, 4));
}

void test_endless_turn_speed_0_unanswered_does_not_end_it(void)
{
    static const uint8_t all[CDS_REG_MOVING_SPEED + 2 - CDS_REG_CW_ANGLE_LIMIT];

    endless_turn(1);
    cds_servos_set_limits(&servos, one, 0, 1023, 300);
    holds(1, 500, 100);
    silence(cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, all, sizeof all));
    assert_refused(CDS_LIMIT, write_word(1, CDS_REG_CCW_ANGLE_LIMIT, 1023));
}

/* A write of all from the angle limits to the speed, in a packet that nobody answers. */
void test_nothing_unacknowledged_makes_goal_or_speed_known(void)
{
    uint8_t data[CDS_REG_MOVING_SPEED + 2 - CDS_REG_CW_ANGLE_LIMIT] = {100, 0, 0xFF, 3};

    data[CDS_REG_GOAL_POSITION + 1 - CDS_REG_CW_ANGLE_LIMIT] = 1; // 256
    data[CDS_REG_MOVING_SPEED - CDS_REG_CW_ANGLE_LIMIT] = 100;
    data[CDS_REG_STATUS_RETURN_LEVEL - CDS_REG_CW_ANGLE_LIMIT] = 2;
    in_position_mode(1);
    cds_servos_set_limits(&servos, one, 200, 800, 300);
    silence(cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, data, sizeof data));
    TEST_ASSERT_FALSE(one->held & CDS_HELD_GOAL);
    TEST_ASSERT_FALSE(one->held & CDS_HELD_SPEED);
    assert_admitted(cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, data, sizeof data));
    TEST_ASSERT_FALSE(one->held & CDS_HELD_GOAL); // rule 6: written is not read
    TEST_ASSERT_FALSE(one->held & CDS_HELD_SPEED);
    holds(1, 256, 100);
    TEST_ASSERT_TRUE(one->held & CDS_HELD_GOAL);
    TEST_ASSERT_TRUE(one->held & CDS_HELD_SPEED);
}

/* It would go on with what it was told before there was a limit. */
void test_torque_on_or_mode_change_checks_the_goal_held(void)
{
    static const uint8_t fast[] = {0xE8, 3, 0xE8, 3}, zeros[4];

    in_position_mode(1);
    assert_admitted(cds_servo_write(&bus, &request, 1, CDS_REG_GOAL_POSITION, fast, 4));
    cds_servos_set_limits(&servos, one, 0, 1023, 100);
    assert_refused(CDS_LIMIT, cds_servo_write(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, zeros, 4));
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    holds(1, 1000, 100);
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    cds_servos_set_limits(&servos, one, 200, 800, 100);
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    assert_admitted(sync_goals(500, 500)); // not acknowledged
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    assert_admitted(goal_and_speed(1, 500, 100));
    assert_refused(CDS_LIMIT, write_byte(1, CDS_REG_TORQUE_ENABLE, 1)); // not read
    holds(1, 500, 100);
    assert_admitted(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
}

void test_the_mode_of_a_held_servo_stays(void)
{
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    for (uint8_t i = 0; i < 4; i++)
        assert_refused(CDS_INHIBITED, write_byte(1, (uint8_t)(CDS_REG_CW_ANGLE_LIMIT + i), 0));
    assert_admitted(write_byte(1, CDS_REG_CCW_ANGLE_LIMIT + 2, 0));
}

void test_refused_id_is_not_overwritten_by_a_permitted_request(void)
{
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    assert_refused(CDS_INHIBITED, goal(2, 500));
    assert_admitted(goal(1, 500));
    assert_admitted(write_byte(2, CDS_REG_LED, 1));
    assert_admitted(goal(CDS_BROADCAST_ID - 1, 500));
    TEST_ASSERT_EQUAL_UINT8(2, servos.refused_id);
}

void test_limits_out_of_range_are_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servos_set_limits(&servos, one, 200, 100, 5));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servos_set_limits(&servos, one, 0, 1024, 5));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servos_set_limits(&servos, one, 0, 1023, 1024));
    TEST_ASSERT_EQUAL_UINT16(1023, one->highest);
    TEST_ASSERT_EQUAL_UINT16(1023, one->fastest);
}

void test_half_a_block_of_a_sync_write_is_no_part_of_it(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 0, 500, 1023));
    memset(buffer, 3, sizeof buffer); // beyond the limit, if it were taken for a goal
    cds_packet_begin(&request.packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
    cds_packet_put(&request.packet, CDS_REG_GOAL_POSITION);
    cds_packet_put(&request.packet, 2);
    cds_packet_put(&request.packet, 1);
    cds_packet_put(&request.packet, 3);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    request.reply_parameters = CDS_REPLY_NONE;
    answer(cds_bus_submit(&bus, &request), 0, 0);
}

/* Whatever a packet says its length is, nothing outside it is judged or learnt. */
void test_odd_packets_pass_unharmed(void)
{
    cds_packet_begin(&request.packet, 1, CDS_WRITE);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    request.reply_parameters = 0;
    answer(cds_bus_submit(&bus, &request), 1, CDS_ERROR_INSTRUCTION);
    cds_packet_begin(&request.packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
    cds_packet_put(&request.packet, CDS_REG_GOAL_POSITION);
    cds_packet_put(&request.packet, 0);
    cds_packet_put(&request.packet, 1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    request.reply_parameters = CDS_REPLY_NONE;
    answer(cds_bus_submit(&bus, &request), 0, 0);
    cds_packet_begin(&request.packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    answer(cds_bus_submit(&bus, &request), 0, 0);
}

/* A length of 255 bytes for each, which no packet has room for; and parameters that are not there,
 * with a buffer that ends where the packet does. */
void test_a_sync_write_of_nothing_is_judged_without_an_end(void)
{
    cds_packet_begin(&request.packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
    cds_packet_put(&request.packet, CDS_REG_GOAL_POSITION);
    cds_packet_put(&request.packet, 255);
    cds_packet_put(&request.packet, 1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    request.reply_parameters = CDS_REPLY_NONE;
    answer(cds_bus_submit(&bus, &request), 0, 0);
}

void test_parameters_that_are_not_there_are_not_read(void)
{
    static const uint8_t instructions[] = {CDS_WRITE, CDS_REG_WRITE, CDS_SYNC_WRITE};
    uint8_t exact[CDS_PACKET_SIZE(0)]; // on the stack: AddressSanitizer watches its end

    request.packet.bytes = exact;
    request.packet.capacity = sizeof exact;
    for (uint8_t i = 0; i < sizeof instructions; i++) {
        cds_packet_begin(&request.packet, CDS_BROADCAST_ID, instructions[i]);
        TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
        request.reply_parameters = CDS_REPLY_NONE;
        answer(cds_bus_submit(&bus, &request), 0, 0);
    }
}

/* ---- list, epoch, entries ---- */

void test_begin_with_bad_arguments_is_refused(void)
{
    struct cds_bus closed = {.port = 0};
    struct cds_servos_config config = {.bus = &closed, .states = states, .capacity = 4};

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servos_begin(&servos, &config));
    config.bus = &bus;
    config.capacity = 255;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servos_begin(&servos, &config));
    config.capacity = 2;
    config.count = 3;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_servos_begin(&servos, &config));
    TEST_ASSERT_EQUAL_UINT8(3, servos.count); // as before
    states[0].id = states[1].id = 1;          // the first pair, with another entry behind
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin(3));
    TEST_ASSERT_EQUAL_UINT8(0, servos.count);
}

void test_epoch_is_never_0_nor_1(void)
{
    servos.epoch = 0xFFFE;
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    TEST_ASSERT_EQUAL_HEX16(0xFFFF, servos.epoch);
    cds_servos_release(&servos, one);
    TEST_ASSERT_EQUAL_HEX16(2, servos.epoch);
}

void test_changed_since_names_one_servo_or_all(void)
{
    uint16_t epoch = servos.epoch;

    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, bus.hooks->changed_since(&servos, &epoch));
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    TEST_ASSERT_EQUAL_UINT8(2, bus.hooks->changed_since(&servos, &epoch));
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, bus.hooks->changed_since(&servos, &epoch));
    cds_servos_release(&servos, two);
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    TEST_ASSERT_EQUAL_UINT8(CDS_BROADCAST_ID, bus.hooks->changed_since(&servos, &epoch));
    cds_servos_inhibit_all(&servos);
    TEST_ASSERT_EQUAL_UINT8(CDS_BROADCAST_ID, bus.hooks->changed_since(&servos, &epoch));
}

void test_entry_is_reserved_only_by_an_id_change_on_the_wire(void)
{
    static const uint8_t first_registers[] = {CDS_REG_MODEL_NUMBER, CDS_REG_ID, CDS_REG_BAUD_RATE};

    for (uint8_t i = 0; i < 3; i++) {
        bool is_reserved = first_registers[i] <= CDS_REG_ID;

        setUp();
        TEST_ASSERT_EQUAL(CDS_OK, write_byte(1, first_registers[i], 1));
        TEST_ASSERT_EQUAL(CDS_BUS_SENDING, bus.state);
        TEST_ASSERT_EQUAL(is_reserved ? CDS_NO_ROOM : CDS_OK, cds_servos_add(&servos, 40));
        TEST_ASSERT_EQUAL(is_reserved, servos.is_full);
    }
    setUp();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 1, CDS_REG_MODEL_NUMBER, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_add(&servos, 40));
    setUp();
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_reset(&bus, &request, 1));
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_servos_add(&servos, 40));
    setUp();
    port_fake.low = true;
    TEST_ASSERT_EQUAL(CDS_OK, write_byte(1, CDS_REG_ID, 9)); // waits for the line
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_add(&servos, 40));
    port_fake.low = false;
    port_fake_settle(&bus);
    TEST_ASSERT_EQUAL(CDS_LIMIT, request.result); // no entry is left for the second ID
    TEST_ASSERT_EQUAL_UINT16(0, sent());
}

void test_may_drive_unknown_and_not_offline_servos(void)
{
    TEST_ASSERT_TRUE(cds_servos_may_drive(&servos, 99));
    TEST_ASSERT_TRUE(cds_servos_may_drive(&servos, 1));
    go_away(1);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 1));
    states[3].inhibits = CDS_INHIBIT_STOPPED; // an entry behind the last servo
    TEST_ASSERT_TRUE(cds_servos_may_drive(&servos, CDS_BROADCAST_ID));
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 2));
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, CDS_BROADCAST_ID));
    cds_servos_inhibit_all(&servos);
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, 99));
}

void test_acknowledge_without_alarms_is_no_news(void)
{
    uint8_t event_count = servos.event_count;

    TEST_ASSERT_EQUAL_HEX8(0, cds_servos_acknowledge(&servos, NULL));
    TEST_ASSERT_EQUAL_HEX8(0, cds_servos_acknowledge(&servos, one));
    TEST_ASSERT_EQUAL_UINT8(event_count, servos.event_count);
    answer(cds_servo_ping(&bus, &request, 1), 1, CDS_ERROR_OVERLOAD);
    event_count = servos.event_count;
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_OVERLOAD, cds_servos_acknowledge(&servos, one));
    TEST_ASSERT_EQUAL_UINT8(event_count + 1, servos.event_count);
}

void test_settled_id_frees_its_entry_for_the_last_one(void)
{
    silence(write_byte(1, CDS_REG_ID, 9));
    TEST_ASSERT_EQUAL_UINT8(4, servos.count);
    TEST_ASSERT_EQUAL(CDS_OK, begin(1)); // anew, with room for two more behind
    silence(write_byte(1, CDS_REG_ID, 9));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_add(&servos, 40));
    cds_servos_inhibit(&servos, &states[2], CDS_INHIBIT_STATE_LOST);
    read_byte_gives(1, CDS_REG_LED, 0);
    go_unheard(9);
    TEST_ASSERT_EQUAL_UINT8(2, servos.count);
    TEST_ASSERT_EQUAL_PTR(&states[1], cds_servos_find(&servos, 40));
    TEST_ASSERT_NULL(cds_servos_find(&servos, 9));
    assert_refused(CDS_INHIBITED, goal(40, 500));
}

void test_moved_entry_of_an_id_in_doubt_keeps_its_pair(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin(2));
    silence(write_byte(1, CDS_REG_ID, 9));
    silence(write_byte(2, CDS_REG_ID, 10));
    TEST_ASSERT_EQUAL_UINT8(4, servos.count);
    read_byte_gives(1, CDS_REG_LED, 0);
    go_unheard(9);
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    assert_refused(CDS_INHIBITED, goal(2, 500));
    assert_refused(CDS_INHIBITED, goal(10, 500));
    cds_servos_release(&servos, cds_servos_find(&servos, 10));
    assert_admitted(goal(2, 500));
    assert_admitted(goal(1, 500));
}

void test_id_in_doubt_stays_so_when_a_second_change_is_answered(void)
{
    silence(write_byte(1, CDS_REG_ID, 9));
    wrote_byte(1, CDS_REG_ID, 9); // by a servo that had not heard the first one
    TEST_ASSERT_EQUAL_UINT8(4, servos.count);
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    assert_refused(CDS_INHIBITED, goal(1, 500));
    assert_refused(CDS_INHIBITED, goal(9, 500));
    read_byte_gives(9, CDS_REG_LED, 0);
    go_unheard(1);
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
    TEST_ASSERT_EQUAL_UINT8(9, one->id);
    assert_refused(CDS_INHIBITED, goal(9, 500));
}

/* ---- routine feedback ---- */

static const uint8_t values[9] = {1, 2, 3};

static void read_feedback(uint8_t id)
{
    read_gives(id, CDS_REG_PRESENT_POSITION, values, 8);
}

void test_feedback_counts_for_the_servo_that_answered(void)
{
    read_feedback(1);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_ONLINE, one->presence);
    read_feedback(1); // the second one is routine
    TEST_ASSERT_EQUAL_UINT16(2, one->counters.ok);
    request.servo_index = 0;
    read_feedback(2); // with the hint of servo 1
    request.servo_index = 0;
    read_feedback(99); // unknown
    request.servo_index = 200;
    read_feedback(99);
    TEST_ASSERT_EQUAL_UINT16(2, one->counters.ok);
    TEST_ASSERT_EQUAL_UINT16(1, two->counters.ok);
}

void test_feedback_with_error_bits_is_noticed(void)
{
    read_feedback(1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 1, CDS_REG_PRESENT_POSITION, 8));
    rig_transmit();
    port_fake_answer(&bus.link, 1, CDS_ERROR_OVERLOAD, values, 8);
    look();
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_OVERLOAD, one->alarms);
}

void test_feedback_at_another_rate_tells_the_rate(void)
{
    read_feedback(1);
    one->baud_reg = CDS_SERVOS_UNKNOWN;
    read_feedback(1);
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, one->baud_reg);
    TEST_ASSERT_EQUAL_UINT16(2, one->counters.ok);
}

void test_feedback_with_an_echo_error_counts_it(void)
{
    read_feedback(1);
    bus.link.echo_errors++;
    read_feedback(1);
    TEST_ASSERT_EQUAL_UINT8(1, one->counters.echo_errors);
    TEST_ASSERT_EQUAL_UINT16(2, one->counters.ok);
    read_feedback(1);
    wrote_byte(1, CDS_REG_LED, 0);
    TEST_ASSERT_EQUAL_UINT8(1, one->counters.echo_errors); // the same one
}

void test_feedback_while_paused_is_not_counted(void)
{
    read_feedback(1);
    servos.is_paused = true;
    read_feedback(1);
    TEST_ASSERT_EQUAL_UINT16(1, one->counters.ok);
    servos.grows = CDS_GROWS_ALWAYS;
    answer(cds_servo_ping(&bus, &request, 99), 99, CDS_ERROR_OVERLOAD);
    TEST_ASSERT_NULL(cds_servos_find(&servos, 99));
    TEST_ASSERT_EQUAL_HEX8(0, servos.alarms);
}

void test_read_up_to_the_registered_instruction_is_learnt(void)
{
    read_feedback(1);
    one->is_registered = true;
    read_feedback(1);
    TEST_ASSERT_TRUE(one->is_registered);
    read_gives(1, CDS_REG_PRESENT_POSITION, values, 9); // 0x2C is 0
    TEST_ASSERT_FALSE(one->is_registered);
}

void test_reply_of_another_length_is_not_learnt(void)
{
    static const uint8_t two_bytes[2] = {0, 0};

    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 1);
    cds_packet_read(&request.packet, 1, CDS_REG_TORQUE_ENABLE, 1);
    request.reply_parameters = 1;
    request.any_length = true;
    request.reply_capacity = CDS_REPLY_ANY; // no more than two bytes come
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
    rig_transmit();
    port_fake_answer(&bus.link, 1, 0, two_bytes, 2);
    look();
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_TRUE(one->torque);
    TEST_ASSERT_FALSE(cds_servos_inhibits(&servos, one));
}

void test_reset_of_all_forgets_misses(void)
{
    silence(cds_servo_ping(&bus, &request, 1));
    silence(cds_servo_ping(&bus, &request, 1));
    cds_servos_allow_reset(&servos, true);
    answer(cds_servo_reset(&bus, &request, CDS_BROADCAST_ID), 0, 0);
    one->baud_reg = CDS_BAUD_1M; // so that a miss counts
    silence(cds_servo_ping(&bus, &request, 1));
    TEST_ASSERT_EQUAL(CDS_PRESENCE_UNKNOWN, one->presence);
}

void test_unrequested_packet_makes_a_low_level_unknown(void)
{
    static const uint8_t after[] = {CDS_LEVEL_UNKNOWN, CDS_LEVEL_UNKNOWN, 2};

    for (uint8_t level = 0; level < 3; level++) {
        one->status_return_level = level & 3u;
        port_fake_answer(&bus.link, 1, 0, NULL, 0);
        look();
        TEST_ASSERT_EQUAL_UINT8(after[level], one->status_return_level);
    }
    TEST_ASSERT_EQUAL_UINT8(3, one->counters.unexpected_packets);
}

void test_reset_unanswered_at_another_rate_leaves_it_unknown(void)
{
    silence(cds_servo_reset(&bus, &request, 1));
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, one->baud_reg); // before and after it
    one->baud_reg = 7;
    silence(cds_servo_reset(&bus, &request, 1));
    TEST_ASSERT_EQUAL_UINT8(CDS_SERVOS_UNKNOWN, one->baud_reg);
}

void test_action_carries_out_a_registered_torque_once(void)
{
    answer(register_byte(1, CDS_REG_TORQUE_ENABLE, 1), 1, 0);
    answer(action(1), 1, 0);
    TEST_ASSERT_TRUE(one->torque);
    wrote_byte(1, CDS_REG_TORQUE_ENABLE, 0);
    answer(action(1), 1, 0);
    TEST_ASSERT_FALSE(one->torque);
}

void test_new_delay_or_level_changes_the_epoch_once(void)
{
    uint16_t epoch;

    wrote_byte(1, CDS_REG_LED, 0);
    epoch = servos.epoch;
    wrote_byte(1, CDS_REG_RETURN_DELAY, 20);
    TEST_ASSERT_NOT_EQUAL(epoch, servos.epoch);
    epoch = servos.epoch;
    wrote_byte(1, CDS_REG_RETURN_DELAY, 20);
    TEST_ASSERT_EQUAL_UINT16(epoch, servos.epoch);
    wrote_byte(1, CDS_REG_STATUS_RETURN_LEVEL, 1);
    TEST_ASSERT_NOT_EQUAL(epoch, servos.epoch);
}

void test_second_entry_of_an_id_counts_from_0(void)
{
    read_feedback(1);
    silence(write_byte(1, CDS_REG_ID, 9));
    TEST_ASSERT_EQUAL_UINT16(0, cds_servos_find(&servos, 9)->counters.ok);
    TEST_ASSERT_EQUAL_UINT16(0, cds_servos_find(&servos, 9)->counters.timeouts);
    TEST_ASSERT_EQUAL_UINT16(1, one->counters.ok);
}

void test_stale_reply_is_no_unexpected_packet(void)
{
    silence(cds_servo_ping(&bus, &request, 1));
    one->status_return_level = 1;
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    look();
    TEST_ASSERT_EQUAL_UINT8(1, one->counters.stale_replies);
    TEST_ASSERT_EQUAL_UINT8(0, one->counters.unexpected_packets);
    TEST_ASSERT_EQUAL_UINT8(1, one->status_return_level);
}

void test_reset_of_all_concerns_the_goals_of_all(void)
{
    uint16_t epoch;

    cds_servos_allow_reset(&servos, true);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_reset(&bus, &request, CDS_BROADCAST_ID));
    epoch = servos.epoch;
    rig_transmit();
    look();
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL_UINT8(CDS_BROADCAST_ID, bus.hooks->changed_since(&servos, &epoch));
}
