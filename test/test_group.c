/* Many servos: SYNC WRITE, and the registered move with everything that can go wrong in it. */
#include "cds55xx/group.h"

#include <string.h>

#include "packets.h"
#include "port_fake.h"
#include "unity.h"

#define PORT 0

static struct cds_bus bus;
static uint8_t buffer[CDS_SYNC_WRITE_SIZE(4, 4)];
static struct cds_request request = CDS_REQUEST(buffer);

static uint8_t other_buffer[8];
static struct cds_request other = CDS_REQUEST(other_buffer);
static struct cds_group_move move;
static struct cds_goal goals[3]; // AddressSanitizer watches its ends

void setUp(void)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    memset(buffer, 0, sizeof buffer);
    request = (struct cds_request)CDS_REQUEST(buffer);
    other = (struct cds_request)CDS_REQUEST(other_buffer);
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    port_fake_forget();
    goals[0] = (struct cds_goal){.id = 0, .position = 0, .speed = 0x100};
    goals[1] = (struct cds_goal){.id = 1, .position = 0x3FF, .speed = 0x200};
    goals[2] = (struct cds_goal){.id = 7, .position = 0x234, .speed = 0};
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void assert_sent(const uint8_t *bytes, uint8_t size)
{
    TEST_ASSERT_EQUAL_UINT16(size, port_fake.sent_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, port_fake.sent, size);
}

/* ---- SYNC WRITE ---- */

static void begin_example_5(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_group_sync_add_goal(&request, 0, 0x010, 0x150);
    cds_group_sync_add_goal(&request, 1, 0x220, 0x360);
    cds_group_sync_add_goal(&request, 2, 0x030, 0x170);
    cds_group_sync_add_goal(&request, 3, 0x220, 0x380);
}

static const struct manual_packet *const example_5 = &manual_packets[7];

static void assert_example_5_goes_out(void)
{
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    assert_sent(example_5->bytes, example_5->size);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus)); // nothing is answered
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
}

void test_sync_write_of_goals_is_example_5(void)
{
    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_send(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    assert_example_5_goes_out();
}

void test_sync_write_of_bytes_is_example_5(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_begin(&request, CDS_REG_GOAL_POSITION, 4));
    cds_group_sync_add(&request, 0, (uint8_t[]){0x10, 0x00, 0x50, 0x01});
    cds_group_sync_add(&request, 1, (uint8_t[]){0x20, 0x02, 0x60, 0x03});
    cds_group_sync_add(&request, 2, (uint8_t[]){0x30, 0x00, 0x70, 0x01});
    cds_group_sync_add(&request, 3, (uint8_t[]){0x20, 0x02, 0x80, 0x03});
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_send(&bus, &request));
    assert_example_5_goes_out();
}

void test_sync_write_past_the_room_is_refused_and_nothing_is_sent(void)
{
    begin_example_5();
    cds_group_sync_add_goal(&request, 4, 0, 0);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_group_sync_send(&bus, &request));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
}

void test_sync_write_can_be_begun_anew_after_a_refusal(void)
{
    begin_example_5();
    cds_group_sync_add_goal(&request, 4, 0, 0);
    cds_group_sync_send(&bus, &request);
    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_send(&bus, &request));
    assert_example_5_goes_out();
}

void test_sync_write_outside_the_control_table_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_group_sync_begin(&request, 0x30, 3));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_group_sync_begin(&request, 0x32, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_group_sync_begin(&request, 0x18, 0));
}

static void occupy_bus(void)
{
    other.reply_parameters = CDS_REPLY_NONE;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_action(&other.packet, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
}

static void free_bus(void)
{
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    cds_bus_poll(&bus);
}

void test_sync_write_takes_its_turn_and_can_be_sent_again(void)
{
    occupy_bus();
    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_send(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_group_sync_send(&bus, &request));
    free_bus();
    assert_example_5_goes_out();
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_send(&bus, &request));
    assert_example_5_goes_out();
}

/* It stands in the buffer that is being sent. */
void test_sync_write_on_its_way_is_not_built_over(void)
{
    static const uint8_t data[4] = {1, 2, 3, 4};

    begin_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_send(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_group_sync_begin(&request, CDS_REG_LED, 1));
    cds_group_sync_add(&request, 9, data);
    cds_group_sync_add_goal(&request, 9, 5000, 0);
    assert_example_5_goes_out();
}

/* ---- the registered move ---- */

static void begin(uint8_t count)
{
    cds_group_move_begin(&move, &bus, &request, goals, count);
}

static void poll_sends(const uint8_t *bytes, uint8_t size)
{
    for (uint8_t i = 0; i < 2 && !bus.request; i++) // a step may send nothing, but not two of them
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_move_poll(&move));
    port_fake_settle(&bus);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    assert_sent(bytes, size);
}

static void answered(uint8_t id, uint8_t error)
{
    port_fake_answer(&bus.link, id, error, NULL, 0);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
}

static void unanswered(void)
{
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    port_fake.now_us += 2000;
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
}

static void assert_over(enum cds_result result)
{
    uint16_t packets = port_fake.packets;

    for (uint8_t i = 0; i < 3; i++)
        TEST_ASSERT_EQUAL(result, cds_group_move_poll(&move));
    TEST_ASSERT_EQUAL_UINT16(packets, port_fake.packets);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus)); // and none is under way
}

/* REG WRITE of goal and speed, 0x1E on; WRITE of 0x2C = 0; ACTION: computed by hand. */
static const uint8_t arm_0[] = {0xFF, 0xFF, 0, 7, 4, 0x1E, 0x00, 0x00, 0x00, 0x01, 0xD5};
static const uint8_t arm_1[] = {0xFF, 0xFF, 1, 7, 4, 0x1E, 0xFF, 0x03, 0x00, 0x02, 0xD1};
static const uint8_t arm_7[] = {0xFF, 0xFF, 7, 7, 4, 0x1E, 0x34, 0x02, 0x00, 0x00, 0x99};
static const uint8_t disarm_0[] = {0xFF, 0xFF, 0, 4, 3, 0x2C, 0x00, 0xCC};
static const uint8_t disarm_1[] = {0xFF, 0xFF, 1, 4, 3, 0x2C, 0x00, 0xCB};
static const uint8_t disarm_7[] = {0xFF, 0xFF, 7, 4, 3, 0x2C, 0x00, 0xC5};
static const uint8_t action[] = {0xFF, 0xFF, 0xFE, 2, 5, 0xFA};

#define SENDS(bytes) poll_sends(bytes, sizeof(bytes))

void test_move_arms_each_servo_then_triggers_all(void)
{
    begin(3);
    SENDS(arm_0);
    answered(0, 0);
    SENDS(arm_1);
    answered(1, 0);
    SENDS(arm_7);
    answered(7, 0);
    SENDS(action);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
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
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_move_poll(&move));
        TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
        TEST_ASSERT_EQUAL_HEX8(said->bytes[2], port_fake.sent[2]);
        TEST_ASSERT_EQUAL_HEX8(said->bytes[4], port_fake.sent[4]);
        if (i < 2) { // address and goal
            TEST_ASSERT_EQUAL_HEX8_ARRAY(said->bytes + 5, port_fake.sent + 5, 3);
            port_fake_hear(&bus.link, said[1].bytes, said[1].size);
        } else {
            assert_sent(said->bytes, said->size);
        }
        TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    }
    assert_over(CDS_OK);
}

void test_move_of_one_servo(void)
{
    static const uint8_t arm_253[] = {0xFF, 0xFF, 253, 7, 4, 0x1E, 0x00, 0x00, 0x00, 0x01, 0xD8};

    goals[0].id = CDS_ID_MAX; // the last there is
    begin(1);
    SENDS(arm_253);
    answered(253, 0);
    SENDS(action);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    assert_over(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
}

void test_move_sends_nothing_before_its_first_poll(void)
{
    begin(2);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    TEST_ASSERT_EQUAL(CDS_PENDING, move.result);
}

/* One exchange at a time: while a servo has not answered, polling the move does nothing. */
void test_move_waits_for_each_answer(void)
{
    begin(2);
    SENDS(arm_0);
    for (uint8_t i = 0; i < 10; i++) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_move_poll(&move));
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    }
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

void test_move_refused_by_the_second_servo_disarms_the_first(void)
{
    begin(3);
    SENDS(arm_0);
    answered(0, 0);
    SENDS(arm_1);
    answered(1, CDS_ERROR_ANGLE);
    SENDS(disarm_0); // not servo 1, which has registered nothing
    answered(0, 0);
    assert_over(CDS_REFUSED);
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
    TEST_ASSERT_EQUAL(CDS_REFUSED, goals[1].result);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_ANGLE, goals[1].error);
    TEST_ASSERT_EQUAL(CDS_PENDING, goals[2].result); // it was not asked
}

void test_move_refused_by_the_first_servo_has_nothing_to_disarm(void)
{
    begin(2);
    SENDS(arm_0);
    answered(0, CDS_ERROR_RANGE);
    assert_over(CDS_REFUSED);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

void test_move_is_refused_by_every_error_of_the_packet(void)
{
    static const uint8_t bits[] = {CDS_ERROR_ANGLE, CDS_ERROR_RANGE, CDS_ERROR_CHECKSUM,
                                   CDS_ERROR_INSTRUCTION};

    for (uint8_t i = 0; i < sizeof bits; i++) {
        begin(2);
        SENDS(arm_0);
        answered(0, bits[i] | CDS_ERROR_VOLTAGE);
        assert_over(CDS_REFUSED);
        TEST_ASSERT_EQUAL_HEX8(bits[i] | CDS_ERROR_VOLTAGE, goals[0].error);
    }
}

/* A condition that merely holds does not mean that the goal was not taken. */
void test_move_goes_on_in_spite_of_conditions(void)
{
    begin(1);
    SENDS(arm_0);
    answered(0, CDS_ERRORS_OF_CONDITION);
    SENDS(action);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    assert_over(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, goals[0].result);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERRORS_OF_CONDITION, goals[0].error);
}

/* Who did not answer may have registered it all the same: disarmed too, last first. */
void test_move_with_a_timeout_disarms_that_servo_too(void)
{
    begin(3);
    SENDS(arm_0);
    answered(0, 0);
    SENDS(arm_1);
    unanswered();
    SENDS(disarm_1);
    answered(1, 0);
    SENDS(disarm_0);
    answered(0, 0);
    assert_over(CDS_TIMEOUT);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, goals[1].result);
    TEST_ASSERT_EQUAL(CDS_PENDING, goals[2].result);
}

void test_move_with_the_last_servo_absent_disarms_all(void)
{
    begin(3);
    SENDS(arm_0);
    answered(0, 0);
    SENDS(arm_1);
    answered(1, 0);
    SENDS(arm_7);
    unanswered();
    SENDS(disarm_7);
    unanswered(); // in doubt, but the others must be disarmed
    SENDS(disarm_1);
    answered(1, CDS_ERROR_RANGE);
    SENDS(disarm_0);
    answered(0, 0);
    assert_over(CDS_TIMEOUT); // the first reason stays
}

void test_move_with_a_damaged_answer_disarms_that_servo_too(void)
{
    begin(2);
    SENDS(arm_0);
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    unanswered();
    SENDS(disarm_0);
    answered(0, 0);
    assert_over(CDS_CORRUPT);
    TEST_ASSERT_EQUAL(CDS_CORRUPT, goals[0].result);
}

void test_move_waits_while_the_bus_is_busy(void)
{
    occupy_bus();
    begin(1);
    for (uint8_t i = 0; i < 5; i++)
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_move_poll(&move));
    free_bus();
    SENDS(arm_0);
    answered(0, 0);
    occupy_bus(); // and between two steps of its own
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_move_poll(&move));
    free_bus();
    SENDS(action);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    assert_over(CDS_OK);
}

void test_move_of_no_servos_is_a_bad_argument(void)
{
    begin(0);
    assert_over(CDS_BAD_ARGUMENT);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
}

/* Broadcast would be answered by none, and so never known to be armed. */
void test_move_with_an_id_of_no_servo_disarms_those_before(void)
{
    for (uint8_t id = CDS_BROADCAST_ID; id; id++) { // 0xFE, 0xFF
        goals[1].id = id;
        begin(2);
        SENDS(arm_0);
        answered(0, 0);
        SENDS(disarm_0);
        answered(0, 0);
        assert_over(CDS_BAD_ARGUMENT);
        TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, goals[1].result);
    }
}

void test_move_in_too_small_a_buffer_is_refused(void)
{
    request.packet.room = CDS_PACKET_SIZE(5) - 1;
    begin(2);
    assert_over(CDS_NO_ROOM);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, goals[0].result);
    request.packet.room = CDS_PACKET_SIZE(5);
    begin(2);
    SENDS(arm_0);
}

void test_move_whose_action_never_leaves_says_so(void)
{
    begin(1);
    SENDS(arm_0);
    answered(0, 0);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_group_move_poll(&move)); // ACTION, but the line is dead
    unanswered();
    assert_over(CDS_TIMEOUT);
}

void test_move_can_be_begun_anew(void)
{
    begin(1);
    SENDS(arm_0);
    unanswered();
    SENDS(disarm_0);
    unanswered();
    assert_over(CDS_TIMEOUT);
    begin(1);
    TEST_ASSERT_EQUAL(CDS_PENDING, goals[0].result);
    SENDS(arm_0);
    answered(0, 0);
    SENDS(action);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    assert_over(CDS_OK);
}

void test_goal_out_of_range_is_not_sent(void)
{
    static const uint16_t wrong[][3] = {{254, 0, 0}, {1, 1024, 0}, {1, 0, 1024}};

    for (uint8_t i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_group_sync_begin(&request, CDS_REG_GOAL_POSITION, 4));
        cds_group_sync_add_goal(&request, (uint8_t)wrong[i][0], wrong[i][1], wrong[i][2]);
        TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_group_sync_send(&bus, &request));
    }
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}
