/* SPDX-License-Identifier: MIT */
/* Commands of the console that are packets: lines in, packets and replies out; input that is lost,
 * and replies that nobody reads. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_ping_sends_the_packet_of_example_3(void)
{
    reply_to("ping 1");
    assert_sent("FF FF 01 02 01 FB");
    TEST_ASSERT_EQUAL_STRING("", said);
    answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_broadcast_ping_prints_id_of_reply(void)
{
    reply_to("ping 254");
    answer(42, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("id 42\r\nok\r\n", said);
}

void test_read_by_name_gives_bytes_and_value(void)
{
    static const uint8_t bytes[] = {0x34, 0x02};

    reply_to("read 7 present_position");
    assert_sent("FF FF 07 04 02 24 02 CC");
    answer(7, 0, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_STRING("0x24: 34 02\r\nPRESENT_POSITION = 564\r\nok\r\n", said);
}

void test_read_by_address_gives_bytes_only(void)
{
    static const uint8_t bytes[] = {32};

    reply_to("read 1 0x2B");
    assert_sent("FF FF 01 04 02 2B 01 CC");
    answer(1, 0, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_STRING("0x2B: 20\r\nok\r\n", said);
}

void test_read_of_ten_bytes_takes_two_lines(void)
{
    static const uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};

    reply_to("read 1 0x1E 10");
    answer(1, 0, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_STRING("0x1E: 01 02 03 04 05 06 07 08\r\n0x26: 09 0A\r\nok\r\n", said);
}

void test_read_of_a_named_register_in_part_gives_no_value(void)
{
    static const uint8_t bytes[] = {0x34};

    reply_to("read 1 PRESENT_POSITION 1");
    answer(1, 0, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_STRING("0x24: 34\r\nok\r\n", said);
}

void test_write_by_name_fills_following_registers(void)
{
    reply_to("write 0 GOAL_POSITION 0x200 512");
    assert_sent("FF FF 00 07 03 1E 00 02 00 02 D3");
}

void test_write_by_address_takes_bytes(void)
{
    reply_to("write 0 0x08 0xFF 1");
    assert_sent("FF FF 00 05 03 08 FF 01 EF");
}

void test_broadcast_write_is_ok_when_sent(void)
{
    reply_to("write 254 ID 1");
    assert_sent("FF FF FE 04 03 03 01 F6");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_regwrite_and_action(void)
{
    reply_to("regwrite 1 goal-position 0x3FF");
    assert_sent("FF FF 01 05 04 1E FF 03 D5");
    answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
    reply_to("action");
    assert_sent("FF FF FE 02 05 FA");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
    reply_to("action 3");
    assert_sent("FF FF 03 02 05 F5");
}

void test_reset(void)
{
    reply_to("reset 0");
    assert_sent("FF FF 00 02 06 F7");
}

void test_sync_of_example_5(void)
{
    reply_to("sync GOAL_POSITION 4 0:0x10,0,0x50,1 1:0x20,2,0x60,3 2:0x30,0,0x70,1 "
             "3:0x20,2,0x80,3");
    assert_sent("FF FF FE 18 83 1E 04 00 10 00 50 01 01 20 02 60 03 02 30 00 70 01 03 20 02 80 "
                "03 12");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_sync_longer_than_any_buffer_of_text(void)
{
    char block[32];

    type("sync 0x1E 4");
    for (uint8_t id = 0; id < 50; id++) {
        sprintf(block, " %u:0x%02X,1,255,3", id, id);
        type(block);
    }
    reply_to("");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
    TEST_ASSERT_EQUAL_UINT16(258, port_fake.sent_size);
    TEST_ASSERT_EQUAL_HEX8(254, port_fake.sent[3]);
    for (uint8_t id = 0; id < 50; id++) {
        const uint8_t expected[] = {id, id, 1, 255, 3};

        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, port_fake.sent + 7 + 5 * id, sizeof expected);
    }
}

void test_sync_with_one_servo_too_many_is_refused(void)
{
    char block[24];

    type("sync 0x1E 4");
    for (uint8_t id = 0; id < 51; id++) {
        sprintf(block, " %u:1,2,3,4", id);
        type(block);
    }
    assert_error(CDS_NO_ROOM, "");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

/* ---- input of the console ---- */

static void mark(uint8_t byte)
{
    char text[2] = {(char)byte, '\0'};

    type(text);
}

void test_lost_input_drops_line_and_prints_error_at_once(void)
{
    type("write 1 GOAL_POSITION 5");
    mark(HOST_MARK_LOST);
    TEST_ASSERT_EQUAL_STRING_LEN("error 36: ", said, 10);
    reply_to("ping 1");
    assert_sent("FF FF 01 02 01 FB");
}

void test_packet_drops_begun_line_without_reply(void)
{
    type("write 1 GOAL_POSITION 5");
    mark(HOST_MARK_DROPPED);
    TEST_ASSERT_EQUAL_STRING("", said);
    reply_to("ping 1");
    assert_sent("FF FF 01 02 01 FB");
}

void test_the_next_line_waits_for_the_reply_to_this_one(void)
{
    reply_to("ping 1\rping 2");
    assert_sent("FF FF 01 02 01 FB");
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
    answer(1, 0, NULL, 0);
    port_fake_transmit(&bus.link, 0);
    assert_sent("FF FF 02 02 01 FA");
}

void test_stopped_reader_delays_reply_without_loss(void)
{
    type("");
    for (const char *c = "help\r"; *c; c++)
        cds_ring_put(&input, (uint8_t)*c);
    for (uint16_t i = 0; i < 2000; i++) {
        cds_bus_poll(&bus);
        console_poll(&console); // nobody reads
    }
    TEST_ASSERT_GREATER_THAN_UINT8(CDS_RING_SIZE - PRINTER_PIECE, cds_ring_count(&output));
    TEST_ASSERT_FALSE(console_idle(&console));
    while (!console_idle(&console))
        turn();
    TEST_ASSERT_NOT_NULL(strstr(said, "play a sequence after power-up"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said + strlen(said) - 4);
}

void test_idle_only_when_there_is_nothing_to_do(void)
{
    TEST_ASSERT_TRUE(console_idle(&console));
    cds_ring_put(&input, 'p');
    TEST_ASSERT_FALSE(console_idle(&console));
    type("ing 1\r");
    TEST_ASSERT_FALSE(console_idle(&console));
    port_fake_transmit(&bus.link, 0);
    answer(1, 0, NULL, 0);
    TEST_ASSERT_TRUE(console_idle(&console));
}
