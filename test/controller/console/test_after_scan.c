/* SPDX-License-Identifier: MIT */
/* The end of a scan: the diagnosis of a servo whose reply was damaged. */
#include "console_rig.h"

static uint8_t rate_of_servo = CDS_BAUD_1M;

void setUp(void)
{
    begin_console();
    rate_of_servo = CDS_BAUD_1M;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* The next packet leaves. If it is for servo `id` at its rate, a damaged reply comes, else none. */
static void go_on(uint8_t id)
{
    static const uint8_t damaged[] = {0xFF, 0xFF, 2, 2, 0, 0};

    if (bus.link.state == CDS_LINK_TALKING) {
        port_fake_transmit(&bus.link, 0);
        if (port_fake.sent[2] == id && bus.baud_reg == rate_of_servo)
            port_fake_hear(&bus.link, damaged, sizeof damaged);
    }
    port_fake.now_us += 50000;
    turn();
}

void test_key_during_diagnosis_after_scan_ends_it(void)
{
    reply_to("scan");
    for (uint16_t i = 0; i < 3000 && strstr(said, "1 found") == NULL; i++)
        go_on(2);
    TEST_ASSERT_NOT_NULL(strstr(said, "id 2: reply damaged"));
    for (uint8_t i = 0; i < 50 && robot.operation == NULL; i++)
        turn();
    TEST_ASSERT_NOT_NULL(robot.operation);
    type("x");
    for (uint8_t i = 0; i < 100; i++)
        go_on(2);
    TEST_ASSERT_NULL(strstr(said, "finding"));
    TEST_ASSERT_NOT_NULL(strstr(said, "1 found, 254 asked\r\nerror 49: "));
}

/* Types the line, and goes on until its `ok`. */
static void scan_with_servo_2_at(uint8_t rate, const char *line)
{
    rate_of_servo = rate;
    reply_to(line);
    for (uint16_t i = 0; i < 30000 && strstr(said, "\r\nok\r\n") == NULL; i++)
        go_on(2);
    TEST_ASSERT_NOT_NULL(strstr(said, "1 found, 1524 asked\r\n"));
}

void test_scan_all_diagnoses_servo_at_bus_rate(void)
{
    scan_with_servo_2_at(CDS_BAUD_1M, "scan all");
    TEST_ASSERT_NOT_NULL(strstr(said, "asked\r\nservo 2: finding "));
}

void test_scan_all_leaves_out_servo_at_other_rate(void)
{
    scan_with_servo_2_at(3, "scan all");
    TEST_ASSERT_NOT_NULL(strstr(said, "asked\r\nok\r\n"));
}

static void find(uint8_t index, uint8_t id, uint8_t baud_reg)
{
    robot.work.scan.found[index] = (struct cds_scan_found){
        .id = id, .baud_reg = baud_reg, .result = CDS_OK, .details = CDS_PENDING};
}

/* A scan that has found `count` servos ends. Returns the rate of servo 2 afterwards. */
static uint8_t rate_after_scan(uint16_t count)
{
    robot.work.scan.scan.count = count;
    robot.states[0].baud_reg = CDS_BAUD_1M;
    console.error = 0;
    scan_sum_up(&console);
    type("");
    return robot.states[0].baud_reg;
}

void test_scan_notes_rate_of_servo_found_only_at_another(void)
{
    robot_add(&robot, 2);
    robot.baud_reg = CDS_BAUD_1M;
    find(0, 2, 3);
    find(1, 2, CDS_BAUD_1M);
    find(2, 2, 3);
    TEST_ASSERT_EQUAL_UINT8(3, rate_after_scan(1));
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, rate_after_scan(2));
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, rate_after_scan(3));
}

void test_scan_with_full_list_notes_no_rate(void)
{
    robot_add(&robot, 2);
    robot.baud_reg = CDS_BAUD_1M;
    for (uint8_t i = 0; i < ROBOT_SERVOS; i++)
        find(i, (uint8_t)(2 + i), 3);
    TEST_ASSERT_EQUAL_UINT8(3, rate_after_scan(ROBOT_SERVOS));
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, rate_after_scan(ROBOT_SERVOS + 1));
}
