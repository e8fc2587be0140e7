/* SPDX-License-Identifier: MIT */
/* Building packets: the manual's own, the bounds, and no byte past a buffer. */
#include "cds55xx/packet.h"

#include <stdbool.h>
#include <string.h>

#include "cds55xx/control_table.h"
#include "packets.h"
#include "unity.h"

#define CANARY 0xA5

/* A buffer of which a test lends the first `capacity` bytes; the other bytes must stay as they are.
 */
static uint8_t buffer[264];
static struct cds_packet packet;

static void lend(uint16_t capacity)
{
    memset(buffer, CANARY, sizeof buffer);
    packet = (struct cds_packet){.bytes = buffer, .capacity = capacity};
}

static void assert_nothing_past(uint16_t capacity)
{
    for (uint16_t i = capacity; i < sizeof buffer; i++)
        TEST_ASSERT_EQUAL_HEX8(CANARY, buffer[i]);
}

void setUp(void)
{
    lend(258);
}

void tearDown(void)
{
    assert_nothing_past(packet.capacity);
}

static const uint8_t blocks[] = {
    0, 0x10, 0x00, 0x50, 0x01, 1, 0x20, 0x02, 0x60, 0x03,
    2, 0x30, 0x00, 0x70, 0x01, 3, 0x20, 0x02, 0x80, 0x03,
};

static enum cds_result build_example_5(void)
{
    enum cds_result result = cds_packet_sync_begin(&packet, 0x1E, 4);

    for (uint8_t i = 0; i < sizeof blocks; i = (uint8_t)(i + 5))
        cds_packet_sync_add(&packet, blocks[i], blocks + i + 1);
    return result == CDS_OK ? cds_packet_end(&packet) : result;
}

/* What the manual's examples ask for, by their words: instruction, ID, address, data. */
static const struct call {
    uint8_t instruction;
    uint8_t id;
    uint8_t address;
    uint8_t length;
    uint8_t data[4];
} calls[] = {
    {CDS_WRITE, 0xFE, 0x03, 1, {1}},
    {CDS_READ, 1, 0x2B, 1, {0}},
    {CDS_PING, 1, 0, 0, {0}},
    {CDS_RESET, 0, 0, 0, {0}},
    {CDS_SYNC_WRITE, 0xFE, 0x1E, 4, {0}},
    {CDS_WRITE, 1, 0x03, 1, {0}},
    {CDS_WRITE, 0, 0x04, 1, {1}},
    {CDS_WRITE, 0, 0x05, 1, {2}},
    {CDS_WRITE, 0, 0x08, 2, {0xFF, 0x01}},
    {CDS_WRITE, 0, 0x0B, 1, {80}},
    {CDS_WRITE, 0, 0x0C, 2, {100, 170}},
    {CDS_WRITE, 0, 0x0E, 2, {0xFF, 0x01}},
    {CDS_WRITE, 0, 0x10, 1, {0}},
    {CDS_WRITE, 0, 0x11, 2, {4, 4}},
    {CDS_WRITE, 0, 0x18, 2, {1, 1}},
    {CDS_WRITE, 0, 0x1E, 4, {0x00, 0x02, 0x00, 0x02}},
    {CDS_REG_WRITE, 0, 0x1E, 2, {0, 0}},
    {CDS_REG_WRITE, 1, 0x1E, 2, {0xFF, 0x03}},
    {CDS_ACTION, 0xFE, 0, 0, {0}},
    {CDS_WRITE, 0, 0x2F, 1, {1}},
    {CDS_WRITE, 0, 0x30, 2, {0x40, 0x00}},
    {CDS_WRITE, 0, 0x30, 2, {0x40, 0x00}},
};

static enum cds_result build(const struct call *call)
{
    switch (call->instruction) {
    case CDS_PING: return cds_packet_ping(&packet, call->id);
    case CDS_READ: return cds_packet_read(&packet, call->id, call->address, call->length);
    case CDS_WRITE:
        return cds_packet_write(&packet, call->id, call->address, call->data, call->length);
    case CDS_REG_WRITE:
        return cds_packet_reg_write(&packet, call->id, call->address, call->data, call->length);
    case CDS_ACTION: return cds_packet_action(&packet, call->id);
    case CDS_RESET: return cds_packet_reset(&packet, call->id);
    default: return build_example_5();
    }
}

void test_every_instruction_of_the_manual_byte_for_byte(void)
{
    uint8_t made = 0;

    for (uint8_t i = 0; i < MANUAL_PACKETS; i++) {
        const struct manual_packet *wanted = &manual_packets[i];

        if (wanted->sender != CONTROLLER)
            continue;
        TEST_ASSERT_TRUE(made < sizeof calls / sizeof calls[0]);
        lend(wanted->size); // and not a byte more
        TEST_ASSERT_EQUAL(CDS_OK, build(&calls[made++]));
        TEST_ASSERT_EQUAL_UINT16(wanted->size, packet.size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(wanted->bytes, buffer, wanted->size);
        assert_nothing_past(wanted->size);
    }
    TEST_ASSERT_EQUAL_UINT8(MANUAL_INSTRUCTIONS, made);
    TEST_ASSERT_EQUAL_UINT8(sizeof calls / sizeof calls[0], made);
}

void test_buffer_one_byte_short_is_refused_for_every_instruction(void)
{
    uint8_t made = 0;

    for (uint8_t i = 0; i < MANUAL_PACKETS; i++) {
        if (manual_packets[i].sender != CONTROLLER)
            continue;
        lend((uint16_t)(manual_packets[i].size - 1));
        TEST_ASSERT_EQUAL(CDS_NO_ROOM, build(&calls[made++]));
        assert_nothing_past(packet.capacity);
    }
}

void test_buffer_of_no_bytes_takes_none(void)
{
    lend(0);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_packet_ping(&packet, 1));
    assert_nothing_past(0);
}

void test_checksum_of_every_manual_packet(void)
{
    for (uint8_t i = 0; i < MANUAL_PACKETS; i++) {
        const struct manual_packet *known = &manual_packets[i];

        TEST_ASSERT_EQUAL_HEX8(known->bytes[known->size - 1], cds_packet_checksum(known->bytes));
    }
}

/* Twice 0xFF among the data: the sum passes 255 more than once, and only its low byte counts. */
void test_checksum_keeps_the_low_byte_of_a_long_sum(void)
{
    static const uint8_t data[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF};

    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_write(&packet, 0xFD, 0x18, data, sizeof data));
    // FD + 08 + 03 + 18 + 5 x FF = 0x61B
    TEST_ASSERT_EQUAL_HEX8(0xE4, buffer[packet.size - 1]);
}

void test_length_counts_what_follows_it(void)
{
    static const uint8_t data[3] = {1, 2, 3};

    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_write(&packet, 1, 0x18, data, 3));
    TEST_ASSERT_EQUAL_UINT8(6, buffer[CDS_AT_LENGTH]);
    TEST_ASSERT_EQUAL_UINT16(4 + 6, packet.size);
}

void test_word_goes_low_byte_first(void)
{
    cds_packet_begin(&packet, 1, CDS_WRITE);
    cds_packet_put(&packet, 0x1E);
    cds_packet_put_word(&packet, 0x0312);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&packet));
    TEST_ASSERT_EQUAL_HEX8(0x12, buffer[6]);
    TEST_ASSERT_EQUAL_HEX8(0x03, buffer[7]);
}

void test_packet_can_be_built_anew_over_an_old_one(void)
{
    build_example_5();
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&packet, 1));
    TEST_ASSERT_EQUAL_UINT16(6, packet.size);
    TEST_ASSERT_EQUAL_HEX8(0xFB, buffer[5]);
}

void test_every_servo_id_can_be_pinged(void)
{
    for (uint16_t id = 0; id <= CDS_ID_MAX; id++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&packet, (uint8_t)id));
        TEST_ASSERT_EQUAL_HEX8(id, buffer[CDS_AT_ID]);
        TEST_ASSERT_EQUAL_HEX8(0xFF & ~(id + 3), buffer[5]);
    }
}

void test_broadcast_is_allowed_for_all_but_read(void)
{
    static const uint8_t one = 1;

    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&packet, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_write(&packet, CDS_BROADCAST_ID, 0x18, &one, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_reg_write(&packet, CDS_BROADCAST_ID, 0x18, &one, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_action(&packet, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_reset(&packet, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_read(&packet, CDS_BROADCAST_ID, 0x18, 1));
}

/* 0xFF as an ID would be read as header (R27). */
void test_id_ff_is_refused_by_every_instruction(void)
{
    for (uint8_t i = 0; i < sizeof calls / sizeof calls[0]; i++) {
        struct call call = calls[i];

        if (call.instruction == CDS_SYNC_WRITE) // always broadcast
            continue;
        call.id = 0xFF;
        TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, build(&call));
    }
}

void test_last_id_can_be_read(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_read(&packet, 253, 0x24, 2));
    TEST_ASSERT_EQUAL_HEX8(0xFD, buffer[CDS_AT_ID]);
}

/* Whatever starts and ends within 0x00 to 0x31 is allowed, and nothing else. */
void test_read_bounds_are_the_control_table(void)
{
    uint16_t wrong = 0; // asserting 65536 times takes the AVR too long

    for (uint16_t address = 0; address < 256; address++)
        for (uint16_t length = 0; length < 256; length++) {
            bool inside = length > 0 && address + length <= 50;
            enum cds_result result = cds_packet_read(&packet, 1, (uint8_t)address, (uint8_t)length);

            if (result != (inside ? CDS_OK : CDS_BAD_ARGUMENT))
                wrong++;
        }
    TEST_ASSERT_EQUAL_UINT16(0, wrong);
}

void test_write_bounds_are_the_control_table(void)
{
    static const uint8_t data[50];

    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_write(&packet, 1, 0x00, data, 50));
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_write(&packet, 1, 0x31, data, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_write(&packet, 1, 0x00, data, 51));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_write(&packet, 1, 0x31, data, 2));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_write(&packet, 1, 0x32, data, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_write(&packet, 1, 0xFF, data, 2));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_write(&packet, 1, 0x18, data, 0));
}

void test_reg_write_bounds_are_the_control_table(void)
{
    static const uint8_t data[50];

    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_reg_write(&packet, 1, 0x00, data, 50));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_reg_write(&packet, 1, 0x01, data, 50));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_reg_write(&packet, 1, 0x18, data, 0));
}

void test_sync_write_bounds_are_the_control_table(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_sync_begin(&packet, 0x1E, 20));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_sync_begin(&packet, 0x1E, 21));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_sync_begin(&packet, 0x1E, 0));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_sync_begin(&packet, 0x32, 1));
}

static enum cds_result sync_of(uint8_t servos, uint8_t length)
{
    static const uint8_t data[4] = {1, 2, 3, 4};

    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_sync_begin(&packet, 0x18, length));
    for (uint8_t i = 0; i < servos; i++)
        cds_packet_sync_add(&packet, i, data);
    return cds_packet_end(&packet);
}

/* (L + 1) x N + 4 fits a byte up to 254 (R23): just so for L = 1 with 125 servos ... */
void test_sync_write_of_length_254_is_the_longest(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, sync_of(125, 1));
    TEST_ASSERT_EQUAL_UINT8(254, buffer[CDS_AT_LENGTH]);
    TEST_ASSERT_EQUAL_UINT16(258, packet.size);
    TEST_ASSERT_EQUAL_UINT16(258, CDS_SYNC_WRITE_SIZE(125, 1));
    TEST_ASSERT_EQUAL_HEX8(buffer[257], cds_packet_checksum(buffer));
}

/* ... and one byte more is too long, however large the buffer. */
void test_sync_write_of_length_255_is_refused(void)
{
    lend(264);
    cds_packet_begin(&packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
    for (uint8_t i = 0; i < 253; i++)
        cds_packet_put(&packet, i);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_packet_end(&packet));
}

void test_sync_write_of_50_times_4_fits_and_51_do_not(void)
{
    lend(264);
    TEST_ASSERT_EQUAL(CDS_OK, sync_of(50, 4));
    TEST_ASSERT_EQUAL_UINT8(254, buffer[CDS_AT_LENGTH]);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, sync_of(51, 4));
}

void test_sync_write_of_83_times_2_fits_and_84_do_not(void)
{
    lend(264);
    TEST_ASSERT_EQUAL(CDS_OK, sync_of(83, 2));
    TEST_ASSERT_EQUAL_UINT8(253, buffer[CDS_AT_LENGTH]);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, sync_of(84, 2));
}

/* 102 blocks of 5 bytes: LENGTH would be 514, which in 8 bits looks like a good 2. */
void test_length_that_wraps_in_8_bits_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, sync_of(102, 4));
    assert_nothing_past(258);
}

/* Parameter by parameter, with space behind it: 252 are the most, and the sum counts them all. */
void test_longest_packet_has_252_parameters(void)
{
    lend(264);
    for (uint8_t count = 253; count >= 252; count--) {
        cds_packet_begin(&packet, 1, CDS_WRITE);
        for (uint8_t i = 0; i < count; i++)
            cds_packet_put(&packet, i);
        TEST_ASSERT_EQUAL(count > 252 ? CDS_NO_ROOM : CDS_OK, cds_packet_end(&packet));
    }
    TEST_ASSERT_EQUAL_HEX8(254, buffer[CDS_AT_LENGTH]);
    TEST_ASSERT_EQUAL_HEX8(cds_packet_checksum(buffer), buffer[257]);
}

/* And so many bytes that 16 bits would wrap to a length that fits. */
void test_length_that_wraps_in_16_bits_is_refused(void)
{
    cds_packet_begin(&packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
    for (uint32_t i = 0; i < 65536; i++)
        cds_packet_put(&packet, 0);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_packet_end(&packet));
}

void test_block_that_does_not_fit_is_refused_at_the_end(void)
{
    lend(CDS_SYNC_WRITE_SIZE(4, 4) - 1);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, build_example_5());
    lend(CDS_SYNC_WRITE_SIZE(4, 4));
    TEST_ASSERT_EQUAL(CDS_OK, build_example_5());
}

/* The length of the blocks stands in the packet; in so small a buffer it stands nowhere. */
void test_sync_write_small_buffer_touches_nothing_past_it(void)
{
    static uint8_t small[7]; // of its own, for AddressSanitizer to watch

    for (uint8_t capacity = 0; capacity <= sizeof small; capacity++) {
        packet =
            (struct cds_packet){.bytes = small + sizeof small - capacity, .capacity = capacity};
        cds_packet_sync_begin(&packet, 0x1E, 4);
        cds_packet_sync_add(&packet, 1, blocks + 1);
        TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_packet_end(&packet));
    }
    lend(0);
}

void test_size_macros_say_what_is_built(void)
{
    TEST_ASSERT_EQUAL_UINT16(6, CDS_PACKET_SIZE(0));
    build_example_5();
    TEST_ASSERT_EQUAL_UINT16(packet.size, CDS_SYNC_WRITE_SIZE(4, 4));
    TEST_ASSERT_EQUAL_UINT16(258, CDS_SYNC_WRITE_SIZE(50, 4)); // in 16 bits
    TEST_ASSERT_EQUAL_UINT16(518, CDS_SYNC_WRITE_SIZE(102, 4));
}

void test_error_bits_are_the_manuals_and_each_has_one_kind(void)
{
    TEST_ASSERT_EQUAL_HEX8(0x7F, CDS_ERROR_VOLTAGE | CDS_ERROR_ANGLE | CDS_ERROR_OVERHEATING |
                                     CDS_ERROR_RANGE | CDS_ERROR_CHECKSUM | CDS_ERROR_OVERLOAD |
                                     CDS_ERROR_INSTRUCTION);
    TEST_ASSERT_EQUAL_HEX8(0x7F, CDS_ERRORS_OF_PACKET | CDS_ERRORS_OF_CONDITION);
    TEST_ASSERT_EQUAL_HEX8(0, CDS_ERRORS_OF_PACKET & CDS_ERRORS_OF_CONDITION);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_VOLTAGE | CDS_ERROR_OVERHEATING | CDS_ERROR_OVERLOAD,
                           CDS_ERRORS_OF_CONDITION);
}

void test_an_ended_packet_may_be_ended_again_and_stays_as_it_is(void)
{
    uint8_t before[8];

    lend(sizeof buffer);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_read(&packet, 1, CDS_REG_PRESENT_TEMPERATURE, 1));
    memcpy(before, buffer, sizeof before);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&packet));
    TEST_ASSERT_EQUAL_UINT16(sizeof before, packet.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(before, buffer, sizeof before);
}

void test_nothing_may_be_put_behind_an_ended_packet(void)
{
    lend(sizeof buffer);
    cds_packet_ping(&packet, 1);
    cds_packet_put(&packet, 0);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
}

void test_no_block_may_be_added_behind_an_ended_packet(void)
{
    static const uint8_t data[4] = {1, 2, 3, 4};

    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&packet, 1));
    cds_packet_sync_add(&packet, 1, data);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
    TEST_ASSERT_EQUAL(CDS_OK, build_example_5());
    cds_packet_sync_add(&packet, 4, data);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
}

/* A reply takes the place of the packet, here one whose LENGTH is 0 then, or that says 252. */
void test_packet_that_was_written_over_is_not_sent_again(void)
{
    lend(CDS_PACKET_SIZE(2));
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_read(&packet, 1, CDS_REG_PRESENT_POSITION, 8));
    memset(buffer, 0, CDS_PACKET_SIZE(2));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
    memset(buffer, 252, CDS_PACKET_SIZE(2));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
}

void test_packet_never_begun_takes_nothing_and_is_not_whole(void)
{
    static const uint8_t data[4] = {1, 2, 3, 4};

    buffer[CDS_AT_LENGTH] = 252; // with that of no bytes it makes 256
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
    buffer[CDS_AT_LENGTH] = CANARY;
    cds_packet_put(&packet, 0);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
    packet.size = 0;
    cds_packet_sync_add(&packet, 1, data);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
    assert_nothing_past(0);
}

void test_first_reason_to_refuse_a_packet_is_told(void)
{
    static const uint8_t data[4] = {1, 2, 3, 4};

    lend(CDS_PACKET_SIZE(0));
    cds_packet_begin(&packet, 0xFF, CDS_WRITE);
    cds_packet_put(&packet, 0);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
    lend(CDS_SYNC_WRITE_SIZE(0, 4));
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_sync_begin(&packet, 0x1E, 4));
    cds_packet_sync_add(&packet, 1, data);
    cds_packet_sync_add(&packet, 254, data);
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_packet_end(&packet));
}

void test_refused_sync_begin_refuses_all_that_follows(void)
{
    static const uint8_t data[4] = {1, 2, 3, 4};

    lend(sizeof buffer);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&packet, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_sync_begin(&packet, 0x31, 4));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
    cds_packet_sync_add(&packet, 1, data);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_packet_end(&packet));
}

void test_sync_block_for_no_servo_is_refused(void)
{
    static const uint8_t data[1] = {1};

    for (uint16_t id = CDS_ID_MAX; id < 256; id++) {
        lend(sizeof buffer);
        cds_packet_sync_begin(&packet, CDS_REG_LED, 1);
        cds_packet_sync_add(&packet, (uint8_t)id, data);
        TEST_ASSERT_EQUAL(id == CDS_ID_MAX ? CDS_OK : CDS_BAD_ARGUMENT, cds_packet_end(&packet));
    }
}

/* Data end anywhere: within the capacity, at its end, behind it. */
void test_data_never_reach_past_the_capacity(void)
{
    static const uint8_t data[3] = {1, 2, 3};

    for (uint16_t capacity = 0; capacity <= CDS_SYNC_WRITE_SIZE(2, 3); capacity++) {
        lend(capacity);
        cds_packet_sync_begin(&packet, 0x1E, 3);
        cds_packet_sync_add(&packet, 1, data);
        cds_packet_sync_add(&packet, 2, data);
        assert_nothing_past(capacity);
        TEST_ASSERT_EQUAL(capacity == CDS_SYNC_WRITE_SIZE(2, 3) ? CDS_OK : CDS_NO_ROOM,
                          cds_packet_end(&packet));
    }
}
