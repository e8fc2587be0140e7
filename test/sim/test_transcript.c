/* SPDX-License-Identifier: MIT */
/* The transcript of a wire with two senders, in the manual's notation. */
#include "output/transcript.h"
#include "unity.h"

#include <stdlib.h>
#include <string.h>

#define FAST (16u * 256u) // 1 Mbit/s at 16 MHz

static struct schedule schedule;
static struct net net;
static struct driver controller, servo;
static struct uart_tx talkers[2];
static struct transcript transcript;
static char *text;
static size_t size;

static void ended(void *context, uint64_t now)
{
    (void)context;
    (void)now;
}

void setUp(void)
{
    schedule_init(&schedule);
    net_init(&net);
    driver_init(&controller, &net);
    driver_init(&servo, &net);
    uart_tx_init(&talkers[0], &schedule, &controller, 0);
    uart_tx_init(&talkers[1], &schedule, &servo, 0);
    talkers[0].on_end = talkers[1].on_end = ended;
    transcript_init(&transcript, &schedule, &net, &controller);
    transcript.file = open_memstream(&text, &size);
}

void tearDown(void)
{
    fclose(transcript.file);
    free(text);
    schedule_free(&schedule);
}

/* Sends a packet from `start` on. Returns its end. */
static uint64_t send(struct uart_tx *tx, uint64_t start, uint32_t bit_time_256, const char *bytes,
                     unsigned count)
{
    schedule_run_until(&schedule, start);
    driver_enable(tx->driver, start, true);
    for (unsigned i = 0; i < count; i++) {
        uart_tx_send(tx, start, bit_time_256, (uint8_t)bytes[i]);
        start = uart_tx_end(tx);
        schedule_run_until(&schedule, start);
    }
    driver_enable(tx->driver, start, false);
    return start;
}

static const char *written(void)
{
    schedule_run_until(&schedule, schedule.now + 100000);
    transcript_end(&transcript);
    fflush(transcript.file);
    return text;
}

#define READ  "\xFF\xFF\x01\x04\x02\x2B\x01\xCC"
#define REPLY "\xFF\xFF\x01\x03\x00\x20\xDB"

void test_transaction_in_the_manuals_notation(void)
{
    uint64_t end = send(&talkers[0], 1000, FAST, READ, 8);
    TEST_ASSERT_EQUAL_UINT64(1000 + 8 * 160, end);
    send(&talkers[1], end + 32, FAST, REPLY, 7);
    TEST_ASSERT_EQUAL_STRING("      1000 ->in: FF FF 01 04 02 2B 01 CC (LEN:008)\n"
                             "      2312 <-out: FF FF 01 03 00 20 DB (LEN:007)\n",
                             written());
    TEST_ASSERT_EQUAL_UINT32(1, transcript.packets_in);
    TEST_ASSERT_EQUAL_UINT32(1, transcript.packets_out);
    TEST_ASSERT_EQUAL_UINT32(0, transcript.damaged);
    TEST_ASSERT_EQUAL_UINT64(15 * 160, transcript.busy);
}

void test_packets_without_a_gap_are_separated_by_length(void)
{
    uint64_t end = send(&talkers[0], 0, FAST, READ, 8);
    send(&talkers[0], end, FAST, READ, 8);
    TEST_ASSERT_EQUAL_STRING("         0 ->in: FF FF 01 04 02 2B 01 CC (LEN:008)\n"
                             "      1280 ->in: FF FF 01 04 02 2B 01 CC (LEN:008)\n",
                             written());
}

void test_any_number_of_ff_may_come_before_the_id(void)
{
    send(&talkers[0], 0, FAST, "\xFF" READ, 9);
    TEST_ASSERT_EQUAL_STRING("         0 ->in: FF FF FF 01 04 02 2B 01 CC (LEN:009)\n", written());
    TEST_ASSERT_EQUAL_UINT32(1, transcript.packets_in);
}

void test_each_sender_is_decoded_at_its_own_rate(void)
{
    uint64_t end = send(&talkers[0], 0, FAST * 2, READ, 8); // 500 kbit/s
    send(&talkers[1], end + 100, 35556, REPLY, 7);          // 115200
    TEST_ASSERT_EQUAL_STRING("         0 ->in: FF FF 01 04 02 2B 01 CC (LEN:008)\n"
                             "      2660 <-out: FF FF 01 03 00 20 DB (LEN:007)\n",
                             written());
}

void test_cut_packet_is_written_when_the_other_side_sends(void)
{
    uint64_t end = send(&talkers[0], 0, FAST, READ, 5);
    send(&talkers[1], end + 10, FAST, REPLY, 7);
    TEST_ASSERT_EQUAL_STRING("         0 ->in: FF FF 01 04 02 (LEN:005) no packet\n"
                             "       810 <-out: FF FF 01 03 00 20 DB (LEN:007)\n",
                             written());
    TEST_ASSERT_EQUAL_UINT32(1, transcript.damaged);
}

void test_a_long_pause_ends_a_packet_and_a_short_one_does_not(void)
{
    uint64_t end = send(&talkers[0], 0, FAST, READ, 4);
    end = send(&talkers[0], end + 400, FAST, READ + 4, 4);
    TEST_ASSERT_EQUAL_UINT64(1680, end);
    end = send(&talkers[0], 10000, FAST, READ, 4);
    send(&talkers[0], end + 600, FAST, READ + 4, 4);
    TEST_ASSERT_EQUAL_STRING("         0 ->in: FF FF 01 04 02 2B 01 CC (LEN:008)\n"
                             "     10000 ->in: FF FF 01 04 (LEN:004) no packet\n"
                             "     11240 ->in: 02 2B 01 CC (LEN:004) no packet\n",
                             written());
}

void test_a_bad_checksum_is_no_packet(void)
{
    send(&talkers[1], 0, FAST, "\xFF\xFF\x01\x03\x00\x20\xDA", 7);
    TEST_ASSERT_EQUAL_STRING("         0 <-out: FF FF 01 03 00 20 DA (LEN:007) no packet\n",
                             written());
    TEST_ASSERT_EQUAL_UINT32(0, transcript.packets_out);
}

void test_a_framing_error_is_marked(void)
{
    driver_set(&servo, 100, true, false);
    schedule_run_until(&schedule, 1000);
    driver_set(&servo, 1000, false, true);
    TEST_ASSERT_EQUAL_STRING("       100 <-out: 00! (LEN:001) no packet\n", written());
}

void test_packet_cut_by_the_end_of_the_run_is_not_counted(void)
{
    send(&talkers[0], 0, FAST, READ, 3);
    transcript_end(&transcript);
    fflush(transcript.file);
    TEST_ASSERT_EQUAL_STRING("         0 ->in: FF FF 01 (LEN:003) unfinished\n", text);
    TEST_ASSERT_EQUAL_UINT32(0, transcript.damaged);
}
