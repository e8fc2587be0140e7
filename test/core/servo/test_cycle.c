/* SPDX-License-Identifier: MIT */
/* The fixed-rate transaction on a wire that takes its time: goals to the microsecond, READs that
 * fit, late polls, goals that never tear. The clock moves in steps of a microsecond. */
#include "cds55xx/cycle.h"

#include <string.h>

#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "unity.h"

#define SERVOS       3
#define PERIOD_US    4000
#define GOALS_US     (23 * 10) // 8 + 3 x 5 bytes
#define READ_US      (8 * 10 + 2 + 17 * 10)
#define ROOM_US      (25 * 10 + 2 + CDS_REPLY_MARGIN_US + 20) // that a READ must have
#define REST_US      20 // two byte times, after a transaction that failed
#define STARTS_MAX   64
#define TURNS_PER_US 4
#define BEGIN_US     (0u - 6000u) // the clock wraps in the second period

static struct cds_queue queue;
static struct cds_cycle cycle;
static struct cds_feedback feedback[CDS_CYCLE_SERVOS_MAX];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(CDS_CYCLE_SERVOS_MAX)];
static uint8_t many[CDS_CYCLE_SERVOS_MAX];
static const uint8_t ids[SERVOS] = {4, 2, 9};

/* Packets as they began: microseconds since BEGIN_US. */
static struct {
    uint16_t us;
    uint8_t id;
} starts[STARTS_MAX];
static uint8_t start_count;

static bool talking;
static uint32_t talk_end_us;
static bool answering;
static uint32_t answer_us;
static uint8_t dead; // ID of a servo that does not answer, 0: none
static uint8_t goals_sent[23];

void setUp(void)
{
    rig_open_at_us(0, BEGIN_US);
    memset(&cycle, 0, sizeof cycle);
    memset(feedback, 0, sizeof feedback);
    memset(goals_sent, 0, sizeof goals_sent);
    cds_bus_set_return_delay(&bus, 2);
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    start_count = 0;
    talking = answering = false;
    dead = 0;
}

void tearDown(void)
{
    rig_check();
}

static uint16_t now(void)
{
    return (uint16_t)(port_fake.now_us - BEGIN_US);
}

/* The wire: a packet takes 10 us a byte, and a READ is answered 2 us later. */
static void wire(void)
{
    static const uint8_t registers[CDS_FEEDBACK_SIZE] = {1, 2, 3};

    if (!talking && bus.link.state == CDS_LINK_TALKING) {
        talking = true;
        talk_end_us = port_fake.now_us + 10u * bus.request->packet.size;
        TEST_ASSERT_LESS_THAN(STARTS_MAX, start_count);
        starts[start_count].us = now();
        starts[start_count++].id = bus.request->packet.bytes[CDS_AT_ID];
    }
    if (talking && port_fake.now_us == talk_end_us) {
        talking = false;
        TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, 0));
        TEST_ASSERT_EQUAL_HEX8(cds_packet_checksum(port_fake.sent),
                               port_fake.sent[port_fake.sent_size - 1]);
        if (port_fake.sent[CDS_AT_ID] == CDS_BROADCAST_ID)
            memcpy(goals_sent, port_fake.sent, sizeof goals_sent);
        answering =
            port_fake.sent[CDS_AT_INSTRUCTION] == CDS_READ && port_fake.sent[CDS_AT_ID] != dead;
        answer_us = talk_end_us + 2 + 17 * 10;
    }
    if (answering && port_fake.now_us == answer_us) {
        answering = false;
        port_fake_answer(&bus.link, port_fake.sent[CDS_AT_ID], 0, registers, sizeof registers);
    }
}

/* The main loop turns several times within a microsecond, as a poll of the bus does one thing. */
static void poll(void)
{
    for (uint8_t i = 0; i < TURNS_PER_US; i++) {
        enum cds_result result;

        cds_bus_poll(&bus);
        result = cds_cycle_poll(&cycle);
        if (!cycle.is_aborted)
            TEST_ASSERT_EQUAL(CDS_PENDING, result);
    }
    wire();
}

/* The main loop turns until `us` after BEGIN_US, and in that microsecond too. */
static void run_to(uint16_t us)
{
    poll();
    while (now() != us) {
        port_fake.now_us++;
        wire();
        poll();
    }
}

/* The main loop is away for so long; the wire is not. */
static void be_away(uint16_t us)
{
    while (us--) {
        port_fake.now_us++;
        wire();
    }
}

static enum cds_result begin_with(struct cds_bus *on, const uint8_t *of, uint8_t count,
                                  uint16_t period_us)
{
    struct cds_cycle_config config = {.bus = on,
                                      .ids = of,
                                      .packets = packets,
                                      .feedback = feedback,
                                      .count = count,
                                      .period_us = period_us};

    return cds_cycle_begin(&cycle, &config);
}

static void begin(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin_with(&bus, ids, SERVOS, PERIOD_US));
}

static void set_all(uint16_t position)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, i, (uint16_t)(position + i), 0x123));
}

static void begin_with_goals(void)
{
    begin();
    set_all(0x200);
    cds_cycle_commit(&cycle);
}

static uint16_t position_sent(uint8_t servo)
{
    return (uint16_t)(goals_sent[8 + 5 * servo] | goals_sent[9 + 5 * servo] << 8);
}

/* Goals go out at these times, and at no other. */
static void assert_goals_at(const uint16_t *at_us, uint8_t count)
{
    uint8_t seen = 0;

    for (uint8_t i = 0; i < start_count; i++) {
        if (starts[i].id != CDS_BROADCAST_ID)
            continue;
        TEST_ASSERT_LESS_THAN(count, seen);
        TEST_ASSERT_EQUAL_UINT16(at_us[seen], starts[i].us);
        seen++;
    }
    TEST_ASSERT_EQUAL_UINT8(count, seen);
}

void test_goals_leave_every_period_to_the_microsecond(void)
{
    static const uint16_t at_us[] = {0, 4000, 8000, 12000};
    static const uint8_t packet[] = {0xFF, 0xFF, 0xFE, 19, 0x83, 0x1E, 4, 4, 0, 2,    0x23,
                                     1,    2,    1,    2,  0x23, 1,    9, 2, 2, 0x23, 1};

    begin_with_goals();
    run_to(15999);
    assert_goals_at(at_us, 4);
    TEST_ASSERT_EQUAL_UINT32(4, cycle.counters.periods);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, goals_sent, sizeof packet);
    TEST_ASSERT_EQUAL_HEX8(cds_packet_checksum(goals_sent), goals_sent[22]);
}

/* READs are back to back, in turn, and stop where one more might not end in time. */
static void assert_reads_fill(uint16_t read_us)
{
    uint8_t servo = 0;

    for (uint8_t i = 0; i + 1 < start_count; i++) {
        uint16_t next_period_us = (uint16_t)((starts[i].us / PERIOD_US + 1) * PERIOD_US);

        if (starts[i].id == CDS_BROADCAST_ID) {
            TEST_ASSERT_EQUAL_UINT16(starts[i].us + GOALS_US, starts[i + 1].us);
            continue;
        }
        TEST_ASSERT_EQUAL_UINT8(ids[servo], starts[i].id);
        servo = (uint8_t)((servo + 1) % SERVOS);
        TEST_ASSERT_LESS_OR_EQUAL(next_period_us - ROOM_US, starts[i].us);
        if (starts[i + 1].id == CDS_BROADCAST_ID)
            TEST_ASSERT_GREATER_THAN(next_period_us - ROOM_US, starts[i].us + read_us);
        else
            TEST_ASSERT_EQUAL_UINT16(starts[i].us + read_us, starts[i + 1].us);
    }
}

void test_reads_fill_the_rest_of_the_period(void)
{
    begin_with_goals();
    run_to(15999);
    assert_reads_fill(READ_US);
    TEST_ASSERT_EQUAL_UINT32(4 * 14, cycle.counters.reads); // (3770 - 372) / 252 + 1
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.failed);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL_HEX16(0x0201, feedback[i].position);
    // two more READs, goals, and what is left of a period
    TEST_ASSERT_EQUAL_UINT32(3 * READ_US + PERIOD_US - 14 * READ_US, cycle.counters.oldest_us);
}

/* The last READ that fits ends, unanswered, before the goals are due. */
void test_read_unanswered_does_not_delay_the_goals(void)
{
    static const uint16_t at_us[] = {0, 4000, 8000};

    for (dead = 2; dead < 10; dead = (uint8_t)(dead + 7)) {
        port_fake.now_us = BEGIN_US - 10000;
        cds_bus_open(&bus, 0, CDS_BAUD_1M);
        cds_bus_set_return_delay(&bus, 2);
        port_fake.now_us = BEGIN_US; // the rest is over
        start_count = 0;
        memset(&cycle, 0, sizeof cycle);
        begin_with_goals();
        run_to(11999);
        assert_goals_at(at_us, 3);
        TEST_ASSERT_GREATER_THAN_UINT32(3, cycle.counters.failed); // the bus rests behind each
        TEST_ASSERT_GREATER_THAN_UINT32(2 * cycle.counters.failed - 3, cycle.counters.reads);
        TEST_ASSERT_EQUAL(CDS_OK, feedback[0].result);
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, feedback[dead == 2 ? 1 : 2].result);
        TEST_ASSERT_EQUAL_UINT32(bus.stats.timeouts, cycle.counters.failed);
        while (bus.request) {
            port_fake.now_us++;
            wire();
            cds_bus_poll(&bus);
        }
    }
}

void test_yields_while_the_bus_rests_is_false(void)
{
    dead = 4; // the first one
    begin_with_goals();
    run_to(GOALS_US + 400);
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.failed);
    TEST_ASSERT_NULL(bus.request);
    TEST_ASSERT_FALSE(cds_cycle_yields(&cycle, 100));
    port_fake.now_us += CDS_STALE_REPLY_US;
    cds_bus_poll(&bus);
    TEST_ASSERT_TRUE(cds_cycle_yields(&cycle, 100));
}

void test_yields_ends_reads_until_the_next_period(void)
{
    uint8_t begun;

    begin_with_goals();
    run_to(GOALS_US + 50); // a READ is in flight
    begun = start_count;
    TEST_ASSERT_FALSE(cds_cycle_yields(&cycle, 1000));
    run_to(1000);
    TEST_ASSERT_EQUAL_UINT8(begun, start_count);
    TEST_ASSERT_TRUE(cds_cycle_yields(&cycle, 1000));
    TEST_ASSERT_TRUE(cds_cycle_yields(&cycle, PERIOD_US - 1000 - 20));
    TEST_ASSERT_FALSE(cds_cycle_yields(&cycle, PERIOD_US - 1000 - 19));
    run_to(PERIOD_US - 1);
    TEST_ASSERT_EQUAL_UINT8(begun, start_count);
    run_to(PERIOD_US + 1000);
    TEST_ASSERT_GREATER_THAN_UINT8(begun + 2, start_count);
}

void test_yields_for_more_than_the_spare_time_leaves_reads_alone(void)
{
    uint16_t spare_us;
    uint8_t begun;

    begin_with_goals();
    spare_us = cds_cycle_spare_us(&cycle);
    TEST_ASSERT_EQUAL_UINT16(PERIOD_US - GOALS_US - CDS_REPLY_MARGIN_US - 40, spare_us);
    run_to(GOALS_US + 50);
    begun = start_count;
    TEST_ASSERT_FALSE(cds_cycle_yields(&cycle, (uint16_t)(spare_us + 1)));
    run_to(1000);
    TEST_ASSERT_GREATER_THAN_UINT8(begun, start_count);
}

void test_yields_after_abort_tells_if_the_bus_is_free(void)
{
    begin_with_goals();
    run_to(GOALS_US + 50);
    cds_cycle_abort(&cycle);
    TEST_ASSERT_FALSE(cds_cycle_yields(&cycle, 1000));
    run_to(1000);
    TEST_ASSERT_TRUE(cds_cycle_yields(&cycle, UINT16_MAX));
}

void test_read_unanswered_is_not_retried(void)
{
    cds_queue_set_retries(&queue, 2);
    dead = 4;
    begin_with_goals();
    run_to(3999);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.retried);
    TEST_ASSERT_GREATER_THAN_UINT32(0, cycle.counters.failed);
}

void test_reads_with_longer_return_delay_leave_more_time(void)
{
    static const uint16_t at_us[] = {0, 4000, 8000};

    cds_bus_set_return_delay(&bus, 508);
    dead = 4;
    begin_with_goals();
    run_to(11999);
    assert_goals_at(at_us, 3);
}

void test_poll_late_by_10_ms_misses_periods_and_keeps_phase(void)
{
    static const uint16_t at_us[] = {0, 4000, 16000, 20000};

    begin_with_goals();
    run_to(7900);
    be_away(6000 + 4000); // to 17900: the periods of 8000 and 12000 are over, 16000 can still begin
    poll();
    TEST_ASSERT_EQUAL_UINT32(2, cycle.counters.missed);
    TEST_ASSERT_EQUAL_UINT16(17900, starts[start_count - 1].us);
    starts[start_count - 1].us = 16000; // late, but in its period
    run_to(23999);
    assert_goals_at(at_us, 4);
    TEST_ASSERT_EQUAL_UINT32(4, cycle.counters.periods);
    TEST_ASSERT_EQUAL_UINT32(2, cycle.counters.missed);
}

void test_goals_too_late_for_their_period_are_not_sent(void)
{
    static const uint16_t at_us[] = {0, 7670, 8000, 12000};
    static const uint16_t too_late_us[] = {0, 8000, 12000};

    begin_with_goals();
    run_to(3000);
    be_away(7670 - 3000); // 330 us are needed: 230 on the wire, 100 margin
    poll();
    run_to(13000);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    assert_goals_at(at_us, 4);

    setUp();
    begin_with_goals();
    run_to(3000);
    be_away(7671 - 3000);
    poll();
    run_to(13000);
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.missed);
    assert_goals_at(too_late_us, 3);
}

void test_poll_very_late_catches_up_in_bounded_steps(void)
{
    begin_with_goals();
    run_to(3999);
    port_fake.now_us += 100ul * PERIOD_US; // 8 periods at most in each poll
    cds_cycle_poll(&cycle);
    TEST_ASSERT_EQUAL_UINT32(8, cycle.counters.missed);
    for (uint8_t i = 0; i < 12; i++)
        cds_cycle_poll(&cycle);
    TEST_ASSERT_EQUAL_UINT32(100, cycle.counters.missed);
    TEST_ASSERT_EQUAL_UINT32(101ul * PERIOD_US, cycle.next_us - BEGIN_US);
}

void test_feedback_taken_late_has_the_age_of_its_reply(void)
{
    begin_with_goals();
    run_to(GOALS_US + 10);
    be_away(1000);
    poll();
    TEST_ASSERT_EQUAL(CDS_OK, feedback[0].result);
    TEST_ASSERT_EQUAL_UINT32(GOALS_US + 10 + 1000 - (GOALS_US + ROOM_US),
                             cds_feedback_age_us(&feedback[0]));
}

/* 372 us: the wait until its deadline and the time to begin it. */
void test_read_unanswered_found_late_counts_until_its_deadline(void)
{
    dead = 4;
    begin_with_goals();
    run_to(GOALS_US + 10);
    be_away(1500);
    poll();
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.failed);
    TEST_ASSERT_EQUAL_UINT32(GOALS_US + ROOM_US, cycle.wire_us);
}

/* ---- goals ---- */

void test_no_goals_are_sent_before_the_first_commit(void)
{
    static const uint16_t at_us[] = {5000, 9000};

    begin();
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 0, 1, 1));
    cds_cycle_goal(&cycle, 2, 1, 1);
    run_to(5000 - 372); // feedback goes on
    TEST_ASSERT_GREATER_THAN_UINT32(10, cycle.counters.reads);
    cycle.bus->return_delay_us = CDS_RETURN_DELAY_MAX_US; // no further READ in this period
    run_to(5000 - 1);
    while (bus.request) {
        be_away(1);
        cds_bus_poll(&bus);
    }
    port_fake.now_us = BEGIN_US + 5000;
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 1, 1, 1));
    cds_cycle_commit(&cycle);
    run_to(12000);
    assert_goals_at(at_us, 2);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
}

void test_goals_set_during_a_period_leave_together(void)
{
    begin_with_goals();
    run_to(100); // on the wire
    set_all(0x300);
    run_to(4300);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL_HEX16(0x200 + i, position_sent(i));
    run_to(8100); // on the wire again
    cds_cycle_commit(&cycle);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_cycle_goal(&cycle, 0, 0x11, 1));
    run_to(8300);
    TEST_ASSERT_EQUAL_HEX16(0x200, position_sent(0));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 1, 0x11, 1));
    run_to(12300);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL_HEX16(0x300 + i, position_sent(i));
}

void test_goal_not_set_since_the_commit_stays(void)
{
    begin_with_goals();
    run_to(1000);
    set_all(0x300);
    cds_cycle_commit(&cycle);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 1, 0x11, 1));
    cds_cycle_commit(&cycle);
    cds_cycle_commit(&cycle); // nothing new: nothing changes
    run_to(4300);
    TEST_ASSERT_EQUAL_HEX16(0x300, position_sent(0));
    TEST_ASSERT_EQUAL_HEX16(0x11, position_sent(1));
    TEST_ASSERT_EQUAL_HEX16(0x302, position_sent(2));
    TEST_ASSERT_EQUAL_HEX8(cds_packet_checksum(goals_sent), goals_sent[22]);
}

/* The position that the last goals set for servo `index`, or -1 if they set none. */
static int16_t position_set(uint8_t index)
{
    int16_t position = -1;

    for (uint8_t i = 0; i < SERVOS; i++)
        if (goals_sent[7 + 5 * i] == ids[index])
            position = (int16_t)position_sent(i);
    return position;
}

static void assert_positions(int16_t first, int16_t second, int16_t third)
{
    TEST_ASSERT_EQUAL_INT16(first, position_set(0));
    TEST_ASSERT_EQUAL_INT16(second, position_set(1));
    TEST_ASSERT_EQUAL_INT16(third, position_set(2));
    TEST_ASSERT_EQUAL_HEX8(cds_packet_checksum(goals_sent), goals_sent[22]);
}

void test_servo_without_a_goal_is_left_out_until_it_has_one(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 1, 501, 1));
    cds_cycle_commit(&cycle);
    run_to(1000);
    assert_positions(-1, 501, -1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 2, 502, 1));
    cds_cycle_commit(&cycle);
    run_to(5000);
    assert_positions(-1, 501, 502);
    for (uint8_t i = 0; i < 2; i++) { // both packets
        set_all((uint16_t)(510 + i));
        cds_cycle_commit(&cycle);
        run_to((uint16_t)(9000 + 4000 * i));
        assert_positions(510 + i, 511 + i, 512 + i);
    }
}

void test_first_goals_out_of_order_leave_out_the_others(void)
{
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 2, 502, 1));
    cds_cycle_commit(&cycle);
    run_to(1000);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 1, 501, 1)); // marks servo 0 as not set
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 0, 500, 1));
    cds_cycle_commit(&cycle);
    run_to(5000);
    assert_positions(500, 501, 502);
}

void test_goal_out_of_range_is_refused(void)
{
    begin_with_goals();
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_cycle_goal(&cycle, 3, 1, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_cycle_goal(&cycle, 0, 1024, 1));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_cycle_goal(&cycle, 0, 1, 1024));
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_goal(&cycle, 0, 1023, 1023));
}

/* ---- others on the bus, beginning and end ---- */

static uint8_t bytes[2][CDS_PACKET_SIZE(2)], replies[2][16];

void test_requests_of_the_application_go_before_reads(void)
{
    struct cds_request urgent = CDS_REQUEST(bytes[0], replies[0]);
    struct cds_request other = CDS_REQUEST(bytes[1], replies[1]);

    urgent.priority = CDS_PRIORITY_HIGH;
    begin_with_goals();
    run_to(100);
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &other, 77, CDS_REG_PRESENT_POSITION, 11));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &urgent, 88, CDS_REG_PRESENT_POSITION, 11));
    run_to(3999);
    TEST_ASSERT_EQUAL_UINT8(CDS_BROADCAST_ID, starts[0].id);
    TEST_ASSERT_EQUAL_UINT8(88, starts[1].id);
    TEST_ASSERT_EQUAL_UINT8(77, starts[2].id);
    TEST_ASSERT_EQUAL_UINT8(ids[0], starts[3].id);
}

/* A period is shorter than the wait for a quiet line. */
void test_goals_do_not_begin_the_wait_of_another_request_again(void)
{
    struct cds_request other = CDS_REQUEST(bytes[0], replies[0]);

    TEST_ASSERT_EQUAL(CDS_OK, begin_with(&bus, ids, SERVOS, 1000));
    set_all(0x200);
    cds_cycle_commit(&cycle);
    run_to(500);
    port_fake.low = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &other, 77, CDS_REG_PRESENT_POSITION, 11));
    run_to(5000);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, other.result);
    TEST_ASSERT_GREATER_THAN_UINT32(0, cycle.counters.unsent);
    port_fake.low = false;
    run_to(9999);
    TEST_ASSERT_GREATER_THAN_UINT16(9000, starts[start_count - 1].us);
}

void test_goals_behind_a_transaction_follow_at_once(void)
{
    static const uint16_t at_us[] = {0, 3990 + READ_US, 8000};
    struct cds_request first = CDS_REQUEST(bytes[0], replies[0]);
    struct cds_request second = CDS_REQUEST(bytes[1], replies[1]);

    begin_with_goals();
    run_to(3989);
    port_fake.now_us++;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &first, 77, CDS_REG_PRESENT_POSITION, 11));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &second, 78, CDS_REG_PRESENT_POSITION, 11));
    run_to(11999);
    assert_goals_at(at_us, 3);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_EQUAL(CDS_OK, second.result);
}

/* A READ that nobody answers lasts longer than a short period. */
void test_goals_in_the_queue_leave_before_newer_ones(void)
{
    uint8_t packet[CDS_PACKET_SIZE(2)], reply[CDS_REPLY_MAX];
    struct cds_request request = CDS_REQUEST(packet, reply);
    uint8_t periods = 0;

    cds_bus_set_return_delay(&bus, 508);
    TEST_ASSERT_EQUAL(CDS_OK, begin_with(&bus, ids, SERVOS, 500));
    set_all(0x200);
    cds_cycle_commit(&cycle);
    run_to(800);
    dead = 7;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_read(&bus, &request, 7, 0, CDS_REPLY_MAX));
    run_to(1100);
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.goals.result); // of the period at 1000
    set_all(0x300);
    cds_cycle_commit(&cycle);
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_cycle_goal(&cycle, 0, 0x111, 0));
    memset(goals_sent, 0, sizeof goals_sent);
    while (position_sent(1) == 0)
        run_to((uint16_t)(now() + 1));
    TEST_ASSERT_EQUAL_HEX16(0x201, position_sent(1));
    TEST_ASSERT_UINT16_WITHIN(10, 800 + 80 + 508 + 560 + CDS_REPLY_MARGIN_US + REST_US + GOALS_US,
                              now());
    run_to(2740);
    TEST_ASSERT_EQUAL_HEX16(0x301, position_sent(1));
    for (uint8_t i = 0; i < start_count; i++)
        periods = (uint8_t)(periods + (starts[i].id == CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL_UINT32(periods, cycle.counters.periods);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.unsent);
}

void test_abort_ends_when_the_packet_in_flight_has_ended(void)
{
    begin_with_goals();
    run_to(4100);
    cds_cycle_abort(&cycle);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_cycle_poll(&cycle));
    TEST_ASSERT_EQUAL(CDS_BUSY, begin_with(&bus, ids, SERVOS, PERIOD_US));
    start_count = 0;
    run_to(9000);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_poll(&cycle));
    TEST_ASSERT_EQUAL_UINT8(0, start_count);
    begin();
}

void test_abort_while_a_read_waits_for_the_line_cancels_it(void)
{
    begin();
    cds_cycle_poll(&cycle);
    port_fake.now_us++;
    port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1);
    cds_cycle_poll(&cycle);
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.read.result);
    TEST_ASSERT_FALSE(port_fake_is_in_flight(&bus));
    cds_cycle_abort(&cycle);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_poll(&cycle));
    run_to(1000);
    TEST_ASSERT_EQUAL_UINT8(0, start_count);
}

void test_abort_of_a_cycle_never_begun_ends_at_once(void)
{
    cds_cycle_abort(&cycle);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_poll(&cycle));
}

void test_begin_with_bad_arguments_is_refused(void)
{
    struct cds_bus closed = {.port = 0};
    static const uint8_t bad[] = {1, 254};

    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_with(&closed, ids, 3, 4000));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_with(&bus, ids, 0, 4000));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_with(&bus, many, 51, 4000));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_with(&bus, bad, 2, 4000));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_with(&bus, many, 50, 2679));
    TEST_ASSERT_EQUAL(CDS_OK, begin_with(&bus, many, 50, 2680));
    TEST_ASSERT_EQUAL_UINT16(258, cycle.goals.packet.size);
    TEST_ASSERT_EQUAL_PTR(packets + 258, cycle.back);
}

void test_oldest_us_and_utilisation_are_right(void)
{
    dead = 9;
    begin_with_goals();
    run_to(8000 - 1);
    TEST_ASSERT_EQUAL_UINT32(CDS_FEEDBACK_NEVER, cds_cycle_oldest_us(&cycle));
    setUp();
    begin_with_goals();
    run_to(8000 - 1);
    TEST_ASSERT_EQUAL_UINT16((GOALS_US + 14 * 250) * 1000ul / PERIOD_US,
                             cds_cycle_utilisation_permille(&cycle));
    port_fake.now_us += 5;
    TEST_ASSERT_EQUAL_UINT32(port_fake.now_us - feedback[cycle.turn].time_us,
                             cds_cycle_oldest_us(&cycle));
}

void test_spare_us_of_the_shortest_period_is_none(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin_with(&bus, ids, SERVOS, GOALS_US + 140));
    TEST_ASSERT_EQUAL_UINT16(0, cds_cycle_spare_us(&cycle));
    TEST_ASSERT_EQUAL(CDS_OK, begin_with(&bus, ids, SERVOS, GOALS_US + CDS_REPLY_MARGIN_US));
    TEST_ASSERT_EQUAL_UINT16(0, cds_cycle_spare_us(&cycle));
    TEST_ASSERT_EQUAL(CDS_OK, begin_with(&bus, ids, SERVOS, GOALS_US + 141));
    TEST_ASSERT_EQUAL_UINT16(1, cds_cycle_spare_us(&cycle));
}

void test_utilisation_before_the_first_period_is_0(void)
{
    begin_with_goals();
    TEST_ASSERT_EQUAL_UINT16(0, cds_cycle_utilisation_permille(&cycle));
}

void test_utilisation_outlives_the_wrap_of_its_sums(void)
{
    begin_with_goals();
    run_to(3999);
    cycle.elapsed_us = 0x3FFFF000; // 4096 us before both sums are halved
    cycle.wire_us = 0x10000000;
    run_to(7999);
    TEST_ASSERT_EQUAL_UINT32(0x3FFFF000 + PERIOD_US, cycle.elapsed_us);
    run_to(8001);
    TEST_ASSERT_EQUAL_UINT32((0x3FFFF000 + 2 * PERIOD_US) / 2, cycle.elapsed_us);
    TEST_ASSERT_UINT32_WITHIN(PERIOD_US, 0x08000000, cycle.wire_us);
    TEST_ASSERT_EQUAL_UINT16(250, cds_cycle_utilisation_permille(&cycle));
}

void test_begin_while_a_read_is_in_flight_is_busy(void)
{
    begin_with_goals();
    run_to(GOALS_US + 50);
    TEST_ASSERT_EQUAL(CDS_PENDING, cycle.read.result);
    TEST_ASSERT_EQUAL(CDS_BUSY, begin_with(&bus, ids, SERVOS, PERIOD_US));
    cds_cycle_abort(&cycle);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_cycle_poll(&cycle));
    start_count = 0;
    run_to(1000);
    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_poll(&cycle));
    TEST_ASSERT_EQUAL_UINT8(0, start_count);
    TEST_ASSERT_EQUAL(CDS_OK, begin_with(&bus, ids, SERVOS, PERIOD_US));
}

void test_periods_before_the_first_commit_are_not_missed(void)
{
    begin();
    cds_bus_set_return_delay(&bus, CDS_RETURN_DELAY_MAX_US);
    port_fake.now_us += 5 * PERIOD_US;
    cds_cycle_poll(&cycle);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.periods);
    TEST_ASSERT_EQUAL_UINT32(6 * PERIOD_US, cycle.next_us - BEGIN_US);
}

/* The goals wait for a line that stays low; the next period begins meanwhile. */
/* The goals, or else the first READ, wait for a line that stays low. */
static void wait_for_a_low_line(void)
{
    cds_cycle_poll(&cycle);
    port_fake.low = true;
    for (uint16_t i = 0; i < 9000 && bus.stats.line_busy == 0; i++)
        run_to((uint16_t)(now() + 1));
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.line_busy);
    TEST_ASSERT_EQUAL_UINT8(0, start_count);
    cds_cycle_poll(&cycle);
}

void test_goals_without_a_quiet_line_count_as_unsent(void)
{
    begin_with_goals();
    port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1);
    wait_for_a_low_line();
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.unsent);
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.periods);
    port_fake.low = false;
    run_to(9000);
    TEST_ASSERT_EQUAL_HEX16(0x200, position_sent(0));
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.unsent);
}

void test_read_without_a_quiet_line_is_no_wire_time(void)
{
    begin();
    cds_cycle_poll(&cycle); // begins the first period
    port_fake.now_us++;
    port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1);
    wait_for_a_low_line();
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.failed);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.wire_us);
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, feedback[0].result);
}

void test_read_that_is_refused_brings_no_values(void)
{
    begin();
    run_to(100); // the READ is on the wire since 1 us
    TEST_ASSERT_TRUE(answering);
    answering = false;
    port_fake_answer(&bus.link, ids[0], CDS_ERROR_INSTRUCTION, NULL, 0);
    for (uint8_t i = 0; i < 20 && cycle.counters.reads == 0; i++) {
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
    }
    TEST_ASSERT_EQUAL_UINT32(1, cycle.counters.failed);
    TEST_ASSERT_EQUAL(CDS_REFUSED, feedback[0].result);
    TEST_ASSERT_FALSE(feedback[0].known);
}

void test_goals_on_a_bus_without_a_queue_wait_for_the_bus(void)
{
    static const uint16_t at_us[] = {0, 4000, 8000};

    bus.hooks = NULL;
    begin_with_goals();
    run_to(11999);
    assert_goals_at(at_us, 3);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.missed);
    TEST_ASSERT_EQUAL_UINT32(0, cycle.counters.failed);
}
