/* Scans of IDs and baud rates, against a few fake servos. */
#include "cds55xx/scan.h"

#include "cds55xx/servos.h"
#include "servos_fake.h"
#include "unity.h"

static struct cds_bus bus;
static uint8_t buffer[CDS_PACKET_SIZE(2)];
static struct cds_request request;
static struct cds_scan scan;
static struct cds_scan_found found[4];

void setUp(void)
{
    port_fake_reset();
    memset(&servos, 0, sizeof servos);
    memset(&bus, 0, sizeof bus);
    memset(found, 0, sizeof found);
    memset(&scan, 0, sizeof scan);
    request = (struct cds_request)CDS_REQUEST(buffer);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, 2);
    cds_scan_begin(&scan, &bus, &request, found, 4);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
    TEST_ASSERT_FALSE(request.skips_rest); // the caller's next READ must not
    if (scan.result != CDS_BAD_ARGUMENT) {
        TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud);
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

static enum cds_result run(void)
{
    return run_at_most(UINT32_MAX);
}

static void assert_found(uint8_t index, uint8_t id, uint8_t baud)
{
    TEST_ASSERT_EQUAL_UINT8(id, found[index].id);
    TEST_ASSERT_EQUAL_UINT8(baud, found[index].baud);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, found[index].result);
}

void test_all_ids_at_1_mbps_within_300_ms_and_first_and_last_are_found(void)
{
    servo_fake_put(0, 0, 1);
    servo_fake_put(1, 253, 1);
    servo_fake_put(2, 100, 1);
    cds_scan_set_bauds(&scan, &bus.baud, 1);
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
    while (!cds_bus_is_in_flight_(&bus))
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_TRUE(request.skips_rest);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, 2);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, cds_scan_poll(&scan));
    TEST_ASSERT_FALSE(request.skips_rest);
}

void test_listed_rates_are_the_default_and_details_are_read(void)
{
    servo_fake_put(0, 7, 103);
    servo_fake_put(1, 7, 16);
    servo_fake_put(2, 8, 9); // not a listed rate
    cds_scan_set_ids(&scan, 6, 8);
    cds_scan_set_details(&scan);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(18, scan.total);
    TEST_ASSERT_EQUAL_UINT16(18, scan.asked);
    TEST_ASSERT_EQUAL_UINT16(2, scan.count);
    assert_found(0, 7, 16);
    assert_found(1, 7, 103);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, found[1].details);
    TEST_ASSERT_EQUAL_UINT8(1, found[1].model);
    TEST_ASSERT_EQUAL_UINT8(103, found[1].own_baud);
}

void test_a_rescue_tries_every_rate(void)
{
    servo_fake_put(0, 5, 254);
    servo_fake_put(1, 5, 0);
    servo_fake_put(2, 5, 99);
    cds_scan_set_ids(&scan, 5, 5);
    cds_scan_set_rescue(&scan);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(255, scan.asked);
    assert_found(0, 5, 0);
    assert_found(1, 5, 99);
    assert_found(2, 5, 254);
}

void test_the_total_of_the_largest_scan_fits(void)
{
    cds_scan_set_rescue(&scan);
    cds_scan_poll(&scan);
    TEST_ASSERT_EQUAL_UINT16(254u * 255u, scan.total);
    cds_scan_abort(&scan);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
}

void test_an_abort_at_any_poll_gives_the_bus_its_rate_back(void)
{
    static const uint8_t slow[] = {3, 7};

    for (uint8_t polls = 0; polls < 200; polls++) {
        setUp();
        servo_fake_put(0, 1, 3);
        cds_scan_set_ids(&scan, 0, 2);
        cds_scan_set_bauds(&scan, slow, 2);
        cds_scan_set_details(&scan);
        for (uint8_t i = 0; i < polls; i++) {
            cds_scan_poll(&scan);
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        cds_scan_abort(&scan);
        TEST_ASSERT_EQUAL(scan.result == CDS_PENDING ? CDS_CANCELLED : scan.result, run());
        TEST_ASSERT_NOT_EQUAL(CDS_PENDING, scan.result);
        tearDown();
    }
}

void test_two_servos_of_one_id_are_reported_as_damage(void)
{
    servo_fake_put(0, 9, 1);
    servo_fake_put(1, 9, 1);
    cds_scan_set_ids(&scan, 8, 10);
    cds_scan_set_bauds(&scan, &bus.baud, 1);
    cds_scan_set_details(&scan);
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
    cds_scan_set_ids(&scan, 8, 10);
    cds_scan_set_bauds(&scan, &bus.baud, 1);
    cds_scan_set_details(&scan);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(1, scan.count);
    TEST_ASSERT_EQUAL_UINT8(CDS_TIMEOUT, found[0].details);
    TEST_ASSERT_EQUAL_UINT8(0, found[0].model);
}

void test_details_that_the_roster_says_nobody_answers_hold_up_nothing(void)
{
    static struct cds_servo_state known[] = {{.id = 9}};
    static struct cds_servos roster;

    servo_fake_put(0, 9, 1);
    servo_fake_put(1, 10, 1);
    servos.servo[0].table[0x10] = 0;
    TEST_ASSERT_EQUAL(CDS_OK, cds_servos_begin(&roster, &bus, known, 1));
    known[0].status_return_level = 0;
    cds_scan_set_ids(&scan, 8, 10);
    cds_scan_set_bauds(&scan, &bus.baud, 1);
    cds_scan_set_details(&scan);
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
    cds_scan_begin(&scan, &bus, &request, found, 2);
    cds_scan_set_ids(&scan, 0, 3);
    cds_scan_set_bauds(&scan, &bus.baud, 1);
    cds_scan_set_details(&scan);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(3, scan.count);
    assert_found(1, 1, 1);
    TEST_ASSERT_EQUAL_UINT8(0, found[2].baud);
}

void test_it_waits_while_others_use_the_bus(void)
{
    static const uint8_t slow[] = {3};
    uint8_t other_buffer[8];
    struct cds_request other = CDS_REQUEST(other_buffer);

    cds_scan_set_bauds(&scan, slow, 1);
    cds_scan_set_ids(&scan, 1, 1);
    cds_packet_ping(&other.packet, 200);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud);
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(2, servos.packets);
}

void test_nonsense_is_refused(void)
{
    static const uint8_t none[] = {255};
    struct cds_bus closed = {.port = 0};

    cds_scan_set_ids(&scan, 0, 254);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, run());
    setUp();
    cds_scan_set_ids(&scan, 2, 1);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, run());
    setUp();
    cds_scan_set_bauds(&scan, none, 1);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, run());
    setUp();
    cds_scan_set_bauds(&scan, NULL, 5);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, run());
    setUp();
    request.packet.capacity--;
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, run());
    setUp();
    cds_scan_begin(&scan, &closed, &request, found, 4);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, run());
    TEST_ASSERT_EQUAL_UINT16(0, servos.packets);
}

/* ---- whose the bus is ---- */

static void run_until(uint8_t baud, bool in_flight)
{
    servo_fake_put(0, 7, baud);
    cds_scan_set_ids(&scan, 7, 7);
    cds_scan_set_details(&scan);
    while (scan.count == 0 || cds_bus_is_in_flight_(&bus) != in_flight) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
        if (scan.count && cds_bus_is_in_flight_(&bus) == in_flight)
            break;
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
}

void test_a_bus_that_is_opened_anew_is_its_opener_s(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        setUp();
        run_until(3, i & 1); // while details are read, or between two exchanges
        cds_bus_open(&bus, 0, 34);
        if (i & 2)
            cds_bus_set_return_delay(&bus, 20);
        TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
        TEST_ASSERT_EQUAL_UINT8(34, bus.baud);
        TEST_ASSERT_EQUAL_UINT16(i & 2 ? 20 : CDS_RETURN_DELAY_MAX_US, bus.return_delay_us);
    }
    scan.result = CDS_BAD_ARGUMENT; // for tearDown(): nothing is to be given back
}

void test_a_scan_whose_request_is_cancelled_gives_the_bus_back(void)
{
    for (uint8_t details = 0; details < 2; details++) {
        setUp();
        servo_fake_put(0, 7, 3);
        cds_scan_set_ids(&scan, details ? 7 : 8, 9);
        cds_scan_set_details(&scan);
        do {
            servos_turn(&bus);
            cds_bus_poll(&bus);
            if (scan.baud_index == 1 && scan.count == details && !bus.request)
                port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1); // it has to wait
            TEST_ASSERT_EQUAL(CDS_PENDING, cds_scan_poll(&scan));
        } while (scan.baud_index != 1 || scan.count != details || !bus.request ||
                 cds_bus_is_in_flight_(&bus));
        TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
        TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
        tearDown();
    }
}

void test_a_scan_begun_anew_under_way_gives_back_what_was_before_the_first(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        setUp();
        run_until(7, i);
        cds_scan_begin(&scan, &bus, &request, found, 4);
        cds_scan_set_ids(&scan, 7, 8);
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL_UINT16(1, scan.count);
        tearDown();
    }
}

/* ---- cds_bus_set_baud() ---- */

void test_another_rate_keeps_counters_and_settings_and_is_only_for_an_idle_bus(void)
{
    struct cds_bus closed = {.port = 0};

    scan.result = CDS_BAD_ARGUMENT; // no scan here
    servo_fake_put(0, 1, 7);
    cds_bus_set_repeats(&bus, 1);
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
    TEST_ASSERT_EQUAL_UINT16(1, bus.counters.timeouts);
    TEST_ASSERT_EQUAL_UINT16(2, bus.return_delay_us);
    TEST_ASSERT_EQUAL_UINT8(1, bus.repeats);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &request));
    do
        servos_turn(&bus);
    while (cds_bus_poll(&bus));
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, request.result);
    TEST_ASSERT_EQUAL_UINT16(1, bus.counters.ok);
}
