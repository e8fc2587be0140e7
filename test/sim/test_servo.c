/* SPDX-License-Identifier: MIT */
/* The simulated servo: every instruction, register and alarm of the manual, and the rulings R1-R40.
 * The tests build their packets themselves, not with the servo's codec. */
#include <string.h>

#include "unity.h"

#include "servo/servo.h"

enum {
    PING = 0x01,
    READ = 0x02,
    WRITE = 0x03,
    REG_WRITE = 0x04,
    ACTION = 0x05,
    RESET = 0x06,
    SYNC_WRITE = 0x83,
    ALL = 0xFE
};

#define SILENCE (-1) // returned instead of an ERROR byte

static struct servo servo;

void setUp(void)
{
    servo_init(&servo, 1);
}

void tearDown(void)
{
}

static bool hear(const uint8_t *bytes, size_t count)
{
    bool due = false;
    while (count--) {
        due = servo_receive(&servo, *bytes++, false);
        if (count > 0) {
            TEST_ASSERT_FALSE(due);
        }
    }
    return due;
}

static size_t build(uint8_t *packet, uint8_t id, uint8_t instruction, const uint8_t *parameters,
                    size_t count)
{
    uint8_t sum = (uint8_t)(id + count + 2 + instruction);
    size_t size = 0;
    packet[size++] = 0xFF;
    packet[size++] = 0xFF;
    packet[size++] = id;
    packet[size++] = (uint8_t)(count + 2);
    packet[size++] = instruction;
    for (size_t i = 0; i < count; i++) {
        packet[size++] = parameters[i];
        sum = (uint8_t)(sum + parameters[i]);
    }
    packet[size++] = (uint8_t)~sum;
    return size;
}

static int answer_to(uint8_t id, uint8_t instruction, const uint8_t *parameters, size_t count)
{
    uint8_t packet[SERVO_PACKET_MAX];
    size_t size = build(packet, id, instruction, parameters, count);
    return hear(packet, size) ? servo.reply.bytes[4] : SILENCE;
}

#define SEND0(id, instruction) answer_to(id, instruction, NULL, 0)
#define SEND(id, instruction, ...)                                                                 \
    answer_to(id, instruction, (const uint8_t[]){__VA_ARGS__},                                     \
              sizeof((const uint8_t[]){__VA_ARGS__}))
#define DO(...)               SEND(1, WRITE, __VA_ARGS__)
#define EXPECT(error, answer) TEST_ASSERT_EQUAL_INT(error, answer)
#define OK(answer)            EXPECT(0, answer)

static unsigned get(uint8_t address)
{
    return servo.registers[address];
}

static unsigned get_word(uint8_t address)
{
    return servo.registers[address] | (unsigned)servo.registers[address + 1] << 8;
}

static void ticks(int count)
{
    while (count-- > 0) {
        servo_tick(&servo);
    }
}

/* The manual's packets. */

/* Every packet that the manual prints: the packet, the state before it, and the reply. */
struct example {
    int number;
    uint8_t id;
    bool locked;
    const char *instruction, *status; // hexadecimal; NULL: no reply
};

// clang-format off
static const struct example examples[] = {
    {1, 9, false, "FFFFFE04030301F6", NULL},
    {2, 1, false, "FFFF0104022B01CC", "FFFF01030020DB"},
    {3, 1, false, "FFFF010201FB", "FFFF010200FC"},
    {4, 0, false, "FFFF000206F7", "FFFF000200FD"},
    {5, 3, false, "FFFFFE18831E04001000500101200260030230007001032002800312", NULL},
    {6, 1, false, "FFFF0104030300F4", "FFFF010200FC"},
    {7, 0, false, "FFFF0004030401F3", "FFFF000200FD"},
    {8, 0, false, "FFFF0004030502F1", "FFFF000200FD"},
    {9, 0, false, "FFFF00050308FF01EF", "FFFF000200FD"},
    {10, 0, false, "FFFF0004030B509D", "FFFF000200FD"},
    {11, 0, false, "FFFF0005030C64AADD", "FFFF000200FD"},
    {12, 0, false, "FFFF0005030EFF01E9", "FFFF000200FD"},
    {13, 0, false, "FFFF0004031000E8", "FFFF000200FD"},
    {15, 0, false, "FFFF000503110404DE", "FFFF000200FD"},
    {16, 0, false, "FFFF000503180101DD", "FFFF000200FD"},
    {18, 0, false, "FFFF0007031E00020002D3", "FFFF000200FD"},
    {19, 0, false, "FFFF0005041E0000D8", "FFFF000200FD"},
    {19, 1, false, "FFFF0105041EFF03D5", "FFFF010200FC"},
    {19, 1, false, "FFFFFE0205FA", NULL},
    {20, 0, false, "FFFF0004032F01C8", "FFFF000200FD"},
    {20, 0, true, "FFFF00050330400087", "FFFF000208F5"},
    {21, 0, false, "FFFF00050330400087", "FFFF000200FD"},
};
// clang-format on

static size_t bytes_of(const char *hexadecimal, uint8_t *bytes)
{
    static const char digits[] = "0123456789ABCDEF";
    size_t size = strlen(hexadecimal) / 2;
    for (size_t i = 0; i < size; i++) {
        size_t high = (size_t)(strchr(digits, hexadecimal[2 * i]) - digits);
        size_t low = (size_t)(strchr(digits, hexadecimal[2 * i + 1]) - digits);
        bytes[i] = (uint8_t)(high << 4 | low);
    }
    return size;
}

void test_all_41_packets_of_the_manual(void)
{
    int packets = 0;
    for (size_t i = 0; i < sizeof examples / sizeof examples[0]; i++) {
        const struct example *row = &examples[i];
        uint8_t sent[64], expected[64];
        servo_init(&servo, row->id);
        servo.registers[TABLE_LOCK] = row->locked;
        size_t size = bytes_of(row->instruction, sent);
        TEST_ASSERT_EQUAL(row->status != NULL, hear(sent, size));
        packets++;
        if (row->status) {
            size = bytes_of(row->status, expected);
            TEST_ASSERT_EQUAL(size, servo.reply.size);
            TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, servo.reply.bytes, size);
            packets++;
        }
    }
    TEST_ASSERT_EQUAL(41, packets);
}

void test_example_1_broadcast_sets_the_id(void)
{
    servo_init(&servo, 77);
    EXPECT(SILENCE, SEND(ALL, WRITE, TABLE_ID, 1));
    TEST_ASSERT_EQUAL(1, get(TABLE_ID));
}

void test_example_19_two_servos_start_together(void)
{
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    OK(SEND(1, REG_WRITE, TABLE_GOAL_POSITION, 0xFF, 0x03));
    TEST_ASSERT_EQUAL(512, servo_goal_position(&servo));
    TEST_ASSERT_EQUAL(1, get(TABLE_REGISTERED));
    EXPECT(SILENCE, SEND0(ALL, ACTION));
    TEST_ASSERT_EQUAL(0x3FF, servo_goal_position(&servo));
    TEST_ASSERT_EQUAL(0, get(TABLE_REGISTERED));
}

/* The control table. */

static void expect_initial_values(void)
{
    /* The 50 bytes of the manual's table in its order. */
    static const uint8_t initial[SERVO_REGISTERS] = {
        0,    1,    1,    1,    1,    0x01, 0x00, 0x00, 0xFF, 0x03, // 0x00
        0x00, 0x50, 0x3C, 0xA0, 0xFF, 0x03, 0x02, 0x25, 0x04, 0x00, // 0x0A
        0,    0,    0,    0,    0x00, 0x00, 0x02, 0x02, 0x20, 0x20, // 0x14
        0x00, 0x02, 0x00, 0x00, 0x20, 0x20, 0x00, 0x02, 0,    0,    // 0x1E
        0,    0,    120,  32,   0x00, 0,    0x00, 0x00, 0x5A, 0x00, // 0x28
    };
    TEST_ASSERT_EQUAL_HEX8_ARRAY(initial, servo.registers, SERVO_REGISTERS);
}

void test_R11_R12_R26_R38_initial_values(void)
{
    expect_initial_values();
    OK(SEND(1, READ, 0, SERVO_REGISTERS));
    TEST_ASSERT_EQUAL(6 + SERVO_REGISTERS, servo.reply.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(servo.registers, servo.reply.bytes + 5, SERVO_REGISTERS);
}

void test_the_rows_cover_each_of_the_50_registers_once(void)
{
    unsigned next = 0;
    for (int i = 0; i < TABLE_ROWS; i++) {
        TEST_ASSERT_EQUAL(next, table_rows[i].address);
        TEST_ASSERT_EQUAL(next < SERVO_EEPROM_SIZE, table_rows[i].eeprom);
        TEST_ASSERT_EQUAL_PTR(&table_rows[i], table_find(table_rows[i].name));
        next += table_rows[i].width;
    }
    TEST_ASSERT_EQUAL(SERVO_REGISTERS, next);
}

/* Highest value that may be written to each address. Words stand at their low byte; -1: read only.
 */
static const int16_t highest[SERVO_REGISTERS] = {
    -1,    -1,  -1,    253, 254,   254, 0x3FF, -2,   0x3FF, -2,  // 0x00
    -1,    255, 255,   255, 0x3FF, -2,  2,     0x7F, 0x7F,  255, // 0x0A
    -1,    -1,  -1,    -1,  1,     1,   255,   255,  255,   255, // 0x14
    0x3FF, -2,  0x3FF, -2,  255,   255, -1,    -1,   -1,    -1,  // 0x1E
    -1,    -1,  -1,    -1,  0,     -1,  -1,    1,    0x3FF, -2,  // 0x28
};

static int write_value(uint8_t address, unsigned value)
{
    bool is_word = address + 1 < SERVO_REGISTERS && highest[address + 1] == -2;
    setUp();
    return is_word ? DO(address, (uint8_t)value, (uint8_t)(value >> 8))
                   : DO(address, (uint8_t)value);
}

void test_R4_R33_every_value_in_range_is_stored(void)
{
    for (uint8_t address = 0; address < SERVO_REGISTERS; address++) {
        for (int value = 0; value <= highest[address]; value++) {
            int error = write_value(address, (unsigned)value) & ~SERVO_ERROR_VOLTAGE &
                        ~SERVO_ERROR_OVERHEATING; // limits may have any value
            TEST_ASSERT_EQUAL_MESSAGE(0, error, "in range");
            TEST_ASSERT_EQUAL(value & 0xFF, get(address));
            if (value > 255) {
                TEST_ASSERT_EQUAL(value, get_word(address));
            }
        }
    }
}

void test_R4_R33_no_value_out_of_range_is_stored(void)
{
    for (uint8_t address = 0; address < SERVO_REGISTERS; address++) {
        bool is_word = highest[address] == 0x3FF;
        int top = is_word ? 0xFFFF : 0xFF;
        for (int value = highest[address] + 1; highest[address] >= 0 && value <= top; value++) {
            TEST_ASSERT_EQUAL(SERVO_ERROR_RANGE, write_value(address, (unsigned)value));
            expect_initial_values();
        }
    }
}

void test_R5_read_only_and_reserved_registers_are_not_written(void)
{
    for (uint8_t address = 0; address < SERVO_REGISTERS; address++) {
        if (highest[address] == -1) {
            EXPECT(SERVO_ERROR_RANGE, DO(address, 1));
            EXPECT(SERVO_ERROR_RANGE, DO(address, 0));
            expect_initial_values();
        }
    }
}

void test_R5_register_0x13_is_writable(void)
{
    OK(DO(0x13, 0xA5));
    TEST_ASSERT_EQUAL_HEX8(0xA5, get(0x13));
}

void test_R5_one_read_only_register_refuses_the_whole_write(void)
{
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_DCC, 50, 0, 0)); // reaches into the present position
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_CCW_LIMIT, 0, 1, 0, 70)); // across the reserved 0x0A
    expect_initial_values();
}

void test_R5_writing_past_the_table_is_refused(void)
{
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_PUNCH, 1, 0, 0));
    EXPECT(SERVO_ERROR_RANGE, DO(SERVO_REGISTERS, 0));
    EXPECT(SERVO_ERROR_RANGE, DO(0xFF, 0));
    expect_initial_values();
}

void test_R5_the_longest_write_is_refused(void)
{
    uint8_t parameters[252] = {TABLE_TORQUE_ENABLE};
    EXPECT(SERVO_ERROR_RANGE, answer_to(1, WRITE, parameters, sizeof parameters));
    EXPECT(SERVO_ERROR_RANGE, answer_to(1, REG_WRITE, parameters, sizeof parameters));
    expect_initial_values();
}

void test_R5_read_past_the_end_or_of_nothing(void)
{
    static const uint8_t reads[][2] = {{0, 0}, {0, 51}, {49, 2}, {50, 1}, {255, 255}, {1, 255}};
    for (size_t i = 0; i < sizeof reads / sizeof reads[0]; i++) {
        EXPECT(SERVO_ERROR_RANGE, SEND(1, READ, reads[i][0], reads[i][1]));
        TEST_ASSERT_EQUAL(6, servo.reply.size);
    }
    OK(SEND(1, READ, 49, 1));
    TEST_ASSERT_EQUAL(7, servo.reply.size);
}

void test_R4_one_value_out_of_range_refuses_the_whole_write(void)
{
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_TORQUE_ENABLE, 1, 2));
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_GOAL_POSITION, 0, 1, 0, 4));
    expect_initial_values();
}

void test_R28_a_lone_byte_of_a_word_takes_effect(void)
{
    OK(DO(TABLE_GOAL_POSITION, 0x34));
    TEST_ASSERT_EQUAL_HEX16(0x234, servo_goal_position(&servo));
    OK(DO(TABLE_GOAL_POSITION + 1, 0x01));
    TEST_ASSERT_EQUAL_HEX16(0x134, servo_goal_position(&servo));
}

void test_R33_a_word_is_judged_by_its_value_after_the_write(void)
{
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_PUNCH + 1, 4)); // would be 0x45A
    TEST_ASSERT_EQUAL_HEX16(0x5A, get_word(TABLE_PUNCH));
    OK(DO(TABLE_PUNCH + 1, 3));
    TEST_ASSERT_EQUAL_HEX16(0x35A, get_word(TABLE_PUNCH));
}

void test_R7_AX12_torque_limit_lands_in_acc_and_dcc(void)
{
    OK(DO(0x22, 0xFF, 0x03));
    TEST_ASSERT_EQUAL(255, get(TABLE_ACC));
    TEST_ASSERT_EQUAL(3, get(TABLE_DCC));
    TEST_ASSERT_EQUAL(1023, servo.torque_limit);
}

void test_R13_highest_temperature_is_writable(void)
{
    OK(DO(TABLE_HIGHEST_TEMPERATURE, 70));
    TEST_ASSERT_EQUAL(70, get(TABLE_HIGHEST_TEMPERATURE));
}

void test_R14_17_volts_may_be_set(void)
{
    OK(DO(TABLE_LOWEST_VOLTAGE, 100, 170));
    TEST_ASSERT_EQUAL(170, get(TABLE_HIGHEST_VOLTAGE));
}

/* Which packets get a reply, when, and how. */

void test_R1_ping_is_answered_at_every_level(void)
{
    for (uint8_t level = 0; level <= 2; level++) {
        DO(TABLE_RETURN_LEVEL, level);
        OK(SEND0(1, PING));
        OK(SEND0(ALL, PING));
        TEST_ASSERT_EQUAL(1, servo.reply.bytes[2]);
    }
}

void test_R1_no_other_broadcast_is_answered(void)
{
    EXPECT(SILENCE, SEND(ALL, READ, 0, 1));
    EXPECT(SILENCE, SEND(ALL, WRITE, TABLE_LED, 1));
    EXPECT(SILENCE, SEND(ALL, REG_WRITE, TABLE_LED, 0));
    EXPECT(SILENCE, SEND0(ALL, ACTION));
    EXPECT(SILENCE, SEND0(ALL, ACTION));
    EXPECT(SILENCE, SEND0(ALL, RESET));
    EXPECT(SILENCE, SEND0(ALL, 0x77));
}

void test_broadcasts_are_executed(void)
{
    SEND(ALL, WRITE, TABLE_LED, 1);
    TEST_ASSERT_EQUAL(1, get(TABLE_LED));
    SEND(ALL, REG_WRITE, TABLE_LED, 0);
    TEST_ASSERT_EQUAL(1, get(TABLE_REGISTERED));
    SEND0(ALL, ACTION);
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
    DO(TABLE_CW_MARGIN, 9);
    SEND0(ALL, RESET);
    TEST_ASSERT_EQUAL(2, get(TABLE_CW_MARGIN));
}

void test_packets_for_others_are_ignored(void)
{
    for (unsigned id = 0; id < ALL; id++) {
        if (id != 1) {
            EXPECT(SILENCE, SEND0((uint8_t)id, PING));
            EXPECT(SILENCE, SEND((uint8_t)id, WRITE, TABLE_LED, 1));
            EXPECT(SILENCE, SEND0((uint8_t)id, RESET));
        }
    }
    expect_initial_values();
}

void test_R2_example_13_level_0_is_answered_at_the_old_level(void)
{
    OK(DO(TABLE_RETURN_LEVEL, 0));
    EXPECT(SILENCE, DO(TABLE_LED, 1));
    TEST_ASSERT_EQUAL(1, get(TABLE_LED));
    EXPECT(SILENCE, DO(TABLE_RETURN_LEVEL, 2));
    OK(DO(TABLE_LED, 0));
}

void test_R2_a_new_id_is_answered_with_the_old_one(void)
{
    OK(DO(TABLE_ID, 7));
    TEST_ASSERT_EQUAL(1, servo.reply.bytes[2]);
    EXPECT(SILENCE, SEND0(1, PING));
    OK(SEND0(7, PING));
    TEST_ASSERT_EQUAL(7, servo.reply.bytes[2]);
}

void test_R2_a_new_baud_rate_is_answered_at_the_old_one(void)
{
    OK(DO(TABLE_BAUD, 34));
    TEST_ASSERT_EQUAL(1, servo.reply.baud);
    TEST_ASSERT_EQUAL(34, servo_baud(&servo));
    OK(SEND0(1, PING));
    TEST_ASSERT_EQUAL(34, servo.reply.baud);
}

void test_R2_a_new_return_delay_holds_from_the_next_reply(void)
{
    OK(SEND0(1, PING));
    TEST_ASSERT_EQUAL(2, servo.reply.delay_us);
    OK(DO(TABLE_RETURN_DELAY, 254));
    TEST_ASSERT_EQUAL(2, servo.reply.delay_us);
    OK(DO(TABLE_RETURN_DELAY, 0));
    TEST_ASSERT_EQUAL(508, servo.reply.delay_us);
    OK(SEND0(1, PING));
    TEST_ASSERT_EQUAL(0, servo.reply.delay_us);
}

void test_R3_level_1_answers_read_and_ping_only(void)
{
    OK(DO(TABLE_RETURN_LEVEL, 1));
    OK(SEND(1, READ, 0, 1));
    EXPECT(SERVO_ERROR_RANGE, SEND(1, READ, 60, 1));
    OK(SEND0(1, PING));
    EXPECT(SILENCE, DO(TABLE_LED, 1));
    EXPECT(SILENCE, DO(TABLE_LED, 2));
    EXPECT(SILENCE, SEND(1, REG_WRITE, TABLE_LED, 0));
    EXPECT(SILENCE, SEND0(1, ACTION));
    EXPECT(SILENCE, SEND0(1, 0x77));
    EXPECT(SILENCE, SEND(1, SYNC_WRITE, TABLE_LED, 1, 1, 1));
    EXPECT(SILENCE, SEND0(1, RESET));
    TEST_ASSERT_EQUAL(2, get(TABLE_RETURN_LEVEL)); // the level on arrival decides
}

void test_R3_level_0_answers_ping_only(void)
{
    OK(DO(TABLE_RETURN_LEVEL, 0));
    EXPECT(SILENCE, SEND(1, READ, 0, 1));
    EXPECT(SILENCE, DO(TABLE_LED, 1));
    EXPECT(SILENCE, SEND0(1, 0x77));
    OK(SEND0(1, PING));
}

/* Instructions that go wrong. */

void test_R34_an_undefined_instruction(void)
{
    for (unsigned instruction = 0; instruction <= 255; instruction++) {
        if ((instruction < PING || instruction > RESET) && instruction != SYNC_WRITE) {
            EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, (uint8_t)instruction));
            EXPECT(SERVO_ERROR_INSTRUCTION, SEND(1, (uint8_t)instruction, 0, 1));
        }
    }
    expect_initial_values();
}

void test_R34_wrong_number_of_parameters(void)
{
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND(1, PING, 0));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, READ));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND(1, READ, 0));
    TEST_ASSERT_EQUAL(6, servo.reply.size);
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND(1, READ, 0, 1, 0));
    TEST_ASSERT_EQUAL(6, servo.reply.size);
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, WRITE));
    EXPECT(SERVO_ERROR_INSTRUCTION, DO(TABLE_LED));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, REG_WRITE));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND(1, REG_WRITE, TABLE_LED));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND(1, RESET, 0));
    OK(SEND(1, REG_WRITE, TABLE_LED, 1));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND(1, ACTION, 0));
    TEST_ASSERT_EQUAL(1, get(TABLE_REGISTERED));
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
}

static bool hear_damaged(uint8_t id, uint8_t instruction)
{
    static const uint8_t led[] = {TABLE_LED, 1};
    uint8_t packet[16];
    size_t size = build(packet, id, instruction, led, instruction == WRITE ? 2 : 0);
    packet[size - 1] ^= 0x10;
    return hear(packet, size);
}

void test_R19_damaged_packet_is_answered_at_level_2_not_executed(void)
{
    TEST_ASSERT_TRUE(hear_damaged(1, WRITE));
    TEST_ASSERT_EQUAL_HEX8(SERVO_ERROR_CHECKSUM, servo.reply.bytes[4]);
    TEST_ASSERT_EQUAL(6, servo.reply.size);
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
    TEST_ASSERT_TRUE(hear_damaged(1, PING));
    TEST_ASSERT_FALSE(hear_damaged(2, WRITE));
    TEST_ASSERT_FALSE(hear_damaged(ALL, WRITE));
    TEST_ASSERT_FALSE(hear_damaged(ALL, PING));
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
    OK(DO(TABLE_RETURN_LEVEL, 1));
    TEST_ASSERT_FALSE(hear_damaged(1, PING));
}

void test_R27_a_packet_inside_a_damaged_one_is_executed(void)
{
    uint8_t packet[32] = {0xFF, 0xFF, 0x05, 9};
    size_t size = 4 + build(packet + 4, 1, WRITE, (const uint8_t[]){TABLE_LED, 1}, 2);
    packet[size++] = 0;
    TEST_ASSERT_FALSE(hear(packet, size - 1));
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
    TEST_ASSERT_TRUE(servo_receive(&servo, packet[size - 1], false));
    TEST_ASSERT_EQUAL(1, get(TABLE_LED));
}

void test_R27_the_last_reply_counts_when_one_byte_brings_several(void)
{
    uint8_t packet[32] = {0xFF, 0xFF, 0x01,
                          9}; // damaged, for this servo, with a good packet inside
    size_t size = 4 + build(packet + 4, 1, WRITE, (const uint8_t[]){TABLE_LED, 1}, 2);
    packet[size++] = 0;
    TEST_ASSERT_TRUE(hear(packet, size));
    TEST_ASSERT_EQUAL(0, servo.reply.bytes[4]);
}

/* A damaged packet whose LENGTH covers a WRITE. The silence comes before its last byte. */
static uint8_t led_of_a_write_before_silence(uint64_t silence_us)
{
    uint8_t packet[32] = {0xFF, 0xFF, 0x05, 9};
    size_t size = 4 + build(packet + 4, 1, WRITE, (const uint8_t[]){TABLE_LED, 1}, 2);
    servo_init(&servo, 1);
    TEST_ASSERT_FALSE(hear(packet, size));
    servo_silence(&servo, silence_us);
    servo_receive(&servo, 0, false);
    return (uint8_t)get(TABLE_LED);
}

void test_a_write_inside_a_damaged_packet_expires_in_2_ms(void)
{
    TEST_ASSERT_EQUAL(1, led_of_a_write_before_silence(0));
    TEST_ASSERT_EQUAL(1, led_of_a_write_before_silence(SERVO_PAUSE_US - 1));
    TEST_ASSERT_EQUAL(0, led_of_a_write_before_silence(SERVO_PAUSE_US));
    TEST_ASSERT_EQUAL(0, led_of_a_write_before_silence(SERVO_PACKET_TIMEOUT_US));
}

void test_a_packet_that_pauses_for_100_ms_is_dropped(void)
{
    uint8_t packet[16];
    size_t size = build(packet, 1, PING, NULL, 0);
    for (size_t heard = 1; heard < size; heard++) {
        TEST_ASSERT_FALSE(hear(packet, heard));
        servo_silence(&servo, SERVO_PACKET_TIMEOUT_US - 1);
        TEST_ASSERT_TRUE(hear(packet + heard, size - heard));
        TEST_ASSERT_FALSE(hear(packet, heard));
        servo_silence(&servo, SERVO_PACKET_TIMEOUT_US);
        TEST_ASSERT_FALSE(hear(packet + heard, size - heard));
    }
    OK(SEND0(1, PING));
}

void test_a_framing_error_breaks_the_packet(void)
{
    uint8_t packet[16];
    size_t size = build(packet, 1, PING, NULL, 0);
    for (size_t bad = 0; bad < size; bad++) {
        for (size_t i = 0; i < size; i++) {
            TEST_ASSERT_FALSE(servo_receive(&servo, packet[i], i == bad));
        }
        OK(SEND0(1, PING));
    }
}

/* REG WRITE and ACTION. */

void test_R20_action_without_a_registered_write(void)
{
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, ACTION));
    EXPECT(SILENCE, SEND0(ALL, ACTION));
    OK(SEND(1, REG_WRITE, TABLE_LED, 1));
    OK(SEND0(1, ACTION));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, ACTION));
}

void test_R20_no_action_after_reset_and_power_up(void)
{
    OK(SEND(1, REG_WRITE, TABLE_LED, 1));
    OK(SEND0(1, RESET));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, ACTION));
    OK(SEND(1, REG_WRITE, TABLE_LED, 1));
    servo_power(&servo, false);
    servo_power(&servo, true);
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, ACTION));
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
}

void test_R20_a_second_reg_write_replaces_the_first(void)
{
    OK(SEND(1, REG_WRITE, TABLE_LED, 1));
    OK(SEND(1, REG_WRITE, TABLE_CW_MARGIN, 8, 9));
    OK(SEND0(1, ACTION));
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
    TEST_ASSERT_EQUAL(8, get(TABLE_CW_MARGIN));
    TEST_ASSERT_EQUAL(9, get(TABLE_CCW_MARGIN));
}

void test_R21_a_bad_reg_write_registers_nothing(void)
{
    EXPECT(SERVO_ERROR_RANGE, SEND(1, REG_WRITE, TABLE_LED, 2));
    EXPECT(SERVO_ERROR_RANGE, SEND(1, REG_WRITE, TABLE_MOVING, 0));
    EXPECT(SERVO_ERROR_RANGE, SEND(1, REG_WRITE, 50, 0));
    TEST_ASSERT_EQUAL(0, get(TABLE_REGISTERED));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, ACTION));
}

void test_R21_a_bad_reg_write_leaves_the_earlier_one(void)
{
    OK(SEND(1, REG_WRITE, TABLE_LED, 1));
    EXPECT(SERVO_ERROR_RANGE, SEND(1, REG_WRITE, TABLE_LED, 2));
    TEST_ASSERT_EQUAL(1, get(TABLE_REGISTERED));
    OK(SEND0(1, ACTION));
    TEST_ASSERT_EQUAL(1, get(TABLE_LED));
}

void test_R39_writing_0_to_0x2C_discards_the_registered_write(void)
{
    OK(SEND(1, REG_WRITE, TABLE_LED, 1));
    OK(DO(TABLE_REGISTERED, 1));
    OK(DO(TABLE_REGISTERED, 0));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, ACTION));
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
}

void test_R39_writing_1_to_0x2C_with_none_registered_is_refused(void)
{
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_REGISTERED, 1));
    TEST_ASSERT_EQUAL(0, get(TABLE_REGISTERED));
}

void test_R39_reg_write_of_a_goal_outside_the_limits(void)
{
    OK(DO(TABLE_CCW_LIMIT, 0xFF, 0x01));
    EXPECT(SERVO_ERROR_ANGLE, SEND(1, REG_WRITE, TABLE_GOAL_POSITION, 0x00, 0x02));
    TEST_ASSERT_EQUAL(0, get(TABLE_REGISTERED));
}

void test_R39_action_checks_the_limits_again(void)
{
    OK(SEND(1, REG_WRITE, TABLE_GOAL_POSITION, 0x84, 0x03, 0x64, 0x00));
    OK(DO(TABLE_CCW_LIMIT, 0x20, 0x03));
    EXPECT(SERVO_ERROR_ANGLE, SEND0(1, ACTION));
    TEST_ASSERT_EQUAL(512, servo_goal_position(&servo));
    TEST_ASSERT_EQUAL(100, get_word(TABLE_MOVING_SPEED));
    TEST_ASSERT_EQUAL(0, get(TABLE_REGISTERED));
}

void test_R39_action_checks_the_lock_again(void)
{
    OK(SEND(1, REG_WRITE, TABLE_CCW_LIMIT, 0, 2));
    OK(DO(TABLE_LOCK, 1));
    EXPECT(SERVO_ERROR_RANGE, SEND0(1, ACTION));
    TEST_ASSERT_EQUAL(0x3FF, get_word(TABLE_CCW_LIMIT));
}

/* Lock, RESET, power. */

void test_R6_lock_leaves_0x18_to_0x23_only(void)
{
    for (uint8_t address = 0; address < SERVO_REGISTERS; address++) {
        if (highest[address] >= 0) {
            setUp();
            OK(DO(TABLE_LOCK, 1));
            bool open = address >= 0x18 && address <= 0x23;
            EXPECT(open ? 0 : SERVO_ERROR_RANGE, DO(address, 0));
        }
    }
}

void test_R6_the_lock_register_is_locked_until_power_off(void)
{
    OK(DO(TABLE_LOCK, 1));
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_LOCK, 0));
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_LOCK, 1));
    EXPECT(SERVO_ERROR_RANGE, SEND(1, REG_WRITE, TABLE_LOCK, 0));
    OK(SEND(1, READ, TABLE_LOCK, 1));
    TEST_ASSERT_EQUAL(1, servo.reply.bytes[5]);
    servo_power(&servo, false);
    servo_power(&servo, true);
    OK(DO(TABLE_CW_LIMIT, 5, 0));
}

void test_R25_R37_reset(void)
{
    OK(DO(TABLE_ID, 9, 3, 20));
    OK(SEND(9, WRITE, TABLE_CW_LIMIT, 10, 0, 0, 3));
    OK(SEND(9, WRITE, TABLE_HIGHEST_TEMPERATURE, 70, 100, 150, 0, 2, 2, 3, 3, 9));
    OK(SEND(9, WRITE, TABLE_TORQUE_ENABLE, 1, 1, 5, 5, 9, 9, 0, 1, 9, 0, 7, 7));
    OK(SEND(9, WRITE, TABLE_PUNCH, 0, 1));
    OK(SEND(9, REG_WRITE, TABLE_LED, 0));
    OK(SEND0(9, RESET));
    TEST_ASSERT_EQUAL(9, servo.reply.bytes[2]);
    TEST_ASSERT_EQUAL(3, servo.reply.baud);
    TEST_ASSERT_EQUAL(40, servo.reply.delay_us);
    expect_initial_values();
    TEST_ASSERT_EQUAL(SERVO_RESET_BAUD, servo_baud(&servo));
    OK(SEND0(1, PING));
    servo_power(&servo, true);
    expect_initial_values(); // and it lasts
}

void test_R37_reset_while_locked_is_refused(void)
{
    OK(DO(TABLE_ID, 9));
    OK(SEND(9, WRITE, TABLE_LOCK, 1));
    EXPECT(SERVO_ERROR_RANGE, SEND0(9, RESET));
    OK(SEND0(9, PING));
}

void test_R37_reset_in_the_middle_of_a_move_stops_it(void)
{
    DO(TABLE_TORQUE_ENABLE, 1);
    DO(TABLE_GOAL_POSITION, 0, 0);
    ticks(30);
    TEST_ASSERT_EQUAL(1, get(TABLE_MOVING));
    OK(SEND0(1, RESET));
    TEST_ASSERT_EQUAL(0, get(TABLE_MOVING));
    TEST_ASSERT_EQUAL(servo_present_position(&servo), servo_goal_position(&servo));
    TEST_ASSERT_LESS_THAN(500, servo_goal_position(&servo));
    TEST_ASSERT_EQUAL(0, get_word(TABLE_MOVING_SPEED));
}

void test_power_off_keeps_the_eeprom_area(void)
{
    uint8_t before[SERVO_EEPROM_SIZE];
    OK(DO(TABLE_ID, 9, 3, 20, 10, 0, 0, 3));
    OK(SEND(9, WRITE, TABLE_HIGHEST_TEMPERATURE, 70, 100, 150, 0, 2, 1, 3, 3, 9));
    memcpy(before, servo.registers, sizeof before);
    servo_power(&servo, false);
    servo_power(&servo, true);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(before, servo.registers, sizeof before);
    OK(SEND(9, READ, 0, 1));
}

void test_power_up_gives_the_ram_area_its_initial_values(void)
{
    DO(TABLE_TORQUE_ENABLE, 1, 1, 5, 5, 9, 9, 0, 1, 9, 0, 7, 7);
    DO(TABLE_PUNCH, 0, 1);
    SEND(1, REG_WRITE, TABLE_LED, 0);
    servo_power(&servo, false);
    servo_power(&servo, true);
    expect_initial_values();
}

void test_each_register_is_kept_without_power_or_is_not(void)
{
    for (uint8_t address = 0; address < SERVO_REGISTERS; address++) {
        if (highest[address] <= 0) {
            continue; // read only, the second byte of a word, or 0x2C
        }
        unsigned other = address == TABLE_BAUD ? 3 : 0; // unlisted rates have their own test
        unsigned value = get(address) == 1 ? other : 1;
        TEST_ASSERT_EQUAL(0, write_value(address, value) & SERVO_ERROR_RANGE);
        TEST_ASSERT_EQUAL(value, get(address));
        servo_power(&servo, false);
        servo_power(&servo, true);
        if (address < 0x18) {
            TEST_ASSERT_EQUAL(value, get(address));
        } else {
            TEST_ASSERT_NOT_EQUAL(value, get(address));
        }
        setUp();
    }
}

void test_a_READ_of_each_byte_returns_it(void)
{
    for (uint8_t address = 0; address < SERVO_REGISTERS; address++) {
        servo.registers[TABLE_PRESENT_SPEED] = 0x12; // registers that are 0 at rest
        servo.registers[TABLE_PRESENT_LOAD] = 0x34;
        for (uint8_t count = 1; address + count <= SERVO_REGISTERS; count++) {
            OK(SEND(1, READ, address, count));
            TEST_ASSERT_EQUAL(6 + count, servo.reply.size);
            TEST_ASSERT_EQUAL_HEX8_ARRAY(servo.registers + address, servo.reply.bytes + 5, count);
        }
    }
}

void test_without_power_it_hears_and_says_nothing(void)
{
    servo_power(&servo, false);
    EXPECT(SILENCE, SEND0(1, PING));
    EXPECT(SILENCE, DO(TABLE_CW_LIMIT, 5, 0));
    TEST_ASSERT_FALSE(servo_torque(&servo));
    TEST_ASSERT_FALSE(servo_led(&servo));
    servo_power(&servo, true);
    TEST_ASSERT_EQUAL(0, get_word(TABLE_CW_LIMIT));
    OK(SEND0(1, PING));
}

void test_a_packet_begun_before_power_off_is_gone(void)
{
    uint8_t packet[16];
    size_t size = build(packet, 1, PING, NULL, 0);
    hear(packet, size - 1);
    servo_power(&servo, false);
    servo_power(&servo, true);
    TEST_ASSERT_FALSE(servo_receive(&servo, packet[size - 1], false));
}

void test_without_power_the_output_coasts(void)
{
    DO(TABLE_TORQUE_ENABLE, 1);
    DO(TABLE_GOAL_POSITION, 0, 0);
    ticks(30);
    servo_power(&servo, false);
    int32_t cut = servo_position_milliunits(&servo);
    ticks(100);
    int32_t rest = servo_position_milliunits(&servo);
    TEST_ASSERT_LESS_THAN(cut, rest);
    TEST_ASSERT_GREATER_THAN(100000, rest);
    servo_power(&servo, true);
    TEST_ASSERT_EQUAL((rest + 500) / 1000, servo_goal_position(&servo));
    ticks(10);
    TEST_ASSERT_EQUAL(rest, servo_position_milliunits(&servo));
}

void test_R24_an_unlisted_baud_rate_works_until_power_off(void)
{
    static const uint8_t listed[] = {1, 3, 7, 16, 34, 103};
    for (unsigned baud = 0; baud <= 254; baud++) {
        setUp();
        OK(DO(TABLE_BAUD, 7));
        OK(DO(TABLE_BAUD, (uint8_t)baud));
        TEST_ASSERT_EQUAL(baud, servo_baud(&servo));
        servo_power(&servo, false);
        servo_power(&servo, true);
        unsigned expected = memchr(listed, (int)baud, sizeof listed) ? baud : 7;
        TEST_ASSERT_EQUAL(expected, servo_baud(&servo));
        TEST_ASSERT_EQUAL(expected, get(TABLE_BAUD));
    }
}

void test_example_12_max_torque_acts_after_the_next_power_up(void)
{
    servo.environment.load = 700;
    DO(TABLE_TORQUE_ENABLE, 1);
    OK(DO(TABLE_MAX_TORQUE, 0xFF, 0x01));
    ticks(250);
    OK(SEND0(1, PING));
    servo_power(&servo, true);
    DO(TABLE_TORQUE_ENABLE, 1);
    ticks(250);
    EXPECT(SERVO_ERROR_OVERLOAD, SEND0(1, PING));
}

void test_eeprom_comes_back_as_it_was_saved(void)
{
    uint8_t saved[SERVO_EEPROM_SIZE], again[SERVO_EEPROM_SIZE];
    OK(DO(TABLE_ID, 42, 34, 9));
    SEND(42, WRITE, TABLE_BAUD, 50); // unlisted
    SEND(42, WRITE, TABLE_MAX_TORQUE, 0, 1);
    servo_get_eeprom(&servo, saved);
    TEST_ASSERT_EQUAL(34, saved[TABLE_BAUD]);
    servo_init(&servo, 5);
    TEST_ASSERT_TRUE(servo_set_eeprom(&servo, saved));
    servo_get_eeprom(&servo, again);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(saved, again, sizeof saved);
    OK(SEND0(42, PING));
    TEST_ASSERT_EQUAL(34, servo.reply.baud);
    TEST_ASSERT_EQUAL(18, servo.reply.delay_us);
    TEST_ASSERT_EQUAL(256, servo.torque_limit);
}

void test_eeprom_that_no_servo_can_hold_is_refused(void)
{
    static const uint8_t bad[][2] = {{TABLE_ID, 254},         {TABLE_BAUD, 2},
                                     {TABLE_BAUD, 255},       {TABLE_CW_LIMIT + 1, 4},
                                     {TABLE_RETURN_LEVEL, 3}, {TABLE_ALARM_LED, 0x80}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        uint8_t bytes[SERVO_EEPROM_SIZE];
        servo_get_eeprom(&servo, bytes);
        bytes[TABLE_RETURN_DELAY] = 100;
        bytes[bad[i][0]] = bad[i][1];
        TEST_ASSERT_FALSE(servo_set_eeprom(&servo, bytes));
        expect_initial_values();
    }
}

void test_eeprom_does_not_change_read_only_registers(void)
{
    uint8_t bytes[SERVO_EEPROM_SIZE];
    servo_get_eeprom(&servo, bytes);
    bytes[TABLE_MODEL] = 55;
    TEST_ASSERT_TRUE(servo_set_eeprom(&servo, bytes));
    expect_initial_values();
}

void test_eeprom_of_a_servo_without_power(void)
{
    uint8_t bytes[SERVO_EEPROM_SIZE];
    servo_get_eeprom(&servo, bytes);
    bytes[TABLE_ID] = 8;
    servo_power(&servo, false);
    TEST_ASSERT_TRUE(servo_set_eeprom(&servo, bytes));
    EXPECT(SILENCE, SEND0(8, PING));
    servo_power(&servo, true);
    OK(SEND0(8, PING));
}

/* SYNC WRITE. */

void test_R30_example_5_each_servo_takes_its_block(void)
{
    static const uint16_t goals[] = {0x010, 0x220, 0x030, 0x220};
    static const uint16_t speeds[] = {0x150, 0x360, 0x170, 0x380};
    for (uint8_t id = 0; id < 4; id++) { // R30: the fourth is 3
        servo_init(&servo, id);
        EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, 0x1E, 4, 0, 0x10, 0x00, 0x50, 0x01, 1, 0x20, 0x02,
                             0x60, 0x03, 2, 0x30, 0x00, 0x70, 0x01, 3, 0x20, 0x02, 0x80, 0x03));
        TEST_ASSERT_EQUAL_HEX16(goals[id], servo_goal_position(&servo));
        TEST_ASSERT_EQUAL_HEX16(speeds[id], get_word(TABLE_MOVING_SPEED));
    }
}

void test_R22_sync_write_for_others_changes_nothing(void)
{
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_LED, 1, 2, 1, 3, 1));
    expect_initial_values();
}

void test_R22_sync_write_to_one_id_is_an_instruction_error(void)
{
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND(1, SYNC_WRITE, TABLE_LED, 1, 1, 1));
    expect_initial_values();
}

void test_R22_a_refused_block_is_dropped_silently(void)
{
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_TORQUE_ENABLE, 2, 1, 1, 2));
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_MOVING, 1, 1, 0));
    expect_initial_values();
    DO(TABLE_LOCK, 1);
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_CW_LIMIT, 1, 1, 4));
    TEST_ASSERT_EQUAL(0, get(TABLE_CW_LIMIT));
}

void test_R22_the_last_block_of_an_id_wins(void)
{
    SEND(ALL, SYNC_WRITE, TABLE_CW_MARGIN, 1, 1, 10, 2, 20, 1, 30);
    TEST_ASSERT_EQUAL(30, get(TABLE_CW_MARGIN));
    SEND(ALL, SYNC_WRITE, TABLE_LED, 1, 1, 1, 1, 2); // refused: the first value is not stored
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
}

void test_R22_data_that_equals_the_id_is_no_block(void)
{
    SEND(ALL, SYNC_WRITE, TABLE_CW_MARGIN, 2, 5, 1, 99, 7, 1, 98);
    expect_initial_values();
}

void test_R22_the_checksum_is_no_block(void)
{
    for (unsigned data = 0; data <= 255; data++) { // one of them makes the checksum 1
        SEND(ALL, SYNC_WRITE, TABLE_CW_MARGIN, 1, 2, (uint8_t)data);
        expect_initial_values();
    }
}

void test_R23_the_largest_sync_writes(void)
{
    static const uint8_t sizes[][2] = {{4, 50}, {2, 83}, {1, 125}}; // L, N
    for (size_t i = 0; i < 3; i++) {
        uint8_t parameters[252] = {TABLE_CW_MARGIN, sizes[i][0]};
        size_t count = 2;
        for (uint8_t n = 0; n < sizes[i][1]; n++) {
            parameters[count++] = (uint8_t)(n + 100);
            memset(parameters + count, n + 1, sizes[i][0]);
            count += sizes[i][0];
        }
        TEST_ASSERT_LESS_OR_EQUAL(sizeof parameters, count);
        servo_init(&servo, (uint8_t)(99 + sizes[i][1]));
        EXPECT(SILENCE, answer_to(ALL, SYNC_WRITE, parameters, count));
        TEST_ASSERT_EQUAL(sizes[i][1], get(TABLE_CW_MARGIN));
    }
}

void test_R34_a_malformed_sync_write_is_met_with_silence(void)
{
    EXPECT(SILENCE, SEND0(ALL, SYNC_WRITE));
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_LED));
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_LED, 1));
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_LED, 1, 1));
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_LED, 0, 1, 1));
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_LED, 1, 1, 1, 1));
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_LED, 255, 1, 1));
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_LED, 1, 1, 1, 2));
    TEST_ASSERT_EQUAL(SERVO_ERROR_INSTRUCTION, servo_errors(&servo));
    expect_initial_values();
}

void test_R15_sync_write_of_a_goal_outside_the_limits(void)
{
    DO(TABLE_CW_LIMIT, 0, 1);
    EXPECT(SILENCE, SEND(ALL, SYNC_WRITE, TABLE_GOAL_POSITION, 4, 1, 10, 0, 20, 0));
    TEST_ASSERT_EQUAL(512, servo_goal_position(&servo));
    TEST_ASSERT_EQUAL(20, get_word(TABLE_MOVING_SPEED));
}

/* Goals, limits, endless turn. */

void test_R15_goal_outside_limits_is_not_taken_but_speed_is(void)
{
    OK(DO(TABLE_CW_LIMIT, 100, 0, 0x84, 0x03)); // 100..900
    EXPECT(SERVO_ERROR_ANGLE, DO(TABLE_GOAL_POSITION, 99, 0, 0x2C, 0x01));
    TEST_ASSERT_EQUAL(512, servo_goal_position(&servo));
    TEST_ASSERT_EQUAL(300, get_word(TABLE_MOVING_SPEED));
    EXPECT(SERVO_ERROR_ANGLE, DO(TABLE_CW_PROPORTION, 40, 41, 0x85, 0x03));
    TEST_ASSERT_EQUAL(512, servo_goal_position(&servo));
    TEST_ASSERT_EQUAL(41, get(TABLE_CCW_PROPORTION));
}

void test_R15_goals_at_the_limits_are_taken(void)
{
    OK(DO(TABLE_CW_LIMIT, 100, 0, 0x84, 0x03));
    OK(DO(TABLE_GOAL_POSITION, 100, 0));
    TEST_ASSERT_EQUAL(100, servo_goal_position(&servo));
    OK(DO(TABLE_GOAL_POSITION, 0x84, 0x03));
    TEST_ASSERT_EQUAL(900, servo_goal_position(&servo));
}

void test_R15_a_lone_byte_of_a_goal_is_judged_too(void)
{
    OK(DO(TABLE_CW_LIMIT, 0, 1, 0, 3));
    EXPECT(SERVO_ERROR_ANGLE, DO(TABLE_GOAL_POSITION + 1, 0));
    TEST_ASSERT_EQUAL(512, servo_goal_position(&servo));
    OK(DO(TABLE_CW_LIMIT, 0, 2, 0, 3));
    OK(DO(TABLE_CW_LIMIT, 1, 2));  // 513: the goal of 512 is outside now
    OK(DO(TABLE_MOVING_SPEED, 5)); // a write that does not touch the goal is allowed
    OK(DO(TABLE_CCW_PROPORTION, 5));
}

void test_R33_cw_limit_above_ccw_limit_leaves_no_goal(void)
{
    OK(DO(TABLE_CW_LIMIT, 0, 3, 0, 1));
    TEST_ASSERT_EQUAL_HEX16(0x300, get_word(TABLE_CW_LIMIT));
    for (unsigned goal = 0; goal <= 0x3FF; goal++) {
        EXPECT(SERVO_ERROR_ANGLE, DO(TABLE_GOAL_POSITION, (uint8_t)goal, (uint8_t)(goal >> 8)));
    }
}

void test_R16_endless_turn_ignores_the_goal_has_a_direction_bit(void)
{
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_MOVING_SPEED, 0, 4));
    OK(DO(TABLE_CCW_LIMIT, 0, 0));
    OK(DO(TABLE_GOAL_POSITION, 0, 1));
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    ticks(50);
    TEST_ASSERT_EQUAL(512, servo_present_position(&servo));
    OK(DO(TABLE_MOVING_SPEED, 200, 4));
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_MOVING_SPEED, 0, 8));
    ticks(50);
    TEST_ASSERT_EQUAL_HEX16(0x400 | 200, get_word(TABLE_PRESENT_SPEED));
    OK(DO(TABLE_MOVING_SPEED, 0xFF, 3));
    ticks(100);
    TEST_ASSERT_EQUAL_HEX16(0x3FF, get_word(TABLE_PRESENT_SPEED));
    OK(DO(TABLE_MOVING_SPEED, 0xFF, 7));
    ticks(150);
    TEST_ASSERT_EQUAL_HEX16(0x7FF, get_word(TABLE_PRESENT_SPEED));
}

void test_R16_one_limit_of_0_is_no_endless_turn(void)
{
    OK(DO(TABLE_CCW_LIMIT, 1, 0));
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_MOVING_SPEED, 0, 4));
    EXPECT(SERVO_ERROR_ANGLE, DO(TABLE_GOAL_POSITION, 2, 0));
    OK(DO(TABLE_CCW_LIMIT, 0xFF, 3));
    OK(DO(TABLE_CW_LIMIT, 1, 0));
    EXPECT(SERVO_ERROR_ANGLE, DO(TABLE_GOAL_POSITION, 0, 0));
    OK(DO(TABLE_CCW_LIMIT, 0, 0));
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_MOVING_SPEED, 0, 4));
    EXPECT(SERVO_ERROR_ANGLE, DO(TABLE_GOAL_POSITION, 0, 0));
}

void test_R40_moving_in_endless_turn(void)
{
    OK(DO(TABLE_CCW_LIMIT, 0, 0));
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    OK(DO(TABLE_MOVING_SPEED, 0, 4)); // CW at 0
    ticks(1);
    TEST_ASSERT_EQUAL(0, get(TABLE_MOVING));
    OK(DO(TABLE_MOVING_SPEED, 1, 0));
    ticks(1);
    TEST_ASSERT_EQUAL(1, get(TABLE_MOVING));
}

void test_R29_goals_and_present_values_change_with_the_tick(void)
{
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    OK(DO(TABLE_GOAL_POSITION, 0, 0));
    servo.environment.supply_dV = 100;
    TEST_ASSERT_EQUAL(0, get(TABLE_MOVING));
    TEST_ASSERT_EQUAL(120, get(TABLE_PRESENT_VOLTAGE));
    servo_tick(&servo);
    TEST_ASSERT_EQUAL(1, get(TABLE_MOVING));
    TEST_ASSERT_EQUAL(100, get(TABLE_PRESENT_VOLTAGE));
}

void test_R31_a_goal_without_torque_is_followed_once_torque_is_on(void)
{
    OK(DO(TABLE_GOAL_POSITION, 0x84, 0x03));
    ticks(250);
    TEST_ASSERT_EQUAL(512, servo_present_position(&servo));
    TEST_ASSERT_EQUAL(0, get(TABLE_MOVING));
    TEST_ASSERT_EQUAL(900, servo_goal_position(&servo));
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    ticks(250);
    TEST_ASSERT_INT_WITHIN(2, 900, servo_present_position(&servo));
}

void test_R32_moving_until_within_the_margin(void)
{
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    OK(DO(TABLE_CW_MARGIN, 10, 10));
    OK(DO(TABLE_GOAL_POSITION, 0, 0));
    for (int i = 0; i < 500; i++) {
        uint16_t before = servo_present_position(&servo);
        servo_tick(&servo);
        if (before > 11) {
            TEST_ASSERT_EQUAL(1, get(TABLE_MOVING));
        } else if (before < 10) {
            TEST_ASSERT_EQUAL(0, get(TABLE_MOVING));
        }
    }
    TEST_ASSERT_LESS_OR_EQUAL(10, servo_present_position(&servo));
}

void test_R8_R9_R35_more_is_ccw_and_0x3FF_is_300_degrees(void)
{
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    OK(DO(TABLE_CW_MARGIN, 0, 0));
    OK(DO(TABLE_GOAL_POSITION, 0xFF, 0x03));
    ticks(20);
    TEST_ASSERT_BITS(0x400, 0, get_word(TABLE_PRESENT_SPEED));
    ticks(400);
    TEST_ASSERT_EQUAL(1023000, servo_position_milliunits(&servo));
    TEST_ASSERT_EQUAL(1023, servo_present_position(&servo));
    OK(DO(TABLE_GOAL_POSITION, 0, 0));
    ticks(20);
    TEST_ASSERT_BITS(0x400, 0x400, get_word(TABLE_PRESENT_SPEED));
    ticks(400);
    TEST_ASSERT_EQUAL(0, servo_position_milliunits(&servo));
}

void test_every_motor_register_reaches_the_motor(void)
{
    /* Each change alone changes the same move or the same load. */
    static const uint8_t changes[][3] = {
        {TABLE_CW_MARGIN, 100, 0},   {TABLE_CCW_MARGIN, 100, 0},
        {TABLE_CW_PROPORTION, 1, 0}, {TABLE_CCW_PROPORTION, 1, 0},
        {TABLE_MOVING_SPEED, 50, 1}, {TABLE_ACC, 1, 0},
        {TABLE_DCC, 1, 0},           {TABLE_PUNCH, 0, 1},
    };
    int32_t usual = 0;
    for (size_t i = 0; i <= sizeof changes / sizeof changes[0]; i++) {
        int32_t way = 0;
        setUp();
        if (i > 0) {
            const uint8_t *row = changes[i - 1];
            OK(row[2] ? DO(row[0], row[1], (uint8_t)(row[2] - 1)) : DO(row[0], row[1]));
        }
        OK(DO(TABLE_TORQUE_ENABLE, 1));
        OK(DO(TABLE_GOAL_POSITION, 0x50, 0x02)); // CCW to 592, then CW
        for (int tick = 0; tick < 400; tick++) {
            servo_tick(&servo);
            way += servo_position_milliunits(&servo) / 100;
            if (tick == 200) {
                OK(DO(TABLE_GOAL_POSITION, 0xB0, 0x01));
            }
        }
        if (i == 0) {
            usual = way;
        } else {
            TEST_ASSERT_NOT_EQUAL(usual, way);
        }
    }
}

/* Conditions and alarms, each by its physical cause. */

static void heat(uint8_t ambient_C)
{
    servo.environment.ambient_C = ambient_C;
    ticks(60000);
}

void test_R18_voltage_out_of_the_limits(void)
{
    static const struct {
        uint8_t supply_dV;
        int error;
    } rows[] = {{60, 0}, {59, SERVO_ERROR_VOLTAGE}, {160, 0}, {161, SERVO_ERROR_VOLTAGE}, {120, 0}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        servo.environment.supply_dV = rows[i].supply_dV;
        servo_tick(&servo);
        EXPECT(rows[i].error, SEND0(1, PING));
        EXPECT(rows[i].error, SEND(1, READ, TABLE_PRESENT_VOLTAGE, 1));
        TEST_ASSERT_EQUAL(rows[i].supply_dV, servo.reply.bytes[5]); // an error, with data
        TEST_ASSERT_EQUAL(rows[i].error, servo_errors(&servo));
    }
}

void test_R18_new_voltage_limits_hold_at_once(void)
{
    EXPECT(SERVO_ERROR_VOLTAGE, DO(TABLE_LOWEST_VOLTAGE, 130));
    OK(DO(TABLE_LOWEST_VOLTAGE, 120));
    EXPECT(SERVO_ERROR_VOLTAGE, DO(TABLE_HIGHEST_VOLTAGE, 119));
}

void test_R18_overheating(void)
{
    heat(81);
    EXPECT(0, SEND0(1, PING)); // 80 is the limit and not above it
    heat(82);
    TEST_ASSERT_EQUAL(81, get(TABLE_PRESENT_TEMPERATURE));
    EXPECT(SERVO_ERROR_OVERHEATING, SEND0(1, PING));
    heat(40);
    OK(SEND0(1, PING));
}

void test_R18_overheating_by_its_own_torque(void)
{
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    servo.environment.load = 900;
    ticks(60000);
    TEST_ASSERT_FALSE(servo_torque(&servo)); // shut down by the factory mask
    TEST_ASSERT_EQUAL(0, get(TABLE_TORQUE_ENABLE));
}

void test_R18_overload(void)
{
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    servo.environment.load = 1100;
    ticks(100);
    EXPECT(SERVO_ERROR_OVERLOAD, SEND0(1, PING));
    servo.environment.load = 0;
    ticks(1);
    OK(SEND0(1, PING));
}

void test_R18_conditions_and_packet_errors_are_reported_together(void)
{
    servo.environment.supply_dV = 50;
    ticks(1);
    EXPECT(SERVO_ERROR_VOLTAGE | SERVO_ERROR_RANGE, DO(TABLE_LED, 2));
    EXPECT(SERVO_ERROR_VOLTAGE | SERVO_ERROR_INSTRUCTION, SEND0(1, 0x77));
    TEST_ASSERT_TRUE(hear_damaged(1, PING));
    TEST_ASSERT_EQUAL(SERVO_ERROR_VOLTAGE | SERVO_ERROR_CHECKSUM, servo.reply.bytes[4]);
}

void test_R18_packet_errors_report_one_packet(void)
{
    EXPECT(SERVO_ERROR_RANGE, DO(TABLE_LED, 2));
    OK(SEND0(1, PING));
    EXPECT(SERVO_ERROR_INSTRUCTION, SEND0(1, ACTION));
    OK(SEND0(1, PING));
}

static int provoke(uint8_t bit)
{
    DO(TABLE_TORQUE_ENABLE, 1);
    switch (bit) {
    case SERVO_ERROR_VOLTAGE:
        servo.environment.supply_dV = 200;
        ticks(1);
        break;
    case SERVO_ERROR_ANGLE:
        DO(TABLE_CCW_LIMIT, 100, 0);
        DO(TABLE_GOAL_POSITION, 101, 0);
        break;
    case SERVO_ERROR_OVERHEATING: heat(90); break;
    case SERVO_ERROR_RANGE: DO(TABLE_LED, 2); break;
    case SERVO_ERROR_CHECKSUM: hear_damaged(1, PING); break;
    case SERVO_ERROR_OVERLOAD:
        servo.environment.load = 1100;
        ticks(100);
        break;
    default: SEND0(1, 0x77); break;
    }
    return servo_errors(&servo);
}

static bool blinks(void)
{
    bool said = servo_lamp(&servo) == SERVO_LAMP_BLINKING;
    int lit = 0;
    for (int i = 0; i < 250; i++) {
        servo_tick(&servo);
        lit += servo_led(&servo);
    }
    TEST_ASSERT_TRUE(lit == 0 || lit == 250 || (lit > 80 && lit < 170));
    TEST_ASSERT_EQUAL(said, lit != 0 && lit != 250);
    return said;
}

void test_R17_each_alarm_bit_blinks_for_its_error_only(void)
{
    for (unsigned bit = 0; bit < 7; bit++) {
        for (unsigned mask = 0; mask < 7; mask++) {
            setUp();
            OK(DO(TABLE_ALARM_LED, (uint8_t)(1u << mask), 0));
            TEST_ASSERT_EQUAL(1 << bit, provoke((uint8_t)(1u << bit)));
            TEST_ASSERT_EQUAL(bit == mask, blinks());
        }
    }
}

void test_R17_the_led_blinks_as_long_as_the_condition_lasts(void)
{
    OK(DO(TABLE_LED, 1));
    TEST_ASSERT_TRUE(servo_led(&servo));
    provoke(SERVO_ERROR_VOLTAGE);
    TEST_ASSERT_TRUE(blinks());
    servo.environment.supply_dV = 120;
    ticks(1);
    TEST_ASSERT_FALSE(blinks());
    TEST_ASSERT_TRUE(servo_led(&servo));
    OK(DO(TABLE_LED, 0));
    TEST_ASSERT_FALSE(servo_led(&servo));
}

void test_R17_each_shutdown_bit_acts_for_its_error_only(void)
{
    for (unsigned bit = 0; bit < 7; bit++) {
        for (unsigned mask = 0; mask < 7; mask++) {
            setUp();
            OK(DO(TABLE_ALARM_SHUTDOWN, (uint8_t)(1u << mask)));
            provoke((uint8_t)(1u << bit));
            bool off = bit == mask && bit != 5; // an overload only lowers the torque
            TEST_ASSERT_EQUAL(!off, servo_torque(&servo));
        }
    }
}

void test_R17_torque_stays_off_until_it_is_enabled_again(void)
{
    OK(DO(TABLE_ALARM_SHUTDOWN, SERVO_ERROR_VOLTAGE));
    provoke(SERVO_ERROR_VOLTAGE);
    servo.environment.supply_dV = 120;
    ticks(10);
    OK(SEND0(1, PING));
    TEST_ASSERT_FALSE(servo_torque(&servo));
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    ticks(10);
    TEST_ASSERT_TRUE(servo_torque(&servo));
}

void test_R36_torque_goes_off_at_once_while_a_condition_lasts(void)
{
    provoke(SERVO_ERROR_OVERHEATING);
    TEST_ASSERT_FALSE(servo_torque(&servo));
    EXPECT(SERVO_ERROR_OVERHEATING, DO(TABLE_TORQUE_ENABLE, 1));
    TEST_ASSERT_EQUAL(0, get(TABLE_TORQUE_ENABLE));
}

void test_R36_a_packet_error_alarms_until_the_next_good_packet(void)
{
    OK(DO(TABLE_ALARM_LED, 0x7F, 0));
    TEST_ASSERT_TRUE(hear_damaged(1, PING));
    ticks(1000);
    TEST_ASSERT_TRUE(blinks());
    SEND0(2, PING); // for another servo
    TEST_ASSERT_TRUE(blinks());
    SEND(ALL, SYNC_WRITE, TABLE_LED, 1, 2, 1);
    TEST_ASSERT_FALSE(blinks());
    hear_damaged(ALL, WRITE);
    TEST_ASSERT_TRUE(blinks());
    OK(SEND0(1, PING));
    TEST_ASSERT_FALSE(blinks());
}

void test_R36_a_damaged_packet_shuts_down_at_once(void)
{
    OK(DO(TABLE_ALARM_SHUTDOWN, SERVO_ERROR_CHECKSUM));
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    hear_damaged(1, PING);
    TEST_ASSERT_EQUAL(0, get(TABLE_TORQUE_ENABLE));
}

void test_R36_overload_lowers_torque_to_20_percent(void)
{
    provoke(SERVO_ERROR_OVERLOAD);
    ticks(100);
    TEST_ASSERT_EQUAL_HEX16(0x400 | 204, get_word(TABLE_PRESENT_LOAD));
    TEST_ASSERT_TRUE(servo_torque(&servo));
}

void test_R36_max_torque_0_is_free_run(void)
{
    OK(DO(TABLE_MAX_TORQUE, 0, 0));
    servo_power(&servo, true);
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    OK(DO(TABLE_GOAL_POSITION, 0, 0));
    ticks(250);
    TEST_ASSERT_EQUAL(512, servo_present_position(&servo));
    TEST_ASSERT_FALSE(servo_torque(&servo));
}

void test_power_up_ends_an_overload(void)
{
    provoke(SERVO_ERROR_OVERLOAD);
    servo_power(&servo, true);
    OK(SEND0(1, PING));
    TEST_ASSERT_EQUAL(0, get(TABLE_MOVING));
    TEST_ASSERT_EQUAL(0, get_word(TABLE_PRESENT_LOAD));
    OK(DO(TABLE_TORQUE_ENABLE, 1));
    OK(DO(TABLE_GOAL_POSITION, 0xFF, 3));
    ticks(24); // again 100 ms of stall
    OK(SEND0(1, PING));
}

void test_R36_power_up_ends_a_packet_error(void)
{
    hear_damaged(1, PING);
    servo_power(&servo, true);
    TEST_ASSERT_EQUAL(0, servo_errors(&servo));
}

/* Differences of real servos. */

void test_quirk_silent_for_1_s_after_power_up(void)
{
    servo.quirks.silent_after_power_up = true;
    ticks(500);
    servo_power(&servo, true);
    ticks(249);
    EXPECT(SILENCE, SEND0(1, PING));
    EXPECT(SILENCE, DO(TABLE_LED, 1));
    ticks(1);
    OK(SEND0(1, PING));
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
}

void test_quirk_extra_turnaround(void)
{
    servo.quirks.extra_turnaround_us = 65535;
    OK(DO(TABLE_RETURN_DELAY, 254));
    OK(SEND0(1, PING));
    TEST_ASSERT_EQUAL(508 + 65535, servo.reply.delay_us);
}

void test_quirk_jitter_stays_in_bounds_and_repeats_with_its_seed(void)
{
    uint32_t first[200];
    bool seen[11] = {false};
    for (int run = 0; run < 2; run++) {
        setUp();
        servo.quirks.jitter_us = 10;
        servo.quirks.seed = 4711;
        for (int i = 0; i < 200; i++) {
            OK(SEND0(1, PING));
            uint32_t jitter = servo.reply.delay_us - 2;
            TEST_ASSERT_LESS_OR_EQUAL(10, jitter);
            seen[jitter] = true;
            if (run == 0) {
                first[i] = jitter;
            } else {
                TEST_ASSERT_EQUAL(first[i], jitter);
            }
        }
    }
    for (int i = 0; i <= 10; i++) {
        TEST_ASSERT_TRUE(seen[i]);
    }
}

void test_quirk_sync_write_limit_of_143_bytes(void)
{
    uint8_t parameters[252] = {TABLE_LED, 1};
    for (int i = 0; i < 2 * 70; i += 2) {
        parameters[2 + i] = (uint8_t)(i == 0 ? 1 : 50);
        parameters[3 + i] = 1;
    }
    servo.quirks.sync_write_limit = true;
    EXPECT(SILENCE, answer_to(ALL, SYNC_WRITE, parameters, 2 + 2 * 68)); // 144 bytes
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
    answer_to(ALL, SYNC_WRITE, parameters, 2 + 2 * 67); // 142 bytes
    TEST_ASSERT_EQUAL(1, get(TABLE_LED));
    servo.quirks.sync_write_limit = false;
    parameters[3] = 0;
    answer_to(ALL, SYNC_WRITE, parameters, 2 + 2 * 68);
    TEST_ASSERT_EQUAL(0, get(TABLE_LED));
}

void test_quirk_sync_write_limit_is_exactly_143(void)
{
    uint8_t parameters[252] = {TABLE_CW_MARGIN, 2};
    parameters[2] = 1;
    memset(parameters + 3, 7, sizeof parameters - 3);
    servo.quirks.sync_write_limit = true;
    answer_to(ALL, SYNC_WRITE, parameters, 2 + 3 * 45); // 143 bytes
    TEST_ASSERT_EQUAL(7, get(TABLE_CW_MARGIN));
}

void test_quirks_are_off_at_first(void)
{
    for (uint8_t id = 0; id < ALL; id++) {
        servo_init(&servo, id);
        TEST_ASSERT_NOT_EQUAL(0, servo.quirks.seed);
    }
    setUp();
    OK(SEND0(1, PING));
    TEST_ASSERT_EQUAL(2, servo.reply.delay_us);
    servo_power(&servo, true);
    OK(SEND0(1, PING));
}

/* Random bytes never write a value outside the table's ranges. */
void test_noise_leaves_a_valid_table(void)
{
    uint32_t noise = 1;
    for (int round = 0; round < 20000; round++) {
        uint8_t parameters[8];
        for (size_t i = 0; i < sizeof parameters; i++) {
            noise = noise * 1664525u + 1013904223u;
            parameters[i] = (uint8_t)(noise >> 24) >> (noise >> 13 & 7);
        }
        noise = noise * 1664525u + 1013904223u;
        uint8_t instruction = (uint8_t)(noise >> 28);
        answer_to(servo.registers[TABLE_ID], instruction == 7 ? SYNC_WRITE : instruction,
                  parameters, noise >> 20 & 7);
        ticks(1);
        for (int i = 0; i < SERVO_REGISTERS; i++) {
            if (highest[i] >= 0 && i != TABLE_MOVING_SPEED && i != TABLE_REGISTERED) {
                unsigned value = highest[i] > 255 ? get_word((uint8_t)i) : get((uint8_t)i);
                TEST_ASSERT_LESS_OR_EQUAL(highest[i], value);
            }
        }
        if (round % 100 == 0) {
            servo_power(&servo, true);
        }
    }
}
