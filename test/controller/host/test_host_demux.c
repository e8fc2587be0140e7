/* SPDX-License-Identifier: MIT */
/* The host link: bytes in; text, marks and packets out. */
#include <string.h>

#include "host/host_demux.h"
#include "ring_input.h"
#include "port_fake.h"
#include "unity.h"

#define MARK_DROPPED "\xF8"
#define MARK_LOST    "\xF9"

static struct cds_ring input, text;
static uint8_t buffers[2][HOST_PACKET_MAX];
static struct host_demux host;

/* Output of the demux. */
static char said[200];
static uint8_t said_size;
static uint8_t packet[HOST_PACKET_MAX];
static uint16_t packets, ids; // number of packets, sum of their IDs
static uint8_t *spare;

void setUp(void)
{
    port_fake_reset();
    memset(&input, 0, sizeof input);
    memset(&text, 0, sizeof text);
    host_demux_open(&host, &input, &text, buffers[0]);
    spare = buffers[1];
    said_size = 0;
    packets = 0;
}

void tearDown(void)
{
}

static uint16_t size_of(const uint8_t *bytes)
{
    return (uint16_t)(bytes[3] + 4);
}

static void take_packet(void)
{
    spare = host_demux_take(&host, spare);
    memcpy(packet, spare, size_of(spare));
    packets++;
    ids = (uint16_t)(ids + packet[2]);
}

static void take_text(void)
{
    while (cds_ring_count(&text)) {
        if (said_size < sizeof said - 1)
            said[said_size++] = (char)ring_peek(&text, 0);
        ring_drop(&text, 1);
    }
    said[said_size] = '\0';
}

static void turn(void)
{
    host_demux_poll(&host);
    if (host.has_packet)
        take_packet();
    take_text();
}

static void settle(void)
{
    for (uint16_t i = 0; i < 300; i++)
        turn();
}

/* The host sends bytes, a few of them, 64 at most, between two polls. */
static void feed(const void *bytes, uint16_t size, uint8_t burst)
{
    const uint8_t *from = bytes;

    for (uint16_t i = 0; i < size; i++) {
        TEST_ASSERT_TRUE(cds_ring_put(&input, from[i]));
        for (uint8_t turns = i % burst == burst - 1u ? 3 : 0; turns; turns--)
            turn();
    }
    settle();
}

static void type(const char *line)
{
    feed(line, (uint16_t)strlen(line), 7);
}

static void assert_said(const char *expected)
{
    TEST_ASSERT_EQUAL_STRING(expected, said_size ? said : "");
    said_size = 0;
}

static void pause_us(uint32_t us)
{
    port_fake.now_us += us;
    settle();
}

/* FF FF 01 LENGTH 03, parameters that are all FF or count up, checksum; returns its size. */
static uint16_t make(uint8_t *to, uint8_t id, uint8_t length, bool headers)
{
    uint8_t sum = (uint8_t)(id + length + 3);

    to[0] = to[1] = 0xFF;
    to[2] = id;
    to[3] = length;
    to[4] = 3;
    for (uint8_t i = 0; i < length - 2; i++) {
        to[5 + i] = headers ? 0xFF : i;
        sum = (uint8_t)(sum + to[5 + i]);
    }
    to[length + 3] = (uint8_t)~sum;
    return (uint16_t)(length + 4);
}

static const uint8_t ping[] = {0xFF, 0xFF, 1, 2, 1, 0xFB};

static void assert_ping_found(uint16_t so_far)
{
    TEST_ASSERT_EQUAL_UINT16(so_far, packets);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(ping, packet, sizeof ping);
}

void test_text_goes_to_the_console(void)
{
    type("ping 1\r\nread 2 \t\x18\x7F\xC3\xA4");
    assert_said("ping 1\r\nread 2 \t\x18\x7F\xC3\xA4");
    TEST_ASSERT_EQUAL_UINT16(0, packets);
}

void test_packet_of_every_length_is_handed_over_unchanged(void)
{
    static uint8_t sent[HOST_PACKET_MAX];

    for (uint16_t length = 2; length <= 254; length++) {
        uint16_t size = make(sent, 9, (uint8_t)length, length & 1);

        feed(sent, size, (uint8_t)(length % 50 + 1));
        TEST_ASSERT_EQUAL_UINT16(length - 1, packets);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(sent, packet, size);
    }
    TEST_ASSERT_EQUAL_UINT16(253, host.counters.packets);
    TEST_ASSERT_EQUAL_UINT16(0, host.counters.malformed);
    assert_said("");
}

void test_packet_drops_the_line_before_it(void)
{
    type("ping");
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
    type("help\r");
    feed(ping, sizeof ping, 1);
    assert_ping_found(2);
    assert_said("ping" MARK_DROPPED "help\r"); // after a whole line there is no line to drop
}

void test_header_of_more_than_two_bytes_is_accepted(void)
{
    for (uint16_t i = 0; i < 600; i++)
        feed(ping, 1, 1);
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
    TEST_ASSERT_EQUAL_UINT16(0, host.counters.malformed);
}

void test_header_byte_alone_begins_no_packet(void)
{
    type("\xFFping 1\r");
    assert_said("ping 1\r");
    type("ping 1");
    type("\xFF"); // a glitch on the idle line
    pause_us(HOST_SILENCE_US);
    type("2\r");
    assert_said("ping 12\r");
    TEST_ASSERT_EQUAL_UINT16(0, host.counters.gaps);
    TEST_ASSERT_EQUAL_UINT16(0, host.counters.malformed);
}

void test_line_with_one_header_byte_is_dropped_to_its_end(void)
{
    type("pose \xFFmove 1 500\r");
    assert_said("pose " MARK_DROPPED);
    type("ping 1\xFF\rping 2\r");
    assert_said("ping 1" MARK_DROPPED "ping 2\r");
    host_demux_gap(&host);
    type("torque\xFF 1\r"); // the rest of a line that a gap has cut
    assert_said(MARK_LOST);
    type("pi\xFFng");
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
    assert_said("pi" MARK_DROPPED);
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.gaps);
    TEST_ASSERT_EQUAL_UINT16(0, host.counters.malformed);
}

void test_damage_to_any_byte_drops_one_packet(void)
{
    for (uint8_t at = 2; at < sizeof ping; at++) {
        uint8_t damaged[sizeof ping];

        setUp();
        memcpy(damaged, ping, sizeof ping);
        damaged[at] ^= 0x40;
        if (at == 3)
            damaged[at] = 1;
        feed(damaged, sizeof damaged, 3);
        if (at == 3) // the bytes after it are text, up to the next packet
            feed(ping, sizeof ping, 3);
        else
            type("help\r");
        feed(ping, sizeof ping, 3);
        assert_ping_found(at == 3 ? 2 : 1);
        TEST_ASSERT_EQUAL_UINT16(1, host.counters.malformed);
        if (at != 3)
            assert_said("help\r");
    }
}

void test_length_out_of_range_is_rejected_at_once(void)
{
    static const uint8_t lengths[] = {0, 1, 255};

    for (uint8_t i = 0; i < sizeof lengths; i++) {
        const uint8_t head[] = {0xFF, 0xFF, 1, lengths[i]};

        setUp();
        feed(head, sizeof head, 1);
        TEST_ASSERT_EQUAL(lengths[i] != 255, host_demux_idle(&host)); // 255 may be a header
        TEST_ASSERT_EQUAL_UINT16(1, host.counters.malformed);
        type("help\r");
        assert_said("help\r");
    }
}

void test_packet_within_a_malformed_one_is_found(void)
{
    static uint8_t sent[HOST_PACKET_MAX];
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 9, 3, 0x1E};

    feed(cut, sizeof cut, 1); // 7 bytes more were due
    feed(ping, sizeof ping, 1);
    feed(ping, sizeof ping, 1);
    assert_ping_found(2);
    make(sent, 1, 254, false); // fills the whole buffer with packets
    for (uint8_t i = 0; i < 42; i++) {
        memcpy(&sent[5 + 6 * i], ping, sizeof ping);
        sent[5 + 6 * i + 2] = i;
        sent[5 + 6 * i + 5] = (uint8_t)(0xFC - i);
    }
    sent[257] = 0;
    ids = 0;
    for (uint8_t i = 0; i < 6; i++)
        feed(&sent[43 * i], 43, 43);
    TEST_ASSERT_EQUAL_UINT16(44, packets);
    TEST_ASSERT_EQUAL_UINT16(41 * 42 / 2, ids);
    TEST_ASSERT_EQUAL_UINT8(41, packet[2]);
    TEST_ASSERT_EQUAL_UINT16(2, host.counters.malformed);
    assert_said("");
}

void test_buffer_full_of_headers_is_worked_off(void)
{
    static const uint8_t beginning[] = {0xFF, 0xFF, 1, 254, 3};

    for (uint16_t i = 0; i < 400; i++)
        feed(beginning, sizeof beginning, 5);
    port_fake.now_us += HOST_SILENCE_US;
    for (uint8_t i = 0; i < 150; i++) // the demux does not wait for their ends
        turn();
    TEST_ASSERT_TRUE(host_demux_idle(&host));
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
}

void test_packet_is_dropped_when_the_host_falls_silent(void)
{
    for (uint8_t cut = 1; cut < sizeof ping; cut++) {
        setUp();
        port_fake.now_us = 0xFFFFFFFF - 20000; // over the wrap of the clock
        feed(ping, cut, 1);
        pause_us(HOST_SILENCE_US - 1);
        TEST_ASSERT_FALSE(host_demux_idle(&host));
        feed(&ping[cut], (uint16_t)(sizeof ping - cut), 1);
        assert_ping_found(1);
        feed(ping, cut, 1);
        pause_us(HOST_SILENCE_US);
        TEST_ASSERT_TRUE(host_demux_idle(&host));
        TEST_ASSERT_EQUAL_UINT16(cut > 1, host.counters.silent);
        type("help\r");
        assert_said("help\r");
    }
}

/* The client has given up waiting for the reply. */
void test_packet_swallowed_by_a_cut_one_is_dropped(void)
{
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 200, 3, 0x1E};

    for (uint8_t i = 0; i < 3; i++) {
        feed(cut, sizeof cut, 1);
        feed(ping, sizeof ping, 1);
        TEST_ASSERT_EQUAL_UINT16(i, packets);
        pause_us(HOST_SILENCE_US);
        TEST_ASSERT_EQUAL_UINT16(i, packets);
        feed(ping, sizeof ping, 1);
        assert_ping_found((uint16_t)(i + 1));
    }
    TEST_ASSERT_EQUAL_UINT16(3, host.counters.silent);
    TEST_ASSERT_EQUAL_UINT16(3, host.counters.late);
}

/* The host sends three packets after a cut one without a pause of 15 ms: the end of the cut one
 * falls into the third. */
void test_packet_found_again_is_dropped_if_it_is_old(void)
{
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 17, 3};

    feed(cut, sizeof cut, 1);
    for (uint8_t i = 0; i < 3; i++) {
        pause_us(HOST_SILENCE_US / 2);
        feed(ping, sizeof ping, 1);
    }
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.malformed);
    TEST_ASSERT_EQUAL_UINT16(0, packets);
    TEST_ASSERT_EQUAL_UINT16(3, host.counters.late);
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
}

static void assert_stop_within_20_ms(void)
{
    uint32_t begin_us = port_fake.now_us;

    while (!host.stop && port_fake.now_us - begin_us < 20000) {
        port_fake.now_us += 100; // a turn of the main loop
        turn();
    }
    TEST_ASSERT_TRUE(host.stop);
    TEST_ASSERT_EQUAL_UINT16(0, packets);
}

/* Ctrl-X after each part of a packet that can contain it. */
void test_stop_in_a_cut_packet_is_found_within_20_ms(void)
{
    static uint8_t bytes[HOST_PACKET_MAX];

    for (uint16_t size = 5; size < HOST_PACKET_MAX; size++) {
        setUp();
        make(bytes, 1, 254, size & 1);
        bytes[5 + 0x18] = 0; // the parameters count up and contain 0x18
        bytes[size - 1] = 0x18;
        feed(bytes, size, 40);
        TEST_ASSERT_FALSE(host.stop);
        assert_stop_within_20_ms();
        TEST_ASSERT_EQUAL_UINT16(1, host.counters.stops);
    }
}

void test_stop_pressed_repeatedly_in_a_cut_packet_is_found(void)
{
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 0xFE, 3};

    feed(cut, sizeof cut, 1);
    for (uint8_t presses = 0; presses < 60; presses++) {
        host.stop = false;
        type("\x18");
        pause_us(33000);
        TEST_ASSERT_TRUE(host.stop);
    }
}

void test_stop_in_a_packet_with_a_bad_checksum_is_found_at_once(void)
{
    uint8_t read_24[] = {0xFF, 0xFF, 7, 4, 2, 0x18, 1, 0xD9};

    feed(read_24, sizeof read_24, 3);
    TEST_ASSERT_EQUAL_UINT16(1, packets);
    TEST_ASSERT_FALSE(host.stop); // the 0x18 stands in a good packet
    read_24[7] ^= 1;
    feed(read_24, sizeof read_24, 3);
    TEST_ASSERT_TRUE(host.stop);
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.stops);
}

/* Else a release sent before the stop would act after it. */
void test_stop_behind_a_packet_that_waits_drops_the_packet(void)
{
    for (uint8_t i = 0; i < sizeof ping; i++)
        cds_ring_put(&input, ping[i]);
    for (uint8_t i = 0; i < 20; i++)
        host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.has_packet);
    cds_ring_put(&input, 'a');
    host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.has_packet);
    cds_ring_put(&input, 0x18);
    host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.stop);
    TEST_ASSERT_FALSE(host.has_packet);
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
}

static void put_all(const void *bytes, uint8_t size)
{
    for (uint8_t i = 0; i < size; i++)
        cds_ring_put(&input, ((const uint8_t *)bytes)[i]);
}

/* A packet waits for the bridge, and these bytes come after it. */
static void come_behind_a_packet(const void *bytes, uint8_t size)
{
    put_all(ping, sizeof ping);
    for (uint8_t i = 0; i < 20; i++)
        host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.has_packet);
    put_all(bytes, size);
    host_demux_poll(&host);
}

static const uint8_t with_stops[] = {0xFF, 0xFF, 2, 5, 3, 0x18, 0x18, 0, 0xC5}; // as data

void test_stop_behind_packets_that_wait_drops_them(void)
{
    come_behind_a_packet(with_stops, sizeof with_stops);
    TEST_ASSERT_FALSE(host.stop);
    put_all(ping, sizeof ping);
    put_all("\x18", 1);
    host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.stop);
    TEST_ASSERT_FALSE(host.has_packet);
    TEST_ASSERT_EQUAL_UINT16(3, host.counters.late);
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&input));
    host.stop = false;
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
}

void test_data_of_a_waiting_packet_is_no_stop_before_its_end(void)
{
    come_behind_a_packet(with_stops, 6);
    TEST_ASSERT_FALSE(host.stop);
    put_all(with_stops + 6, 3);
    host_demux_poll(&host);
    TEST_ASSERT_FALSE(host.stop);
    TEST_ASSERT_TRUE(host.has_packet);
}

void test_data_of_a_packet_longer_than_the_ring_is_no_stop(void)
{
    for (uint16_t length = 57; length <= CDS_LENGTH_MAX; length++) {
        const uint8_t bytes[] = {0xFF, 0xFF, 254, (uint8_t)length, 0x83, 0x18, 0x18};

        setUp();
        come_behind_a_packet(bytes, sizeof bytes);
        TEST_ASSERT_FALSE(host.stop);
        TEST_ASSERT_TRUE(host.has_packet);
    }
}

void test_stop_in_a_damaged_packet_behind_one_that_waits(void)
{
    static const uint8_t bytes[] = {0xFF, 0xFF, 2, 5, 3, 0x18, 0x18, 0, 0xC6};

    come_behind_a_packet(bytes, sizeof bytes);
    TEST_ASSERT_TRUE(host.stop);
    TEST_ASSERT_FALSE(host.has_packet);
}

void test_stop_behind_bytes_that_are_no_packet(void)
{
    static const uint8_t bytes[] = {0xFF, 0xFF, 0xFF, 2, 1, 0xFF, 'a', 0xFF, 0xFF, 3, 255, 0x18};

    come_behind_a_packet(bytes, sizeof bytes);
    TEST_ASSERT_TRUE(host.stop);
}

void test_stop_behind_a_damaged_packet_counts_once(void)
{
    static const uint8_t damaged[] = {0xFF, 0xFF, 1, 2, 1, 0xFC};

    feed(damaged, sizeof damaged, 1);
    type("\xFF\x18");
    TEST_ASSERT_TRUE(host.stop);
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.stops);
}

/* The packet stands within a cut packet; the bytes after it are lost. */
void test_packet_in_a_cut_one_before_a_gap_is_dropped(void)
{
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 200, 3};

    feed(cut, sizeof cut, 1);
    feed(ping, sizeof ping, 1);
    host_demux_gap(&host);
    settle();
    TEST_ASSERT_EQUAL_UINT16(0, packets);
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.late);
}

void test_stop_in_bytes_before_a_gap_is_found(void)
{
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 0xFE, 3, 0x18};

    feed(cut, sizeof cut, 1);
    host_demux_gap(&host);
    settle();
    TEST_ASSERT_TRUE(host.stop);
    TEST_ASSERT_TRUE(cds_ring_count(&text) == 0);
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
}

/* READ of TORQUE_ENABLE (0x18), swallowed by a cut packet: a good packet, dropped, and no stop. */
void test_stop_is_not_seen_in_a_good_packet_that_is_dropped(void)
{
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 200, 3};
    static const uint8_t read_24[] = {0xFF, 0xFF, 7, 4, 2, 0x18, 1, 0xD9};

    feed(cut, sizeof cut, 1);
    feed(read_24, sizeof read_24, 1);
    pause_us(HOST_SILENCE_US);
    TEST_ASSERT_FALSE(host.stop);
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.late);
    TEST_ASSERT_EQUAL_UINT16(0, packets);
}

void test_silence_drops_one_packet(void)
{
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 200, 3, 0xFF, 0xFF, 2};

    feed(cut, sizeof cut, 1);
    pause_us(HOST_SILENCE_US);
    TEST_ASSERT_TRUE(host_demux_idle(&host));
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.silent);
}

void test_packet_that_waits_keeps_the_next_from_being_taken(void)
{
    for (uint8_t i = 0; i < 2 * sizeof ping; i++)
        cds_ring_put(&input, ping[i % sizeof ping]);
    for (uint8_t i = 0; i < 20; i++)
        host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.has_packet);
    TEST_ASSERT_EQUAL_UINT8(sizeof ping, cds_ring_count(&input));
    settle();
    assert_ping_found(2);
}

void test_gap_drops_the_packet_or_line_and_is_marked_once(void)
{
    type("ping ");
    host_demux_gap(&host);
    type("12\rping 2\r");
    assert_said("ping " MARK_LOST "ping 2\r");
    feed(ping, 4, 1);
    host_demux_gap(&host);
    feed(&ping[5], 1, 1); // must not be joined
    feed(ping, sizeof ping, 1);
    assert_ping_found(1);
    host_demux_gap(&host);
    type("abc");
    pause_us(HOST_SILENCE_US);
    type("ping 3\r");
    assert_said(MARK_LOST MARK_LOST "ping 3\r");
    TEST_ASSERT_EQUAL_UINT16(3, host.counters.gaps);
}

/* A host that waits for the reply to each line sends the next line when the loss is reported. */
void test_gap_is_marked_before_the_next_line(void)
{
    type("ping 1");
    host_demux_gap(&host); // the end of the line is lost
    settle();
    assert_said("ping 1");
    pause_us(HOST_SILENCE_US);
    assert_said(MARK_LOST);
    type("ping 2\r");
    assert_said("ping 2\r");
}

void test_gap_after_a_packet_that_waits_keeps_the_packet(void)
{
    for (uint8_t i = 0; i < sizeof ping + 2; i++)
        cds_ring_put(&input, ping[i % sizeof ping]);
    for (uint8_t i = 0; i < 10; i++)
        host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.has_packet);
    ring_drop(&input, 2);
    host_demux_gap(&host);
    settle();
    assert_ping_found(1);
    type("12\rping 2\r");
    assert_said(MARK_LOST "ping 2\r");
}

void test_text_without_room_is_lost_and_marked(void)
{
    for (uint8_t i = 0; i < 90; i++) { // the ring of text holds 64
        cds_ring_put(&input, 'x');
        host_demux_poll(&host);
    }
    TEST_ASSERT_EQUAL_UINT16(1, host.counters.gaps);
    take_text();
    TEST_ASSERT_EQUAL_UINT8(64, said_size);
    said_size = 0;
    type("x\rping 1\r");
    assert_said(MARK_LOST "ping 1\r");
}

void test_packet_passes_while_the_text_ring_is_full(void)
{
    for (uint8_t i = 0; i < 90; i++) {
        cds_ring_put(&input, 'x');
        host_demux_poll(&host);
    }
    for (uint8_t i = 0; i < sizeof ping; i++)
        cds_ring_put(&input, ping[i]);
    for (uint8_t i = 0; i < sizeof ping; i++)
        host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.has_packet);
    take_packet();
    assert_ping_found(1);
    TEST_ASSERT_EQUAL_UINT8(64, cds_ring_count(&text));
}

void test_line_cut_without_room_for_a_mark_is_not_joined(void)
{
    for (uint8_t i = 0; i < 64; i++) {
        cds_ring_put(&input, 'x');
        host_demux_poll(&host);
    }
    for (uint8_t i = 0; i < 2; i++)
        cds_ring_put(&input, CDS_HEADER);
    host_demux_poll(&host);
    take_text();
    said_size = 0;
    feed(&ping[2], sizeof ping - 2, 1);
    type("ping 1\r");
    assert_said(MARK_LOST "ping 1\r");
}

void test_ctrl_x_outside_a_packet_is_a_stop(void)
{
    static uint8_t sent[0x18 + 4];

    feed(sent, make(sent, 1, 0x18, false), 1); // LENGTH, within a packet
    TEST_ASSERT_EQUAL_UINT16(1, packets);
    TEST_ASSERT_FALSE(host.stop);
    host_demux_gap(&host);
    type("abc\x18");
    TEST_ASSERT_TRUE(host.stop);
}

void test_ctrl_x_after_a_packet_that_waits_is_taken(void)
{
    static const char typed[] = "abc\x18"
                                "de";
    uint8_t sent[16];
    uint16_t size = make(sent, 1, 2, false);

    for (uint16_t i = 0; i < size; i++)
        cds_ring_put(&input, sent[i]);
    for (uint8_t i = 0; typed[i]; i++)
        cds_ring_put(&input, (uint8_t)typed[i]);
    for (uint16_t i = 0; i < size; i++)
        cds_ring_put(&input, sent[i]);
    for (uint8_t i = 0; i < 20; i++)
        host_demux_poll(&host);
    TEST_ASSERT_TRUE(host.stop);
    settle();
    TEST_ASSERT_EQUAL_UINT16(1, packets); // the packet after it
    assert_said("abc\x18"
                "de" MARK_DROPPED);
}

void test_mark_bytes_of_the_host_are_dropped(void)
{
    type("a\xF8\xF9"
         "b\r");
    assert_said("ab\r");
}

void test_rest_of_a_malformed_packet_does_not_reach_a_later_line(void)
{
    static const uint8_t damaged[] = {0xFF, 0xFF, 1, 2, 3, 'a', 'b', 'c', 'd'}; // LENGTH was 5

    feed(damaged, sizeof damaged, 1);
    pause_us(HOST_SILENCE_US);
    type("ping 1\r");
    assert_said("bcd" MARK_DROPPED "ping 1\r");
    type("pi");
    pause_us(HOST_SILENCE_US); // a person may take more time
    type("ng 2\r");
    assert_said("ping 2\r");
}

void test_poll_returns_true_while_more_may_be_taken(void)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 1, 2, 1, 0xFB};

    for (uint8_t i = 0; i < sizeof ping; i++) {
        cds_ring_put(&input, ping[i]);
        TEST_ASSERT_EQUAL(i + 1u < sizeof ping, host_demux_poll(&host));
        TEST_ASSERT_FALSE(host_demux_poll(&host)); // no byte has come since
    }
    TEST_ASSERT_TRUE(host.has_packet);
    cds_ring_put(&input, 'x');
    TEST_ASSERT_FALSE(host_demux_poll(&host));
}

void test_poll_returns_false_once_the_text_ring_is_half_full(void)
{
    uint8_t taken = 0;

    do {
        cds_ring_put(&input, 'x');
        taken++;
    } while (host_demux_poll(&host));
    TEST_ASSERT_EQUAL_UINT8(CDS_RING_SIZE / 2, taken);
}
