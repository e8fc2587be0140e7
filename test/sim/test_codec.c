/* SPDX-License-Identifier: MIT */
/* The codec: what is a packet, and that no packet is lost after a damaged one (R27). */
#include <string.h>

#include "unity.h"

#include "wire/codec.h"

static struct codec codec;
static struct codec_packet found;
static int packets, damaged;

void setUp(void)
{
    codec_reset(&codec);
    memset(&found, 0, sizeof found);
    packets = damaged = 0;
}

void tearDown(void)
{
}

static void put(uint8_t byte)
{
    struct codec_packet packet;
    enum codec_event event;
    codec_put(&codec, byte);
    TEST_ASSERT_LESS_OR_EQUAL(CODEC_PACKET_MAX, codec.size);
    while ((event = codec_next(&codec, &packet)) != CODEC_NOTHING) {
        packets += event == CODEC_PACKET;
        damaged += event == CODEC_DAMAGED;
        found = packet;
    }
}

static void put_all(const uint8_t *bytes, size_t count)
{
    while (count--) {
        put(*bytes++);
    }
}

#define PUT(...) put_all((const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

/* The manual's examples 3, 2 and 18. */
#define PING_1 0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB
#define READ_1 0xFF, 0xFF, 0x01, 0x04, 0x02, 0x2B, 0x01, 0xCC
#define MOVE_0 0xFF, 0xFF, 0x00, 0x07, 0x03, 0x1E, 0x00, 0x02, 0x00, 0x02, 0xD3

void test_a_packet_is_taken_with_its_last_byte(void)
{
    PUT(0xFF, 0xFF, 0x01, 0x04, 0x02, 0x2B, 0x01);
    TEST_ASSERT_EQUAL(0, packets);
    put(0xCC);
    TEST_ASSERT_EQUAL(1, packets);
    TEST_ASSERT_EQUAL_HEX8(0x01, found.id);
    TEST_ASSERT_EQUAL_HEX8(0x02, found.instruction);
    TEST_ASSERT_EQUAL(2, found.count);
    TEST_ASSERT_EQUAL_HEX8(0x2B, found.parameters[0]);
    TEST_ASSERT_EQUAL_HEX8(0x01, found.parameters[1]);
    TEST_ASSERT_EQUAL(8, found.size);
}

void test_a_packet_without_parameters(void)
{
    PUT(PING_1);
    TEST_ASSERT_EQUAL(1, packets);
    TEST_ASSERT_EQUAL(0, found.count);
    TEST_ASSERT_EQUAL(6, found.size);
}

void test_packets_follow_one_another_without_gap(void)
{
    PUT(PING_1, READ_1, MOVE_0, PING_1);
    TEST_ASSERT_EQUAL(4, packets);
    TEST_ASSERT_EQUAL(0, damaged);
}

void test_R27_any_number_of_FF_is_one_header(void)
{
    for (int extra = 0; extra <= 600; extra++) {
        setUp();
        for (int i = 0; i < extra; i++) {
            put(0xFF);
        }
        PUT(PING_1);
        TEST_ASSERT_EQUAL(1, packets);
        TEST_ASSERT_EQUAL(0, damaged);
    }
}

void test_R27_an_ID_of_FF_is_header_whatever_ID_follows(void)
{
    for (unsigned id = 0; id <= 253; id++) {
        setUp();
        PUT(0xFF, 0xFF, 0xFF, (uint8_t)id, 0x02, 0x01, (uint8_t) ~(id + 3));
        TEST_ASSERT_EQUAL(1, packets); // complete with its last byte, though `id` might be a LENGTH
        TEST_ASSERT_EQUAL(0, damaged);
        TEST_ASSERT_EQUAL(id, found.id);
    }
}

void test_R27_one_FF_is_no_header(void)
{
    PUT(0xFF, 0x01, 0x02, 0x01, 0xFB);
    TEST_ASSERT_EQUAL(0, packets);
    PUT(PING_1);
    TEST_ASSERT_EQUAL(1, packets);
}

void test_R27_length_0_1_and_255_are_no_packet(void)
{
    static const uint8_t lengths[] = {0, 1, 255};
    for (size_t i = 0; i < sizeof lengths; i++) {
        setUp();
        PUT(0xFF, 0xFF, 0x01, lengths[i]);
        PUT(PING_1);
        TEST_ASSERT_EQUAL(1, packets);
        TEST_ASSERT_EQUAL(0, damaged);
    }
}

void test_R27_length_255_can_itself_be_the_next_header(void)
{
    PUT(0xFF, 0xFF, 0x05); // then the FF FF of a good packet: its first FF stands at LENGTH
    PUT(PING_1);
    TEST_ASSERT_EQUAL(1, packets);
}

void test_R27_every_length_from_2_to_254_is_taken(void)
{
    for (unsigned length = 2; length <= 254; length++) {
        uint8_t sum = (uint8_t)(7 + length);
        setUp();
        PUT(0xFF, 0xFF, 7, (uint8_t)length);
        for (unsigned i = 0; i < length - 1; i++) {
            TEST_ASSERT_EQUAL(0, packets);
            put((uint8_t)i);
            sum = (uint8_t)(sum + i);
        }
        put((uint8_t)~sum);
        TEST_ASSERT_EQUAL(1, packets);
        TEST_ASSERT_EQUAL(length - 2, found.count);
        TEST_ASSERT_EQUAL(length + 4, found.size);
    }
}

void test_noise_before_the_longest_packet(void)
{
    for (int noise = 0; noise <= 3; noise++) {
        setUp();
        for (int i = 0; i < noise; i++) {
            put(0x55);
        }
        PUT(0xFF, 0xFF, 0x00, 254);
        for (int i = 0; i < 253; i++) {
            put(0);
        }
        put(0x01);
        TEST_ASSERT_EQUAL(1, packets);
    }
}

void test_data_of_FF_is_no_header(void)
{
    PUT(0xFF, 0xFF, 0x01, 0x06, 0x03, 0xFF, 0xFF, 0xFF, 0xFF, 0xF9);
    TEST_ASSERT_EQUAL(1, packets);
    TEST_ASSERT_EQUAL(0, damaged);
}

void test_every_single_bit_error_behind_the_header_is_noticed(void)
{
    static const uint8_t good[] = {MOVE_0};
    for (size_t bit = 16; bit < sizeof good * 8; bit++) {
        uint8_t bad[sizeof good];
        memcpy(bad, good, sizeof good);
        bad[bit / 8] ^= (uint8_t)(1u << bit % 8);
        setUp();
        put_all(bad, sizeof bad);
        TEST_ASSERT_EQUAL(0, packets);
    }
}

void test_R19_a_damaged_packet_is_reported_with_its_id(void)
{
    PUT(0xFF, 0xFF, 0x09, 0x02, 0x01, 0xFB);
    TEST_ASSERT_EQUAL(0, packets);
    TEST_ASSERT_EQUAL(1, damaged);
    TEST_ASSERT_EQUAL_HEX8(0x09, found.id);
}

void test_R27_a_packet_inside_a_damaged_one_is_found(void)
{
    PUT(0xFF, 0xFF, 0x05, 0x0A, 0x03, READ_1, 0x00);
    TEST_ASSERT_EQUAL(1, damaged);
    TEST_ASSERT_EQUAL(1, packets);
    TEST_ASSERT_EQUAL_HEX8(0x02, found.instruction);
}

void test_R27_several_packets_inside_a_damaged_one_are_found(void)
{
    PUT(0xFF, 0xFF, 0x05, 0x16, 0x03, PING_1, READ_1, PING_1);
    TEST_ASSERT_EQUAL(0, packets + damaged); // one byte of LENGTH is missing
    PUT(0xFF);
    TEST_ASSERT_EQUAL(1, damaged);
    TEST_ASSERT_EQUAL(3, packets);
    PUT(0xFF, 0x01, 0x02, 0x01, 0xFB); // that byte was the first of a header
    TEST_ASSERT_EQUAL(4, packets);
}

void test_packets_before_a_pause_are_dropped(void)
{
    PUT(0xFF, 0xFF, 0x05, 0x16, 0x03, PING_1, READ_1);
    codec_pause(&codec);
    PUT(PING_1, 0x00); // the damaged packet ends here
    TEST_ASSERT_EQUAL(1, damaged);
    TEST_ASSERT_EQUAL(1, packets);
    TEST_ASSERT_EQUAL_HEX8(0x01, found.instruction);
}

void test_damaged_packets_before_a_pause_are_dropped(void)
{
    PUT(0xFF, 0xFF, 0x05, 0x08, 0xFF, 0xFF, 0x01, 0x02, 0x01, 0x00); // a damaged PING of servo 1
    codec_pause(&codec);
    PUT(0x00, 0x00);
    TEST_ASSERT_EQUAL(1, damaged);
    TEST_ASSERT_EQUAL(5, found.id);
}

void test_a_packet_with_a_pause_in_it_is_found(void)
{
    static const uint8_t good[] = {READ_1};
    for (size_t pause = 1; pause < sizeof good; pause++) {
        setUp();
        PUT(PING_1, 0xFF, 0xFF, 0x01);
        put_all(good, pause);
        codec_pause(&codec);
        put_all(good + pause, sizeof good - pause);
        TEST_ASSERT_EQUAL(2, packets);
        PUT(PING_1); // after the pause
        TEST_ASSERT_EQUAL(3, packets);
    }
}

void test_R27_packet_that_shares_a_header_with_damage_is_found(void)
{
    /* FF FF 02 02 FF
     *
     *  FF: damaged; it ends with the first header byte of a good packet. */
    PUT(0xFF, 0xFF, 0x02, 0x02, PING_1);
    TEST_ASSERT_EQUAL(1, packets);
}

/* Sends good packets after the cut one until 258 bytes have passed: its LENGTH covers no more. */
static void expect_good_after(const uint8_t *torn, size_t count)
{
    static const uint8_t good[] = {READ_1};
    setUp();
    put_all(torn, count);
    int sent = 0;
    for (size_t bytes = 0; bytes < CODEC_PACKET_MAX; bytes += sizeof good) {
        put_all(good, sizeof good);
        sent++;
    }
    TEST_ASSERT_EQUAL(sent, packets);
}

void test_R27_every_truncation_loses_no_packet_behind_it(void)
{
    static const uint8_t whole[] = {0xFF, 0xFF, 0xFE, 0x18, 0x83, 0x1E, 0x04, 0x00, 0x10, 0x00,
                                    0x50, 0x01, 0x01, 0x20, 0x02, 0x60, 0x03, 0x02, 0x30, 0x00,
                                    0x70, 0x01, 0x03, 0x20, 0x02, 0x80, 0x03, 0x12};
    for (size_t count = 0; count < sizeof whole; count++) {
        expect_good_after(whole, count);
    }
}

void test_R27_every_wrong_length_loses_no_packet_behind_it(void)
{
    for (unsigned length = 0; length <= 255; length++) {
        const uint8_t torn[] = {0xFF, 0xFF, 0x05, (uint8_t)length, 0x03, 0x1E};
        expect_good_after(torn, sizeof torn);
    }
}

void test_R27_every_lost_byte_loses_no_packet_behind_it(void)
{
    static const uint8_t whole[] = {MOVE_0};
    for (size_t lost = 0; lost < sizeof whole; lost++) {
        uint8_t torn[sizeof whole];
        memcpy(torn, whole, lost);
        memcpy(torn + lost, whole + lost + 1, sizeof whole - lost - 1);
        setUp();
        put_all(torn, sizeof torn - 1);
        TEST_ASSERT_EQUAL(0, packets);
        expect_good_after(torn, sizeof torn - 1);
    }
}

void test_noise_never_overruns_and_a_packet_after_it_is_found(void)
{
    uint32_t noise = 1;
    for (int round = 0; round < 200; round++) {
        for (int i = 0; i < 300; i++) {
            noise = noise * 1664525u + 1013904223u;
            put(noise >> 30 ? (uint8_t)(noise >> 20)
                            : 0xFF); // a quarter of the bytes are header bytes
        }
        for (int i = 0; i < CODEC_PACKET_MAX; i++) {
            put(0); // ends whatever packet the noise has begun
        }
        int before = packets;
        PUT(PING_1);
        TEST_ASSERT_EQUAL(before + 1, packets);
    }
}

void test_reset_drops_an_unfinished_packet(void)
{
    PUT(0xFF, 0xFF, 0x01, 0x02, 0x01);
    codec_reset(&codec);
    put(0xFB);
    TEST_ASSERT_EQUAL(0, packets);
    PUT(PING_1);
    TEST_ASSERT_EQUAL(1, packets);
}

void test_status_packet_as_in_example_2(void)
{
    static const uint8_t expected[] = {0xFF, 0xFF, 0x01, 0x03, 0x00, 0x20, 0xDB};
    static const uint8_t temperature = 0x20;
    uint8_t bytes[8] = {0, 0, 0, 0, 0, 0, 0xAA};
    TEST_ASSERT_EQUAL(7, codec_status(bytes, 1, 0, &temperature, 1));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bytes, 7);
}

void test_status_packet_with_error_and_no_parameters(void)
{
    static const uint8_t expected[] = {0xFF, 0xFF, 0x00, 0x02, 0x08, 0xF5};
    uint8_t bytes[6] = {0, 0, 0, 0, 0, 0xAA};
    TEST_ASSERT_EQUAL(6, codec_status(bytes, 0, 0x08, NULL, 0));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bytes, 6);
}
