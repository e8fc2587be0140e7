/* SPDX-License-Identifier: MIT */
/* The direction of one bus, verb by verb, and what its receiver hears. */
#include "cds55xx/link.h"

#include <string.h>

#include "port_fake.h"
#include "unity.h"

#define PORT 2

static struct cds_link link_;

static const uint8_t packet[] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};

/* The byte `offset` after the oldest one received. */
static uint8_t peek(uint8_t offset)
{
    return cds_ring_at(&link_.rx, cds_ring_after(cds_ring_begin(&link_.rx), offset));
}

void setUp(void)
{
    port_fake_reset();
    memset(&link_, 0, sizeof link_);
    cds_link_open(&link_, PORT);
    port_fake_forget();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void assert_verb(uint8_t index, uint8_t verb, uint8_t byte)
{
    TEST_ASSERT_TRUE(index < port_fake.verbs);
    TEST_ASSERT_EQUAL(verb, port_fake.log[index].verb);
    TEST_ASSERT_EQUAL_UINT8(PORT, port_fake.log[index].port);
    TEST_ASSERT_EQUAL_HEX8(byte, port_fake.log[index].byte);
}

void test_link_that_was_not_opened_is_in_high_z(void)
{
    memset(&link_, 0, sizeof link_);
    TEST_ASSERT_EQUAL(CDS_LINK_HIGH_Z, link_.state);
}

void test_open_listens(void)
{
    memset(&link_, 0, sizeof link_);
    cds_link_open(&link_, PORT);
    TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, link_.state);
    assert_verb(0, FAKE_HIGH_Z, 0);
    assert_verb(1, FAKE_LISTEN, 0);
    TEST_ASSERT_EQUAL_UINT16(2, port_fake.verbs);
}

/* A byte heard in high impedance is no harm: it is dropped with all other bytes when talk begins.
 */
void test_byte_heard_in_high_z_changes_no_direction(void)
{
    memset(&link_, 0, sizeof link_);
    cds_link_on_rx(&link_, 0x11, 0);
    TEST_ASSERT_EQUAL(CDS_LINK_HIGH_Z, link_.state);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.verbs);
}

void test_complete_in_high_z_ends_in_listening(void)
{
    memset(&link_, 0, sizeof link_);
    cds_link_on_tx_complete(&link_, PORT);
    TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, link_.state);
    assert_verb(0, FAKE_LISTEN, 0);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.verbs);
}

void test_whole_packet_verb_by_verb(void)
{
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    TEST_ASSERT_TRUE(port_fake_transmit(&link_, PORT));
    assert_verb(0, FAKE_HIGH_Z, 0);
    assert_verb(1, FAKE_TALK, 0);
    for (uint8_t i = 0; i < sizeof packet - 1; i++)
        assert_verb((uint8_t)(2 + i), FAKE_TX, packet[i]);
    assert_verb(7, FAKE_TX_LAST, 0xFB);
    assert_verb(8, FAKE_LISTEN, 0);
    TEST_ASSERT_EQUAL_UINT16(9, port_fake.verbs);
}

/* Tied pins: what is sent comes back, and the reply may come before "complete" is served. */
void test_own_echo_is_compared_and_dropped(void)
{
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    TEST_ASSERT_TRUE(port_fake_drain(&link_, PORT));
    for (uint8_t i = 0; i < sizeof packet; i++)
        cds_link_on_rx_echo(&link_, i == 2 ? 0x00 : packet[i], i == 4 ? CDS_LINE_FRAMING : 0);
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&link_.rx));
    TEST_ASSERT_EQUAL_UINT16(2, cds_link_count(&link_.echo_errors));
    TEST_ASSERT_EQUAL_UINT8(0, link_.framing_errors);
    cds_link_on_rx_echo(&link_, 0x77, 0);
    cds_link_on_tx_complete(&link_, PORT);
    cds_link_on_rx_echo(&link_, 0x88, 0);
    TEST_ASSERT_EQUAL_UINT8(2, cds_ring_count(&link_.rx));
    TEST_ASSERT_EQUAL_HEX8(0x77, peek(0));
}

void test_lost_echo_does_not_cost_the_reply(void)
{
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    TEST_ASSERT_TRUE(port_fake_transmit(&link_, PORT));
    cds_link_on_rx_echo(&link_, 0x88, 0);
    TEST_ASSERT_EQUAL_UINT8(1, cds_ring_count(&link_.rx));
}

void test_states_of_a_packet(void)
{
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    for (uint8_t i = 1; i < sizeof packet - 1; i++) {
        TEST_ASSERT_EQUAL(CDS_LINK_TALKING, link_.state);
        cds_link_on_tx_ready(&link_, PORT);
    }
    TEST_ASSERT_EQUAL(CDS_LINK_TALKING, link_.state);
    cds_link_on_tx_ready(&link_, PORT);
    TEST_ASSERT_EQUAL(CDS_LINK_DRAINING, link_.state);
    cds_link_on_tx_complete(&link_, PORT);
    TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, link_.state);
}

/* While the last byte drains the driver stays on: only "complete" releases it. */
void test_driver_is_held_until_complete(void)
{
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    TEST_ASSERT_TRUE(port_fake_drain(&link_, PORT));
    TEST_ASSERT_EQUAL(FAKE_TX_LAST, port_fake.lines[PORT]);
    TEST_ASSERT_EQUAL_UINT16(8, port_fake.verbs); // no listen among them yet
    cds_link_on_tx_complete(&link_, PORT);
    TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[PORT]);
}

void test_talk_two_bytes_taken_at_once_continues_with_the_third(void)
{
    port_fake.takes_two = true;
    cds_link_talk(&link_, PORT, packet, 3);
    cds_link_on_tx_ready(&link_, PORT);
    assert_verb(2, FAKE_TX, 0xFF);
    assert_verb(3, FAKE_TX, 0xFF);
    assert_verb(4, FAKE_TX_LAST, 0x01);
    TEST_ASSERT_EQUAL(CDS_LINK_DRAINING, link_.state);
}

void test_longest_packet_goes_out_whole(void)
{
    static uint8_t longest[258];

    for (uint16_t i = 0; i < sizeof longest; i++)
        longest[i] = i < 2 ? CDS_HEADER : (uint8_t)(i * 7);
    cds_link_talk(&link_, PORT, longest, sizeof longest);
    TEST_ASSERT_TRUE(port_fake_transmit(&link_, PORT));
    TEST_ASSERT_EQUAL_UINT16(sizeof longest, port_fake.sent_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(longest, port_fake.sent, sizeof longest);
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
}

/* The verb's events may come before it returns, be it by a slow main loop and a fast line. */
void test_whole_packet_may_leave_before_talk_returns(void)
{
    port_fake.eager = &link_;
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, link_.state);
    TEST_ASSERT_EQUAL_UINT16(sizeof packet, port_fake.sent_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, port_fake.sent, sizeof packet);
}

void test_second_packet_follows_the_first(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        cds_link_talk(&link_, PORT, packet, sizeof packet);
        TEST_ASSERT_TRUE(port_fake_transmit(&link_, PORT));
        TEST_ASSERT_EQUAL_UINT16(sizeof packet, port_fake.sent_size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, port_fake.sent, sizeof packet);
    }
    TEST_ASSERT_EQUAL_UINT16(2, port_fake.packets);
}

void test_bytes_heard_are_kept_in_order(void)
{
    port_fake_hear(&link_, packet, sizeof packet);
    TEST_ASSERT_EQUAL_UINT8(sizeof packet, cds_ring_count(&link_.rx));
    for (uint8_t i = 0; i < sizeof packet; i++)
        TEST_ASSERT_EQUAL_HEX8(packet[i], peek(i));
    TEST_ASSERT_EQUAL_UINT8(0, link_.broken);
}

void test_talk_throws_away_what_was_heard(void)
{
    port_fake_hear(&link_, packet, sizeof packet);
    cds_link_on_rx(&link_, 0, CDS_LINE_FRAMING);
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(&link_.rx));
    TEST_ASSERT_EQUAL_UINT8(0, link_.broken);
}

void test_damaged_byte_is_marked_and_not_stored(void)
{
    port_fake_hear(&link_, packet, 3);
    cds_link_on_rx(&link_, 0x77, CDS_LINE_FRAMING);
    TEST_ASSERT_EQUAL_UINT8(3, cds_ring_count(&link_.rx));
    TEST_ASSERT_NOT_EQUAL(0, link_.broken);
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(link_.rx.tail + 3), link_.broken_at);
}

void test_first_of_several_damaged_bytes_is_the_one_marked(void)
{
    port_fake_hear(&link_, packet, 2);
    cds_link_on_rx(&link_, 0x77, CDS_LINE_FRAMING);
    port_fake_hear(&link_, packet, 2);
    cds_link_on_rx(&link_, 0x77, CDS_LINE_OVERRUN);
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(link_.rx.tail + 2), link_.broken_at);
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(link_.rx.tail + 4), link_.whole_from);
    TEST_ASSERT_EQUAL_UINT8(4, cds_ring_count(&link_.rx));
}

static void assert_counts(uint8_t framing, uint8_t overruns, uint8_t both, uint8_t full)
{
    TEST_ASSERT_EQUAL_UINT8(framing, link_.framing_errors);
    TEST_ASSERT_EQUAL_UINT8(overruns, link_.overruns);
    TEST_ASSERT_EQUAL_UINT8(both, link_.both_errors);
    TEST_ASSERT_EQUAL_UINT8(full, link_.ring_overflows);
}

void test_line_errors_are_counted_apart(void)
{
    cds_link_on_rx(&link_, 0, CDS_LINE_FRAMING);
    cds_link_on_rx(&link_, 0, CDS_LINE_FRAMING);
    assert_counts(2, 0, 0, 0);
    cds_link_on_rx(&link_, 0, CDS_LINE_OVERRUN);
    assert_counts(2, 1, 0, 0);
    cds_link_on_rx(&link_, 0, CDS_LINE_FRAMING | CDS_LINE_OVERRUN);
    assert_counts(2, 1, 1, 0);
    TEST_ASSERT_EQUAL(CDS_LINK_DAMAGED, link_.broken);
}

void test_byte_for_a_full_ring_is_counted_and_marked(void)
{
    for (uint8_t i = 0; i < CDS_RING_SIZE; i++)
        cds_link_on_rx(&link_, i, 0);
    TEST_ASSERT_EQUAL_UINT8(0, link_.broken);
    cds_link_on_rx(&link_, 0xEE, 0); // which is told by what it breaks
    TEST_ASSERT_EQUAL(CDS_LINK_FULL, link_.broken);
    assert_counts(0, 0, 0, 0);
    cds_link_on_rx(&link_, 0xEF, 0);
    cds_link_on_rx(&link_, 0xEF, 0);
    TEST_ASSERT_EQUAL(CDS_LINK_FULL, link_.broken);
    assert_counts(0, 0, 0, 2);
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(link_.rx.tail + CDS_RING_SIZE), link_.broken_at);
    TEST_ASSERT_EQUAL_UINT8(CDS_RING_SIZE - 1, peek(CDS_RING_SIZE - 1));
}

void test_byte_for_a_full_ring_behind_damage_is_counted(void)
{
    cds_link_on_rx(&link_, 0, CDS_LINE_FRAMING);
    for (uint8_t i = 0; i < CDS_RING_SIZE; i++)
        cds_link_on_rx(&link_, i, 0);
    cds_link_on_rx(&link_, 0xEE, 0);
    TEST_ASSERT_EQUAL(CDS_LINK_DAMAGED, link_.broken);
    TEST_ASSERT_EQUAL_UINT8(link_.rx.tail, link_.broken_at);
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(link_.rx.tail + CDS_RING_SIZE), link_.whole_from);
    assert_counts(1, 0, 0, 1);
}

void test_abort_releases_the_driver_before_it_listens(void)
{
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    cds_link_on_tx_ready(&link_, PORT);
    port_fake_forget();
    cds_link_abort(&link_, PORT);
    assert_verb(0, FAKE_HIGH_Z, 0);
    assert_verb(1, FAKE_LISTEN, 0);
    TEST_ASSERT_EQUAL_UINT16(2, port_fake.verbs);
    TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, link_.state);
}

void test_abort_while_draining_and_while_listening(void)
{
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    TEST_ASSERT_TRUE(port_fake_drain(&link_, PORT));
    for (uint8_t i = 0; i < 2; i++) {
        cds_link_abort(&link_, PORT);
        TEST_ASSERT_EQUAL(CDS_LINK_LISTENING, link_.state);
        TEST_ASSERT_EQUAL(FAKE_LISTEN, port_fake.lines[PORT]);
    }
}

void test_next_packet_after_an_abort_goes_out_whole(void)
{
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    cds_link_on_tx_ready(&link_, PORT);
    cds_link_abort(&link_, PORT);
    cds_link_talk(&link_, PORT, packet, sizeof packet);
    TEST_ASSERT_TRUE(port_fake_transmit(&link_, PORT));
    TEST_ASSERT_EQUAL_UINT16(sizeof packet, port_fake.sent_size);
}

void test_counter_is_read_as_it_stands(void)
{
    volatile uint16_t counter = 0xABCD;

    TEST_ASSERT_EQUAL_HEX16(0xABCD, cds_link_count(&counter));
}
