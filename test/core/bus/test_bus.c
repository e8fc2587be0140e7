/* SPDX-License-Identifier: MIT */
/* Transactions on one bus: outcomes, deadlines, faults, and counters that add up. */
#include "cds55xx/bus.h"

#include <string.h>

#include "cds55xx/queue.h"
#include "bus_rig.h"
#include "unity.h"

#define PORT 1

/* At 1 Mbps, with the return delay taken for its longest: 12 bytes of PING and reply. */
#define PING_DEADLINE_US (12 * 10 + 508 + 100)
#define WORD_DEADLINE_US (16 * 10 + 508 + 100) // READ of a word: 8 bytes out, 8 back

static struct cds_queue queue;
static uint8_t buffer[CDS_PACKET_SIZE(2)], reply[CDS_REPLY_MAX];
static struct cds_request request = CDS_REQUEST(buffer, reply);

static const uint8_t word_reply[] = {0xFF, 0xFF, 0x05, 0x04, 0x00, 0x34, 0x12, 0xB0};
static const uint8_t pong[] = {0xFF, 0xFF, 0x05, 0x02, 0x00, 0xF8};

static void open_at(uint8_t baud)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    cds_bus_open(&bus, PORT, baud);
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    port_fake_forget();
}

void setUp(void)
{
    memset(buffer, 0, sizeof buffer);
    memset(reply, 0, sizeof reply);
    request = (struct cds_request)CDS_REQUEST(buffer, reply);
    open_at(CDS_BAUD_1M);
}

/* Whatever a test did: no verb out of place, and every packet has its outcome. */
void tearDown(void)
{
    rig_check();
}

static void submit_ping(uint8_t id)
{
    request.reply_parameters = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&request.packet, id));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
}

static void submit_read(uint8_t id, uint8_t length)
{
    request.reply_parameters = length;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_read(&request.packet, id, 0x00, length));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
}

static void submit_broadcast_action(void)
{
    request.reply_parameters = CDS_REPLY_NONE;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_action(&request.packet, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
}

static void hear(const uint8_t *bytes, uint8_t count)
{
    port_fake_hear(&bus.link, bytes, count);
}

static void ping(uint8_t id)
{
    submit_ping(id);
    rig_transmit();
}

static void read_word(void)
{
    submit_read(5, 2);
    rig_transmit();
}

static void assert_pending(void)
{
    port_fake_look(&bus);
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
}

static void assert_ended(enum cds_result result)
{
    port_fake_look(&bus);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(result, request.result);
    TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[PORT]);
    TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, bus.link.state);
}

/* The next transaction must work whatever the last one met. */
static void assert_next_is_ok(void)
{
    uint16_t value = 0;

    read_word();
    hear(word_reply, sizeof word_reply);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, cds_request_word(&request, 0, &value));
    TEST_ASSERT_EQUAL_HEX16(0x1234, value);
}

/* Each poll examines a little: as many polls as all that has come takes. */
static void poll_idle(void)
{
    for (uint8_t i = 0; i < 20; i++)
        TEST_ASSERT_FALSE(cds_bus_poll(&bus));
}

/* Polled now and then, so that no wrap of the timer is missed. */
static void assert_pending_for(uint32_t us)
{
    for (; us > 10000; us -= 10000) {
        port_fake.now_us += 10000;
        assert_pending();
    }
    port_fake.now_us += us;
    assert_pending();
}

static void assert_ends_at(uint32_t deadline_us, enum cds_result result)
{
    assert_pending_for(deadline_us - 1);
    port_fake.now_us++;
    assert_ended(result);
}

void test_open_sets_the_rate_and_listens(void)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    cds_bus_open(&bus, PORT, 34);
    TEST_ASSERT_EQUAL(FAKE_OPEN, port_fake.log[0].verb);
    TEST_ASSERT_EQUAL_UINT8(PORT, port_fake.log[0].port);
    TEST_ASSERT_EQUAL_UINT8(34, port_fake.log[0].byte);
    TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[PORT]);
}

void test_open_starts_all_stats_at_0(void)
{
    static const struct cds_stats none;
    struct cds_stats count;

    ping(5);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING | CDS_LINE_OVERRUN);
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    cds_bus_stats(&bus, &count);
    TEST_ASSERT_EQUAL_MEMORY(&none, &count, sizeof none);
}

void test_ping_answered_is_ok(void)
{
    ping(5);
    assert_pending();
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(5, request.id);
    TEST_ASSERT_EQUAL_HEX8(0, request.error);
    TEST_ASSERT_EQUAL_UINT8(0, request.length);
}

void test_packet_on_the_line_is_the_requests(void)
{
    static const uint8_t wanted[] = {0xFF, 0xFF, 0x05, 0x02, 0x01, 0xF7};

    ping(5);
    TEST_ASSERT_EQUAL_UINT16(sizeof wanted, port_fake.sent_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(wanted, port_fake.sent, sizeof wanted);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
}

void test_read_word_gives_the_value(void)
{
    assert_next_is_ok();
    TEST_ASSERT_EQUAL_UINT8(2, request.length);
}

void test_longest_read_gives_every_byte(void)
{
    uint8_t table[CDS_REPLY_MAX];
    uint8_t value = 0;

    for (uint8_t i = 0; i < sizeof table; i++)
        table[i] = (uint8_t)(255 - i * 5);
    submit_read(5, sizeof table);
    rig_transmit();
    port_fake_answer(&bus.link, 5, 0, table, sizeof table);
    assert_ended(CDS_OK);
    for (uint8_t i = 0; i < sizeof table; i++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_request_byte(&request, i, &value));
        TEST_ASSERT_EQUAL_HEX8(table[i], value);
    }
}

void test_reply_byte_by_byte_with_a_poll_after_each(void)
{
    read_word();
    for (uint8_t i = 0; i < sizeof word_reply; i++) {
        assert_pending();
        hear(word_reply + i, 1);
    }
    assert_ended(CDS_OK);
}

void test_poll_without_an_transaction_does_nothing(void)
{
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
}

void test_outcome_stays_after_further_polls(void)
{
    ping(5);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    port_fake.now_us += 1000000;
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().ok);
}

void test_submit_of_a_pending_request_changes_nothing(void)
{
    submit_ping(5);
    port_fake_forget();
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_submit(&bus, &request));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().sent);
    rig_transmit();
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
}

void test_poll_of_a_closed_bus_does_nothing(void)
{
    memset(&bus, 0, sizeof bus);
    port_fake_reset();
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_set_baud(&bus, 3));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
}

void test_set_baud_changes_rate_deadlines_and_classification(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_set_baud(&bus, 255));
    submit_ping(5);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_set_baud(&bus, 254));
    rig_transmit();
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    hear(pong, 1);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_SUSPECT, cds_bus_line(&bus));
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, port_fake.bauds[PORT]);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, 254));
    TEST_ASSERT_EQUAL_UINT8(254, port_fake.bauds[PORT]);
    TEST_ASSERT_EQUAL(CDS_BUS_LINE_QUIET, cds_bus_line(&bus));
    hear(pong, sizeof pong);
    poll_idle();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().duplicate_replies); // at this rate nobody was asked
    port_fake.now_us += 2 * 1275;
    cds_bus_poll(&bus);
    submit_ping(5);
    rig_transmit();
    assert_pending_for(12 * 1275 + 508 + 99 - 10000);
}

void test_packet_before_the_first_transaction_is_unexpected(void)
{
    port_fake_answer(&bus.link, 0, 0, NULL, 0);
    poll_idle();
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().duplicate_replies);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
}

void test_submit_to_a_closed_bus_is_refused(void)
{
    memset(&bus, 0, sizeof bus);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&request.packet, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_submit(&bus, &request));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
}

void test_more_reply_than_there_can_be_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&request.packet, 1));
    request.reply_parameters = CDS_REPLY_MAX + 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_submit(&bus, &request));
    request.reply_parameters = CDS_REPLY_NONE - 1;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_submit(&bus, &request));
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().sent);
}

void test_reply_that_would_not_fit_the_buffer_is_refused(void)
{
    request.reply_capacity = 8;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_read(&request.packet, 1, 0, 9));
    request.reply_parameters = 9;
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_bus_submit(&bus, &request));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
    request.reply_parameters = 8;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
}

void test_submit_to_a_busy_bus_without_queue_is_refused(void)
{
    uint8_t other_buffer[8];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(other_buffer);

    bus.hooks = NULL;
    ping(5);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&other.packet, 6));
    other.priority = CDS_PRIORITY_TORQUE_OFF;
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_submit(&bus, &other));
    TEST_ASSERT_NOT_EQUAL(CDS_PENDING, other.result);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_cancel(&bus, &other));
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().sent);
}

void test_any_length_takes_a_reply_longer_than_expected(void)
{
    uint8_t longest[CDS_REPLY_ANY], most[CDS_REPLY_ANY];

    memset(most, 0x11, sizeof most);
    request = (struct cds_request)CDS_REQUEST(buffer, longest);
    request.any_length = true;
    submit_ping(5);
    rig_transmit();
    port_fake_answer(&bus.link, 5, 0, most, sizeof most);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL_UINT8(sizeof most, request.length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(most, longest, sizeof most);
    request.reply_capacity--; // a byte of the longest would stand behind it
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&request.packet, 5));
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_bus_submit(&bus, &request));
}

/* A packet that does not fit the ring never gets whole, and a reply like that has no room. */
void test_packet_longer_than_the_ring_is_malformed(void)
{
    static const uint8_t head[] = {0xFF, 0xFF, 5, CDS_PARSER_LENGTH_MAX + 1, 0};
    uint8_t taken[CDS_REPLY_ANY], longest[CDS_REPLY_ANY] = {0};

    hear(head, sizeof head);
    cds_bus_poll(&bus);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().malformed);
    request = (struct cds_request)CDS_REQUEST(buffer, taken);
    request.any_length = true;
    submit_ping(5);
    rig_transmit();
    hear(head, sizeof head);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(2, rig_stats().malformed);
    assert_ends_at(PING_DEADLINE_US, CDS_CORRUPT);
    port_fake.now_us += 1000;
    cds_bus_poll(&bus);
    port_fake_answer(&bus.link, 6, 0, longest, sizeof longest);
    poll_idle();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
}

/* Neither call waits for anything: the clock stands still, and each looks at it once at most. */
void test_nothing_waits_while_the_clock_stands_still(void)
{
    submit_ping(5);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.clock_reads);
    for (uint16_t i = 0; i < 1001; i++) // the first sets the deadline
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL_UINT16(1001, port_fake.clock_reads);
    rig_transmit();
    for (uint16_t i = 0; i < 1000; i++)
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL_UINT16(2001, port_fake.clock_reads);
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
}

void test_absent_servo_times_out_at_the_deadline_and_not_before(void)
{
    ping(5);
    assert_ends_at(PING_DEADLINE_US, CDS_TIMEOUT);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().timeouts);
    assert_next_is_ok();
}

void test_reply_that_came_just_before_the_deadline_counts(void)
{
    ping(5);
    hear(pong, sizeof pong);
    port_fake.now_us += PING_DEADLINE_US;
    assert_ended(CDS_OK);
}

/* One row: rate, return delay, what is asked, and the microseconds it may take, by hand. */
static void assert_deadline(uint8_t baud, uint16_t return_delay_us, uint8_t parameters,
                            uint32_t deadline_us)
{
    open_at(baud);
    cds_bus_set_return_delay(&bus, return_delay_us);
    if (parameters)
        submit_read(5, parameters);
    else
        submit_ping(5);
    rig_transmit();
    assert_ends_at(deadline_us, CDS_TIMEOUT);
}

void test_deadline_at_1_mbps(void)
{
    assert_deadline(1, 508, 0, 728);
    assert_deadline(1, 508, 2, 768);
    assert_deadline(1, 508, 50, 1248);
}

void test_deadline_at_the_other_rates_of_the_manual(void)
{
    assert_deadline(3, 508, 0, 240 + 608);    // 20 us a byte
    assert_deadline(7, 508, 0, 480 + 608);    // 40
    assert_deadline(16, 508, 0, 1020 + 608);  // 85
    assert_deadline(34, 508, 0, 2100 + 608);  // 175
    assert_deadline(103, 508, 0, 6240 + 608); // 520
}

void test_deadline_at_the_fastest_and_slowest_rate(void)
{
    assert_deadline(0, 508, 0, 60 + 608);            // 2 Mbps: 5 us a byte
    assert_deadline(254, 508, 50, 64 * 1275L + 608); // 7843 bit/s: beyond 16 bits
}

void test_deadline_follows_the_return_delay(void)
{
    assert_deadline(1, 0, 0, 220);
    assert_deadline(1, 4, 0, 224);
    assert_deadline(103, 4, 2, 16 * 520 + 104);
}

void test_no_reply_due_has_no_return_delay(void)
{
    submit_broadcast_action();
    assert_ends_at(6 * 10 + 100, CDS_TIMEOUT); // and nobody transmits it
}

/* 258 bytes at the slowest rate: 328950 us, which does not fit 16 bits. */
void test_deadline_of_the_longest_packet_at_the_slowest_rate(void)
{
    static uint8_t longest[258];
    static struct cds_request sync = CDS_REQUEST_WITHOUT_DATA(longest);
    uint8_t one = 1;

    open_at(254);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_sync_begin(&sync.packet, 0x19, 1));
    for (uint8_t id = 0; id < 125; id++)
        cds_packet_sync_add(&sync.packet, id, &one);
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_end(&sync.packet));
    sync.reply_parameters = CDS_REPLY_NONE;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &sync));
    for (uint32_t us = 0; us < 258 * 1275L + 100; us++) {
        port_fake.now_us = us;
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    }
    port_fake.now_us++;
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, sync.result);
}

/* The port's alarm may ring too early for a deadline so far away. */
void test_distant_deadline_is_kept_by_a_bus_polled_all_the_time(void)
{
    open_at(254);
    submit_read(5, 50);
    rig_transmit();
    for (uint8_t i = 0; i < 82; i++) {
        assert_pending();
        port_fake.now_us += 1000;
    }
    assert_ends_at(64 * 1275L + 608 - 82000, CDS_TIMEOUT);
}

void test_clock_wraps_during_an_transaction(void)
{
    port_fake.now_us = 0xFFFFFFFF - 100;
    ping(5);
    assert_ends_at(PING_DEADLINE_US, CDS_TIMEOUT);
    port_fake.now_us = 0xFFFFFFFF - 100;
    assert_next_is_ok();
}

void test_clock_wraps_exactly_at_the_deadline(void)
{
    port_fake.now_us = (uint32_t)0 - PING_DEADLINE_US;
    ping(5);
    assert_ends_at(PING_DEADLINE_US, CDS_TIMEOUT);
    TEST_ASSERT_EQUAL_HEX32(0, port_fake.now_us);
}

void test_clock_in_the_middle_of_its_range(void)
{
    port_fake.now_us = 0x7FFFFFFF - 100;
    ping(5);
    assert_ends_at(PING_DEADLINE_US, CDS_TIMEOUT);
}

void test_poll_100_ms_late_loses_nothing(void)
{
    read_word();
    hear(word_reply, sizeof word_reply);
    port_fake.now_us += 100000;
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(2, request.length);
}

void test_reply_with_the_line_babbling_behind_it_is_taken(void)
{
    read_word();
    hear(word_reply, sizeof word_reply);
    for (uint8_t i = 0; i < 200; i++)
        cds_link_on_rx(&bus.link, 0xFF, 0);
    port_fake.now_us += 100000;
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT16(200 - (CDS_RING_SIZE - 8), rig_stats().ring_overflows);
    assert_next_is_ok();
}

void test_reply_then_a_damaged_byte_is_taken(void)
{
    read_word();
    hear(word_reply, sizeof word_reply);
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    assert_ended(CDS_OK);
    assert_next_is_ok();
}

void test_wrong_id_waits_on_and_is_counted(void)
{
    ping(5);
    port_fake_answer(&bus.link, 6, 0, NULL, 0);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(5, request.id);
}

void test_only_wrong_ids_time_out(void)
{
    ping(5);
    for (uint8_t i = 0; i < 3; i++)
        port_fake_answer(&bus.link, 6, 0, NULL, 0);
    assert_ends_at(PING_DEADLINE_US, CDS_TIMEOUT);
    TEST_ASSERT_EQUAL_UINT16(3, rig_stats().unexpected_packets);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().malformed);
}

void test_wrong_id_byte_by_byte_is_unexpected_not_malformed(void)
{
    static const uint8_t foreign[] = {0xFF, 0xFF, 0x06, 0x02, 0x00, 0xF7};

    ping(5);
    for (uint8_t i = 0; i < sizeof foreign; i++) {
        hear(foreign + i, 1);
        assert_pending();
    }
    assert_ends_at(PING_DEADLINE_US, CDS_TIMEOUT);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().malformed);
}

void test_wrong_id_with_a_wrong_checksum_is_corrupt(void)
{
    static const uint8_t damaged[] = {0xFF, 0xFF, 0x06, 0x02, 0x00, 0xF6};

    ping(5);
    hear(damaged, sizeof damaged);
    assert_ends_at(PING_DEADLINE_US, CDS_CORRUPT);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().unexpected_packets);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().malformed);
}

void test_wrong_id_with_error_bits_is_no_reply(void)
{
    ping(5);
    port_fake_answer(&bus.link, 6, CDS_ERROR_RANGE, NULL, 0);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
}

void test_stale_reply_is_dropped_before_the_next_packet(void)
{
    uint8_t old[2] = {0x11, 0x11};

    read_word();
    assert_ends_at(WORD_DEADLINE_US, CDS_TIMEOUT);
    port_fake_answer(&bus.link, 5, 0, old, 2); // too late
    assert_next_is_ok();                       // and not 0x1111
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().unexpected_packets);
}

void test_submit_after_ok_is_sent_at_once_despite_an_old_timeout(void)
{
    cds_bus_set_return_delay(&bus, 2);
    ping(9);
    assert_ends_at(222, CDS_TIMEOUT); // 506 us more if it is set to that
    assert_next_is_ok();
    submit_ping(5);
    TEST_ASSERT_EQUAL(CDS_LINK_TALKING, bus.link.state);
    rig_transmit();
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
}

void test_broadcast_write_does_not_change_classification(void)
{
    assert_next_is_ok();
    submit_broadcast_action();
    rig_transmit();
    assert_ended(CDS_OK);
    port_fake_answer(&bus.link, 7, 0, NULL, 0);
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    poll_idle();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets); // 7
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().duplicate_replies);  // 5
}

void test_half_a_stale_reply_is_dropped_before_the_next_packet(void)
{
    read_word();
    hear(word_reply, 5);
    assert_ends_at(WORD_DEADLINE_US, CDS_TIMEOUT);
    hear(word_reply + 5, 3);
    assert_next_is_ok();
}

void test_mark_of_an_old_damage_is_gone_before_the_next(void)
{
    cds_link_on_rx(&bus.link, 0, CDS_LINE_OVERRUN);
    assert_next_is_ok();
    read_word();
    assert_ends_at(WORD_DEADLINE_US, CDS_TIMEOUT); // not corrupt
}

void test_refusal_without_parameters_ends_a_read(void)
{
    uint8_t value = 0xAA;

    submit_read(5, 1);
    rig_transmit();
    port_fake_answer(&bus.link, 5, CDS_ERROR_RANGE, NULL, 0);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, request.error);
    TEST_ASSERT_EQUAL_UINT8(0, request.length);
    TEST_ASSERT_EQUAL(CDS_REFUSED, cds_request_byte(&request, 0, &value));
    TEST_ASSERT_EQUAL_HEX8(0xAA, value);
}

/* F19: a condition that merely holds comes with the data. */
void test_all_error_bits_reach_the_caller_with_the_data(void)
{
    for (uint8_t bit = 0; bit < 7; bit++) { // bit 7 is always 0
        uint8_t data[2] = {0x34, 0x12};
        uint16_t value = 0;

        read_word();
        port_fake_answer(&bus.link, 5, (uint8_t)(1 << bit), data, 2);
        assert_ended(CDS_OK);
        TEST_ASSERT_EQUAL_HEX8(1 << bit, request.error);
        TEST_ASSERT_EQUAL(CDS_OK, cds_request_word(&request, 0, &value));
        TEST_ASSERT_EQUAL_HEX16(0x1234, value);
    }
}

/* The same request again: what the last reply brought must not be taken for this one's. */
void test_a_refusal_with_half_the_data_is_no_reply(void)
{
    static const uint8_t half[] = {1, 2};

    submit_read(5, 4);
    rig_transmit();
    port_fake_answer(&bus.link, 5, CDS_ERROR_RANGE, half, sizeof half);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
}

void test_new_transaction_begins_with_a_clean_request(void)
{
    uint8_t data[2] = {0x34, 0x12};

    read_word();
    port_fake_answer(&bus.link, 5, CDS_ERROR_VOLTAGE, data, 2);
    assert_ended(CDS_OK);
    submit_broadcast_action();
    rig_transmit();
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_HEX8(0, request.error);
    TEST_ASSERT_EQUAL_UINT8(0, request.length);
    TEST_ASSERT_EQUAL_HEX8(CDS_BROADCAST_ID, request.id);
}

void test_short_read_reply_is_no_reply(void)
{
    uint8_t data[1] = {0x34};

    read_word();
    port_fake_answer(&bus.link, 5, 0, data, 1);
    assert_pending();
    port_fake_answer(&bus.link, 5, CDS_ERROR_VOLTAGE, data, 1); // nor with a condition
    assert_pending();
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    assert_ends_at(WORD_DEADLINE_US, CDS_TIMEOUT);
    TEST_ASSERT_EQUAL_UINT16(3, rig_stats().unexpected_packets);
    assert_next_is_ok();
}

void test_long_read_reply_is_no_reply(void)
{
    uint8_t data[3] = {1, 2, 3};

    read_word();
    port_fake_answer(&bus.link, 5, 0, data, 3);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().malformed); // as soon as its LENGTH is seen
    TEST_ASSERT_EQUAL_HEX8(0, reply[0]);                // nothing of it was stored
}

void test_reply_with_bit_7_of_error_is_unexpected(void)
{
    uint8_t data[2] = {1, 2};

    read_word();
    port_fake_answer(&bus.link, 5, 0x80, data, 2);
    port_fake_look(&bus);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
}

void test_read_answered_with_a_condition_and_no_data_is_no_reply(void)
{
    read_word();
    port_fake_answer(&bus.link, 5, CDS_ERROR_OVERLOAD, NULL, 0);
    assert_pending();
    port_fake_answer(&bus.link, 5, CDS_ERROR_RANGE | CDS_ERROR_OVERLOAD, NULL, 0);
    assert_ended(CDS_OK);
}

void test_cut_header_with_a_large_length_does_not_hide_the_reply(void)
{
    static const uint8_t stray[] = {0xFF, 0xFF, 5, 40};

    read_word();
    hear(stray, sizeof stray);
    hear(word_reply, sizeof word_reply);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().malformed);
}

void test_bytes_between_two_damaged_ones_are_dropped(void)
{
    read_word();
    hear(word_reply, 4);
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    hear(word_reply + 4, 4); // would complete it
    cds_link_on_rx(&bus.link, 0, CDS_LINE_OVERRUN);
    hear(word_reply, sizeof word_reply);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().unexpected_packets);
}

void test_idle_bus_takes_unasked_bytes_out_of_the_ring(void)
{
    for (uint16_t i = 0; i < 3 * CDS_RING_SIZE; i++) {
        hear(word_reply, 1);
        TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    }
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().ring_overflows);
}

void test_opening_again_cancels_the_transaction_in_flight(void)
{
    submit_read(5, 2);
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, request.result);
    TEST_ASSERT_NULL(bus.request);
    assert_next_is_ok();
}

/* The reply buffer is exactly as long as the parameters. The packet stays as it is. */
void test_nothing_is_stored_past_the_buffer(void)
{
    uint8_t data[10], packet[sizeof buffer];

    memset(data, 0x5A, sizeof data);
    memset(reply, 0xA5, sizeof reply);
    request.reply_capacity = 10;
    submit_read(5, 10);
    memcpy(packet, buffer, sizeof packet);
    rig_transmit();
    port_fake_answer(&bus.link, 5, 0, data, 10);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, buffer, sizeof packet);
    TEST_ASSERT_EQUAL_HEX8(0x5A, reply[9]);
    for (uint8_t i = 10; i < sizeof reply; i++)
        TEST_ASSERT_EQUAL_HEX8(0xA5, reply[i]);
}

void test_broadcast_ping_is_answered_by_any_servo(void)
{
    for (uint16_t id = 0; id <= CDS_ID_MAX; id++) {
        ping(CDS_BROADCAST_ID);
        port_fake_answer(&bus.link, (uint8_t)id, 0, NULL, 0);
        assert_ended(CDS_OK);
        TEST_ASSERT_EQUAL_UINT8(id, request.id);
    }
}

/* No servo has that ID; the packet's own echo, for one, looks like such a reply. */
/* R27: any number of FF before an ID; nothing of it is taken for an ID. */
void test_broadcast_ping_takes_a_reply_after_a_third_FF(void)
{
    static const uint8_t header[] = {0xFF};

    ping(CDS_BROADCAST_ID);
    hear(header, sizeof header);
    port_fake_answer(&bus.link, 2, 0, NULL, 0); // its ID is the LENGTH due
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(2, request.id);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().malformed);
}

/* A caller that overlooks CDS_BUSY must not take the value of the time before for a new one. */
void test_a_refused_request_gives_no_old_value(void)
{
    static uint8_t other_buffer[8];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(other_buffer);
    uint16_t value = 0x5A5A;

    assert_next_is_ok();
    bus.hooks = NULL;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&other.packet, 6));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
    request.reply_parameters = 2;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_read(&request.packet, 5, 0x24, 2));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_submit(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_request_word(&request, 0, &value));
    TEST_ASSERT_EQUAL_HEX16(0x5A5A, value);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    port_fake.now_us += 1000;
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, other.result);
}

void test_packet_that_was_never_ended_is_refused(void)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_submit(&bus, &request)); // nor begun
    cds_packet_begin(&request.packet, 5, CDS_PING);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_submit(&bus, &request));
    TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[PORT]);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().sent);
}

void test_reply_from_the_broadcast_id_is_no_reply(void)
{
    ping(CDS_BROADCAST_ID);
    port_fake_answer(&bus.link, CDS_BROADCAST_ID, 0x01, NULL, 0);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
}

void test_no_reply_due_ends_when_the_driver_is_released(void)
{
    submit_broadcast_action();
    assert_pending();
    TEST_ASSERT_TRUE(port_fake_drain(&bus.link, PORT));
    assert_pending(); // the last byte is still on the line
    cds_link_on_tx_complete(&bus.link, PORT);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_HEX8(0, request.error);
    TEST_ASSERT_EQUAL_UINT8(0, request.length);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().ok);
}

/* A handler of the program's own took until the deadline, amid a poll that had seen the driver talk
 * yet. */
void test_no_reply_due_that_completes_at_the_deadline_is_ok(void)
{
    submit_broadcast_action();
    assert_pending();
    TEST_ASSERT_TRUE(port_fake_drain(&bus.link, PORT));
    port_fake.now_us += 10000;
    port_fake.late = &bus.link;
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    assert_ended(CDS_OK);
}

void test_no_reply_due_gives_no_value(void)
{
    uint8_t value = 0xAA;

    submit_broadcast_action();
    rig_transmit();
    assert_ended(CDS_OK);
    TEST_ASSERT_NOT_EQUAL(CDS_OK, cds_request_byte(&request, 0, &value));
    TEST_ASSERT_EQUAL_HEX8(0xAA, value);
}

static void assert_stuck_after(uint8_t bytes)
{
    open_at(CDS_BAUD_1M);
    submit_ping(5);
    for (uint8_t i = 0; i < bytes; i++)
        cds_link_on_tx_ready(&bus.link, PORT);
    assert_ends_at(PING_DEADLINE_US, CDS_TIMEOUT);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().timeouts);
    assert_next_is_ok();
}

void test_transmitter_that_stops_is_aborted_at_the_deadline(void)
{
    for (uint8_t bytes = 0; bytes <= 5; bytes++) // behind the first; 5: all given, never complete
        assert_stuck_after(bytes);
}

void test_reply_is_not_parsed_while_the_packet_is_being_sent(void)
{
    submit_ping(5);
    TEST_ASSERT_TRUE(port_fake_drain(&bus.link, PORT));
    hear(pong, sizeof pong);
    assert_pending();
}

void test_line_error_at_every_position_of_a_reply_never_splices(void)
{
    for (uint8_t at = 0; at <= sizeof word_reply; at++) {
        setUp();
        read_word();
        hear(word_reply, at);
        cds_link_on_rx(&bus.link, 0x00, CDS_LINE_FRAMING); // one byte too many, damaged
        hear(word_reply + at, (uint8_t)(sizeof word_reply - at));
        if (at == 0 || at == sizeof word_reply) {
            assert_ended(CDS_OK); // it came before or after the reply: polling late loses nothing
            continue;
        }
        assert_ends_at(WORD_DEADLINE_US, CDS_CORRUPT);
        TEST_ASSERT_EQUAL_UINT16(1, rig_stats().framing_errors);
        assert_next_is_ok();
    }
}

/* Two halves that would make a sound packet, if what lies between were forgotten. */
void test_damaged_byte_in_place_of_a_good_one_is_not_bridged(void)
{
    for (uint8_t at = 0; at < sizeof word_reply; at++) {
        setUp();
        read_word();
        hear(word_reply, at);
        cds_bus_poll(&bus);
        cds_link_on_rx(&bus.link, word_reply[at], CDS_LINE_OVERRUN);
        cds_bus_poll(&bus);
        hear(word_reply + at, (uint8_t)(sizeof word_reply - at));
        if (at == 0) {
            assert_ended(CDS_OK); // all of it came, after the damage
            continue;
        }
        assert_ends_at(WORD_DEADLINE_US, CDS_CORRUPT);
        assert_next_is_ok();
    }
}

/* The second reply has a good checksum: the bus takes it, with ID, error bits and data of its own.
 */
void test_good_reply_after_one_with_a_wrong_checksum_is_taken(void)
{
    static const uint8_t bad_word[] = {0xFF, 0xFF, 0x05, 0x04, 0x00, 0x99, 0x88, 0x00};
    static const uint8_t bad_refusal[] = {0xFF, 0xFF, 0x05, 0x02, 0x08, 0x00};
    static const uint8_t bad_pong[] = {0xFF, 0xFF, 0x07, 0x02, 0x00, 0x00};
    uint16_t value = 0;

    read_word();
    hear(bad_word, sizeof bad_word);
    assert_pending();
    hear(word_reply, sizeof word_reply);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, cds_request_word(&request, 0, &value));
    TEST_ASSERT_EQUAL_HEX16(0x1234, value);
    read_word();
    hear(bad_refusal, sizeof bad_refusal);
    port_fake_look(&bus);
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&bus.link.rx));
    hear(word_reply, sizeof word_reply);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(2, request.length);
    ping(CDS_BROADCAST_ID);
    hear(bad_pong, sizeof bad_pong);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(5, request.id);
}

/* When all that is skipped in a poll is all there was before it. */
void test_damage_behind_as_much_noise_as_a_poll_skips_is_corrupt(void)
{
    static const uint8_t noise[CDS_PARSER_SKIPPED_MAX] = {0};

    ping(5);
    assert_pending();
    port_fake.now_us += PING_DEADLINE_US;
    hear(noise, sizeof noise);
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    assert_ended(CDS_CORRUPT);
}

void test_a_damaged_last_byte_is_corrupt(void)
{
    read_word();
    hear(word_reply, sizeof word_reply - 1);
    assert_pending();
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    assert_ends_at(WORD_DEADLINE_US, CDS_CORRUPT);
}

/* What stands before the damage is whole, however little of it a poll takes. */
void test_a_long_reply_with_damage_behind_it_is_taken(void)
{
    uint8_t table[50] = {0};

    submit_read(5, 50);
    rig_transmit();
    port_fake_answer(&bus.link, 5, 0, table, sizeof table);
    for (uint8_t i = 0; i < 3; i++) // deadline, head, some parameters
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    assert_ended(CDS_OK);
}

void test_good_reply_after_a_damaged_one_is_taken(void)
{
    read_word();
    hear(word_reply, 4);
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    assert_pending();
    hear(word_reply, sizeof word_reply);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().corrupt);
}

/* The packet is sent again as it was, whatever has come of the reply. */
static void assert_read_is_sent_again(const uint8_t *bytes, uint8_t count, uint8_t due)
{
    uint8_t packet[8];
    uint16_t deadline_us = (uint16_t)(WORD_DEADLINE_US + due * 10u);

    cds_queue_set_retries(&queue, 1);
    submit_read(5, due);
    rig_transmit();
    memcpy(packet, buffer, sizeof packet);
    for (uint8_t i = 0; i < count; i++) {
        hear(bytes + i, 1);
        assert_pending();
    }
    port_fake.now_us += deadline_us;
    port_fake_look(&bus);
    assert_pending();
    rig_transmit();
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, port_fake.sent, sizeof packet);
    assert_pending();
    port_fake.now_us += deadline_us;
    assert_ended(CDS_TIMEOUT);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, buffer, sizeof packet);
    TEST_ASSERT_EQUAL_UINT8(5, request.id);
    TEST_ASSERT_EQUAL_HEX8(0, request.error);
    TEST_ASSERT_EQUAL_UINT8(0, request.length);
    cds_queue_set_retries(&queue, 0);
}

void test_a_read_that_failed_amid_its_reply_is_sent_again(void)
{
    static const uint8_t eleven[] = {0xFF, 0xFF, 0x05, 0x0D, 0x20, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
    uint8_t bytes[sizeof word_reply];

    for (uint8_t count = 0; count < sizeof word_reply; count++)
        assert_read_is_sent_again(word_reply, count, 2);
    memcpy(bytes, word_reply, sizeof bytes);
    bytes[7] ^= 0x01;
    assert_read_is_sent_again(bytes, sizeof bytes, 2);
    bytes[4] = 0x80; // no servo's
    assert_read_is_sent_again(bytes, sizeof bytes, 2);
    assert_read_is_sent_again(eleven, sizeof eleven, 11);
}

void test_ended_request_is_submitted_again_as_it_stands(void)
{
    uint8_t packet[8];

    assert_next_is_ok();
    memcpy(packet, buffer, sizeof packet);
    for (uint8_t i = 0; i < 5; i++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
        rig_transmit();
        TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, port_fake.sent, sizeof packet);
        if (i & 1) {
            port_fake.now_us += WORD_DEADLINE_US;
            assert_ended(CDS_TIMEOUT);
        } else {
            hear(word_reply, sizeof word_reply);
            assert_ended(CDS_OK);
        }
    }
    TEST_ASSERT_EQUAL_UINT16(4, rig_stats().ok);
    TEST_ASSERT_EQUAL_UINT16(2, rig_stats().timeouts);
}

void test_a_damaged_byte_in_a_reply_that_is_taken_is_not_bridged(void)
{
    for (uint8_t at = 4; at < sizeof word_reply; at++) {
        setUp();
        read_word();
        for (uint8_t i = 0; i < sizeof word_reply; i++) {
            if (i == at)
                cds_link_on_rx(&bus.link, 0x00, CDS_LINE_FRAMING);
            hear(word_reply + i, 1);
            assert_pending();
        }
        assert_ends_at(WORD_DEADLINE_US, CDS_CORRUPT);
        assert_next_is_ok();
    }
}

void test_wrong_checksum_is_corrupt_at_the_deadline(void)
{
    uint8_t bytes[sizeof word_reply];

    memcpy(bytes, word_reply, sizeof bytes);
    bytes[5] ^= 0x08;
    read_word();
    hear(bytes, sizeof bytes);
    assert_ends_at(WORD_DEADLINE_US, CDS_CORRUPT);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().corrupt);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().malformed);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().timeouts);
    assert_next_is_ok();
}

/* F1, over bytes and error bits chosen so that a bit of LENGTH can make another sound packet. */
void test_single_bit_flip_never_gives_a_value_not_sent(void)
{
    static const uint8_t values[] = {0x00, 0x01, 0x20, 0xDB, 0xF8, 0xF7, 0xFF};

    for (uint8_t v = 0; v < sizeof values; v++)
        for (uint8_t error = 0; error <= 0x20; error = (uint8_t)(error + 0x20))
            for (uint8_t bit = 0; bit < 56; bit++) {
                uint8_t reply[7] = {0xFF, 0xFF, 0x05, 0x03, error, values[v]};
                uint8_t value = 0xAA;

                reply[6] = (uint8_t) ~(0x05 + 0x03 + error + values[v]);
                reply[bit / 8] = (uint8_t)(reply[bit / 8] ^ 1 << bit % 8);
                submit_read(5, 1);
                rig_transmit();
                hear(reply, sizeof reply);
                port_fake.now_us += 2000;
                port_fake_look(&bus);
                TEST_ASSERT_FALSE(cds_bus_poll(&bus));
                TEST_ASSERT_NOT_EQUAL(CDS_OK, cds_request_byte(&request, 0, &value));
                TEST_ASSERT_EQUAL_HEX8(0xAA, value);
            }
}

/* F3, F4: a byte too few or too many, anywhere; then the next transaction. */
void test_byte_lost_at_every_position(void)
{
    for (uint8_t at = 0; at < sizeof word_reply; at++) {
        read_word();
        hear(word_reply, at);
        hear(word_reply + at + 1, (uint8_t)(sizeof word_reply - 1 - at));
        port_fake.now_us += WORD_DEADLINE_US;
        port_fake_look(&bus);
        TEST_ASSERT_FALSE(cds_bus_poll(&bus));
        TEST_ASSERT_TRUE(request.result == CDS_TIMEOUT || request.result == CDS_CORRUPT);
        assert_next_is_ok();
    }
}

static uint16_t values_not_sent_with_extra(uint8_t extra)
{
    uint16_t wrong = 0;

    for (uint8_t at = 0; at <= sizeof word_reply; at++) {
        uint16_t value = 0x1234;

        read_word();
        hear(word_reply, at);
        hear(&extra, 1);
        hear(word_reply + at, (uint8_t)(sizeof word_reply - at));
        port_fake.now_us += WORD_DEADLINE_US;
        port_fake_look(&bus);
        TEST_ASSERT_FALSE(cds_bus_poll(&bus));
        cds_request_word(&request, 0, &value);
        if (value != 0x1234)
            wrong++;
    }
    return wrong;
}

void test_extra_byte_anywhere_never_gives_a_value_not_sent(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, values_not_sent_with_extra(0x00));
    TEST_ASSERT_EQUAL_UINT16(0, values_not_sent_with_extra(0xFF));
    TEST_ASSERT_EQUAL_UINT16(0, values_not_sent_with_extra(0x55));
    assert_next_is_ok();
}

/* What a sum cannot tell: a copy of the checksum, slipped in before a parameter, leaves a packet
 * whose last parameter is the right checksum. (Before ERROR it sets bit 7, which no servo does.)
 * Nothing else of 256 x 9 goes unnoticed. */
void test_extra_byte_passes_only_as_a_copy_of_the_checksum(void)
{
    for (uint16_t extra = 0; extra < 256; extra++)
        TEST_ASSERT_EQUAL_UINT16(extra == word_reply[7] ? 2 : 0,
                                 values_not_sent_with_extra((uint8_t)extra));
}

/* F10: the line held low is a framing error for every byte time. */
void test_line_stuck_low_ends_corrupt_and_recovers(void)
{
    ping(5);
    for (uint16_t i = 0; i < 70; i++) {
        cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
        assert_pending();
        port_fake.now_us += 10;
    }
    port_fake.now_us += PING_DEADLINE_US - 700;
    assert_ended(CDS_CORRUPT);
    TEST_ASSERT_EQUAL_UINT16(70, rig_stats().framing_errors);
    assert_next_is_ok();
}

/* F9: bytes for ever, or headers for ever: each poll returns, and the last one at the deadline. */
static void assert_babble_ends(const uint8_t *bytes, uint8_t count, uint8_t per_poll)
{
    uint16_t polls = 0;
    uint8_t at = 0;

    open_at(CDS_BAUD_1M);
    ping(5);
    do {
        for (uint8_t i = 0; i < per_poll; i++) {
            cds_link_on_rx(&bus.link, bytes[at], 0);
            at = (uint8_t)((at + 1) % count);
        }
        port_fake.now_us += 10;
        polls++;
        // then what was there at the deadline is examined: of a full ring little in each poll
        TEST_ASSERT_TRUE(polls <= (PING_DEADLINE_US + 9) / 10 + (per_poll > 1 ? 30 : 3));
    } while (cds_bus_poll(&bus));
    TEST_ASSERT_TRUE(request.result == CDS_TIMEOUT || request.result == CDS_CORRUPT);
    assert_next_is_ok();
}

void test_babbling_line_ends_by_its_deadline(void)
{
    static const uint8_t headers[] = {0xFF}, zeros[] = {0x00}, candidates[] = {0xFF, 0xFF, 1, 60},
                         foreign[] = {0xFF, 0xFF, 1, 2, 0, 0xFC};

    assert_babble_ends(headers, sizeof headers, 1);
    assert_babble_ends(zeros, sizeof zeros, 1);
    assert_babble_ends(candidates, sizeof candidates, 1);
    assert_babble_ends(foreign, sizeof foreign, 1);
    assert_babble_ends(foreign, sizeof foreign, 100); // more than a ring between two polls
    assert_babble_ends(candidates, sizeof candidates, 100);
}

/* A poll looks at few bytes; what was there at the deadline is looked at before it is judged. */
void test_the_longest_reply_behind_noise_is_taken_however_late(void)
{
    static const uint8_t noise[] = {1, 2, 3, 4, 5, 6, 7, 8};
    uint8_t table[50] = {0}, polls = 0;

    submit_read(5, 50);
    rig_transmit();
    hear(noise, sizeof noise);
    port_fake_answer(&bus.link, 5, 0, table, sizeof table);
    port_fake.now_us += 100000;
    while (cds_bus_poll(&bus))
        polls++;
    // the deadline, the noise, the head, then so many parameters each time
    TEST_ASSERT_EQUAL_UINT8(3 + 50 / CDS_PARSER_TAKEN_MAX, polls);
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
    TEST_ASSERT_EQUAL_UINT16(0,
                             rig_stats().unexpected_packets); // what is taken is not searched
}

/* A poll sets the deadline, one finds the head, one takes the parameters. */
void test_reply_of_twelve_bytes_after_its_head_takes_three_polls(void)
{
    static const uint8_t values[CDS_PARSER_TAKEN_MAX - 1] = {0};

    submit_read(5, sizeof values);
    rig_transmit();
    port_fake_answer(&bus.link, 5, 0, values, sizeof values);
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_TRUE(cds_bus_poll(&bus));
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, request.result);
}

void test_bytes_after_the_deadline_do_not_delay_the_end(void)
{
    ping(5);
    assert_pending();
    port_fake.now_us += PING_DEADLINE_US;
    for (uint8_t i = 0; i < 60; i++)
        cds_link_on_rx(&bus.link, 0, 0);
    for (uint8_t polls = 0; polls < 1 + 60 / CDS_PARSER_SKIPPED_MAX; polls++) {
        TEST_ASSERT_TRUE(cds_bus_poll(&bus));
        for (uint8_t j = 0; j < 40; j++)
            cds_link_on_rx(&bus.link, 0, 0);
    }
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
}

/* What was there when the deadline was seen to pass is still looked at, and nothing behind it. */
void test_reply_while_the_transaction_closes_is_stale(void)
{
    ping(5);
    port_fake.now_us += PING_DEADLINE_US;
    for (uint8_t i = 0; i < 30; i++)
        cds_link_on_rx(&bus.link, 0, 0);
    for (uint8_t polls = 0; polls < 2 + 30 / CDS_PARSER_SKIPPED_MAX; polls++)
        TEST_ASSERT_TRUE(cds_bus_poll(&bus)); // the first one sets the deadline
    port_fake_answer(&bus.link, 5, 0, NULL, 0);
    TEST_ASSERT_FALSE(cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, request.result);
    poll_idle();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().stale_replies);
}

void test_ring_full_of_noise_and_late_polls_is_corrupt(void)
{
    ping(5);
    for (uint8_t i = 0; i < CDS_RING_SIZE + 10; i++)
        cds_link_on_rx(&bus.link, 0x00, 0);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(10, rig_stats().ring_overflows);
    assert_ends_at(PING_DEADLINE_US, CDS_CORRUPT);
}

/* As many as there can be: the index of the damaged one lies as far behind the head as it ever
 * does.
 */
void test_damage_before_a_full_ring_is_dropped(void)
{
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    for (uint8_t i = 0; i < CDS_RING_SIZE; i++)
        cds_link_on_rx(&bus.link, 0, 0);
    for (uint8_t polls = 0; polls <= CDS_RING_SIZE / CDS_PARSER_SKIPPED_MAX; polls++)
        cds_bus_poll(&bus);
    TEST_ASSERT_FALSE(bus.link.broken);
    assert_next_is_ok();
}

void test_failed_request_gives_no_value(void)
{
    uint8_t byte = 0xAA;
    uint16_t word = 0xAAAA;

    read_word();
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_request_byte(&request, 0, &byte));
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_request_word(&request, 0, &word));
    assert_ends_at(WORD_DEADLINE_US, CDS_TIMEOUT);
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_request_byte(&request, 0, &byte));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, cds_request_word(&request, 0, &word));
    TEST_ASSERT_EQUAL_HEX8(0xAA, byte);
    TEST_ASSERT_EQUAL_HEX16(0xAAAA, word);
}

void test_index_past_the_reply_gives_no_value(void)
{
    uint8_t byte = 0xAA;
    uint16_t word = 0xAAAA;

    assert_next_is_ok();
    TEST_ASSERT_EQUAL(CDS_OK, cds_request_byte(&request, 1, &byte));
    TEST_ASSERT_EQUAL_HEX8(0x12, byte);
    TEST_ASSERT_EQUAL(CDS_REFUSED, cds_request_byte(&request, 2, &byte));
    TEST_ASSERT_EQUAL(CDS_REFUSED, cds_request_word(&request, 1, &word)); // half of it is there
    TEST_ASSERT_EQUAL(CDS_REFUSED, cds_request_word(&request, 255, &word));
    TEST_ASSERT_EQUAL_HEX8(0x12, byte);
    TEST_ASSERT_EQUAL_HEX16(0xAAAA, word);
}

void test_a_word_is_found_by_its_index(void)
{
    static const uint8_t parameters[] = {1, 2, 3, 4};
    uint16_t word = 0;

    submit_read(5, sizeof parameters);
    rig_transmit();
    port_fake_answer(&bus.link, 5, 0, parameters, sizeof parameters);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL(CDS_OK, cds_request_word(&request, 2, &word));
    TEST_ASSERT_EQUAL_HEX16(0x0403, word);
}

void test_stats_of_one_transaction_of_each_kind(void)
{
    struct cds_stats count;

    assert_next_is_ok(); // ok
    read_word();         // timeout
    assert_ends_at(WORD_DEADLINE_US, CDS_TIMEOUT);
    read_word(); // corrupt
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING | CDS_LINE_OVERRUN);
    cds_link_on_rx(&bus.link, 0, CDS_LINE_OVERRUN);
    assert_ends_at(WORD_DEADLINE_US, CDS_CORRUPT);
    submit_broadcast_action(); // no reply due
    rig_transmit();
    assert_ended(CDS_OK);
    cds_bus_stats(&bus, &count);
    TEST_ASSERT_EQUAL_UINT16(4, count.sent);
    TEST_ASSERT_EQUAL_UINT16(2, count.ok);
    TEST_ASSERT_EQUAL_UINT16(1, count.timeouts);
    TEST_ASSERT_EQUAL_UINT16(1, count.corrupt);
    TEST_ASSERT_EQUAL_UINT16(1, count.framing_errors);
    TEST_ASSERT_EQUAL_UINT16(2, count.overruns);
    TEST_ASSERT_EQUAL_UINT16(0, count.ring_overflows);
}

/* Handlers count in 8 bits; the bus adds up when it looks. */
void test_damage_is_counted_modulo_65536(void)
{
    for (uint16_t looks = 0; looks < 330; looks++) {
        for (uint8_t i = 0; i < 100; i++) {
            cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING | CDS_LINE_OVERRUN);
            cds_link_on_rx(&bus.link, 0, i & 1 ? CDS_LINE_FRAMING : CDS_LINE_OVERRUN);
        }
        cds_bus_poll(&bus);
    }
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING); // not looked at yet
    TEST_ASSERT_EQUAL_UINT16(49501, rig_stats().framing_errors);
    TEST_ASSERT_EQUAL_UINT16(49500, rig_stats().overruns);
}

void test_every_byte_too_many_is_counted(void)
{
    for (uint16_t looks = 0; looks < 300; looks++) {
        for (uint8_t i = 0; i < CDS_RING_SIZE + 3; i++)
            cds_link_on_rx(&bus.link, 0, 0);
        TEST_ASSERT_EQUAL_UINT16(3 * (looks + 1), rig_stats().ring_overflows);
        for (uint8_t polls = 0; polls <= CDS_RING_SIZE / CDS_PARSER_SKIPPED_MAX; polls++)
            cds_bus_poll(&bus);
        TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&bus.link.rx));
    }
    TEST_ASSERT_EQUAL_UINT16(900, rig_stats().ring_overflows);
}

/* Two buses share nothing. */
void test_two_buses_do_not_meet(void)
{
    static struct cds_bus other;
    static uint8_t other_buffer[8];
    struct cds_request other_request = CDS_REQUEST_WITHOUT_DATA(other_buffer);

    memset(&other, 0, sizeof other);
    cds_bus_open(&other, PORT + 1, CDS_BAUD_1M);
    other_request.reply_parameters = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_ping(&other_request.packet, 5));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&other, &other_request));
    TEST_ASSERT_TRUE(port_fake_transmit(&other.link, PORT + 1));
    ping(5);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    TEST_ASSERT_TRUE(cds_bus_poll(&other));
    TEST_ASSERT_EQUAL(CDS_PENDING, other_request.result);
    port_fake_answer(&other.link, 5, 0, NULL, 0);
    port_fake_look(&other);
    TEST_ASSERT_EQUAL(CDS_OK, other_request.result);
}

void test_submit_of_a_request_pending_on_another_bus_is_refused(void)
{
    static struct cds_bus other;

    memset(&other, 0, sizeof other);
    cds_bus_open(&other, PORT + 1, CDS_BAUD_1M);
    ping(5);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_submit(&other, &request));
    TEST_ASSERT_EQUAL(CDS_BUS_IDLE, other.state);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
}

/* A bus without hooks, and a request without on_end, end by a shorter path. */
void test_reply_damaged_then_another_packet_without_hooks_corrupt(void)
{
    static const uint8_t bad_pong[] = {0xFF, 0xFF, 0x05, 0x02, 0x00, 0x00};

    bus.hooks = NULL;
    ping(5);
    hear(bad_pong, sizeof bad_pong);
    port_fake_answer(&bus.link, 6, 0, NULL, 0);
    assert_pending();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().unexpected_packets);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
}

void test_duplicate_reply_on_a_bus_without_hooks(void)
{
    bus.hooks = NULL;
    ping(5);
    hear(pong, sizeof pong);
    assert_ended(CDS_OK);
    hear(pong, sizeof pong);
    poll_idle();
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().duplicate_replies);
    TEST_ASSERT_EQUAL_UINT16(1, rig_stats().ok);
}

static uint32_t random_state;

static uint8_t random_below(uint8_t limit)
{
    random_state = random_state * 1103515245u + 12345u;
    return (uint8_t)((random_state >> 16) % limit);
}

/* One transaction of the storm. The reply of 8 bytes is 0x1234, whatever is done to it. */
static void suffer(uint8_t fault)
{
    uint8_t at = random_below(sizeof word_reply);
    uint8_t bytes[sizeof word_reply];

    submit_read(5, 2);
    if (fault == 0) { // the transmitter stops
        port_fake_settle(&bus);
        cds_link_on_tx_ready(&bus.link, PORT);
        return;
    }
    rig_transmit();
    memcpy(bytes, word_reply, sizeof bytes);
    switch (fault) {
    case 1: break; // absent
    case 2:        // a bit flips
        bytes[at] = (uint8_t)(bytes[at] ^ 1 << random_below(8));
        hear(bytes, sizeof bytes);
        break;
    case 3: // cut
        hear(bytes, at);
        break;
    case 4: // a byte damaged
        hear(bytes, at);
        cds_link_on_rx(&bus.link, bytes[at], (uint8_t)(1 + random_below(3)));
        hear(bytes + at, (uint8_t)(sizeof bytes - at));
        break;
    case 5: // a stranger, then the reply
        port_fake_answer(&bus.link, (uint8_t)(6 + random_below(200)), 0, bytes + 5, 2);
        hear(bytes, sizeof bytes);
        break;
    case 6: // noise, then the reply
        for (uint8_t i = 0; i < at; i++) {
            uint8_t noise = random_below(255);

            hear(&noise, 1);
        }
        hear(bytes, sizeof bytes);
        break;
    case 7: // a flood
        for (uint8_t i = 0; i < 150; i++)
            hear(bytes + i % (at + 1), 1);
        break;
    case 8: // refused
        port_fake_answer(&bus.link, 5, CDS_ERROR_RANGE, NULL, 0);
        break;
    default: hear(bytes, sizeof bytes); break;
    }
}

void test_stats_add_up_over_a_storm_of_faults(void)
{
    struct cds_stats count;
    uint16_t ok = 0, timeouts = 0, corrupt = 0;

    random_state = 20100817;
    for (uint16_t i = 0; i < 600; i++) {
        uint16_t value = 0x1234;
        uint16_t polls = 0;

        suffer(random_below(10));
        while (cds_bus_poll(&bus)) {
            port_fake.now_us += 1u + random_below(50);
            TEST_ASSERT_TRUE(++polls <= WORD_DEADLINE_US);
        }
        TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[PORT]);
        ok = (uint16_t)(ok + (request.result == CDS_OK));
        timeouts = (uint16_t)(timeouts + (request.result == CDS_TIMEOUT));
        corrupt = (uint16_t)(corrupt + (request.result == CDS_CORRUPT));
        cds_request_word(&request, 0, &value);
        TEST_ASSERT_EQUAL_HEX16(0x1234, value);
        if (i % 8 == 0) {
            assert_next_is_ok();
            ok++;
        }
    }
    cds_bus_stats(&bus, &count);
    TEST_ASSERT_EQUAL_UINT16(600 + 75, count.sent);
    TEST_ASSERT_EQUAL_UINT16(ok, count.ok);
    TEST_ASSERT_EQUAL_UINT16(timeouts, count.timeouts);
    TEST_ASSERT_EQUAL_UINT16(corrupt, count.corrupt);
    TEST_ASSERT_EQUAL_UINT16(count.sent, (uint16_t)(count.ok + count.timeouts + count.corrupt));
    TEST_ASSERT_TRUE(ok > 100 && timeouts > 50 && corrupt > 50); // it was a storm
}

/* Behind an adapter that is slow to echo, the last byte may come back when the link listens
 * already: then it is not counted as echo, and must do no harm in front of the reply. */
static void ping_with_late_echo(uint8_t id, const uint8_t *reply, uint8_t late)
{
    uint8_t echo[6];

    submit_ping(id);
    memcpy(echo, request.packet.bytes, sizeof echo);
    TEST_ASSERT_TRUE(port_fake_drain(&bus.link, PORT));
    for (uint8_t i = 0; i < sizeof echo; i++) {
        if (i == sizeof echo - late)
            cds_link_on_tx_complete(&bus.link, PORT);
        cds_link_on_rx_echo(&bus.link, echo[i], 0);
    }
    for (uint8_t i = 0; i < sizeof pong; i++)
        cds_link_on_rx_echo(&bus.link, reply[i], 0);
    assert_ended(CDS_OK);
    TEST_ASSERT_EQUAL_UINT8(id, request.id);
}

void test_late_echo_does_not_cost_the_reply(void)
{
    static const uint8_t pong_253[] = {0xFF, 0xFF, 0xFD, 0x02, 0x00, 0x00};

    for (uint8_t late = 1; late <= 2; late++) {
        ping_with_late_echo(5, pong, late);
        ping_with_late_echo(253, pong_253, late); // its PING ends with FF, as if a header came
    }
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().echo_errors);
    TEST_ASSERT_EQUAL_UINT16(0, rig_stats().unexpected_packets);
    TEST_ASSERT_EQUAL_UINT16(4, rig_stats().ok);
}
