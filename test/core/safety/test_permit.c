/* SPDX-License-Identifier: MIT */
/* The table of docs/internals/permit.md, row by row: the number of the row begins the name of its
 * test. */
#include <string.h>

#include "bus/bus_internal.h" // cds_bus_submit_prechecked()
#include "cds55xx/servo.h"
#include "cds55xx/servos.h"
#include "cds55xx/sync_write.h"
#include "bus_rig.h"
#include "unity.h"

#define COUNT 50

static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state states[COUNT + 1];
static struct cds_servo_state *const one = &states[0], *const two = &states[1];
static uint8_t buffers[2][CDS_SYNC_WRITE_SIZE(COUNT, 4)], replies[2][CDS_REPLY_MAX];
static struct cds_request request, other;

/* Servos 1 to `count`, and room for one more. */
static void begin(uint8_t count)
{
    for (uint8_t i = 0; i < count; i++)
        states[i].id = (uint8_t)(i + 1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_begin(&servos, &(struct cds_servos_config){
                                                            .bus = &bus,
                                                            .queue = &queue,
                                                            .states = states,
                                                            .count = count,
                                                            .capacity = (uint8_t)(count + 1)}));
}

void setUp(void)
{
    rig_open(0);
    memset(&servos, 0, sizeof servos);
    request = (struct cds_request)CDS_REQUEST(buffers[0], replies[0]);
    other = (struct cds_request)CDS_REQUEST(buffers[1], replies[1]);
    begin(2);
}

void tearDown(void)
{
    rig_check();
}

/* ---- what passes and what is refused ---- */

static void look(void)
{
    for (uint8_t i = 0; i < 14; i++)
        cds_bus_poll(&bus);
}

/* The packet of `request` leaves; `answers`: its servo answers with `data`, else no reply comes. */
static void pass_with(enum cds_result submitted, bool answers, const uint8_t *data, uint8_t length)
{
    TEST_ASSERT_EQUAL(CDS_OK, rig_result_of_check(&request, submitted));
    rig_transmit();
    if (answers && request.reply_parameters != CDS_REPLY_NONE && !request.is_muted)
        port_fake_answer(&bus.link, port_fake.sent[CDS_AT_ID], 0, data, length);
    else
        port_fake.now_us += 5000;
    look();
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, request.result);
}

static void pass(enum cds_result submitted)
{
    pass_with(submitted, true, NULL, 0);
}

static void silence(enum cds_result submitted)
{
    pass_with(submitted, false, NULL, 0);
}

static void refuse(enum cds_result why, enum cds_result submitted)
{
    uint16_t packets = port_fake.packets;

    TEST_ASSERT_EQUAL(why, rig_result_of_check(&request, submitted));
    TEST_ASSERT_NULL(bus.request);
    TEST_ASSERT_EQUAL_UINT16(packets, port_fake.packets);
}

static enum cds_result byte(uint8_t id, uint8_t reg, uint8_t value)
{
    return cds_servo_write_byte(&bus, &request, id, reg, value);
}

static enum cds_result word(uint8_t id, uint8_t reg, uint16_t value)
{
    return cds_servo_write_word(&bus, &request, id, reg, value);
}

static enum cds_result goal(uint8_t id, uint16_t position, uint16_t speed)
{
    const uint8_t data[4] = {(uint8_t)position, (uint8_t)(position >> 8), (uint8_t)speed,
                             (uint8_t)(speed >> 8)};

    return cds_servo_write(&bus, &request, id, CDS_REG_GOAL_POSITION, data, 4);
}

static enum cds_result registers(uint8_t id, uint8_t reg, const uint8_t *data, uint8_t length)
{
    return cds_servo_reg_write(&bus, &request, id, reg, data, length);
}

static enum cds_result torque(uint8_t id)
{
    return byte(id, CDS_REG_TORQUE_ENABLE, 1);
}

static enum cds_result action(uint8_t id)
{
    return cds_servo_action(&bus, &request, id);
}

static enum cds_result reset(uint8_t id)
{
    return cds_servo_reset(&bus, &request, id);
}

static enum cds_result angles(uint8_t id, uint16_t cw, uint16_t ccw)
{
    const uint8_t data[4] = {(uint8_t)cw, (uint8_t)(cw >> 8), (uint8_t)ccw, (uint8_t)(ccw >> 8)};

    return cds_servo_write(&bus, &request, id, CDS_REG_CW_ANGLE_LIMIT, data, 4);
}

/* A SYNC WRITE of one byte each to servos 1 and `id`. */
static enum cds_result sync(uint8_t reg, uint8_t first, uint8_t id, uint8_t second)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, reg, 1));
    cds_sync_write_add(&request, 1, &first);
    cds_sync_write_add(&request, id, &second);
    return cds_sync_write_send(&bus, &request);
}

static enum cds_result sync_goals(uint16_t first, uint8_t id, uint16_t second)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_sync_write_add_goal(&request, 1, first, 100);
    cds_sync_write_add_goal(&request, id, second, 100);
    return cds_sync_write_send(&bus, &request);
}

/* A packet of `count` zeros as parameters. */
static enum cds_result raw(uint8_t id, uint8_t instruction, uint8_t count)
{
    cds_packet_begin(&request.packet, id, instruction);
    while (count--)
        cds_packet_put(&request.packet, 0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    request.reply_parameters = CDS_REPLY_NONE;
    return cds_bus_submit(&bus, &request);
}

static void read_gives(uint8_t id, uint8_t reg, const uint8_t *data, uint8_t length)
{
    pass_with(cds_servo_read(&bus, &request, id, reg, length), true, data, length);
}

static void in_mode(uint8_t id, uint8_t ccw_high)
{
    const uint8_t data[4] = {0, 0, 0, ccw_high};

    read_gives(id, CDS_REG_CW_ANGLE_LIMIT, data, 4);
}

static void in_position_mode(uint8_t id)
{
    in_mode(id, 3);
}

static void in_endless_turn(uint8_t id)
{
    in_mode(id, 0);
}

static void holds(uint8_t id, uint16_t position, uint16_t speed)
{
    const uint8_t data[4] = {(uint8_t)position, (uint8_t)(position >> 8), (uint8_t)speed,
                             (uint8_t)(speed >> 8)};

    read_gives(id, CDS_REG_GOAL_POSITION, data, 4);
}

static void torque_is(uint8_t id, uint8_t value)
{
    read_gives(id, CDS_REG_TORQUE_ENABLE, &value, 1);
}

static void go_offline(uint8_t id)
{
    for (uint8_t i = 0; i < CDS_SERVOS_MISSES; i++)
        silence(cds_servo_ping(&bus, &request, id));
}

static void return_again(uint8_t id)
{
    go_offline(id);
    pass(cds_servo_ping(&bus, &request, id));
}

static void limit_goal(struct cds_servo_state *servo)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, servo, 200, 800, 1023));
}

static void limit_speed(struct cds_servo_state *servo)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, servo, 0, 1023, 300));
}

static const uint8_t all_ids[] = {1, 77, CDS_BROADCAST_ID}; // known, unknown, all

/* ---- any ID ---- */

void test_01_torque_off_always_passes(void)
{
    go_offline(2);
    limit_goal(one);
    cds_servos_inhibit_all(&servos);
    for (uint8_t i = 0; i < 3; i++)
        pass(byte(all_ids[i], CDS_REG_TORQUE_ENABLE, 0));
    pass(byte(2, CDS_REG_TORQUE_ENABLE, 0));
}

void test_02_ping_and_read_pass(void)
{
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    pass(cds_servo_ping(&bus, &request, 1));
    silence(cds_servo_read(&bus, &request, 1, 0x24, 2));
    cds_servos_inhibit_all(&servos);
    pass(cds_servo_ping(&bus, &request, 1));
    silence(cds_servo_read(&bus, &request, 77, 0x24, 2));
}

void test_03_inhibited_refuses_every_write_that_may_move(void)
{
    static const uint8_t regs[] = {6,    7,    8,    9,    0x18, 0x1A, 0x1B, 0x1C,
                                   0x1D, 0x1E, 0x1F, 0x20, 0x21, 0x30, 0x31};
    static const uint8_t value = 1;

    cds_servos_inhibit_all(&servos);
    for (uint8_t reg = 0; reg < CDS_TABLE_SIZE; reg++) {
        enum cds_result due = memchr(regs, reg, sizeof regs) ? CDS_INHIBITED : CDS_OK;

        for (uint8_t i = 0; i < 3; i++) {
            if (reg == CDS_REG_ID)
                continue;
            if (due == CDS_INHIBITED) {
                refuse(due, byte(all_ids[i], reg, 1));
                refuse(due, registers(all_ids[i], reg, &value, 1));
                if (i < 2)
                    refuse(due, sync(reg, 0, all_ids[i], 1));
            } else {
                pass(byte(all_ids[i], reg, 1));
            }
        }
    }
    pass(sync(CDS_REG_TORQUE_ENABLE, 0, 77, 0));
}

void test_04_inhibited_refuses_action_reset_and_unknown_ones(void)
{
    static const uint8_t instructions[] = {0, CDS_ACTION, CDS_RESET, 7, 0x82, 0x84, 0xFF};

    for (uint8_t i = 0; i < 3; i++)
        for (uint8_t j = 0; j < sizeof instructions; j++) {
            cds_servos_inhibit_all(&servos);
            refuse(CDS_INHIBITED, raw(all_ids[i], instructions[j], 0));
            cds_servos_release_all(&servos);
            if (instructions[j] != CDS_RESET)
                pass(raw(all_ids[i], instructions[j], 0));
        }
}

void test_05_inhibited_refuses_packets_of_odd_lengths(void)
{
    static const uint8_t odd[][2] = {{CDS_PING, 1},      {CDS_READ, 3},      {CDS_WRITE, 0},
                                     {CDS_WRITE, 1},     {CDS_REG_WRITE, 1}, {CDS_SYNC_WRITE, 0},
                                     {CDS_SYNC_WRITE, 1}};

    for (uint8_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        cds_servos_inhibit_all(&servos);
        refuse(CDS_INHIBITED, raw(1, odd[i][0], odd[i][1]));
        cds_servos_release_all(&servos);
        pass(raw(1, odd[i][0], odd[i][1]));
    }
    cds_servos_inhibit_all(&servos);
    pass(raw(CDS_BROADCAST_ID, CDS_SYNC_WRITE, 2));
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_LED, 1));
    cds_packet_put(&request.packet, 1); // an ID without its byte
    refuse(CDS_INHIBITED, cds_sync_write_send(&bus, &request));
}

void test_06_level_0_refuses_read(void)
{
    one->status_return_level = 0;
    refuse(CDS_NO_REPLY_DUE, cds_servo_read(&bus, &request, 1, 0x24, 2));
    pass(cds_servo_ping(&bus, &request, 1));
    one->status_return_level = CDS_LEVEL_UNKNOWN;
    silence(cds_servo_read(&bus, &request, 1, 0x24, 2));
}

static enum cds_result begin_with_delay(uint8_t shortest_delay)
{
    return cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                                 .queue = &queue,
                                                                 .states = states,
                                                                 .count = 2,
                                                                 .capacity = 3,
                                                                 .shortest_delay = shortest_delay});
}

void test_07_a_delay_too_short_is_refused(void)
{
    static const uint8_t zero = 0;

    TEST_ASSERT_EQUAL(CDS_OK, begin_with_delay(2));
    for (uint8_t i = 0; i < 3; i++) {
        refuse(CDS_TOO_EARLY, byte(all_ids[i], CDS_REG_RETURN_DELAY, 1));
        pass(byte(all_ids[i], CDS_REG_RETURN_DELAY, 2));
    }
    refuse(CDS_TOO_EARLY, registers(77, CDS_REG_RETURN_DELAY, &zero, 1));
    refuse(CDS_TOO_EARLY, sync(CDS_REG_RETURN_DELAY, 2, 77, 1));
    TEST_ASSERT_EQUAL_UINT16(5, servos.too_early);
}

void test_07_the_shortest_delay_stays_while_a_packet_waits(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 2));
    TEST_ASSERT_EQUAL(CDS_OK, byte(1, CDS_REG_RETURN_DELAY, 1));
    TEST_ASSERT_EQUAL(CDS_BUSY, begin_with_delay(2));
    TEST_ASSERT_EQUAL_UINT8(0, servos.shortest_delay);
    TEST_ASSERT_EQUAL_UINT8(2, servos.count);
}

/* A READ of servo 2 is in flight; the other request waits. Then the READ ends. */
static void end_of_read_in_flight(void)
{
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 2, 0, (const uint8_t[]){0}, 1);
    look();
}

void test_08_a_release_revives_nothing_that_waited(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 2, 0x24, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_word(&bus, &other, 77, 0x1E, 500));
    cds_servos_inhibit_all(&servos);
    cds_servos_release_all(&servos);
    end_of_read_in_flight();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, other.result);
    pass(word(77, 0x1E, 500));
}

void test_08_nor_a_long_packet_amid_its_check(void)
{
    begin(COUNT);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    for (uint8_t id = 1; id <= COUNT; id++)
        cds_sync_write_add_goal(&request, id, 500, 100);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    cds_servos_inhibit_all(&servos);
    cds_servos_release_all(&servos);
    look();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, request.result);
}

void test_08_a_read_of_odd_length_that_waited_passes(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 2));
    TEST_ASSERT_EQUAL(CDS_OK, raw(1, CDS_READ, 3));
    cds_servos_inhibit_all(&servos);
    cds_servos_release_all(&servos);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 2, 0, NULL, 0);
    look();
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
}

void test_09_an_unknown_servo_passes(void)
{
    limit_goal(one);
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    pass(goal(77, 1000, 0));
    pass(torque(77));
    pass(angles(77, 0, 0));
    pass(action(77));
    pass(registers(77, CDS_REG_ID, (const uint8_t[]){5}, 1));
    pass(byte(77, CDS_REG_ID, 78));
    pass(sync(CDS_REG_LED, 0, 77, 1));
    cds_servos_inhibit_all(&servos);
    pass(byte(77, CDS_REG_LED, 1));
}

/* ---- a known servo ---- */

static void refuse_all_that_drives(uint8_t id)
{
    for (uint8_t reg = 6; reg <= 9; reg++)
        refuse(CDS_INHIBITED, byte(id, reg, 1));
    for (uint8_t reg = 0x1E; reg <= 0x21; reg++)
        refuse(CDS_INHIBITED, byte(id, reg, 1));
    refuse(CDS_INHIBITED, torque(id));
    refuse(CDS_INHIBITED, registers(id, CDS_REG_TORQUE_ENABLE, (const uint8_t[]){1}, 1));
}

void test_10_an_inhibited_servo_is_not_driven(void)
{
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STATE_LOST);
    refuse_all_that_drives(2);
    refuse(CDS_INHIBITED, sync_goals(500, 2, 500));
    TEST_ASSERT_EQUAL_UINT8(2, servos.refused_id);
    refuse(CDS_INHIBITED, sync(CDS_REG_TORQUE_ENABLE, 0, 2, 1));
    pass(sync(CDS_REG_TORQUE_ENABLE, 1, 2, 0));
    refuse(CDS_INHIBITED, torque(CDS_BROADCAST_ID));
    cds_servos_release(&servos, two);
    return_again(2);
    refuse_all_that_drives(2);
    refuse(CDS_INHIBITED, torque(CDS_BROADCAST_ID));
    torque_is(2, 0);
    pass(torque(CDS_BROADCAST_ID));
}

void test_11_an_offline_servo_is_not_driven_alone(void)
{
    go_offline(2);
    refuse_all_that_drives(2);
}

void test_12_an_offline_servo_stops_no_other(void)
{
    go_offline(2);
    pass(sync_goals(500, 2, 500));
    pass(torque(CDS_BROADCAST_ID));
    limit_goal(two);
    refuse(CDS_LIMIT, sync_goals(500, 2, 900));
}

void test_13_what_does_not_drive_passes_to_an_inhibited_servo(void)
{
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    pass(byte(1, CDS_REG_LED, 1));
    pass(byte(1, CDS_REG_CW_COMPLIANCE_MARGIN, 1));
    pass(byte(1, CDS_REG_REGISTERED_INSTRUCTION, 0));
    pass(byte(1, CDS_REG_ID, 9));
    pass(reset(9));
}

/* ---- a reserved servo ---- */

/* Servo 9 is not known. */
void test_14_only_one_request_sets_goals_of_reserved_servos(void)
{
    static const uint8_t ids[] = {2, 9}, value = 1;
    static struct cds_request goals;

    cds_servos_reserve(&servos, &goals, ids, 2);
    for (uint8_t i = 0; i < 2; i++) {
        for (uint8_t reg = 0; reg < CDS_TABLE_SIZE; reg++) {
            if ((reg >= 3 && reg <= 9) || reg == 0x10 || (reg >= 0x1E && reg <= 0x21)) {
                refuse(CDS_RESERVED, byte(ids[i], reg, 1));
                refuse(CDS_RESERVED, byte(CDS_BROADCAST_ID, reg, 1));
            }
        }
        refuse(CDS_RESERVED, goal(ids[i], 500, 100));
        refuse(CDS_RESERVED, registers(ids[i], 0x1E, &value, 1));
        refuse(CDS_RESERVED, sync_goals(500, ids[i], 500));
        pass(torque(ids[i]));
        pass(byte(ids[i], CDS_REG_TORQUE_ENABLE, 0));
        pass(byte(ids[i], CDS_REG_LED, 1));
        pass(sync(CDS_REG_TORQUE_ENABLE, 0, ids[i], 1));
        refuse(CDS_RESERVED, sync(CDS_REG_ID, 7, ids[i], 8));
        refuse(CDS_RESERVED, sync(CDS_REG_BAUD_RATE, 34, ids[i], 34));
    }
    pass(goal(1, 500, 100));
    pass(byte(1, CDS_REG_BAUD_RATE, 34));
    refuse(CDS_RESERVED, sync_goals(500, 3, 500)); // to whatever servos
    cds_servos_reserve(&servos, &request, ids, 2); // the request of these functions
    pass(goal(2, 500, 100));
    pass(sync_goals(500, 2, 500));
    cds_servos_reserve(&servos, &goals, ids, 0);
    pass(goal(2, 500, 100));
}

void test_15_no_action_and_no_reset_reaches_a_reserved_servo(void)
{
    static const uint8_t ids[] = {2};
    static struct cds_request goals;

    cds_servos_reserve(&servos, &goals, ids, 1);
    refuse(CDS_RESERVED, action(2));
    refuse(CDS_RESERVED, action(CDS_BROADCAST_ID));
    refuse(CDS_RESERVED, reset(2));
    refuse(CDS_RESERVED, reset(CDS_BROADCAST_ID));
    pass(action(1));
}

/* ---- registered writes ---- */

void test_20_reg_write_of_settings_is_refused(void)
{
    static const uint8_t value = 1;

    for (uint8_t reg = 0; reg < CDS_TABLE_SIZE; reg++) {
        if ((reg >= 3 && reg <= 9) || reg == 0x10) {
            refuse(CDS_LIMIT, registers(1, reg, &value, 1));
            refuse(CDS_LIMIT, registers(CDS_BROADCAST_ID, reg, &value, 1));
        } else {
            pass(registers(1, reg, &value, 1));
        }
    }
}

void test_21_reg_write_to_a_servo_with_limits_is_refused(void)
{
    static const uint8_t value = 1, inside[] = {0xF4, 1, 100, 0};

    limit_goal(two);
    in_position_mode(2);
    for (uint8_t reg = 0; reg < CDS_TABLE_SIZE; reg++)
        refuse(CDS_LIMIT, registers(2, reg, &value, 1));
    refuse(CDS_LIMIT, registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    refuse(CDS_LIMIT, registers(CDS_BROADCAST_ID, CDS_REG_LED, &value, 1));
    pass(registers(1, CDS_REG_LED, &value, 1));
}

static const uint8_t inside[] = {0xF4, 1, 100, 0}, beyond[] = {0xE8, 3, 100, 0};

/* The registered move of `request` begins; servo 2 has limits of its goal. */
static void begin_move(void)
{
    limit_goal(two);
    in_position_mode(2);
    bus.hooks->set_move(bus.hooks->context, &request);
}

void test_22_reg_write_of_the_move_keeps_the_limits(void)
{
    begin_move();
    refuse(CDS_LIMIT, registers(2, CDS_REG_GOAL_POSITION, beyond, 4));
    refuse(CDS_LIMIT, registers(2, CDS_REG_GOAL_POSITION, inside, 2));
    refuse(CDS_LIMIT, registers(2, CDS_REG_LED, inside, 4));
    refuse(CDS_LIMIT, cds_servo_reg_write(&bus, &other, 2, 0x1E, inside, 4)); // not of the move
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    in_endless_turn(2);
    refuse(CDS_LIMIT, registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    in_position_mode(2);
    bus.hooks->set_move(bus.hooks->context, NULL);
    refuse(CDS_LIMIT, registers(2, CDS_REG_GOAL_POSITION, inside, 4));
}

void test_23_action_reaches_no_inhibited_servo(void)
{
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    refuse(CDS_INHIBITED, action(2));
    refuse(CDS_INHIBITED, action(CDS_BROADCAST_ID));
    pass(action(1));
    cds_servos_release(&servos, two);
    bus.hooks->set_move(bus.hooks->context, &request);
    return_again(2);
    refuse(CDS_INHIBITED, action(CDS_BROADCAST_ID));
}

void test_24_action_reaches_no_servo_with_limits(void)
{
    limit_speed(two);
    refuse(CDS_LIMIT, action(2));
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
    pass(action(1));
    go_offline(2);
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
}

void test_25_action_of_a_move_that_was_answered_passes(void)
{
    begin_move();
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID)); // servo 2 is not part of it yet
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    pass(action(CDS_BROADCAST_ID));
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID)); // once
}

void test_25_action_of_the_move_needs_every_answer(void)
{
    begin_move();
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    silence(registers(1, CDS_REG_GOAL_POSITION, inside, 4));
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
    begin_move();
    silence(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
}

void test_25_what_changes_behind_the_move_ends_its_permit(void)
{
    begin_move();
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    return_again(2);
    torque_is(2, 0);
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID)); // its power may have been gone
    begin_move();
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    pass(byte(2, CDS_REG_REGISTERED_INSTRUCTION, 0));
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
    begin_move();
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    in_endless_turn(2);
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
}

void test_26_a_limit_or_inhibit_aborts_the_move(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        begin_move();
        pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
        if (i == 0)
            limit_goal(two); // the same limits
        else if (i == 1)
            cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
        else
            cds_servos_inhibit_all(&servos);
        if (i == 3)
            refuse(CDS_INHIBITED, action(CDS_BROADCAST_ID));
        cds_servos_release_all(&servos);
        refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
        refuse(CDS_LIMIT, registers(2, CDS_REG_GOAL_POSITION, inside, 4));
        refuse(CDS_LIMIT, registers(1, CDS_REG_GOAL_POSITION, inside, 4));
        pass(byte(2, CDS_REG_REGISTERED_INSTRUCTION, 0));
    }
}

/* The speed that the servo registered may have been 0. */
void test_39_after_the_action_of_a_move_the_speed_may_be_0(void)
{
    begin_move();
    pass(registers(1, CDS_REG_GOAL_POSITION, inside, 4));
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    two->held &= (uint8_t)~CDS_HELD_SPEED_0;
    pass(action(CDS_BROADCAST_ID));
    TEST_ASSERT_BITS_HIGH(CDS_HELD_SPEED_0, two->held);
}

void test_25_a_second_move_needs_its_own_answers(void)
{
    begin_move();
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    TEST_ASSERT_TRUE(two->is_registered);
    bus.hooks->set_move(bus.hooks->context, &request);
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_reg_write(&bus, &other, 1, 0x1E, inside, 4));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 1, 0, NULL, 0);
    look();
    TEST_ASSERT_EQUAL(CDS_OK, other.result);
    TEST_ASSERT_FALSE(one->is_registered); // by another request than the move's
}

void test_26_torque_found_off_aborts_the_move(void)
{
    uint16_t epoch;

    pass(torque(1));
    begin_move();
    pass(registers(2, CDS_REG_GOAL_POSITION, inside, 4));
    epoch = servos.epoch;
    torque_is(1, 0);
    TEST_ASSERT_NOT_EQUAL(epoch, servos.epoch); // goals that wait are checked again
    cds_servos_release_all(&servos);
    refuse(CDS_LIMIT, action(CDS_BROADCAST_ID));
    refuse(CDS_LIMIT, registers(2, CDS_REG_GOAL_POSITION, inside, 4));
}

/* ---- a servo with limits ---- */

void test_30_goals_beyond_the_limits_are_refused(void)
{
    in_position_mode(1);
    limit_goal(one);
    refuse(CDS_LIMIT, word(1, 0x1E, 199));
    pass(word(1, 0x1E, 200));
    pass(word(1, 0x1E, 800));
    refuse(CDS_LIMIT, word(1, 0x1E, 801));
    refuse(CDS_LIMIT, byte(1, 0x1E, 0));
    refuse(CDS_LIMIT, byte(1, 0x1F, 1));
    refuse(CDS_LIMIT, word(CDS_BROADCAST_ID, 0x1E, 801));
    refuse(CDS_LIMIT, sync_goals(801, 2, 0));
    pass(sync_goals(800, 2, 1023));
}

void test_31_speed_with_a_limited_goal_needs_position_mode(void)
{
    limit_goal(one);
    refuse(CDS_LIMIT, word(1, 0x20, 1));
    refuse(CDS_LIMIT, byte(1, 0x20, 0));
    refuse(CDS_LIMIT, sync_goals(500, 2, 500));
    pass(word(1, 0x20, 0));
    in_endless_turn(1);
    refuse(CDS_LIMIT, word(1, 0x20, 1));
    in_position_mode(1);
    pass(word(1, 0x20, 1));
    pass(sync_goals(500, 2, 500));
}

void test_32_a_goal_needs_a_speed_in_the_same_packet(void)
{
    limit_speed(one);
    in_position_mode(1);
    holds(1, 500, 100);
    refuse(CDS_LIMIT, word(1, 0x1E, 500));
    pass(goal(1, 500, 300));
    in_endless_turn(1);
    refuse(CDS_LIMIT, word(1, 0x1E, 500));
}

void test_33_speeds_beyond_the_limit_are_refused(void)
{
    limit_speed(one);
    refuse(CDS_LIMIT, word(1, 0x20, 301));
    refuse(CDS_LIMIT, goal(1, 500, 301));
    refuse(CDS_LIMIT, byte(1, 0x20, 1));
    refuse(CDS_LIMIT, byte(1, 0x21, 0));
    pass(word(1, 0x20, 300));
    pass(goal(1, 500, 300));
    in_endless_turn(1);
    pass(word(1, 0x20, 0x400 + 300));
    refuse(CDS_LIMIT, word(1, 0x20, 0x400 + 301));
}

void test_34_speed_0_needs_endless_turn(void)
{
    limit_speed(one);
    refuse(CDS_LIMIT, word(1, 0x20, 0));
    refuse(CDS_LIMIT, goal(1, 500, 0));
    in_position_mode(1);
    refuse(CDS_LIMIT, word(1, 0x20, 0));
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_sync_write_add_goal(&request, 1, 500, 0);
    refuse(CDS_LIMIT, cds_sync_write_send(&bus, &request));
    in_endless_turn(1);
    pass(word(1, 0x20, 0));
    pass(goal(1, 500, 0));
}

/* What servo 1 needs to be switched on. */
static void read_all_but(uint8_t left_out)
{
    if (left_out != 0)
        in_position_mode(1);
    if (left_out != 1)
        read_gives(1, CDS_REG_GOAL_POSITION, inside, 2);
    if (left_out != 2)
        read_gives(1, CDS_REG_MOVING_SPEED, inside + 2, 2);
}

void test_35_torque_on_needs_mode_goal_and_speed_read(void)
{
    for (uint8_t left_out = 0; left_out <= 3; left_out++) {
        setUp();
        cds_servos_set_limits(&servos, one, 200, 800, 300);
        read_all_but(left_out);
        if (left_out < 3)
            refuse(CDS_LIMIT, torque(1));
        else
            pass(torque(1));
    }
}

void test_35_torque_found_off_makes_all_unknown(void)
{
    for (uint8_t left_out = 0; left_out <= 3; left_out++) {
        setUp();
        limit_speed(one);
        read_all_but(3);
        pass(torque(1));
        torque_is(1, 0);
        cds_servos_release(&servos, one);
        pass(goal(1, 500, 100)); // written is not read
        read_all_but(left_out);
        if (left_out < 3)
            refuse(CDS_LIMIT, torque(1));
        else
            pass(torque(1));
    }
}

void test_35_a_goal_or_speed_held_beyond_the_limit_stays_off(void)
{
    cds_servos_set_limits(&servos, one, 200, 800, 300);
    in_position_mode(1);
    holds(1, 801, 100);
    refuse(CDS_LIMIT, torque(1));
    holds(1, 500, 301);
    refuse(CDS_LIMIT, torque(1));
    holds(1, 500, 300);
    pass(torque(1));
    cds_servos_set_limits(&servos, one, 501, 800, 300);
    refuse(CDS_LIMIT, torque(1));
    refuse(CDS_LIMIT, torque(CDS_BROADCAST_ID));
    refuse(CDS_LIMIT, sync(CDS_REG_TORQUE_ENABLE, 1, 2, 0));
}

void test_36_torque_on_at_speed_0_needs_endless_turn(void)
{
    limit_speed(one);
    in_position_mode(1);
    holds(1, 500, 0);
    refuse(CDS_LIMIT, torque(1));
    in_endless_turn(1);
    pass(torque(1));
    holds(1, 500, 100);
    pass(word(1, 0x20, 0));
    in_position_mode(1);
    refuse(CDS_LIMIT, torque(1));
}

void test_37_a_limited_goal_keeps_position_mode(void)
{
    limit_goal(one);
    refuse(CDS_LIMIT, angles(1, 0, 0));
    in_position_mode(1);
    refuse(CDS_LIMIT, angles(1, 0, 0));
    refuse(CDS_LIMIT, byte(1, 0x09, 0));
    pass(angles(1, 10, 1000));
    in_endless_turn(1); // by another program
    holds(1, 500, 0);
    refuse(CDS_LIMIT, torque(1));
}

void test_38_position_mode_begins_with_a_known_goal(void)
{
    limit_goal(one);
    in_endless_turn(1);
    refuse(CDS_LIMIT, angles(1, 0, 1023));
    holds(1, 900, 0);
    refuse(CDS_LIMIT, angles(1, 0, 1023));
    holds(1, 500, 0);
    pass(angles(1, 0, 1023));
}

void test_39_a_mode_begins_with_a_known_speed(void)
{
    limit_speed(one);
    in_position_mode(1);
    refuse(CDS_LIMIT, angles(1, 0, 0));
    holds(1, 500, 300);
    pass(angles(1, 0, 0));
    pass(word(1, 0x20, 0));
    refuse(CDS_LIMIT, angles(1, 0, 1023));
    pass(word(1, 0x20, 100));
    pass(angles(1, 0, 1023));
}

/* ---- changes of an ID ---- */

void test_40_an_id_that_is_known_is_refused(void)
{
    refuse(CDS_LIMIT, byte(1, CDS_REG_ID, 2));
    refuse(CDS_LIMIT, byte(77, CDS_REG_ID, 2));
    refuse(CDS_LIMIT, reset(2));
    refuse(CDS_LIMIT, reset(77));
    pass(byte(1, CDS_REG_ID, 1));
    pass(reset(1));
}

void test_41_a_change_of_id_needs_a_free_entry(void)
{
    silence(byte(1, CDS_REG_ID, 9));
    refuse(CDS_LIMIT, byte(1, CDS_REG_ID, 10)); // a third ID
    refuse(CDS_LIMIT, byte(9, CDS_REG_ID, 10));
    refuse(CDS_LIMIT, byte(2, CDS_REG_ID, 10)); // no entry is free
    silence(byte(1, CDS_REG_ID, 9));            // the same once more
    TEST_ASSERT_EQUAL_UINT8(3, servos.count);
}

void test_42_ids_do_not_change_by_broadcast(void)
{
    refuse(CDS_LIMIT, byte(CDS_BROADCAST_ID, CDS_REG_ID, 9));
    refuse(CDS_LIMIT, sync(CDS_REG_ID, 9, 77, 10));
    refuse(CDS_LIMIT, reset(CDS_BROADCAST_ID));
    cds_servos_forget(&servos);
    pass(byte(CDS_BROADCAST_ID, CDS_REG_ID, 9));
    pass(sync(CDS_REG_ID, 9, 77, 10));
    pass(reset(CDS_BROADCAST_ID));
}

void test_43_a_reset_of_all_on_purpose_passes(void)
{
    cds_servos_allow_reset(&servos, true);
    pass(reset(CDS_BROADCAST_ID));
    refuse_all_that_drives(1);
    refuse_all_that_drives(2);
}

/* ---- when a packet is checked ---- */

/* Goals of all 50 servos, `last` to the last one. */
static enum cds_result fifty_goals(uint16_t last)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    for (uint8_t id = 1; id <= COUNT; id++)
        cds_sync_write_add_goal(&request, id, id == COUNT ? last : 500, 100);
    return cds_sync_write_send(&bus, &request);
}

/* Fifty servos, the last one with limits. */
static void begin_fifty(void)
{
    begin(COUNT);
    in_position_mode(COUNT);
    limit_goal(&states[COUNT - 1]);
}

/* An answer that was given before a speed of 0 was noted must not be used any more. */
void test_39_angles_wait_behind_goals_that_bring_a_speed_of_0(void)
{
    static const uint8_t turn[4] = {0}, position[4] = {0, 0, 0xFF, 3};
    static const uint8_t held[4] = {0, 2, 100, 0};
    static uint8_t bytes[CDS_PACKET_SIZE(8)], reply[1];
    static struct cds_request angles = CDS_REQUEST(bytes, reply);

    begin(2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 0, 1023, 300));
    pass_with(cds_servo_read(&bus, &request, 1, CDS_REG_CW_ANGLE_LIMIT, 4), true, turn, 4);
    pass_with(cds_servo_read(&bus, &request, 1, CDS_REG_GOAL_POSITION, 4), true, held, 4);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 2));
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_sync_write_add_goal(&request, 1, 512, 0);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servo_write(&bus, &angles, 1, CDS_REG_CW_ANGLE_LIMIT, position, 4));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 2, 0, NULL, 0);
    for (uint8_t i = 0; i < 100 && bus.request != &request; i++)
        cds_bus_poll(&bus);
    for (uint8_t i = 0; i < 100 && angles.result == CDS_PENDING; i++) {
        port_fake_transmit(&bus.link, 0);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL(CDS_LIMIT, angles.result);
}

/* Its servo may have carried it out: it is learnt as if its reply had been lost. */
void test_bus_reopened_packet_on_the_wire_is_learnt(void)
{
    begin(2);
    limit_goal(one);
    TEST_ASSERT_EQUAL(CDS_OK, byte(1, CDS_REG_ID, 9));
    rig_transmit();
    bus.link.echo_errors = 3;
    servos.echo_errors = 3;
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, request.result);
    TEST_ASSERT_NOT_NULL(cds_servos_find(&servos, 9));
    TEST_ASSERT_EQUAL_UINT16(0, servos.echo_errors);
    port_fake.now_us += 5000;
    look();
    refuse(CDS_LIMIT, goal(9, 1000, 100));
}

void test_calls_that_change_nothing_do_not_begin_a_check_anew(void)
{
    begin_fifty();
    cds_servos_inhibit(&servos, &states[0], CDS_INHIBIT_STOPPED);
    cds_servos_release(&servos, &states[0]);
    TEST_ASSERT_EQUAL(CDS_OK, fifty_goals(500));
    for (uint8_t i = 0; i < 30 && bus.state == CDS_BUS_WAITING_FOR_LINE; i++) {
        cds_servos_release(&servos, &states[0]);
        cds_servos_release_all(&servos);
        cds_servos_allow(&servos);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_BUS_SENDING, bus.state);
}

/* The inhibit was so long ago that the difference of the two epochs changes its sign. */
void test_an_old_inhibit_refuses_no_long_packet(void)
{
    begin_fifty();
    cds_servos_inhibit_all(&servos);
    cds_servos_release_all(&servos);
    for (uint16_t i = 0; i < 40000u; i++)
        cds_servos_allow_reset(&servos, false);
    pass(fifty_goals(500));
    for (uint16_t i = 0; i < 40000u; i++) // and back again
        cds_servos_allow_reset(&servos, false);
    pass(fifty_goals(500));
}

void test_an_inhibit_amid_the_first_check_refuses_the_packet(void)
{
    begin_fifty();
    servos.epoch = UINT16_MAX;
    cds_servos_allow_reset(&servos, false); // the epoch wraps
    TEST_ASSERT_EQUAL(CDS_OK, fifty_goals(500));
    cds_servos_inhibit_all(&servos);
    cds_servos_release_all(&servos);
    look();
    TEST_ASSERT_EQUAL(CDS_INHIBITED, request.result);
}

void test_a_long_packet_is_checked_some_blocks_a_call(void)
{
    uint8_t polls = 0;

    begin_fifty();
    TEST_ASSERT_EQUAL(CDS_OK, fifty_goals(500));
    while (bus.state == CDS_BUS_WAITING_FOR_LINE) {
        cds_bus_poll(&bus);
        polls++;
    }
    TEST_ASSERT_TRUE(polls >= 50 / 8 && polls <= 18);
    pass(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
}

/* A search through 50 servos is all that one call does. */
void test_each_search_of_a_check_has_a_call_of_its_own(void)
{
    uint8_t polls = 0;

    begin_fifty();
    cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t id = COUNT; id; id--)
        cds_sync_write_add_goal(&request, id, 500, 100);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    for (; polls < 200 && bus.state == CDS_BUS_WAITING_FOR_LINE; polls++)
        cds_bus_poll(&bus);
    TEST_ASSERT_TRUE(polls >= 2 * COUNT - 2 && polls <= 2 * COUNT + 1);
    pass(CDS_OK);
}

void test_a_block_behind_the_first_calls_refuses_the_packet(void)
{
    begin_fifty();
    refuse(CDS_LIMIT, fifty_goals(900));
    TEST_ASSERT_EQUAL_UINT8(COUNT, servos.refused_id);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets); // the READ, and no more
}

void test_a_change_amid_the_check_begins_it_again(void)
{
    begin_fifty();
    TEST_ASSERT_EQUAL(CDS_OK, fifty_goals(500));
    cds_bus_poll(&bus);
    limit_goal(one); // its block was found good before
    TEST_ASSERT_EQUAL(CDS_BUS_WAITING_FOR_LINE, bus.state);
    look();
    TEST_ASSERT_EQUAL(CDS_LIMIT, request.result); // its mode is not known
}

void test_a_check_that_was_cancelled_is_not_continued(void)
{
    begin_fifty();
    TEST_ASSERT_EQUAL(CDS_OK, fifty_goals(500));
    cds_bus_poll(&bus); // the first goals were found good
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    servos.epoch = servos.walk_epoch; // as if that had not counted
    refuse(CDS_INHIBITED, fifty_goals(500));
}

void test_a_caller_cannot_mark_a_packet_as_checked(void)
{
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    request.permit_epoch = servos.epoch;
    refuse(CDS_INHIBITED, torque(1));
    cds_packet_write(&request.packet, 1, CDS_REG_TORQUE_ENABLE, (const uint8_t[]){1}, 1);
    refuse(CDS_INHIBITED, cds_bus_submit_prechecked(&bus, &request, (uint16_t)(servos.epoch - 1)));
}

void test_torque_to_fifty_by_sync_write_is_learnt(void)
{
    static const uint8_t on = 1;

    begin(COUNT);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_TORQUE_ENABLE, 1));
    for (uint8_t id = 1; id <= COUNT; id++)
        cds_sync_write_add(&request, id, &on);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    for (uint8_t i = 0; i < 60 && bus.state < CDS_BUS_SENDING; i++)
        cds_bus_poll(&bus);
    cds_bus_poll(&bus);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    cds_bus_poll(&bus); // not all is learnt yet
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    TEST_ASSERT_TRUE(one->torque);
    TEST_ASSERT_FALSE(states[COUNT - 1].torque);
    look();
    look();
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_TRUE(states[COUNT - 1].torque);
}

/* Else torque on to all would never leave beside a cycle of 50 servos. */
void test_a_check_of_fifty_goes_on_behind_goals_of_a_cycle(void)
{
    static const uint8_t goal[] = {0, 2, 0, 1};
    uint8_t checked;

    begin(COUNT);
    TEST_ASSERT_EQUAL(CDS_OK, torque(CDS_BROADCAST_ID));
    for (uint8_t i = 0; i < 10; i++)
        cds_bus_poll(&bus);
    checked = servos.walked;
    TEST_ASSERT_GREATER_THAN_UINT8(10, checked);
    cds_packet_sync_begin(&other.packet, CDS_REG_GOAL_POSITION, 4);
    cds_packet_sync_add(&other.packet, 1, goal);
    cds_packet_end(&other.packet);
    other.reply_parameters = CDS_REPLY_NONE;
    other.priority = CDS_PRIORITY_HIGH;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit_prechecked(&bus, &other, servos.epoch));
    TEST_ASSERT_EQUAL_PTR(&other, bus.request);
    cds_bus_poll(&bus);
    cds_bus_poll(&bus);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, other.result);
    for (uint8_t i = 0; i < 4; i++)
        cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL_PTR(&request, bus.request);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT8(checked, servos.walked);
}

/* ---- beside the queue ---- */

void test_without_a_queue_a_second_request_is_busy(void)
{
    struct cds_bus alone = {0};
    struct cds_servos unqueued = {0};

    cds_bus_open(&alone, 1, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_OK,
                      cds_servos_begin(&unqueued, &(struct cds_servos_config){.bus = &alone}));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&alone, &request, 1));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&alone, &other, 1));
    TEST_ASSERT_TRUE(port_fake_transmit(&alone.link, 1));
    while (request.result == CDS_PENDING) {
        port_fake.now_us += 500;
        cds_bus_poll(&alone);
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&alone, &other, 1)); // waits: the line rests
    TEST_ASSERT_EQUAL(CDS_PENDING, other.result);
    cds_servos_inhibit_all(&unqueued);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&alone, &other));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, cds_servo_action(&alone, &other, 1));
}

void test_other_hooks_are_not_replaced(void)
{
    struct cds_servos others = {0};

    TEST_ASSERT_EQUAL(CDS_BUSY,
                      cds_servos_begin(&others, &(struct cds_servos_config){.bus = &bus}));
    TEST_ASSERT_EQUAL_PTR(&servos.hooks, bus.hooks);
}

void test_nothing_is_retried_while_torque_off_waits(void)
{
    cds_queue_set_retries(&queue, 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1));
    other.priority = CDS_PRIORITY_TORQUE_OFF;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_write_byte(&bus, &other, CDS_BROADCAST_ID, 0x18, 0));
    silence(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.retried);
    TEST_ASSERT_EQUAL(CDS_PENDING, other.result);
}

void test_a_request_that_is_refused_at_submit_does_not_wait(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 2));
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, torque(1));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, request.result);
    TEST_ASSERT_NULL(queue.first);
}

/* ---- a list that grows ---- */

static void grow(enum cds_servos_growth grows)
{
    begin(0);
    servos.capacity = 3;
    servos.grows = (uint8_t)grows;
}

void test_a_list_grows_by_alarms_and_settings(void)
{
    grow(CDS_GROWS_ON_ALARM_OR_SETTING);
    pass(cds_servo_ping(&bus, &request, 5));
    pass(torque(5));
    TEST_ASSERT_EQUAL_UINT8(0, servos.count);
    pass(byte(5, CDS_REG_STATUS_RETURN_LEVEL, 1));
    TEST_ASSERT_EQUAL_UINT8(1, cds_servos_find(&servos, 5)->status_return_level);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 6));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 6, CDS_ERROR_VOLTAGE, NULL, 0);
    look();
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_VOLTAGE, cds_servos_find(&servos, 6)->alarms);
    port_fake_answer(&bus.link, 7, CDS_ERROR_OVERLOAD, NULL, 0);
    look();
    TEST_ASSERT_NOT_NULL(cds_servos_find(&servos, 7));
    TEST_ASSERT_FALSE(servos.is_full);
    port_fake_answer(&bus.link, 8, CDS_ERROR_OVERLOAD, NULL, 0);
    look();
    TEST_ASSERT_TRUE(servos.is_full);
}

void test_a_list_grows_by_all_that_answers_or_is_written_to(void)
{
    grow(CDS_GROWS_ALWAYS);
    silence(cds_servo_ping(&bus, &request, 5));
    TEST_ASSERT_EQUAL_UINT8(0, servos.count);
    pass(cds_servo_ping(&bus, &request, 5));
    silence(torque(6));
    pass(sync(CDS_REG_LED, 1, 5, 1));
    TEST_ASSERT_NOT_NULL(cds_servos_find(&servos, 5));
    TEST_ASSERT_NOT_NULL(cds_servos_find(&servos, 6));
    TEST_ASSERT_NOT_NULL(cds_servos_find(&servos, 1));
    pass(torque(77)); // without an entry
    TEST_ASSERT_TRUE(servos.is_full);
    cds_servos_forget(&servos);
    TEST_ASSERT_EQUAL_UINT8(0, servos.count);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, CDS_BROADCAST_ID));
    rig_transmit();
    port_fake_answer(&bus.link, 9, 0, NULL, 0);
    look();
    TEST_ASSERT_NOT_NULL(cds_servos_find(&servos, 9));
}

void test_while_paused_replies_tell_nothing(void)
{
    one->return_delay = 10;
    one->status_return_level = 0;
    servos.is_paused = true;
    go_offline(2);
    TEST_ASSERT_EQUAL(CDS_PRESENCE_UNKNOWN, two->presence);
    TEST_ASSERT_EQUAL_UINT16(0, two->counters.timeouts);
    in_position_mode(1); // answered although the level is 0
    TEST_ASSERT_FALSE(one->held & (CDS_HELD_CCW_SET | CDS_HELD_CCW_0));
    TEST_ASSERT_EQUAL_UINT16(CDS_RETURN_DELAY_MAX_US, request.return_delay_us);
    port_fake_answer(&bus.link, 1, CDS_ERROR_OVERLOAD, NULL, 0);
    look();
    TEST_ASSERT_EQUAL_HEX8(0, servos.alarms);
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    refuse(CDS_INHIBITED, torque(1)); // driving stays inhibited
}

void test_event_count_counts_errors_and_presence_only(void)
{
    uint8_t event_count;

    pass(cds_servo_ping(&bus, &request, 1));
    event_count = servos.event_count;
    pass(cds_servo_ping(&bus, &request, 1));
    pass(byte(1, CDS_REG_LED, 1));
    TEST_ASSERT_EQUAL_UINT8(event_count, servos.event_count);
    go_offline(1);
    TEST_ASSERT_EQUAL_UINT8(event_count + 1, servos.event_count);
    port_fake_answer(&bus.link, 2, CDS_ERROR_OVERLOAD, NULL, 0);
    look();
    TEST_ASSERT_EQUAL_UINT8(event_count + 2, servos.event_count);
}

/* ---- blocks of a SYNC WRITE ---- */

/* A SYNC WRITE to servo 1 whose block has the ID `id`, which no servo can have. */
static enum cds_result sync_to_no_servo(uint8_t reg, uint8_t length, uint8_t id)
{
    static const uint8_t zeros[4];
    uint8_t *bytes = buffers[0];

    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, reg, length));
    cds_sync_write_add(&request, 1, zeros);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    bytes[CDS_AT_PARAMETERS + 2] = id;
    bytes[request.packet.size - 1] = cds_packet_checksum(bytes);
    request.reply_parameters = CDS_REPLY_NONE;
    return cds_bus_submit(&bus, &request);
}

void test_block_of_an_id_above_253_does_not_drive(void)
{
    for (uint8_t id = CDS_BROADCAST_ID; id; id++) {
        refuse(CDS_LIMIT, sync_to_no_servo(CDS_REG_GOAL_POSITION, 4, id));
        refuse(CDS_LIMIT, sync_to_no_servo(CDS_REG_GOAL_POSITION, 2, id));
        pass(sync_to_no_servo(CDS_REG_RETURN_DELAY, 1, id));
    }
    begin(0); // no servo is known
    pass(sync_to_no_servo(CDS_REG_GOAL_POSITION, 4, CDS_BROADCAST_ID));
    pass(sync_to_no_servo(CDS_REG_GOAL_POSITION, 2, CDS_BROADCAST_ID));
}

void test_goals_in_a_list_that_grows_are_checked_alike(void)
{
    servos.grows = CDS_GROWS_ALWAYS;
    in_position_mode(1);
    limit_goal(one);
    refuse(CDS_LIMIT, sync_goals(900, 2, 500));
    refuse(CDS_LIMIT, sync_to_no_servo(CDS_REG_GOAL_POSITION, 4, CDS_BROADCAST_ID));
    pass(sync_goals(500, 2, 500));
    TEST_ASSERT_EQUAL_UINT8(2, servos.count);
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    refuse(CDS_INHIBITED, sync_goals(500, 2, 500));
    TEST_ASSERT_EQUAL_UINT8(2, servos.refused_id);
    pass(sync_goals(500, 40, 500));
    TEST_ASSERT_NOT_NULL(cds_servos_find(&servos, 40));
}

void test_goal_to_an_inhibited_servo_by_sync_write_is_refused(void)
{
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    refuse(CDS_INHIBITED, sync_goals(500, 2, 500));
    TEST_ASSERT_EQUAL_UINT8(2, servos.refused_id);
    pass(sync_goals(500, 99, 500));
}

void test_offline_servo_does_not_stop_torque_by_sync_write(void)
{
    go_offline(1);
    refuse(CDS_INHIBITED, torque(1));
    pass(sync(CDS_REG_TORQUE_ENABLE, 1, 2, 1));
}

static enum cds_result permit_goal(uint8_t id, uint8_t *index, const uint8_t *data)
{
    return bus.hooks->permit_goal(bus.hooks->context, id, index, data);
}

void test_permit_goal_refuses_what_is_inhibited_or_beyond(void)
{
    uint8_t index = 7;

    in_position_mode(1);
    limit_goal(one);
    TEST_ASSERT_EQUAL(CDS_OK, permit_goal(1, &index, inside));
    TEST_ASSERT_EQUAL_UINT8(0, index);
    TEST_ASSERT_EQUAL(CDS_LIMIT, permit_goal(1, &index, beyond));
    TEST_ASSERT_EQUAL(CDS_OK, permit_goal(2, &index, beyond));
    TEST_ASSERT_EQUAL(CDS_OK, permit_goal(99, &index, beyond));
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, permit_goal(2, &index, inside));
    cds_servos_inhibit_all(&servos);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, permit_goal(99, &index, inside));
}

void test_check_cancelled_in_the_queue_begins_anew(void)
{
    begin_fifty();
    in_position_mode(1);
    limit_goal(one);
    pass(cds_servo_ping(&bus, &request, 2));
    TEST_ASSERT_EQUAL(CDS_OK, fifty_goals(500));
    cds_bus_poll(&bus);
    other.priority = CDS_PRIORITY_HIGH;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &other, 2, CDS_REG_PRESENT_POSITION, 2));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4));
    for (uint8_t id = 1; id <= COUNT; id++) // the first goal was found good, and is another now
        cds_sync_write_add_goal(&request, id, id == 1 ? 900 : 500, 100);
    TEST_ASSERT_EQUAL(CDS_OK, cds_sync_write_send(&bus, &request));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 2, 0, inside, 2);
    look();
    TEST_ASSERT_EQUAL(CDS_OK, other.result);
    TEST_ASSERT_EQUAL(CDS_LIMIT, request.result);
    TEST_ASSERT_EQUAL_UINT8(1, servos.refused_id);
}

/* A broadcast between the goals of a cycle would never be checked to its end else. */
void test_check_goes_on_behind_a_request_that_goes_first(void)
{
    begin_fifty();
    TEST_ASSERT_EQUAL(CDS_OK, fifty_goals(500));
    TEST_ASSERT_EQUAL_UINT8(2, servos.walked);
    other.priority = CDS_PRIORITY_HIGH;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &other, 2));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    port_fake_answer(&bus.link, 2, 0, NULL, 0);
    while (other.result == CDS_PENDING)
        cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL_UINT8(2, servos.walked); // the check goes on in the next poll
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL_UINT8(5, servos.walked);
}

void test_id_above_253_is_refused_to_a_known_servo(void)
{
    refuse(CDS_LIMIT, byte(1, CDS_REG_ID, CDS_BROADCAST_ID));
    refuse(CDS_LIMIT, byte(1, CDS_REG_ID, 255));
    pass(byte(99, CDS_REG_ID, CDS_BROADCAST_ID)); // an unknown one refuses it itself
    TEST_ASSERT_EQUAL_UINT8(1, one->id);
}

void test_request_that_ignores_servo_state_is_sent(void)
{
    one->return_delay = 10;
    one->status_return_level = 0;
    refuse(CDS_NO_REPLY_DUE, cds_servo_read(&bus, &request, 1, CDS_REG_LED, 1));
    request.ignores_servo_state = true;
    read_gives(1, CDS_REG_LED, (const uint8_t[]){1}, 1);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL_UINT16(CDS_RETURN_DELAY_MAX_US, request.return_delay_us);
}

/* ---- limits, register by register ---- */

void test_half_an_angle_limit_of_0_keeps_endless_turn(void)
{
    limit_speed(one);
    in_endless_turn(1);
    holds(1, 0, 100);
    pass(byte(1, CDS_REG_CW_ANGLE_LIMIT, 0));
    TEST_ASSERT_BITS(CDS_HELD_CW_0 | CDS_HELD_CW_SET, CDS_HELD_CW_0, one->held);
    pass(word(1, CDS_REG_MOVING_SPEED, 0)); // stands still: only in endless turn
    in_mode(2, 0);
    two->held &= (uint8_t) ~(CDS_HELD_CW_0 | CDS_HELD_CW_SET);
    pass(byte(2, CDS_REG_CW_ANGLE_LIMIT, 0));
    TEST_ASSERT_BITS(CDS_HELD_CW_0 | CDS_HELD_CW_SET, 0, two->held);
}

void test_angle_limits_that_keep_the_mode_need_no_speed(void)
{
    limit_speed(one);
    in_position_mode(1);
    TEST_ASSERT_BITS_LOW(CDS_HELD_SPEED, one->held);
    pass(angles(1, 100, 800));
    refuse(CDS_LIMIT, angles(1, 0, 0)); // another mode
}

void test_speed_0_stops_endless_turn_of_a_limited_goal(void)
{
    in_endless_turn(1);
    limit_goal(one);
    refuse(CDS_LIMIT, word(1, CDS_REG_MOVING_SPEED, 1));
    pass(word(1, CDS_REG_MOVING_SPEED, 0));
}

void test_half_a_goal_or_speed_read_is_not_known(void)
{
    static const uint8_t half[1] = {100};

    holds(1, 500, 100);
    TEST_ASSERT_BITS(CDS_HELD_GOAL | CDS_HELD_SPEED | CDS_HELD_SPEED_0,
                     CDS_HELD_GOAL | CDS_HELD_SPEED, one->held);
    read_gives(1, CDS_REG_GOAL_POSITION, half, 1);
    TEST_ASSERT_BITS_LOW(CDS_HELD_GOAL, one->held);
    TEST_ASSERT_BITS_HIGH(CDS_HELD_SPEED, one->held);
    read_gives(1, CDS_REG_MOVING_SPEED, half, 1);
    TEST_ASSERT_BITS_LOW(CDS_HELD_SPEED, one->held);
    TEST_ASSERT_BITS_HIGH(CDS_HELD_SPEED_0, one->held);
}

/* ---- every register, every length ---- */

void test_registers_that_drive_are_these_and_no_other(void)
{
    for (uint8_t reg = 0; reg < CDS_TABLE_SIZE; reg++) {
        bool drives = (reg >= CDS_REG_CW_ANGLE_LIMIT && reg <= CDS_REG_CCW_ANGLE_LIMIT + 1) ||
                      reg == CDS_REG_TORQUE_ENABLE ||
                      (reg >= CDS_REG_GOAL_POSITION && reg <= CDS_REG_MOVING_SPEED + 1);

        setUp();
        cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
        TEST_ASSERT_EQUAL(drives ? CDS_INHIBITED : CDS_OK, byte(1, reg, 1));
    }
}

void test_write_beyond_the_table_is_taken_for_one_that_drives(void)
{
    cds_packet_begin(&request.packet, 1, CDS_WRITE);
    cds_packet_put(&request.packet, CDS_REG_PUNCH);
    for (uint8_t i = 0; i < 220; i++) // as long as to reach register 0x0C behind 0xFF
        cds_packet_put(&request.packet, 1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&request.packet));
    cds_servos_inhibit(&servos, one, CDS_INHIBIT_STOPPED);
    refuse(CDS_INHIBITED, cds_bus_submit(&bus, &request));
    cds_servos_release(&servos, one);
    pass(cds_bus_submit(&bus, &request));
}

void test_refused_packet_built_anew_is_checked_from_its_start(void)
{
    limit_goal(one); // neither mode nor goal is known: torque stays off
    cds_servos_inhibit(&servos, two, CDS_INHIBIT_STOPPED);
    refuse(CDS_INHIBITED, sync(CDS_REG_TORQUE_ENABLE, 0, 2, 1)); // the second block
    refuse(CDS_LIMIT, sync(CDS_REG_TORQUE_ENABLE, 1, 2, 0));     // the first one
}

void test_broadcast_to_fifty_is_learnt_some_entries_a_poll(void)
{
    uint8_t polls = 0;

    begin(COUNT);
    TEST_ASSERT_EQUAL(CDS_OK, byte(CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY, 10));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    for (; request.result == CDS_PENDING && polls < 100; polls++)
        cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT8(COUNT / 4, polls);
    for (uint8_t i = 0; i < COUNT; i++)
        TEST_ASSERT_EQUAL_UINT8(10, states[i].return_delay);
}

void test_torque_off_to_fifty_is_learnt_in_one_poll(void)
{
    begin(COUNT);
    for (uint8_t i = 0; i < COUNT; i++)
        states[i].torque = true;
    TEST_ASSERT_EQUAL(CDS_OK, byte(CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 0));
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
    cds_bus_poll(&bus); // sets the deadline
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    for (uint8_t i = 0; i < COUNT; i++)
        TEST_ASSERT_FALSE(states[i].torque);
}

void test_limits_that_are_taken_back_are_none(void)
{
    limit_goal(one);
    refuse(CDS_LIMIT, registers(1, CDS_REG_GOAL_POSITION, inside, 4));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_set_limits(&servos, one, 0, 1023, 1023));
    pass(registers(1, CDS_REG_GOAL_POSITION, inside, 4));
}
