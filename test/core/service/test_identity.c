/* SPDX-License-Identifier: MIT */
/* ID, baud rate and factory reset as transactions, with packets and replies lost and the power cut
 * at every step: what is reported is where the servo is. */
#include "cds55xx/identity.h"

#include "bus_rig.h"
#include "permit_fake.h"
#include "servos_fake.h"
#include "unity.h"

enum what { NEW_ID, NEW_BAUD, RESET_IT, RESET_IN_PLACE, WHATS };

#define LONGEST 14 // packets of a transaction

static uint8_t buffer[CDS_PACKET_SIZE(2)];
static struct cds_request request;
static struct cds_identity_config config;
static struct cds_identity identity;

void setUp(void)
{
    port_fake_reset();
    memset(&servos, 0, sizeof servos);
    memset(&bus, 0, sizeof bus);
    request = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(buffer);
}

void tearDown(void)
{
    rig_check();
}

static enum cds_result begin_change(uint8_t change)
{
    config.change = change;
    return cds_identity_begin(&identity, &config);
}

/* Servo 0 is at ID 5 and 250 kbps, or already where RESET leaves it; servo 1 stands by. */
static enum cds_result begin(uint8_t what)
{
    bool in_place = what == RESET_IN_PLACE;

    setUp();
    servo_fake_put(0, in_place ? 1 : 5, in_place ? 1 : 7);
    servo_fake_put(1, 6, in_place ? 1 : 7);
    cds_bus_open(&bus, 0, in_place ? 1 : 7);
    cds_bus_set_return_delay(&bus, 2);
    config = (struct cds_identity_config){
        .bus = &bus, .request = &request, .id = 5, .new_id = 9, .new_baud_reg = 1};
    switch (what) {
    case NEW_ID: return begin_change(CDS_IDENTITY_ID);
    case NEW_BAUD: return begin_change(CDS_IDENTITY_BAUD);
    case RESET_IT: return begin_change(CDS_IDENTITY_RESET);
    default: config.id = 1; return begin_change(CDS_IDENTITY_RESET);
    }
}

static enum cds_result run(void)
{
    enum cds_result result;

    while ((result = cds_identity_poll(&identity)) == CDS_PENDING) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL_UINT16(2, bus.return_delay_us);
    TEST_ASSERT_FALSE(request.ignores_stale); // the caller's next READ must not
    TEST_ASSERT_FALSE(request.passes_lock);
    TEST_ASSERT_NULL(bus.lock);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(1, servos.writes);
    TEST_ASSERT_EQUAL_UINT8(servos.writes, identity.is_written);
    TEST_ASSERT_EQUAL_UINT8(bus.baud_reg, port_fake.bauds[0]);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(LONGEST, servos.packets);
    return result;
}

static bool is_at(const struct cds_identity_place *place)
{
    return servos.servo[0].table[0x03] == place->id &&
           servos.servo[0].table[0x04] == place->baud_reg;
}

/* The report, held against the servo itself. */
static void assert_the_truth(void)
{
    switch (identity.state) {
    case CDS_IDENTITY_CHANGED:
        TEST_ASSERT_EQUAL(CDS_OK, identity.steps.result);
        TEST_ASSERT_TRUE(is_at(&identity.to));
        TEST_ASSERT_EQUAL_UINT8(identity.to.baud_reg, bus.baud_reg);
        break;
    case CDS_IDENTITY_UNCHANGED:
        TEST_ASSERT_NOT_EQUAL(CDS_OK, identity.steps.result);
        TEST_ASSERT_TRUE(is_at(&identity.from));
        TEST_ASSERT_EQUAL_UINT8(identity.from.baud_reg, bus.baud_reg);
        break;
    case CDS_IDENTITY_LOST:
        TEST_ASSERT_NOT_EQUAL(CDS_OK, identity.steps.result);
        TEST_ASSERT_EQUAL_UINT8(identity.from.baud_reg, bus.baud_reg);
        break;
    default: TEST_FAIL_MESSAGE("neither changed, unchanged nor lost");
    }
    TEST_ASSERT_EQUAL_UINT8(6, servos.servo[1].table[0x03]);
}

/* One transaction under this plan: told truly, and the servo found in the end. */
static void try(uint8_t what, struct servos_plan first, struct servos_plan second)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin(what));
    servos.plan[0] = first;
    servos.plan[1] = second;
    run();
    assert_the_truth();
    if (identity.state == CDS_IDENTITY_LOST) {
        TEST_ASSERT_GREATER_THAN_UINT8(0, first.absent); // nothing less loses it
        servos.dark = 0;
        memset(servos.plan, 0, sizeof servos.plan);
        servos.packets = 0;
        TEST_ASSERT_EQUAL(CDS_OK, cds_identity_look_again(&identity));
        run();
        assert_the_truth();
        TEST_ASSERT_NOT_EQUAL(CDS_IDENTITY_LOST, identity.state);
    }
}

void test_what_goes_well(void)
{
    for (uint8_t what = 0; what < WHATS; what++) {
        TEST_ASSERT_EQUAL(CDS_OK, begin(what));
        TEST_ASSERT_EQUAL_UINT16(0, bus.stats.sent);
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL(CDS_IDENTITY_CHANGED, identity.state);
        TEST_ASSERT_EQUAL_UINT8(CDS_OK, identity.at_to);
        assert_the_truth();
        TEST_ASSERT_EQUAL(CDS_OK, cds_identity_poll(&identity)); // and stays so
    }
}

void test_change_any_fault_or_power_cut_reports_the_truth(void)
{
    static const uint8_t absences[] = {0, 1, 2, 3, 4, 5, 7, SERVOS_FOREVER};
    struct servos_plan none = {0};

    for (uint8_t what = 0; what < WHATS; what++)
        for (uint8_t fault = 1; fault < FAULTS; fault++)
            for (uint8_t at = 1; at <= LONGEST; at++) {
                try(what, (struct servos_plan){at, fault, 0}, none);
                for (uint8_t i = 1; fault >= CUT_BEFORE && i < sizeof absences; i++)
                    try(what, (struct servos_plan){at, fault, absences[i]}, none);
            }
}

void test_any_two_losses_end_with_the_truth(void)
{
    for (uint8_t what = 0; what < WHATS; what++)
        for (uint8_t faults = 0; faults < 4; faults++)
            for (uint8_t at = 1; at < LONGEST; at++)
                for (uint8_t then = (uint8_t)(at + 1); then <= LONGEST; then++)
                    try(what, (struct servos_plan){at, faults & 1 ? LOSE_PACKET : LOSE_REPLY, 0},
                        (struct servos_plan){then, faults & 2 ? LOSE_PACKET : LOSE_REPLY, 0});
}

void test_change_lost_write_is_unchanged_lost_reply_is_changed(void)
{
    begin(NEW_ID); // three PINGs of the new ID, one of the old one, and the WRITE
    servos.plan[0] = (struct servos_plan){5, LOSE_PACKET, 0};
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_UNCHANGED, identity.state);
    TEST_ASSERT_EQUAL_UINT8(CDS_TIMEOUT, identity.at_to);
    begin(NEW_ID);
    servos.plan[0] = (struct servos_plan){5, LOSE_REPLY, 0};
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_CHANGED, identity.state);
}

void test_change_place_taken_is_never_written_whatever_the_faults(void)
{
    for (uint8_t what = 0; what < RESET_IN_PLACE; what++)
        for (uint8_t at = 1; at <= 3; at++)
            for (uint8_t fault = LOSE_PACKET; fault <= SPOIL_REPLY; fault++) {
                TEST_ASSERT_EQUAL(CDS_OK, begin(what));
                servo_fake_put(2, identity.to.id, identity.to.baud_reg);
                servos.plan[0] = (struct servos_plan){1, fault, 0};
                servos.plan[1] = (struct servos_plan){at, fault, 0};
                TEST_ASSERT_EQUAL(CDS_REFUSED, run());
                TEST_ASSERT_EQUAL(CDS_IDENTITY_TAKEN, identity.state);
                TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
                TEST_ASSERT_EQUAL_UINT8(CDS_OK, identity.at_from);
                TEST_ASSERT_TRUE(is_at(&identity.from));
                TEST_ASSERT_EQUAL_UINT8(identity.from.baud_reg, bus.baud_reg);
            }
}

void test_an_absent_servo_is_not_written_to(void)
{
    for (uint8_t what = 0; what < WHATS; what++) {
        begin(what);
        servos.dark = SERVOS_FOREVER;
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
        TEST_ASSERT_EQUAL(CDS_IDENTITY_LOST, identity.state);
        TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
    }
}

void test_two_servos_in_the_old_place_are_not_written_to(void)
{
    begin(NEW_ID);
    servo_fake_put(2, 5, 7);
    TEST_ASSERT_EQUAL(CDS_CORRUPT, run());
    TEST_ASSERT_EQUAL_UINT8(CDS_CORRUPT, identity.at_from);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

void test_a_twin_that_comes_to_light_is_told(void)
{
    begin(NEW_ID);
    while (!servos.writes) {
        cds_identity_poll(&identity);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    servo_fake_put(2, 5, 7);
    TEST_ASSERT_EQUAL(CDS_CORRUPT, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_BOTH, identity.state);
}

void test_a_locked_servo_refuses_and_says_why(void)
{
    begin(NEW_BAUD);
    servos.servo[0].table[0x2F] = 1;
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, identity.error);
    TEST_ASSERT_EQUAL(CDS_IDENTITY_UNCHANGED, identity.state);
    assert_the_truth();
}

void test_a_servo_that_answers_pings_only_is_changed_too(void)
{
    for (uint8_t what = 0; what < RESET_IN_PLACE; what++) {
        begin(what);
        servos.servo[0].table[0x10] = 0;
        TEST_ASSERT_EQUAL(CDS_OK, run());
        assert_the_truth();
    }
}

void test_reset_of_every_servo_needs_its_own_call(void)
{
    begin(RESET_IT);
    cds_identity_abort(&identity);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
    config.id = CDS_BROADCAST_ID;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, begin_change(CDS_IDENTITY_RESET));
    TEST_ASSERT_EQUAL(CDS_OK, begin_change(CDS_IDENTITY_RESET_ALL));
    TEST_ASSERT_EQUAL(CDS_CORRUPT, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_CHANGED, identity.state);
    TEST_ASSERT_EQUAL_UINT8(1, servos.servo[0].table[0x03]);
    TEST_ASSERT_EQUAL_UINT8(1, servos.servo[1].table[0x03]);
    TEST_ASSERT_EQUAL_UINT8(1, bus.baud_reg);
}

static void run_until_written(void)
{
    while (!servos.writes) {
        cds_identity_poll(&identity);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
}

void test_new_place_of_two_servos_is_taken(void)
{
    begin(NEW_ID);
    servo_fake_put(1, 9, 7);
    servo_fake_put(2, 9, 7);
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_TAKEN, identity.state);
    TEST_ASSERT_EQUAL_UINT8(CDS_CORRUPT, identity.at_to);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, identity.at_from);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
}

void test_damage_at_the_new_place_after_the_write_is_lost(void)
{
    begin(NEW_ID);
    run_until_written();
    servo_fake_put(2, 9, 7); // where the servo is now
    TEST_ASSERT_EQUAL(CDS_CORRUPT, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_LOST, identity.state);
    TEST_ASSERT_EQUAL_UINT8(CDS_CORRUPT, identity.at_to);
    TEST_ASSERT_EQUAL_UINT8(CDS_TIMEOUT, identity.at_from);
}

void test_damage_at_the_old_place_after_the_write_is_lost(void)
{
    begin(NEW_ID);
    servos.plan[0] = (struct servos_plan){5, LOSE_PACKET, 0};
    run_until_written();
    servo_fake_put(2, 5, 7); // where the servo still is
    TEST_ASSERT_EQUAL(CDS_CORRUPT, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_LOST, identity.state);
    TEST_ASSERT_EQUAL_UINT8(CDS_TIMEOUT, identity.at_to);
    TEST_ASSERT_EQUAL_UINT8(CDS_CORRUPT, identity.at_from);
}

void test_silence_at_both_places_after_the_write_is_a_timeout(void)
{
    begin(NEW_ID);
    run_until_written();
    servos.dark = SERVOS_FOREVER;
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_LOST, identity.state);
    TEST_ASSERT_TRUE(identity.is_written);
}

void test_damage_after_a_reset_in_place_is_lost(void)
{
    begin(RESET_IN_PLACE);
    run_until_written();
    servo_fake_put(2, 1, 1);
    TEST_ASSERT_EQUAL(CDS_CORRUPT, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_LOST, identity.state);
    TEST_ASSERT_EQUAL_UINT8(CDS_CORRUPT, identity.at_to);
}

void test_reset_of_every_servo_that_none_answers_is_lost(void)
{
    begin(NEW_ID);
    cds_identity_abort(&identity);
    run();
    servos.dark = SERVOS_FOREVER;
    servos.servo[1].there = false;
    TEST_ASSERT_EQUAL(CDS_OK, begin_change(CDS_IDENTITY_RESET_ALL));
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_LOST, identity.state);
    TEST_ASSERT_TRUE(identity.is_written);
}

void test_reply_that_refuses_a_ping_is_presence(void)
{
    begin(NEW_ID);
    servos.servo[0].error = CDS_ERROR_CHECKSUM;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_CHANGED, identity.state);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, identity.at_to);
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_CHECKSUM, identity.error);
    TEST_ASSERT_EQUAL_UINT16(3 + 1 + 1 + 1 + 3, servos.packets); // one reply ends a look
    begin(NEW_ID);
    servo_fake_put(2, 9, 7);
    servos.servo[2].error = CDS_ERROR_CHECKSUM;
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_TAKEN, identity.state);
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, identity.at_to);
}

void test_line_in_use_before_the_write_ends_it_unwritten(void)
{
    begin(NEW_ID);
    port_fake.low = true;
    while (bus.stats.line_busy < 1) {
        cds_identity_poll(&identity);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    port_fake.low = false;
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_UNDECIDED, identity.state);
    TEST_ASSERT_EQUAL_UINT16(0, servos.packets);
}

void test_write_that_finds_no_quiet_line_was_not_sent(void)
{
    begin(NEW_ID);
    while (servos.packets < 4 || bus.request) {
        cds_identity_poll(&identity);
        if (servos.packets == 4 && !port_fake_is_in_flight(&bus))
            break;
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    port_fake.low = true;
    while (bus.stats.line_busy < 1) {
        cds_identity_poll(&identity);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    port_fake.low = false;
    TEST_ASSERT_EQUAL(CDS_LINE_BUSY, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_UNCHANGED, identity.state);
    TEST_ASSERT_FALSE(identity.is_written);
}

/* A stale reply does harm behind the write, and if both places are one. */
static void assert_ignores_stale(uint8_t what, const char *expected)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin(what));
    for (; *expected; expected++) {
        uint16_t heard = servos.packets;

        while (servos.packets == heard) {
            TEST_ASSERT_EQUAL(CDS_PENDING, cds_identity_poll(&identity));
            if (port_fake_is_in_flight(&bus))
                TEST_ASSERT_EQUAL(*expected == 'i', request.ignores_stale);
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        while (bus.request) {
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
    }
    TEST_ASSERT_EQUAL(CDS_OK, run());
}

void test_stale_replies_are_awaited_behind_the_write(void)
{
    assert_ignores_stale(NEW_ID, "iii"
                                 "i"
                                 "w"
                                 "w"
                                 "wii"); // i: ignored, w: awaited
    assert_ignores_stale(RESET_IN_PLACE, "w"
                                         "w"
                                         "w");
}

/* ---- whose the bus is ---- */

static void run_until(uint8_t packets, bool in_flight)
{
    while (servos.packets < packets || port_fake_is_in_flight(&bus) != in_flight) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_identity_poll(&identity));
        if (servos.packets == packets && port_fake_is_in_flight(&bus) == in_flight)
            break;
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
}

void test_a_bus_that_is_opened_anew_is_its_opener_s(void)
{
    for (uint8_t packets = 1; packets < 8; packets++)
        for (uint8_t i = 0; i < 4; i++) {
            begin(NEW_BAUD);
            run_until(packets, i & 1);
            cds_bus_open(&bus, 0, 34);
            if (i & 2)
                cds_bus_set_return_delay(&bus, 20);
            while (cds_identity_poll(&identity) == CDS_PENDING) {
                servos_turn(&bus);
                cds_bus_poll(&bus);
            }
            TEST_ASSERT_EQUAL(CDS_CANCELLED, identity.steps.result);
            TEST_ASSERT_EQUAL(CDS_IDENTITY_UNDECIDED, identity.state);
            if (packets != 4) // the fifth is the WRITE
                TEST_ASSERT_EQUAL(packets > 4, identity.is_written);
            TEST_ASSERT_EQUAL_UINT8(34, bus.baud_reg);
            TEST_ASSERT_EQUAL_UINT16(i & 2 ? 20 : CDS_RETURN_DELAY_MAX_US, bus.return_delay_us);
        }
}

/* Its request waits for a line that is not quiet. */
static void run_until_it_waits(uint8_t packets)
{
    do {
        servos_turn(&bus);
        cds_bus_poll(&bus);
        if (servos.packets == packets && !bus.request)
            port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1);
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_identity_poll(&identity));
    } while (servos.packets < packets || !bus.request || port_fake_is_in_flight(&bus));
}

void test_one_whose_request_is_cancelled_gives_the_bus_back(void)
{
    for (uint8_t packets = 1; packets < 8; packets++) {
        begin(NEW_BAUD);
        run_until_it_waits(packets);
        TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
        TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
        TEST_ASSERT_EQUAL(CDS_IDENTITY_UNDECIDED, identity.state);
        TEST_ASSERT_EQUAL_UINT8(identity.from.baud_reg, bus.baud_reg);
    }
}

void test_abort_at_any_poll_frees_the_bus_and_tells_what_it_wrote(void)
{
    for (uint16_t polls = 0; polls < 3000; polls++) {
        begin(NEW_BAUD);
        for (uint16_t i = 0; i < polls && cds_identity_poll(&identity) == CDS_PENDING; i++) {
            servos_turn(&bus);
            cds_bus_poll(&bus);
        }
        if (identity.steps.result != CDS_PENDING)
            return;
        cds_identity_abort(&identity);
        TEST_ASSERT_EQUAL(CDS_CANCELLED, run());
        TEST_ASSERT_EQUAL(CDS_IDENTITY_UNDECIDED, identity.state);
        TEST_ASSERT_EQUAL_UINT8(identity.from.baud_reg, bus.baud_reg);
    }
    TEST_FAIL_MESSAGE("never ended");
}

/* ---- the permit's answer ---- */

static bool at_its_turn; // not when it is submitted

static enum cds_result refusal;

static enum cds_result refuse_writes(struct cds_request *asked)
{
    bool waits = asked->result == CDS_PENDING;

    if (asked->packet.bytes[CDS_AT_INSTRUCTION] != CDS_WRITE)
        return CDS_OK;
    port_fake.low_looks = at_its_turn && !waits; // it must wait for the line
    return at_its_turn == waits ? refusal : CDS_OK;
}

void test_change_write_refused_ends_with_nothing_written(void)
{
    for (uint8_t i = 0; i < 2 * (CDS_RESERVED - CDS_LINE_BUSY); i++) {
        begin(NEW_ID);
        at_its_turn = i % 2;
        refusal = (enum cds_result)(CDS_NO_REPLY_DUE + i / 2);
        permit_fake_attach(&bus, refuse_writes);
        TEST_ASSERT_EQUAL(refusal, run());
        TEST_ASSERT_EQUAL(CDS_IDENTITY_UNCHANGED, identity.state);
        TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
        TEST_ASSERT_FALSE(identity.is_written);
    }
}

static enum cds_result refuse_all(struct cds_request *asked)
{
    (void)asked;
    return CDS_INHIBITED;
}

void test_refused_ping_or_reset_of_all_leaves_it_undecided(void)
{
    begin(NEW_ID);
    permit_fake_attach(&bus, refuse_all);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_UNDECIDED, identity.state);
    TEST_ASSERT_EQUAL(CDS_OK, begin_change(CDS_IDENTITY_RESET_ALL));
    TEST_ASSERT_EQUAL(CDS_INHIBITED, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_UNDECIDED, identity.state);
    TEST_ASSERT_EQUAL_UINT8(7, bus.baud_reg);
}

void test_request_that_passes_the_lock_delays_the_rate(void)
{
    static uint8_t other_buffer[8];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(other_buffer);

    begin(NEW_BAUD);
    cds_packet_ping(&other.packet, 77);
    other.passes_lock = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
    while (other.result == CDS_PENDING) {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_identity_poll(&identity));
        TEST_ASSERT_EQUAL_UINT8(7, port_fake.bauds[0]);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, other.result);
    servos.packets = 0;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL(CDS_IDENTITY_CHANGED, identity.state);
}

static void assert_refused(enum cds_result result, uint8_t change, uint8_t id, uint8_t new_value)
{
    config.id = id;
    config.new_id = config.new_baud_reg = new_value;
    TEST_ASSERT_EQUAL(result, begin_change(change));
    TEST_ASSERT_NULL(bus.lock);
}

void test_nonsense_is_refused(void)
{
    struct cds_bus closed = {.port = 0};

    begin(NEW_ID);
    TEST_ASSERT_EQUAL(CDS_BUSY, begin_change(CDS_IDENTITY_ID)); // it is under way
    cds_identity_abort(&identity);
    run();
    assert_refused(CDS_BAD_ARGUMENT, CDS_IDENTITY_ID, 5, 254);
    assert_refused(CDS_BAD_ARGUMENT, CDS_IDENTITY_ID, 254, 5);
    assert_refused(CDS_BAD_ARGUMENT, CDS_IDENTITY_BAUD, 5, 255);
    assert_refused(CDS_BAD_ARGUMENT, CDS_IDENTITY_BAUD, 254, 1);
    assert_refused(CDS_BAD_ARGUMENT, CDS_IDENTITY_RESET_ALL + 1, 5, 9);
    config.bus = &closed;
    assert_refused(CDS_BAD_ARGUMENT, CDS_IDENTITY_ID, 5, 9);
    config.bus = &bus;
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_identity_look_again(&identity));
    request.packet.capacity--;
    assert_refused(CDS_NO_ROOM, CDS_IDENTITY_RESET, 5, 9);
    request.result = CDS_PENDING;
    assert_refused(CDS_BUSY, CDS_IDENTITY_RESET, 5, 9);
}

void test_change_to_same_place_only_looks_for_servo(void)
{
    for (uint8_t change = CDS_IDENTITY_ID; change <= CDS_IDENTITY_BAUD; change++) {
        begin(NEW_ID);
        cds_identity_abort(&identity);
        run();
        config.new_id = 5;
        config.new_baud_reg = 7;
        TEST_ASSERT_EQUAL(CDS_OK, begin_change(change));
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL(CDS_IDENTITY_CHANGED, identity.state);
        TEST_ASSERT_FALSE(identity.is_written);
        assert_the_truth();
        servos.servo[0].there = false;
        TEST_ASSERT_EQUAL(CDS_OK, begin_change(change));
        TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
        TEST_ASSERT_EQUAL(CDS_IDENTITY_LOST, identity.state);
        TEST_ASSERT_FALSE(identity.is_written);
    }
}
