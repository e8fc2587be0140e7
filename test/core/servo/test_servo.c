/* SPDX-License-Identifier: MIT */
/* The typed calls for one servo: what they put on the line, what they expect back. */
#include "cds55xx/servo.h"

#include <string.h>

#include "bus_rig.h"
#include "packets.h"
#include "unity.h"

#define PORT 0

static uint8_t buffer[CDS_PACKET_SIZE(CDS_TABLE_SIZE + 1)]; // WRITE of the whole table: an address
static uint8_t reply[CDS_REPLY_MAX];
static struct cds_request request = CDS_REQUEST(buffer, reply);

static const uint8_t data[CDS_TABLE_SIZE] = {0x11, 0x22, 0x33, 0x44};

static uint16_t count_ok(void)
{
    struct cds_stats stats;

    cds_bus_stats(&bus, &stats);
    return stats.ok;
}

void setUp(void)
{
    rig_open(PORT);
    memset(buffer, 0, sizeof buffer);
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
}

void tearDown(void)
{
    rig_check();
}

/* The call before was accepted: its packet goes out, and so far nothing is decided. */
static void transmit(enum cds_result submitted)
{
    TEST_ASSERT_EQUAL(CDS_OK, submitted);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
}

static void assert_ended(enum cds_result result)
{
    port_fake_look(&bus);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(result, request.result);
}

static void assert_waits_for(uint8_t id, uint8_t parameters)
{
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    port_fake_answer(&bus.link, id, 0, data, parameters);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(id, request.id);
    TEST_ASSERT_EQUAL_UINT8(parameters, request.length);
}

static void assert_refused(enum cds_result reason, enum cds_result result)
{
    TEST_ASSERT_EQUAL(reason, result);
    TEST_ASSERT_EQUAL(reason, request.result); // a READ before it must not look like its answer
    request.result = CDS_OK;
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
}

/* The manual's conversations but for SYNC WRITE, which is a group's: each packet of the controller
 * by the typed call that makes it, then the manual's own reply, if it has one. */
static enum cds_result converse(uint8_t index)
{
    switch (index) {
    case 0: return cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_ID, 1);
    case 1: return cds_servo_read(&bus, &request, 1, CDS_REG_PRESENT_TEMPERATURE, 1);
    case 3: return cds_servo_ping(&bus, &request, 1);
    case 5: return cds_servo_reset(&bus, &request, 0);
    case 8: return cds_servo_write_byte(&bus, &request, 1, CDS_REG_ID, 0);
    case 10: return cds_servo_write_byte(&bus, &request, 0, CDS_REG_BAUD_RATE, 1);
    case 12: return cds_servo_write_byte(&bus, &request, 0, CDS_REG_RETURN_DELAY, 2);
    case 14: return cds_servo_write_word(&bus, &request, 0, CDS_REG_CCW_ANGLE_LIMIT, 0x1FF);
    case 16: return cds_servo_write_byte(&bus, &request, 0, CDS_REG_MAX_TEMPERATURE, 80);
    case 18: return cds_servo_write_word(&bus, &request, 0, CDS_REG_MIN_VOLTAGE, 170u << 8 | 100);
    case 20: return cds_servo_write_word(&bus, &request, 0, CDS_REG_MAX_TORQUE, 0x1FF);
    case 22: return cds_servo_write_byte(&bus, &request, 0, CDS_REG_STATUS_RETURN_LEVEL, 0);
    case 24: return cds_servo_write(&bus, &request, 0, CDS_REG_ALARM_LED, (uint8_t[]){4, 4}, 2);
    case 26: return cds_servo_write(&bus, &request, 0, CDS_REG_TORQUE_ENABLE, (uint8_t[]){1, 1}, 2);
    case 28:
        return cds_servo_write(&bus, &request, 0, CDS_REG_GOAL_POSITION, (uint8_t[]){0, 2, 0, 2},
                               4);
    case 30:
        return cds_servo_reg_write(&bus, &request, 0, CDS_REG_GOAL_POSITION, (uint8_t[]){0, 0}, 2);
    case 32:
        return cds_servo_reg_write(&bus, &request, 1, CDS_REG_GOAL_POSITION,
                                   (uint8_t[]){0xFF, 0x03}, 2);
    case 34: return cds_servo_action(&bus, &request, CDS_BROADCAST_ID);
    case 35: return cds_servo_write_byte(&bus, &request, 0, CDS_REG_LOCK, 1);
    default: return cds_servo_write_word(&bus, &request, 0, CDS_REG_PUNCH, 0x40);
    }
}

void test_conversations_of_the_manual(void)
{
    for (uint8_t i = 0; i < MANUAL_PACKETS; i++) {
        const struct manual_packet *said = &manual_packets[i];

        if (said->example == 5)
            continue;
        if (said->sender == CONTROLLER) {
            transmit(converse(i));
            rig_assert_sent(said->bytes, said->size);
            if (said->bytes[2] == CDS_BROADCAST_ID)
                assert_ended(CDS_OK);
        } else {
            TEST_ASSERT_TRUE(cds_bus_poll(&bus));
            port_fake_hear(&bus.link, said->bytes, said->size);
            assert_ended(CDS_OK);
            TEST_ASSERT_EQUAL_UINT8(said->bytes[2], request.id);
            TEST_ASSERT_EQUAL_HEX8(said->bytes[4], request.error);
        }
    }
    TEST_ASSERT_EQUAL_UINT16(21, count_ok()); // 19 replies, 2 broadcasts
}

void test_temperature_of_example_2(void)
{
    uint8_t celsius = 0;

    transmit(cds_servo_read(&bus, &request, 1, CDS_REG_PRESENT_TEMPERATURE, 1));
    port_fake_hear(&bus.link, manual_packets[2].bytes, manual_packets[2].size);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, cds_request_byte(&request, 0, &celsius));
    TEST_ASSERT_EQUAL_UINT8(32, celsius);
}

void test_refusal_of_example_20_keeps_the_two_worlds_apart(void)
{
    transmit(cds_servo_write_word(&bus, &request, 0, CDS_REG_PUNCH, 0x40));
    port_fake_answer(&bus.link, 0, CDS_ERROR_RANGE, NULL, 0);
    assert_ended(CDS_OK); // the transaction went well
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, request.error);
}

void test_reply_due_to_each_instruction(void)
{
    transmit(cds_servo_ping(&bus, &request, 7));
    assert_waits_for(7, 0);
    transmit(cds_servo_read(&bus, &request, 7, 0x00, 50));
    assert_waits_for(7, 50);
    transmit(cds_servo_write(&bus, &request, 7, 0x00, data, 50));
    assert_waits_for(7, 0);
    transmit(cds_servo_write_byte(&bus, &request, 7, CDS_REG_LED, 1));
    assert_waits_for(7, 0);
    transmit(cds_servo_write_word(&bus, &request, 7, CDS_REG_PUNCH, 1));
    assert_waits_for(7, 0);
    transmit(cds_servo_reg_write(&bus, &request, 7, CDS_REG_GOAL_POSITION, data, 4));
    assert_waits_for(7, 0);
    transmit(cds_servo_action(&bus, &request, 7));
    assert_waits_for(7, 0);
    transmit(cds_servo_reset(&bus, &request, 7));
    assert_waits_for(7, 0);
}

void test_broadcast_is_answered_to_ping_only(void)
{
    transmit(cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_LED, 1));
    assert_ended(CDS_OK);
    transmit(cds_servo_write_word(&bus, &request, CDS_BROADCAST_ID, CDS_REG_PUNCH, 1));
    assert_ended(CDS_OK);
    transmit(cds_servo_reg_write(&bus, &request, CDS_BROADCAST_ID, CDS_REG_LED, data, 1));
    assert_ended(CDS_OK);
    transmit(cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    assert_ended(CDS_OK);
    transmit(cds_servo_reset(&bus, &request, CDS_BROADCAST_ID));
    assert_ended(CDS_OK);
    transmit(cds_servo_ping(&bus, &request, CDS_BROADCAST_ID));
    assert_waits_for(42, 0);
}

void test_broadcast_read_is_refused(void)
{
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_read(&bus, &request, CDS_BROADCAST_ID, 0, 1));
}

/* A request that ended without a reply due must not be remembered as one for the next call. */
void test_reply_is_due_again_after_a_broadcast(void)
{
    transmit(cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    assert_ended(CDS_OK);
    transmit(cds_servo_action(&bus, &request, 3));
    assert_waits_for(3, 0);
}

void test_word_is_written_low_byte_first_in_one_packet(void)
{
    static const uint8_t wanted[] = {0xFF, 0xFF, 0x07, 0x05, 0x03, 0x1E, 0x34, 0x02, 0x9C};

    transmit(cds_servo_write_word(&bus, &request, 7, CDS_REG_GOAL_POSITION, 0x0234));
    rig_assert_sent(wanted, sizeof wanted);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

void test_id_ff_is_refused(void)
{
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_ping(&bus, &request, 0xFF));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_read(&bus, &request, 0xFF, 0, 1));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_write(&bus, &request, 0xFF, 0x18, data, 1));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_write_byte(&bus, &request, 0xFF, 0x18, 1));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_write_word(&bus, &request, 0xFF, 0x18, 1));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_reg_write(&bus, &request, 0xFF, 0x18, data, 1));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_action(&bus, &request, 0xFF));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_reset(&bus, &request, 0xFF));
}

void test_addresses_and_lengths_outside_the_table_are_refused(void)
{
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_read(&bus, &request, 1, 0x32, 1));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_read(&bus, &request, 1, 0x31, 2));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_read(&bus, &request, 1, 0, 0));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_write_word(&bus, &request, 1, 0x31, 1));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_write(&bus, &request, 1, 0x18, data, 0));
    assert_refused(CDS_BAD_ARGUMENT, cds_servo_reg_write(&bus, &request, 1, 0x30, data, 3));
}

void test_buffer_too_small_for_the_packet_is_refused(void)
{
    request.packet.capacity = 9;
    assert_refused(CDS_NO_ROOM, cds_servo_write(&bus, &request, 1, 0x18, data, 3));
    assert_refused(CDS_NO_ROOM, cds_servo_reg_write(&bus, &request, 1, 0x18, data, 3));
    request.packet.capacity = 5;
    assert_refused(CDS_NO_ROOM, cds_servo_ping(&bus, &request, 1));
}

void test_buffer_too_small_for_the_reply_is_refused(void)
{
    request.reply_capacity = 49;
    assert_refused(CDS_NO_ROOM, cds_servo_read(&bus, &request, 1, 0, 50));
    request.reply_capacity = 50;
    transmit(cds_servo_read(&bus, &request, 1, 0, 50));
    assert_waits_for(1, 50);
}

/* It would need more room than is looked at: the calls know how long the reply is. */
void test_reply_of_any_length_is_none_of_a_typed_call(void)
{
    request.reply_capacity = 8;
    request.any_length = true;
    transmit(cds_servo_read(&bus, &request, 1, 0, 8));
    TEST_ASSERT_FALSE(request.any_length);
    assert_waits_for(1, 8);
    request.any_length = true;
    transmit(cds_servo_ping(&bus, &request, 1));
    TEST_ASSERT_FALSE(request.any_length);
    assert_waits_for(1, 0);
}

/* The packet in flight stands in the request's buffer: it must be left alone. */
void test_request_on_its_way_is_not_built_over(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &request, 1));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &request, 2));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_read(&bus, &request, 2, 0, 1));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_write(&bus, &request, 2, 0x18, data, 1));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_write_byte(&bus, &request, 2, 0x18, 1));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_write_word(&bus, &request, 2, 0x18, 1));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_reg_write(&bus, &request, 2, 0x18, data, 1));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_action(&bus, &request, 2));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_reset(&bus, &request, 2));
    transmit(CDS_OK);
    rig_assert_sent(manual_packets[3].bytes, manual_packets[3].size); // PING 1, whole
    assert_waits_for(1, 0);
}

void test_same_request_serves_again_and_again(void)
{
    for (uint8_t id = 0; id < 20; id++) {
        transmit(cds_servo_read(&bus, &request, id, 0x24, 8));
        assert_waits_for(id, 8);
    }
    TEST_ASSERT_EQUAL_UINT16(20, count_ok());
}
