/* SPDX-License-Identifier: MIT */
/* Finding packets in a stream: the manual's, and what is left of them after every kind of damage.
 */
#include "cds55xx/parser.h"

#include <string.h>

#include "packets.h"
#include "unity.h"

#define FOUND_SIZE 3

static struct cds_ring ring;
static struct cds_parser parser;

/* The last packets found, by ID, LENGTH, ERROR and parameters, and how many there were. */
static struct {
    uint8_t count;
    uint8_t malformed;
    uint8_t size[FOUND_SIZE];
    uint8_t bytes[FOUND_SIZE][CDS_RING_SIZE];
} found;

static uint8_t parameters[CDS_RING_SIZE];

static const uint8_t warm[] = {0xFF, 0xFF, 0x01, 0x03, 0x00, 0x20, 0xDB}; // manual, example 2
static const uint8_t done[] = {0xFF, 0xFF, 0x00, 0x02, 0x00, 0xFD};       // example 4
/* Not from a small ID: a 00 slipped in before ID 5, which is LENGTH + 1, makes a sound packet from
 * ID 0. Only the bus knows which servo it has asked. */
static const uint8_t word[] = {0xFF, 0xFF, 0x45, 0x04, 0x00, 0x34, 0x12, 0x70};

static uint8_t find(void)
{
    return cds_parser_find(&parser, &ring, cds_ring_end(&ring));
}

static uint8_t take(void)
{
    return cds_parser_take(&parser, &ring, cds_ring_end(&ring));
}

/* The byte `offset` after the oldest one in the ring. */
static uint8_t peek(uint8_t offset)
{
    return cds_ring_at(&ring, cds_ring_after(cds_ring_begin(&ring), offset));
}

/* A packet is whole. The checksum has left the ring: it is what makes the sum 255. */
static void note_packet(void)
{
    uint8_t slot = found.count % FOUND_SIZE, size = (uint8_t)(parser.length + 4);
    uint8_t *bytes = found.bytes[slot], sum = 0;

    bytes[0] = bytes[1] = CDS_HEADER;
    bytes[2] = parser.id;
    bytes[3] = parser.length;
    bytes[4] = parser.error;
    memcpy(bytes + 5, parameters, (size_t)size - 6);
    for (uint8_t i = 2; i < size - 1; i++)
        sum = (uint8_t)(sum + bytes[i]);
    bytes[size - 1] = (uint8_t)~sum;
    found.size[slot] = size;
    found.count++;
}

/* One call, as of a poll of the bus. */
static uint8_t step(void)
{
    uint8_t parsed = parser.found == CDS_FOUND_HEAD ? take() : find();

    if (parsed == CDS_PARSED_HEAD)
        cds_parser_keep(&parser, parameters);
    else if (parsed == CDS_PARSED_PACKET)
        note_packet();
    else if (parsed == CDS_PARSED_MALFORMED)
        found.malformed++;
    return parsed;
}

/* As the bus does: everything there is. */
static void parse(void)
{
    while (step() != CDS_PARSED_MORE) {
    }
}

static void hear(uint8_t byte)
{
    TEST_ASSERT_TRUE(cds_ring_put(&ring, byte));
    parse();
}

static void hear_all(const uint8_t *bytes, uint16_t count)
{
    for (uint16_t i = 0; i < count; i++)
        hear(bytes[i]);
}

static void assert_found(uint8_t index, const uint8_t *bytes, uint8_t size)
{
    TEST_ASSERT_TRUE(index < found.count && index < FOUND_SIZE);
    TEST_ASSERT_EQUAL_UINT8(size, found.size[index]);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, found.bytes[index], size);
}

static void assert_only(const uint8_t *bytes, uint8_t size)
{
    TEST_ASSERT_EQUAL_UINT8(1, found.count);
    assert_found(0, bytes, size);
}

void setUp(void)
{
    memset(&ring, 0, sizeof ring);
    memset(&parser, 0, sizeof parser);
    parser.longest = CDS_PARSER_LENGTH_MAX;
    memset(&found, 0, sizeof found);
}

void tearDown(void)
{
}

void test_every_status_packet_of_the_manual(void)
{
    uint8_t replies = 0;

    for (uint8_t i = 0; i < MANUAL_PACKETS; i++) {
        const struct manual_packet *sent = &manual_packets[i];

        if (sent->sender != SERVO)
            continue;
        found.count = 0;
        hear_all(sent->bytes, sent->size);
        assert_only(sent->bytes, sent->size);
        replies++;
    }
    TEST_ASSERT_EQUAL_UINT8(MANUAL_PACKETS - MANUAL_INSTRUCTIONS, replies);
    TEST_ASSERT_EQUAL_UINT8(0, found.malformed);
}

void test_packet_is_found_at_its_last_byte_and_not_before(void)
{
    hear_all(warm, sizeof warm - 1);
    TEST_ASSERT_EQUAL_UINT8(0, found.count);
    hear(warm[sizeof warm - 1]);
    assert_only(warm, sizeof warm);
}

/* All of it, and nothing of what came behind it. */
void test_accepted_packet_has_left_the_ring(void)
{
    for (uint8_t i = 0; i < sizeof warm; i++)
        cds_ring_put(&ring, warm[i]);
    cds_ring_put(&ring, 0x77);
    TEST_ASSERT_EQUAL(CDS_PARSED_HEAD, find());
    TEST_ASSERT_EQUAL(CDS_PARSED_SOME,
                      cds_parser_take(&parser, &ring, (uint8_t)(cds_ring_end(&ring) - 2)));
    TEST_ASSERT_EQUAL(CDS_PARSED_MORE,
                      cds_parser_take(&parser, &ring, (uint8_t)(cds_ring_end(&ring) - 2)));
    TEST_ASSERT_EQUAL(CDS_PARSED_PACKET, take());
    TEST_ASSERT_EQUAL_UINT8(1, cds_ring_count(&ring));
    TEST_ASSERT_EQUAL_HEX8(0x77, peek(0));
    TEST_ASSERT_EQUAL_UINT8(cds_ring_begin(&ring), parser.position);
}

void test_found_packet_stays_in_the_ring_until_accepted(void)
{
    for (uint8_t i = 0; i < sizeof warm - 1; i++) {
        cds_ring_put(&ring, warm[i]);
        TEST_ASSERT_EQUAL(i < 4    ? CDS_PARSED_MORE
                          : i == 4 ? CDS_PARSED_HEAD
                                   : CDS_PARSED_SOME,
                          step());
        TEST_ASSERT_FALSE(cds_parser_has_unread(&parser, &ring));
        TEST_ASSERT_EQUAL(CDS_PARSED_MORE, step());
    }
    TEST_ASSERT_EQUAL_UINT8(1, parser.id);
    TEST_ASSERT_EQUAL_UINT8(3, parser.length);
    TEST_ASSERT_EQUAL_UINT8(0, parser.error);
    TEST_ASSERT_EQUAL_UINT8(sizeof warm - 1, cds_ring_count(&ring));
    for (uint8_t i = 0; i < sizeof warm - 1; i++)
        TEST_ASSERT_EQUAL_HEX8(warm[i], peek(i));
    hear(warm[sizeof warm - 1]);
    assert_only(warm, sizeof warm);
}

void test_packets_back_to_back(void)
{
    hear_all(warm, sizeof warm);
    hear_all(done, sizeof done);
    hear_all(word, sizeof word);
    TEST_ASSERT_EQUAL_UINT8(3, found.count);
    assert_found(0, warm, sizeof warm);
    assert_found(1, done, sizeof done);
    assert_found(2, word, sizeof word);
}

/* R27: each further 0xFF is still header, be they more than the ring holds. */
void test_any_number_of_ff_before_the_header(void)
{
    for (uint16_t extra = 0; extra < 150; extra++) {
        setUp();
        for (uint16_t i = 0; i < extra; i++)
            hear(0xFF);
        hear_all(warm, sizeof warm);
        assert_only(warm, sizeof warm);
        TEST_ASSERT_EQUAL_UINT8(0, found.malformed);
        TEST_ASSERT_EQUAL_UINT16(0, parser.noise_bytes);
    }
}

void test_one_ff_is_no_header(void)
{
    hear_all(warm + 1, sizeof warm - 1);
    TEST_ASSERT_EQUAL_UINT8(0, found.count);
    hear_all(done, sizeof done);
    assert_only(done, sizeof done);
}

void test_bytes_that_begin_nothing_leave_the_ring_at_once(void)
{
    for (uint16_t byte = 0; byte < 0xFF; byte++) {
        parser.noise_bytes = 0;
        hear((uint8_t)byte);
        TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&ring));
        TEST_ASSERT_EQUAL_UINT16(1, parser.noise_bytes);
        hear(0xFF);
        TEST_ASSERT_EQUAL_UINT16(1, parser.noise_bytes);
        hear((uint8_t)byte);
        TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&ring));
        TEST_ASSERT_EQUAL_UINT16(2, parser.noise_bytes);
    }
    TEST_ASSERT_EQUAL_UINT8(0, found.malformed); // nothing of it looked like a packet
}

static void assert_length_is_malformed(uint8_t length)
{
    uint8_t bytes[] = {0xFF, 0xFF, 0x01, length};

    setUp();
    parser.is_clean = true;
    hear_all(bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_UINT8(1, found.malformed);
    TEST_ASSERT_FALSE(parser.is_clean);
    hear_all(done, sizeof done);
    assert_only(done, sizeof done);
}

void test_length_0_is_malformed_at_once(void)
{
    assert_length_is_malformed(0);
}

void test_length_1_is_malformed_at_once(void)
{
    assert_length_is_malformed(1);
}

/* FF FF 01 FF: the search goes on right behind the first FF, and the last FF may begin a header. */
void test_length_255_is_malformed_at_once(void)
{
    assert_length_is_malformed(255);
}

void test_length_longer_than_the_ring_is_malformed_at_once(void)
{
    for (uint16_t length = CDS_RING_SIZE - 4 + 1; length < 256; length++)
        assert_length_is_malformed((uint8_t)length);
}

void test_every_length_that_fits_is_parsed(void)
{
    for (uint8_t length = 2; length <= CDS_RING_SIZE - 4; length++) {
        uint8_t sum = (uint8_t)(1 + length);

        setUp();
        hear(0xFF);
        hear(0xFF);
        hear(1);
        hear(length);
        for (uint8_t i = 0; i < length - 1; i++) {
            hear((uint8_t)(i * 3));
            sum = (uint8_t)(sum + i * 3);
        }
        hear((uint8_t)~sum);
        TEST_ASSERT_EQUAL_UINT8(1, found.count);
        TEST_ASSERT_EQUAL_UINT8(length + 4, found.size[0]);
    }
}

void test_no_wrong_checksum_is_accepted(void)
{
    for (uint16_t checksum = 0; checksum < 256; checksum++) {
        setUp();
        hear_all(warm, sizeof warm - 1);
        hear((uint8_t)checksum);
        TEST_ASSERT_EQUAL_UINT8(checksum == 0xDB, found.count);
        TEST_ASSERT_EQUAL_UINT8(checksum != 0xDB, found.malformed);
    }
}

/* The sum passes 255 more than once; a parser that kept the carries would refuse it. */
void test_checksum_of_a_long_sum(void)
{
    static const uint8_t bytes[] = {0xFF, 0xFF, 0xFD, 0x06, 0x7F, 0xFF, 0xFF, 0xFF, 0xFE, 0x82};

    hear_all(bytes, sizeof bytes);
    assert_only(bytes, sizeof bytes);
}

void test_single_bit_flips_never_give_another_packet(void)
{
    for (uint8_t bit = 0; bit < 8 * sizeof word; bit++) {
        uint8_t bytes[sizeof word];

        setUp();
        memcpy(bytes, word, sizeof word);
        bytes[bit / 8] = (uint8_t)(bytes[bit / 8] ^ 1 << bit % 8);
        hear_all(bytes, sizeof bytes);
        TEST_ASSERT_EQUAL_UINT8(0, found.count);
    }
}

void test_single_byte_errors_never_give_another_packet(void)
{
    for (uint8_t at = 0; at < sizeof word; at++)
        for (uint16_t value = 0; value < 256; value++) {
            uint8_t bytes[sizeof word];

            memcpy(bytes, word, sizeof word);
            bytes[at] = (uint8_t)value;
            if (value == word[at])
                continue;
            setUp();
            hear_all(bytes, sizeof bytes);
            TEST_ASSERT_EQUAL_UINT8(0, found.count);
        }
}

/* Of each manual reply: what follows the damage must be found, and nothing else. */
static void assert_next_is_found(const uint8_t *damaged, uint8_t size)
{
    setUp();
    hear_all(damaged, size);
    TEST_ASSERT_EQUAL_UINT8(0, found.count);
    hear_all(done, sizeof done);
    assert_only(done, sizeof done);
}

void test_after_a_lost_byte_the_next_packet_is_found(void)
{
    for (uint8_t lost = 0; lost < sizeof word; lost++) {
        uint8_t bytes[sizeof word];

        memcpy(bytes, word, lost);
        memcpy(bytes + lost, word + lost + 1, sizeof word - 1 - lost);
        assert_next_is_found(bytes, sizeof word - 1);
    }
}

void test_after_a_cut_packet_the_next_one_is_found(void)
{
    for (uint8_t size = 1; size < sizeof word; size++)
        assert_next_is_found(word, size);
}

/* A packet cut before its LENGTH, or with a LENGTH too long, swallows bytes of the next ones, but
 * gives them back when its checksum turns out wrong. */
void test_header_that_follows_a_truncated_one(void)
{
    static const uint8_t swallows[] = {0xFF, 0xFF, 0x01, 0x09, 0x00};

    hear_all(swallows, sizeof swallows); // 8 bytes to come: one packet and two bytes
    hear_all(done, sizeof done);
    TEST_ASSERT_EQUAL_UINT8(0, found.count);
    hear_all(warm, sizeof warm);
    TEST_ASSERT_EQUAL_UINT8(2, found.count);
    TEST_ASSERT_EQUAL_UINT8(1, found.malformed);
    assert_found(0, done, sizeof done);
    assert_found(1, warm, sizeof warm);
}

void test_longest_swallower_gives_back_all_it_took(void)
{
    static const uint8_t swallows[] = {0xFF, 0xFF, 0x01, CDS_PARSER_LENGTH_MAX};
    uint8_t swallowed = 0;

    hear_all(swallows, sizeof swallows);
    while (found.count == 0) {
        hear_all(done, sizeof done);
        swallowed++;
        TEST_ASSERT_TRUE(swallowed <= CDS_RING_SIZE / sizeof done);
    }
    TEST_ASSERT_EQUAL_UINT8(swallowed, found.count);
    TEST_ASSERT_EQUAL_UINT8(1, found.malformed);
}

static void insert(uint8_t *bytes, const uint8_t *packet, uint8_t size, uint8_t at, uint8_t extra)
{
    memcpy(bytes, packet, at);
    bytes[at] = extra;
    memcpy(bytes + at + 1, packet + at, (uint8_t)(size - at));
}

static void try_an_extra(uint8_t extra)
{
    for (uint8_t at = 0; at <= sizeof word; at++) {
        uint8_t bytes[sizeof word + 1];

        setUp();
        insert(bytes, word, sizeof word, at, extra);
        hear_all(bytes, sizeof bytes);
        hear_all(done, sizeof done);
        // whole, if the extra byte stands outside or is one more FF of the header; else gone
        if (at == 0 || at == sizeof word || (extra == 0xFF && at <= 2)) {
            TEST_ASSERT_EQUAL_UINT8(2, found.count);
            assert_found(0, word, sizeof word);
            assert_found(1, done, sizeof done);
        } else {
            assert_only(done, sizeof done);
        }
    }
}

void test_extra_00_at_every_position(void)
{
    try_an_extra(0x00);
}

void test_extra_ff_at_every_position(void)
{
    try_an_extra(0xFF);
}

void test_extra_55_at_every_position(void)
{
    try_an_extra(0x55);
}

void test_packet_inside_a_damaged_packet_is_found(void)
{
    static const uint8_t bytes[] = {0xFF, 0xFF, 0x01, 0x0A, 0x00, 0xFF,
                                    0xFF, 0x00, 0x02, 0x00, 0xFD, /* then */ 0x11,
                                    0x22, 0x33};

    hear_all(bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_UINT8(1, found.malformed);
    assert_only(done, sizeof done);
}

/* Headers within headers: none but the whole packet at the end is true. */
void test_nested_headers_are_all_given_up(void)
{
    for (uint8_t i = 0; i < 8; i++) {
        static const uint8_t bytes[] = {0xFF, 0xFF, 0x01, 0x08};

        hear_all(bytes, sizeof bytes);
    }
    for (uint8_t i = 0; i < 8; i++)
        hear(0x00);
    TEST_ASSERT_EQUAL_UINT8(0, found.count);
    hear_all(done, sizeof done);
    assert_only(done, sizeof done);
}

/* Noise that holds half a header, and the noise and packet arriving in two pieces, cut anywhere. */
void test_garbage_then_packet_at_every_split(void)
{
    static const uint8_t bytes[] = {0x00, 0xFF, 0x55, 0xFF, 0xFF, 0x05, 0x01, 0xFF,
                                    0xFF, 0x45, 0x04, 0x00, 0x34, 0x12, 0x70};

    for (uint8_t split = 0; split <= sizeof bytes; split++) {
        setUp();
        for (uint8_t i = 0; i < sizeof bytes; i++) {
            cds_ring_put(&ring, bytes[i]);
            if (i + 1 == split)
                parse();
        }
        parse();
        assert_only(word, sizeof word);
    }
}

void test_packet_across_every_offset_of_the_ring(void)
{
    for (uint16_t offset = 0; offset < 256; offset++) {
        setUp();
        ring.head = (uint8_t)offset;
        ring.tail = (uint8_t)offset;
        hear_all(word, sizeof word);
        assert_only(word, sizeof word);
    }
}

void test_a_candidate_that_was_thrown_away_is_forgotten(void)
{
    hear_all(word, 6);
    cds_ring_release(&ring, cds_ring_end(&ring));
    cds_parser_reset(&parser, &ring);
    hear_all(word + 6, 2);
    TEST_ASSERT_EQUAL_UINT8(0, found.count);
    hear_all(done, sizeof done);
    assert_only(done, sizeof done);
}

/* The worst line there is: a header every four bytes, each claiming all that follows. Each is taken
 * to the ring's end, a few bytes in a call, and is malformed there. */
void test_full_ring_of_headers_is_parsed_in_bounded_steps(void)
{
    const uint8_t headers = CDS_RING_SIZE / 4;
    uint16_t steps = 0, most = 0;

    for (uint8_t i = 0; i < CDS_RING_SIZE; i = (uint8_t)(i + 4)) {
        cds_ring_put(&ring, 0xFF);
        cds_ring_put(&ring, 0xFF);
        cds_ring_put(&ring, 0x01);
        cds_ring_put(&ring, (uint8_t)(CDS_PARSER_LENGTH_MAX - i));
        // to find it, then to take what follows it
        most = (uint16_t)(most + 2u + (uint8_t)(CDS_RING_SIZE - i) / CDS_PARSER_TAKEN_MAX);
    }
    while (step() != CDS_PARSED_MORE)
        TEST_ASSERT_TRUE(++steps < 1000);
    TEST_ASSERT_TRUE(steps <= most);
    TEST_ASSERT_EQUAL_UINT8(headers, found.malformed); // the last one by its LENGTH, 0
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&ring));
}

/* Whatever comes, the candidate lies within the ring. */
void test_noise_never_leads_out_of_the_ring(void)
{
    uint32_t random = 1;

    for (uint16_t i = 0; i < 5000; i++) {
        random = random * 1103515245u + 12345u;
        // many FF and small numbers: noise that looks like packets
        hear((uint8_t)(random >> 29 == 0  ? random >> 16
                       : random >> 29 < 4 ? 0xFF
                                          : random >> 24 & 7));
        TEST_ASSERT_TRUE(cds_ring_count(&ring) < CDS_RING_SIZE);
    }
    for (uint8_t i = 0; i < CDS_RING_SIZE; i++)
        hear(0x00);
    found.count = 0;
    hear_all(done, sizeof done);
    assert_only(done, sizeof done);
}

/* What is found, and the bytes passed over, do not depend on how often is looked. */
void test_looking_at_every_byte_or_once_is_the_same(void)
{
    uint32_t random = 77;
    uint8_t found_ever = 0;

    for (uint16_t round = 0; round < 500; round++) {
        uint8_t bytes[CDS_RING_SIZE - 8], count, refuted, left;
        uint16_t stray;

        setUp();
        for (uint8_t i = 0; i < sizeof bytes; i++) {
            random = random * 1664525u + 1013904223u;
            bytes[i] = (uint8_t)(random >> 29 < 4 ? 0xFF : random >> 24 & 7);
        }
        memcpy(bytes + (random >> 16) % (sizeof bytes - sizeof done), done, sizeof done);
        hear_all(bytes, sizeof bytes);
        count = found.count, refuted = found.malformed, stray = parser.noise_bytes;
        left = cds_ring_count(&ring);
        found_ever = (uint8_t)(found_ever | count);
        setUp();
        for (uint8_t i = 0; i < sizeof bytes; i++)
            cds_ring_put(&ring, bytes[i]);
        parse();
        TEST_ASSERT_EQUAL_UINT8(count, found.count);
        TEST_ASSERT_EQUAL_UINT8(refuted, found.malformed);
        TEST_ASSERT_EQUAL_UINT16(stray, parser.noise_bytes);
        TEST_ASSERT_EQUAL_UINT8(left, cds_ring_count(&ring));
    }
    TEST_ASSERT_NOT_EQUAL(0, found_ever); // there were packets among it
}

void test_bytes_after_the_end_are_not_examined(void)
{
    for (uint8_t i = 0; i < 9; i++)
        cds_ring_put(&ring, 0x55);
    TEST_ASSERT_EQUAL(CDS_PARSED_MORE, cds_parser_find(&parser, &ring, 4));
    TEST_ASSERT_EQUAL_UINT8(4, parser.position);
    TEST_ASSERT_EQUAL(CDS_PARSED_MORE, cds_parser_find(&parser, &ring, 4));
    TEST_ASSERT_EQUAL_UINT8(5, cds_ring_count(&ring));
    TEST_ASSERT_TRUE(cds_parser_has_unread(&parser, &ring));
}

/* A head whose ERROR stands after the end is none yet. */
void test_head_is_found_only_before_the_end(void)
{
    for (uint8_t i = 0; i < sizeof warm; i++)
        cds_ring_put(&ring, warm[i]);
    for (uint8_t end = 0; end < 5; end++) {
        TEST_ASSERT_EQUAL(CDS_PARSED_MORE, cds_parser_find(&parser, &ring, end));
        TEST_ASSERT_EQUAL_UINT8(end, parser.position);
    }
    TEST_ASSERT_EQUAL(CDS_PARSED_HEAD, cds_parser_find(&parser, &ring, 5));
}

void test_one_call_skips_no_more_than_it_may(void)
{
    for (uint8_t i = 0; i < 2 * CDS_PARSER_SKIPPED_MAX; i++)
        cds_ring_put(&ring, i < CDS_PARSER_SKIPPED_MAX ? 0x55 : 0xFF);
    TEST_ASSERT_EQUAL(CDS_PARSED_SOME, find());
    TEST_ASSERT_EQUAL_UINT8(CDS_PARSER_SKIPPED_MAX, cds_ring_count(&ring));
    TEST_ASSERT_EQUAL_UINT16(CDS_PARSER_SKIPPED_MAX, parser.noise_bytes);
    for (uint8_t i = 0; i < CDS_PARSER_SKIPPED_MAX; i++)
        cds_ring_put(&ring, 0xFF);
    TEST_ASSERT_EQUAL(CDS_PARSED_SOME, find());
    TEST_ASSERT_EQUAL_UINT8(CDS_PARSER_SKIPPED_MAX, cds_ring_count(&ring));
    parse();
    TEST_ASSERT_EQUAL_UINT8(2, cds_ring_count(&ring)); // a header may be its last two bytes
    TEST_ASSERT_EQUAL_UINT16(CDS_PARSER_SKIPPED_MAX, parser.noise_bytes);
}

static void put_packet(uint8_t count)
{
    uint8_t sum = (uint8_t)(1 + count + 2);

    cds_ring_put(&ring, 0xFF);
    cds_ring_put(&ring, 0xFF);
    cds_ring_put(&ring, 1);
    cds_ring_put(&ring, (uint8_t)(count + 2));
    cds_ring_put(&ring, 0);
    for (uint8_t i = 0; i < count; i++) {
        cds_ring_put(&ring, (uint8_t)(i + 1));
        sum = (uint8_t)(sum + i + 1);
    }
    cds_ring_put(&ring, (uint8_t)~sum);
}

void test_one_call_takes_no_more_than_it_may(void)
{
    for (uint8_t count = 0; count <= 50; count++) {
        uint8_t calls = 1;

        setUp();
        put_packet(count);
        TEST_ASSERT_EQUAL(CDS_PARSED_HEAD, find());
        while (take() == CDS_PARSED_SOME)
            calls++;
        TEST_ASSERT_EQUAL(CDS_FOUND_NOTHING, parser.found);
        TEST_ASSERT_EQUAL_UINT8((count + 1 + CDS_PARSER_TAKEN_MAX - 1) / CDS_PARSER_TAKEN_MAX,
                                calls);
    }
}

void test_parameters_are_stored_only_if_the_packet_is_kept(void)
{
    uint8_t stored[4] = {0xA5, 0xA5, 0xA5, 0xA5};

    put_packet(3);
    TEST_ASSERT_EQUAL(CDS_PARSED_HEAD, find());
    cds_parser_keep(&parser, stored);
    TEST_ASSERT_EQUAL(CDS_PARSED_PACKET, take());
    TEST_ASSERT_EQUAL_UINT8(3, stored[2]);
    TEST_ASSERT_EQUAL_HEX8(0xA5, stored[3]); // not the checksum
    stored[2] = 0xA5;
    put_packet(3);
    TEST_ASSERT_EQUAL(CDS_PARSED_HEAD, find()); // the next one is not kept by that
    TEST_ASSERT_EQUAL(CDS_PARSED_PACKET, take());
    TEST_ASSERT_EQUAL_HEX8(0xA5, stored[2]);
}

void test_skipped_damage_ends_the_packet_before_it(void)
{
    parser.is_clean = true;
    for (uint8_t i = 0; i < 6; i++)
        cds_ring_put(&ring, warm[i]);
    parse();
    TEST_ASSERT_EQUAL(CDS_FOUND_HEAD, parser.found);
    cds_parser_skip_damage(&parser, &ring, cds_ring_end(&ring));
    TEST_ASSERT_FALSE(parser.is_clean);
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&ring));
    hear(warm[6]);
    TEST_ASSERT_EQUAL_UINT8(0, found.count);
    hear_all(done, sizeof done);
    assert_only(done, sizeof done);
}
