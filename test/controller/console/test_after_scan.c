/* SPDX-License-Identifier: MIT */
/* The end of a scan: the diagnosis of a servo whose reply was damaged. */
#include "console_rig.h"

void setUp(void)
{
    begin_console();
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* The next packet leaves. If it is for servo `id`, a damaged reply comes, else none. */
static void go_on(uint8_t id)
{
    static const uint8_t damaged[] = {0xFF, 0xFF, 2, 2, 0, 0};

    if (bus.link.state == CDS_LINK_TALKING) {
        port_fake_transmit(&bus.link, 0);
        if (port_fake.sent[2] == id)
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
