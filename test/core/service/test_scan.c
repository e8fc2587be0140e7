/* SPDX-License-Identifier: MIT */
/* Scans of IDs and baud rates, against a few fake servos. */
#include "cds55xx/scan.h"

#include "cds55xx/queue.h"
#include "cds55xx/servo.h"
#include "bus_rig.h"
#include "permit_fake.h"
#include "servos_fake.h"
#include "unity.h"

static struct cds_queue queue;
static uint8_t packet[CDS_SCAN_PACKET_SIZE], reply[CDS_SCAN_REPLY_SIZE];
static struct cds_request request;
static struct cds_scan_config config;
static struct cds_scan scan;
static struct cds_scan_found found[4];
static bool is_opened_anew; // nothing is given back

void setUp(void)
{
    rig_open(0);
    is_opened_anew = false;
    memset(&servos, 0, sizeof servos);
    memset(found, 0, sizeof found);
    memset(&scan, 0, sizeof scan);
    request = (struct cds_request)CDS_REQUEST(packet, reply);
    cds_bus_set_return_delay(&bus, 2);
    config = (struct cds_scan_config){
        .bus = &bus, .request = &request, .found = found, .found_capacity = 4, .last_id = 253};
}

static void begin(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_scan_begin(&scan, &config));
}

void tearDown(void)
{
    rig_check();
    TEST_ASSERT_FALSE(request.ignores_stale); // the caller's next READ must not
    TEST_ASSERT_FALSE(request.passes_lock);
    TEST_ASSERT_NULL(request.on_end);
    if (bus.state != CDS_BUS_CLOSED && !is_opened_anew) {
        TEST_ASSERT_NULL(bus.lock);
        TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud_reg);
        TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, port_fake.bauds[0]);
        TEST_ASSERT_EQUAL_UINT16(2, bus.return_delay_us);
    }
}

static enum cds_result run_at_most(uint32_t turns)
{
    enum cds_result result;

    while ((result = cds_scan_poll(&scan)) == CDS_PENDING && turns--) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    return result;
}

static enum cds_result go_on(void)
{
    return run_at_most(UINT32_MAX);
}

static enum cds_result run(void)
{
    begin();
    return go_on();
}

static void set_ids(uint8_t first, uint8_t last)
{
    config.first_id = first;
    config.last_id = last;
}

static void set_bauds(const uint8_t *baud_regs, uint8_t count)
{
    config.baud_regs = baud_regs;
    config.baud_count = count;
}

static void assert_found(uint8_t index, uint8_t id, uint8_t baud)
{
    TEST_ASSERT_EQUAL_UINT8(id, found[index].id);
    TEST_ASSERT_EQUAL_UINT8(baud, found[index].baud_reg);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, found[index].result);
}

void test_scan_all_ids_at_1_mbps_takes_less_than_300_ms(void)
{
    servo_fake_put(0, 0, 1);
    servo_fake_put(1, 253, 1);
    servo_fake_put(2, 100, 1);
    set_bauds(&bus.baud_reg, 1);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_LESS_THAN_UINT32(300000, port_fake.now_us);
    TEST_ASSERT_GREATER_THAN_UINT32(251u * 728u, port_fake.now_us); // safe at any return delay
    TEST_ASSERT_EQUAL_UINT16(3, scan.count);
    assert_found(0, 0, 1);
    assert_found(1, 100, 1);
    assert_found(2, 253, 1);
    TEST_ASSERT_EQUAL_UINT8(CDS_PENDING, found[0].details);
    TEST_ASSERT_EQUAL_UINT16(254, servos.packets);
    TEST_ASSERT_EQUAL_UINT16(254, scan.asked);
    TEST_ASSERT_EQUAL_UINT16(254, scan.total);
}

void test_scan_on_a_bus_opened_again_gives_back_the_request(void)
{
    begin();
    while (!port_fake_is_in_flight(&bus))
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_TRUE(request.ignores_stale);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, 2);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_scan_poll(&scan));
    TEST_ASSERT_FALSE(request.ignores_stale);
}

void test_listed_rates_are_the_default_and_details_are_read(void)
{
    servo_fake_put(0, 7, 103);
    servo_fake_put(1, 7, 16);
    servo_fake_put(2, 8, 9); // not a listed rate
    set_ids(6, 8);
    config.reads_details = true;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(18, scan.total);
    TEST_ASSERT_EQUAL_UINT16(18, scan.asked);
    TEST_ASSERT_EQUAL_UINT16(2, scan.count);
    assert_found(0, 7, 16);
    assert_found(1, 7, 103);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, found[1].details);
    TEST_ASSERT_EQUAL_UINT8(1, found[1].model);
    TEST_ASSERT_EQUAL_UINT8(103, found[1].own_baud_reg);
}

void test_a_rescue_tries_every_rate(void)
{
    servo_fake_put(0, 5, 254);
    servo_fake_put(1, 5, 0);
    servo_fake_put(2, 5, 99);
    set_ids(5, 5);
    config.tries_every_rate = true;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(255, scan.asked);
    assert_found(0, 5, 0);
    assert_found(1, 5, 99);
    assert_found(2, 5, 254);
}

void test_the_total_of_the_largest_scan_fits(void)
{
    config.tries_every_rate = true;
    begin();
    TEST_ASSERT_EQUAL_UINT16(254u * 255u, scan.total);
    cds_scan_abort(&scan);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, go_on());
}

void test_an_abort_at_any_poll_gives_the_bus_its_rate_back(void)
{
    static const uint8_t slow[] = {3, 7};

    for (uint8_t polls = 0; polls < 200; polls++) {
        setUp();
        servo_fake_put(0, 1, 3);
        set_ids(0, 2);
        set_bauds(slow, 2);
        config.reads_details = true;
        begin();
        for (uint8_t i = 0; i < polls; i++) {
            cds_scan_poll(&scan);
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        cds_scan_abort(&scan);
        TEST_ASSERT_EQUAL(scan.steps.result == CDS_PENDING ? CDS_CANCELLED : scan.steps.result,
                          go_on());
        TEST_ASSERT_NOT_EQUAL(CDS_PENDING, scan.steps.result);
        tearDown();
    }
}

void test_two_servos_of_one_id_are_reported_as_damage(void)
{
    servo_fake_put(0, 9, 1);
    servo_fake_put(1, 9, 1);
    set_ids(8, 10);
    set_bauds(&bus.baud_reg, 1);
    config.reads_details = true;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(1, scan.count);
    TEST_ASSERT_EQUAL_UINT8(9, found[0].id);
    TEST_ASSERT_EQUAL_UINT8(CDS_CORRUPT, found[0].result);
    TEST_ASSERT_EQUAL_UINT8(CDS_PENDING, found[0].details);
}

void test_details_that_were_not_read_are_no_values(void)
{
    servo_fake_put(0, 9, 1);
    servos.servo[0].table[0x10] = 0; // answers PING only
    set_ids(8, 10);
    set_bauds(&bus.baud_reg, 1);
    config.reads_details = true;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(1, scan.count);
    TEST_ASSERT_EQUAL_UINT8(CDS_TIMEOUT, found[0].details);
    TEST_ASSERT_EQUAL_UINT8(0, found[0].model);
}

/* A permit that knows servo 9 to answer PING only. */
static enum cds_result refuse_read_of_9(struct cds_request *asked)
{
    const uint8_t *bytes = asked->packet.bytes;

    return bytes[CDS_AT_ID] == 9 && bytes[CDS_AT_INSTRUCTION] == CDS_READ ? CDS_NO_REPLY_DUE
                                                                          : CDS_OK;
}

void test_details_that_the_permit_refuses_hold_up_nothing(void)
{

    servo_fake_put(0, 9, 1);
    servo_fake_put(1, 10, 1);
    servos.servo[0].table[0x10] = 0;
    permit_fake_attach(&bus, refuse_read_of_9);
    set_ids(8, 10);
    set_bauds(&bus.baud_reg, 1);
    config.reads_details = true;
    begin();
    TEST_ASSERT_EQUAL(CDS_OK, run_at_most(1000));
    TEST_ASSERT_EQUAL_UINT16(3, scan.asked);
    TEST_ASSERT_EQUAL_UINT16(2, scan.count);
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_REPLY_DUE, found[0].details);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, found[1].details);
}

void test_more_than_there_is_room_for_are_counted_only(void)
{
    for (uint8_t i = 0; i < 3; i++)
        servo_fake_put(i, i, 1);
    config.found_capacity = 2;
    set_ids(0, 3);
    set_bauds(&bus.baud_reg, 1);
    config.reads_details = true;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(3, scan.count);
    assert_found(1, 1, 1);
    TEST_ASSERT_EQUAL_UINT8(0, found[2].baud_reg);
}

void test_it_waits_while_others_use_the_bus(void)
{
    static const uint8_t slow[] = {3};
    uint8_t other_buffer[8];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(other_buffer);

    set_bauds(slow, 1);
    set_ids(1, 1);
    cds_packet_ping(&other.packet, 200);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
    begin();
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud_reg);
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    TEST_ASSERT_EQUAL_UINT16(2, servos.packets);
}

static void assert_refused(enum cds_result result)
{
    TEST_ASSERT_EQUAL(result, cds_scan_begin(&scan, &config));
    TEST_ASSERT_NULL(bus.lock);
    TEST_ASSERT_EQUAL_UINT16(2, bus.return_delay_us);
    TEST_ASSERT_FALSE(request.passes_lock);
}

void test_nonsense_is_refused(void)
{
    static const uint8_t none[] = {255};
    struct cds_bus closed = {.port = 0};

    set_ids(0, 254);
    assert_refused(CDS_BAD_ARGUMENT);
    set_ids(2, 1);
    assert_refused(CDS_BAD_ARGUMENT);
    set_ids(1, 2);
    set_bauds(none, 1);
    assert_refused(CDS_BAD_ARGUMENT);
    set_bauds(NULL, 5);
    assert_refused(CDS_BAD_ARGUMENT);
    set_bauds(&bus.baud_reg, 0);
    assert_refused(CDS_BAD_ARGUMENT);
    set_bauds(NULL, 0);
    request.packet.capacity--;
    assert_refused(CDS_NO_ROOM);
    request.packet.capacity++;
    request.reply_capacity--;
    config.reads_details = true;
    assert_refused(CDS_NO_ROOM);
    config.reads_details = false; // then no reply has parameters
    begin();
    cds_scan_abort(&scan);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, go_on());
    request.result = CDS_PENDING;
    assert_refused(CDS_BUSY);
    request.result = CDS_OK;
    config.bus = &closed;
    assert_refused(CDS_BAD_ARGUMENT);
    TEST_ASSERT_EQUAL_UINT16(0, servos.packets);
}

/* ---- whose the bus is ---- */

static void run_until(uint8_t baud, bool in_flight)
{
    servo_fake_put(0, 7, baud);
    set_ids(7, 7);
    config.reads_details = true;
    begin();
    while (scan.count == 0 || port_fake_is_in_flight(&bus) != in_flight) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
        if (scan.count && port_fake_is_in_flight(&bus) == in_flight)
            break;
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
}

void test_a_bus_that_is_opened_anew_is_its_opener_s(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        setUp();
        run_until(3, i & 1); // while details are read, or between two transactions
        cds_bus_open(&bus, 0, 34);
        if (i & 2)
            cds_bus_set_return_delay(&bus, 20);
        TEST_ASSERT_EQUAL(CDS_CANCELLED, go_on());
        TEST_ASSERT_EQUAL_UINT8(34, bus.baud_reg);
        TEST_ASSERT_EQUAL_UINT16(i & 2 ? 20 : CDS_RETURN_DELAY_MAX_US, bus.return_delay_us);
    }
    is_opened_anew = true;
}

void test_a_scan_whose_request_is_cancelled_gives_the_bus_back(void)
{
    for (uint8_t details = 0; details < 2; details++) {
        setUp();
        servo_fake_put(0, 7, 3);
        set_ids(details ? 7 : 8, 9);
        config.reads_details = true;
        begin();
        do {
            servos_turn(&bus);
            cds_bus_poll(&bus);
            if (scan.baud_index == 1 && scan.count == details && !bus.request)
                port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1); // it has to wait
            TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
        } while (scan.baud_index != 1 || scan.count != details || !bus.request ||
                 port_fake_is_in_flight(&bus));
        TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
        TEST_ASSERT_EQUAL(CDS_CANCELLED, go_on());
        tearDown();
    }
}

void test_scan_under_way_begin_is_refused_until_it_frees_the_bus(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        setUp();
        run_until(7, i);
        TEST_ASSERT_EQUAL(CDS_BUSY, cds_scan_begin(&scan, &config));
        TEST_ASSERT_EQUAL_UINT16(1, scan.count);
        cds_scan_abort(&scan);
        TEST_ASSERT_EQUAL(i ? CDS_BUSY : CDS_OK, cds_scan_begin(&scan, &config));
        TEST_ASSERT_EQUAL(i ? CDS_CANCELLED : CDS_OK, go_on());
        set_ids(7, 8);
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL_UINT16(1, scan.count);
        tearDown();
    }
}

static uint8_t ping_buffer[CDS_PACKET_SIZE(0)];

void test_scan_locks_the_bus_except_for_requests_that_pass(void)
{
    struct cds_request ping = CDS_REQUEST_WITHOUT_DATA(ping_buffer);
    struct cds_scan second;

    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    set_bauds(&bus.baud_reg, 1);
    begin();
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &ping, 7));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_scan_begin(&second, &config));
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_servo_ping(&bus, &ping, 7));
    ping.passes_lock = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &ping, 7));
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, ping.result);
    ping.passes_lock = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &ping, 7));
}

void test_a_scan_leaves_behind_a_request_that_waited(void)
{
    struct cds_request pings[] = {CDS_REQUEST_WITHOUT_DATA(ping_buffer),
                                  CDS_REQUEST_WITHOUT_DATA(ping_buffer)};

    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    request.priority = CDS_PRIORITY_HIGH;
    set_bauds(&bus.baud_reg, 1);
    for (uint8_t i = 0; i < 2; i++)
        TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &pings[i], 9));
    begin();
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_EQUAL(CDS_PENDING, request.result);
    while (pings[0].result == CDS_PENDING) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL_PTR(&pings[1], bus.request);
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, pings[1].result);
}

void test_scan_abort_behind_a_passing_request_restores_the_rate(void)
{
    static const uint8_t slow[] = {7};
    struct cds_request ping = CDS_REQUEST_WITHOUT_DATA(ping_buffer);

    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    ping.passes_lock = true;
    set_bauds(slow, 1);
    set_ids(7, 7);
    begin();
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_EQUAL(CDS_OK, cds_servo_ping(&bus, &ping, 9));
    while (bus.request != &ping) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_EQUAL_UINT16(1, scan.asked);
    TEST_ASSERT_NOT_NULL(bus.lock);
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, ping.result);
}

/* As torque off does it: the lock is all it knows of the operation. */
void test_scan_abort_by_the_lock_restores_the_bus_without_poll(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        setUp();
        run_until(7, i);
        TEST_ASSERT_EQUAL_UINT8(7, bus.baud_reg);
        TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.lock->baud_reg);
        bus.lock->abort(bus.lock->context);
        TEST_ASSERT_EQUAL(i, bus.lock != NULL); // its packet is on the wire
        while (bus.request) {
            TEST_ASSERT_EQUAL_UINT8(7, bus.baud_reg);
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        TEST_ASSERT_NULL(bus.lock);
        TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud_reg);
        TEST_ASSERT_EQUAL_UINT16(2, bus.return_delay_us);
        TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_scan_poll(&scan));
        TEST_ASSERT_EQUAL_UINT16(1, scan.count);
        tearDown();
    }
}

void test_abort_takes_back_a_request_that_waits_for_the_line(void)
{
    run_until(7, false);
    port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_EQUAL(CDS_BUS_WAITING_FOR_LINE, bus.state);
    cds_scan_abort(&scan);
    TEST_ASSERT_NULL(bus.lock);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, request.result);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_scan_poll(&scan));
    cds_scan_abort(&scan); // does nothing any more
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_scan_poll(&scan));
}

void test_a_return_delay_that_is_set_meanwhile_stays(void)
{
    begin();
    cds_bus_set_return_delay(&bus, 30);
    cds_scan_abort(&scan);
    TEST_ASSERT_EQUAL_UINT16(30, bus.return_delay_us);
    cds_bus_set_return_delay(&bus, 2);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_scan_poll(&scan));
}

void test_ping_that_is_refused_finds_the_servo(void)
{
    servo_fake_put(0, 5, 1);
    servos.servo[0].error = CDS_ERROR_CHECKSUM; // the packet came damaged, but to this servo
    set_ids(4, 6);
    set_bauds(&bus.baud_reg, 1);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(1, scan.count);
    assert_found(0, 5, 1);
}

void test_line_that_is_not_quiet_ends_the_scan(void)
{
    servo_fake_put(0, 5, 1);
    set_ids(5, 7);
    set_bauds(&bus.baud_reg, 1);
    begin();
    while (scan.count == 0)
        run_at_most(1);
    port_fake.low = true;
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, go_on());
    TEST_ASSERT_EQUAL_UINT16(1, scan.count); // what was found before stays
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.line_busy);
}

/* ---- cds_bus_set_baud() ---- */

void test_set_baud_idle_bus_only_keeps_stats_and_settings(void)
{
    struct cds_bus closed = {.port = 0};
    struct cds_stats stats;

    is_opened_anew = true; // no scan here
    servo_fake_put(0, 1, 7);
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    cds_queue_set_retries(&queue, 1);
    cds_packet_ping(&request.packet, 1);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_BUSY, cds_bus_set_baud(&bus, 7));
    TEST_ASSERT_EQUAL_UINT8(1, port_fake.bauds[0]);
    do
        servos_turn(&bus);
    while (cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_set_baud(&bus, 255));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_bus_set_baud(&closed, 1));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_set_baud(&bus, 7));
    TEST_ASSERT_EQUAL_UINT8(7, port_fake.bauds[0]);
    TEST_ASSERT_EQUAL_UINT16(40, bus.byte_time_us);
    TEST_ASSERT_EQUAL_UINT16(2, bus.stats.timeouts); // one of them retried
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.retried);
    TEST_ASSERT_EQUAL_UINT16(2, bus.return_delay_us);
    TEST_ASSERT_EQUAL_PTR(&queue.hooks, bus.hooks);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
    do
        servos_turn(&bus);
    while (cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, request.result);
    cds_bus_stats(&bus, &stats);
    TEST_ASSERT_EQUAL_UINT16(1, stats.ok);
}
