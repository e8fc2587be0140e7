/* Settings that are written only if they differ, and read back. */
#include "cds55xx/setup.h"

#include "servos_fake.h"
#include "unity.h"

static struct cds_bus bus;
static uint8_t buffer[CDS_PACKET_SIZE(5)];
static struct cds_request request;
static struct cds_setup setup;
static const uint8_t limits[4] = {0x10, 0x00, 0xF0, 0x03};

void setUp(void)
{
    port_fake_reset();
    memset(&servos, 0, sizeof servos);
    memset(&bus, 0, sizeof bus);
    request = (struct cds_request)CDS_REQUEST(buffer);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    servo_fake_put(0, 5, 1);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static enum cds_result run(void)
{
    enum cds_result result;

    while ((result = cds_setup_poll(&setup)) == CDS_PENDING) {
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    return result;
}

static enum cds_result begin_limits(void)
{
    return cds_setup_write_begin(&setup, &bus, &request, 5, CDS_REG_CW_ANGLE_LIMIT, limits, 4);
}

static bool holds_limits(void)
{
    return memcmp(&servos.servo[0].table[6], limits, 4) == 0;
}

void test_what_differs_is_written_once_and_read_back_and_then_never_again(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, begin_limits());
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_TRUE(setup.written);
    TEST_ASSERT_EQUAL_UINT16(3, servos.packets);
    TEST_ASSERT_EQUAL_UINT16(1, servos.writes);
    TEST_ASSERT_TRUE(holds_limits());
    TEST_ASSERT_EQUAL(CDS_OK, begin_limits());
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_FALSE(setup.written);
    TEST_ASSERT_EQUAL_UINT16(4, servos.packets);
}

void test_any_byte_that_differs_is_a_difference(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        memcpy(&servos.servo[0].table[6], limits, 4);
        servos.servo[0].table[6 + i] ^= 1;
        begin_limits();
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_TRUE(setup.written);
        TEST_ASSERT_TRUE(holds_limits());
    }
}

void test_ok_means_that_it_holds_whatever_was_lost(void)
{
    for (uint8_t fault = 1; fault < FAULTS; fault++)
        for (uint8_t at = 1; at <= 3; at++) {
            setUp();
            servos.plan[0] = (struct servos_plan){at, fault, 0};
            begin_limits();
            if (run() == CDS_OK)
                TEST_ASSERT_TRUE(holds_limits());
            else
                TEST_ASSERT_TRUE(at != 2 || !holds_limits()); // a lost answer alone is made good
            begin_limits();
            TEST_ASSERT_EQUAL(CDS_OK, run());
            TEST_ASSERT_TRUE(holds_limits());
        }
}

void test_an_absent_servo_is_not_written_to(void)
{
    servos.dark = SERVOS_FOREVER;
    begin_limits();
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, run());
    TEST_ASSERT_EQUAL_UINT16(1, servos.packets);
    TEST_ASSERT_FALSE(setup.written);
}

void test_a_locked_servo_refuses_and_says_why(void)
{
    servos.servo[0].table[0x2F] = 1;
    begin_limits();
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, setup.error);
    TEST_ASSERT_EQUAL_UINT16(3, servos.packets);
}

void test_a_refusal_stands_if_it_cannot_be_read_back(void)
{
    servos.servo[0].table[0x2F] = 1;
    servos.plan[0] = (struct servos_plan){3, LOSE_REPLY, 0};
    begin_limits();
    TEST_ASSERT_EQUAL(CDS_REFUSED, run());
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_RANGE, setup.error);
}

/* A WRITE that was carried out, and of which only the refusal of its repeat is heard. */
void test_one_that_refuses_and_holds_the_value_has_it(void)
{
    begin_limits();
    while (!servos.packets || bus.request) {
        cds_setup_poll(&setup);
        servos_turn(&bus);
        cds_bus_poll(&bus);
    }
    memcpy(&servos.servo[0].table[6], limits, 4);
    servos.servo[0].table[0x2F] = 1;
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_HEX8(0, setup.error);
    TEST_ASSERT_TRUE(setup.written);
}

void test_a_lock_whose_answer_is_lost_is_not_sent_twice(void)
{
    cds_bus_set_repeats(&bus, 2);
    servos.plan[0] = (struct servos_plan){2, LOSE_REPLY, 0};
    TEST_ASSERT_EQUAL(CDS_OK, cds_setup_lock_begin(&setup, &bus, &request, 5));
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT16(1, servos.writes);
}

void test_return_delay_is_rounded_up_and_never_longer_than_the_bus_waits(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, cds_setup_return_delay_begin(&setup, &bus, &request, 5, 3));
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(2, servos.servo[0].table[5]);
    TEST_ASSERT_EQUAL(CDS_OK, cds_setup_return_delay_begin(&setup, &bus, &request, 5, 508));
    TEST_ASSERT_EQUAL(CDS_OK, run());
    TEST_ASSERT_EQUAL_UINT8(254, servos.servo[0].table[5]);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT,
                      cds_setup_return_delay_begin(&setup, &bus, &request, 5, 509));
    cds_bus_set_return_delay(&bus, 10);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT,
                      cds_setup_return_delay_begin(&setup, &bus, &request, 5, 11));
}

void test_lock_is_verified_and_may_be_set_already(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL(CDS_OK, cds_setup_lock_begin(&setup, &bus, &request, 5));
        TEST_ASSERT_EQUAL(CDS_OK, run());
        TEST_ASSERT_EQUAL_UINT8(1, servos.servo[0].table[0x2F]);
        TEST_ASSERT_EQUAL_UINT8(!i, setup.written);
    }
}

static bool at_its_turn; // not when it is submitted

static enum cds_result refuse_writes(struct cds_bus_observer *observer, struct cds_request *asked)
{
    bool waits = asked->result == CDS_PENDING;

    (void)observer;
    if (asked->packet.bytes[CDS_AT_INSTRUCTION] != CDS_WRITE)
        return CDS_OK;
    port_fake.low = at_its_turn && !waits; // it must wait for the line
    return at_its_turn == waits ? CDS_LIMIT : CDS_OK;
}

static void ignore(struct cds_bus_observer *observer, const struct cds_bus_news *news)
{
    (void)observer;
    (void)news;
}

void test_what_is_not_admitted_was_not_written(void)
{
    struct cds_bus_observer observer = {.admit = refuse_writes, .on_news = ignore};

    for (uint8_t i = 0; i < 2; i++) {
        setUp();
        at_its_turn = i;
        bus.observer = &observer;
        TEST_ASSERT_EQUAL(CDS_OK, begin_limits());
        TEST_ASSERT_EQUAL(CDS_LIMIT, run());
        TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
        TEST_ASSERT_FALSE(setup.written);
    }
}

void test_nonsense_and_the_identity_are_refused(void)
{
    static const uint8_t data[50];

    for (uint8_t from = 0; from < 50; from++)
        for (uint8_t length = 0; length <= 4; length++) {
            bool fine = length && from + length <= 50 && (from > 4 || from + length <= 3);

            TEST_ASSERT_EQUAL(fine ? CDS_OK : CDS_BAD_ARGUMENT,
                              cds_setup_write_begin(&setup, &bus, &request, 5, from, data, length));
        }
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT,
                      cds_setup_write_begin(&setup, &bus, &request, 254, 6, data, 1));
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, cds_setup_write_begin(&setup, &bus, &request, 5, 6, data, 5));
    request.result = CDS_PENDING;
    TEST_ASSERT_EQUAL(CDS_BUSY, begin_limits());
}
