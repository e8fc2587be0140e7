/* SPDX-License-Identifier: MIT */
/* Driving is inhibited: what the bus refuses and what passes, whether servos.h knows the servo or
 * not; and return delays that the board cannot bear. */
#include "cds55xx/servos.h"

#include <string.h>

#include "cds55xx/sync_write.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

static struct cds_servos servos;
static struct cds_queue queue;
static struct cds_servo_state states[2];
static uint8_t buffers[2][CDS_PACKET_SIZE(CDS_REPLY_MAX)], replies[2][CDS_REPLY_MAX];
static struct cds_request request, other;

static const uint8_t ids[] = {1, 77, CDS_BROADCAST_ID}; // known, unknown, all

static enum cds_result begin_with_delay(uint8_t count, uint8_t shortest_delay)
{
    return cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                                 .queue = &queue,
                                                                 .states = states,
                                                                 .count = count,
                                                                 .capacity = 2,
                                                                 .shortest_delay = shortest_delay});
}

static enum cds_result begin(uint8_t count)
{
    return begin_with_delay(count, 0);
}

void setUp(void)
{
    rig_open(0);
    memset(&servos, 0, sizeof servos);
    memset(states, 0, sizeof states);
    request = (struct cds_request)CDS_REQUEST(buffers[0], replies[0]);
    other = (struct cds_request)CDS_REQUEST(buffers[1], replies[1]);
    states[0].id = 1;
    states[1].id = 2;
    TEST_ASSERT_EQUAL(CDS_OK, begin(2));
}

void tearDown(void)
{
    rig_check();
}

static void inhibit(void)
{
    cds_servos_inhibit_all(&servos);
}

static void assert_refused(enum cds_result submitted)
{
    TEST_ASSERT_EQUAL(CDS_INHIBITED, rig_result_of_check(&request, submitted));
    TEST_ASSERT_NULL(bus.request);
}

/* The packet is on the bus; its silence lasts until the request has ended. */
static void assert_sent(enum cds_result submitted)
{
    uint16_t packets = port_fake.packets;

    TEST_ASSERT_EQUAL(CDS_OK, submitted);
    rig_transmit();
    TEST_ASSERT_EQUAL_UINT16(packets + 1, port_fake.packets);
    for (uint8_t i = 0; i < 100 && request.result == CDS_PENDING; i++) {
        port_fake.now_us += 1000;
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, request.result);
}

static enum cds_result write_byte(uint8_t id, uint8_t reg, uint8_t value)
{
    return cds_servo_write_byte(&bus, &request, id, reg, value);
}

static enum cds_result write_word(uint8_t id, uint8_t reg, uint16_t value)
{
    return cds_servo_write_word(&bus, &request, id, reg, value);
}

static enum cds_result sync_one(uint8_t id, uint8_t reg, const uint8_t *data, uint8_t length)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, reg, length));
    cds_sync_write_add(&request, id, data);
    return cds_sync_write_send(&bus, &request);
}

/* TORQUE_ENABLE of servo 9 is 0, of servo `id` 1. */
static enum cds_result sync_on_behind_off(uint8_t id)
{
    static const uint8_t on = 1, off = 0;

    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_TORQUE_ENABLE, 1));
    cds_sync_write_add(&request, 9, &off);
    cds_sync_write_add(&request, id, &on);
    return cds_sync_write_send(&bus, &request);
}

static enum cds_result raw(uint8_t id, uint8_t instruction)
{
    const uint8_t bytes[] = {0xFF, 0xFF, id, 2, instruction, (uint8_t) ~(id + 2 + instruction)};

    memcpy(buffers[0], bytes, sizeof bytes);
    request.packet.size = sizeof bytes;
    request.reply_parameters = CDS_REPLY_NONE;
    return cds_bus_submit(&bus, &request);
}

void test_inhibit_of_a_goal_or_speed_refuses_every_id(void)
{
    inhibit();
    for (uint8_t i = 0; i < sizeof ids; i++) {
        assert_refused(write_word(ids[i], CDS_REG_GOAL_POSITION, 500));
        assert_refused(write_byte(ids[i], CDS_REG_GOAL_POSITION + 1, 1));
        assert_refused(write_word(ids[i], CDS_REG_MOVING_SPEED, 0));
        assert_refused(write_byte(ids[i], CDS_REG_MOVING_SPEED + 1, 4));
    }
}

void test_inhibit_of_an_angle_limit_refuses_every_id(void)
{
    inhibit();
    for (uint8_t i = 0; i < sizeof ids; i++) {
        assert_refused(write_word(ids[i], CDS_REG_CW_ANGLE_LIMIT, 0));
        assert_refused(write_byte(ids[i], CDS_REG_CCW_ANGLE_LIMIT + 1, 0));
    }
}

void test_inhibit_of_torque_on_refuses_every_id(void)
{
    inhibit();
    for (uint8_t i = 0; i < sizeof ids; i++) {
        assert_refused(write_byte(ids[i], CDS_REG_TORQUE_ENABLE, 1));
        assert_sent(write_byte(ids[i], CDS_REG_TORQUE_ENABLE, 0));
    }
}

void test_inhibit_of_a_long_write_sees_the_goal_in_it(void)
{
    static const uint8_t off_and_goal[8] = {0, 0, 32, 32, 0, 0, 100, 0}; // from 0x18 on

    inhibit();
    for (uint8_t i = 0; i < sizeof ids; i++) {
        assert_refused(cds_servo_write(&bus, &request, ids[i], 0x18, off_and_goal, 8));
        assert_refused(cds_servo_reg_write(&bus, &request, ids[i], 0x18, off_and_goal, 8));
        assert_sent(cds_servo_write(&bus, &request, ids[i], 0x18, off_and_goal, 2));
    }
}

void test_inhibit_of_action_and_reset_refuses_every_id(void)
{
    inhibit();
    for (uint8_t i = 0; i < sizeof ids; i++) {
        assert_refused(cds_servo_action(&bus, &request, ids[i]));
        assert_refused(raw(ids[i], CDS_RESET));
    }
}

void test_inhibit_of_an_unknown_instruction_refuses_it(void)
{
    inhibit();
    for (uint16_t instruction = 0; instruction < 256; instruction++)
        for (uint8_t i = 0; i < sizeof ids; i++)
            if (instruction == 0 || (instruction > CDS_RESET && instruction != CDS_SYNC_WRITE))
                assert_refused(raw(ids[i], (uint8_t)instruction));
}

void test_inhibit_of_a_sync_write_refuses_unknown_ids(void)
{
    static const uint8_t goal[4] = {0, 2, 0, 1}, on = 1, off = 0;
    uint8_t index = 0;

    inhibit();
    for (uint8_t id = 1; id < 100; id = (uint8_t)(id + 76)) {
        assert_refused(sync_one(id, CDS_REG_GOAL_POSITION, goal, 4));
        assert_refused(sync_one(id, CDS_REG_TORQUE_ENABLE, &on, 1));
        assert_refused(sync_on_behind_off(id));
        assert_sent(sync_one(id, CDS_REG_TORQUE_ENABLE, &off, 1));
        assert_sent(sync_one(id, CDS_REG_LED, &on, 1));
        TEST_ASSERT_EQUAL(CDS_INHIBITED,
                          bus.hooks->permit_goal(bus.hooks->context, id, &index, goal));
        TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, id));
    }
    TEST_ASSERT_FALSE(cds_servos_may_drive(&servos, CDS_BROADCAST_ID));
}

/* The last block of the packet has `count` of its 5 bytes. */
static enum cds_result sync_cut(uint8_t reg, uint8_t length, uint8_t count)
{
    uint8_t sum = (uint8_t)(CDS_BROADCAST_ID + 4 + count + CDS_SYNC_WRITE + reg + length);
    uint8_t *bytes = buffers[0];

    bytes[0] = bytes[1] = 0xFF;
    bytes[2] = CDS_BROADCAST_ID;
    bytes[3] = (uint8_t)(4 + count);
    bytes[4] = CDS_SYNC_WRITE;
    bytes[5] = reg;
    bytes[6] = length;
    for (uint8_t i = 0; i < count; i++)
        sum = (uint8_t)(sum + (bytes[7 + i] = 1));
    bytes[7 + count] = (uint8_t)~sum;
    request.packet.size = (uint16_t)(8 + count);
    request.reply_parameters = CDS_REPLY_NONE;
    return cds_bus_submit(&bus, &request);
}

void test_inhibit_of_a_cut_block_refuses_the_packet(void)
{
    inhibit();
    for (uint8_t count = 1; count < 12; count++)
        assert_refused(sync_cut(CDS_REG_GOAL_POSITION, 4, count));
    assert_refused(sync_cut(CDS_REG_LED, 1, 3));
    assert_sent(sync_cut(CDS_REG_LED, 1, 4));
    cds_servos_release_all(&servos);
    assert_sent(sync_cut(CDS_REG_GOAL_POSITION, 4, 4)); // the servos refuse it (R34)
}

/* They decide how far from its goal a servo stands still whose torque is on. */
void test_inhibit_of_margin_proportion_and_punch_refuses(void)
{
    static const uint8_t margin = 0;

    inhibit();
    for (uint8_t reg = CDS_REG_CW_COMPLIANCE_MARGIN; reg <= CDS_REG_CCW_PROPORTION; reg++) {
        assert_refused(write_byte(77, reg, 0));
        assert_refused(sync_one(77, reg, &margin, 1));
    }
    assert_refused(write_word(77, CDS_REG_PUNCH, 500));
    assert_refused(write_byte(77, CDS_REG_PUNCH + 1, 1));
}

/* A damaged bit may make a packet of its own of what stands there. */
void test_inhibit_of_ping_or_read_with_more_parameters_refuses(void)
{
    inhibit();
    for (uint8_t instruction = CDS_PING; instruction <= CDS_READ; instruction++) {
        uint8_t length = instruction == CDS_PING ? 3 : 5;
        const uint8_t bytes[] = {0xFF, 0xFF, 1, length, instruction, 0, 0, 0, 0};

        memcpy(buffers[0], bytes, sizeof bytes);
        request.packet.size = (uint16_t)(length + 4);
        request.reply_parameters = 0;
        assert_refused(cds_bus_submit(&bus, &request));
    }
}

void test_inhibit_of_what_cannot_drive_passes(void)
{
    inhibit();
    for (uint8_t i = 0; i < sizeof ids; i++) {
        assert_sent(write_byte(ids[i], CDS_REG_LED, 1));
        assert_sent(write_byte(ids[i], CDS_REG_REGISTERED_INSTRUCTION, 0));
        assert_sent(write_byte(ids[i], CDS_REG_RETURN_DELAY, 10));
        assert_sent(cds_servo_ping(&bus, &request, ids[i]));
    }
    assert_sent(cds_servo_read(&bus, &request, 77, CDS_REG_PRESENT_POSITION, 2));
}

void test_inhibit_without_a_known_servo_refuses_goals(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin(0));
    assert_sent(write_word(1, CDS_REG_GOAL_POSITION, 500));
    inhibit();
    assert_refused(write_word(1, CDS_REG_GOAL_POSITION, 500));
    cds_servos_release_all(&servos);
    assert_sent(write_word(1, CDS_REG_GOAL_POSITION, 500));
}

void test_inhibit_with_one_servo_released_stays(void)
{
    inhibit();
    cds_servos_release(&servos, &states[0]);
    assert_refused(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STATE_LOST);
    cds_servos_allow(&servos);
    assert_sent(write_byte(1, CDS_REG_TORQUE_ENABLE, 1));
    assert_refused(write_byte(2, CDS_REG_TORQUE_ENABLE, 1)); // it lost its state
    cds_servos_release_all(&servos);
    assert_sent(write_byte(2, CDS_REG_TORQUE_ENABLE, 1));
}

void test_inhibit_of_a_request_that_waits_refuses_it(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &other, 77, CDS_REG_TORQUE_ENABLE, 1));
    inhibit();
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    for (uint8_t i = 0; i < 5; i++)
        cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, other.result);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

void test_delay_below_what_the_board_bears_is_refused(void)
{
    static const uint8_t from_id[3] = {9, 1, 0}, none = 0, enough = 1;

    TEST_ASSERT_EQUAL(CDS_OK, begin_with_delay(2, 1));
    for (uint8_t i = 0; i < sizeof ids; i++) {
        TEST_ASSERT_EQUAL(CDS_TOO_EARLY, write_byte(ids[i], CDS_REG_RETURN_DELAY, 0));
        TEST_ASSERT_EQUAL(CDS_TOO_EARLY,
                          cds_servo_write(&bus, &request, ids[i], CDS_REG_ID, from_id, 3));
        TEST_ASSERT_EQUAL(CDS_TOO_EARLY, cds_servo_reg_write(&bus, &request, ids[i],
                                                             CDS_REG_RETURN_DELAY, &none, 1));
        assert_sent(write_byte(ids[i], CDS_REG_RETURN_DELAY, 1));
    }
    TEST_ASSERT_EQUAL(CDS_TOO_EARLY,
                      rig_result_of_check(&request, sync_one(77, CDS_REG_RETURN_DELAY, &none, 1)));
    assert_sent(sync_one(77, CDS_REG_RETURN_DELAY, &enough, 1));
    TEST_ASSERT_EQUAL(CDS_OK, begin(2));
    assert_sent(write_byte(77, CDS_REG_RETURN_DELAY, 0));
}
