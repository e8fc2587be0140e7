/* SPDX-License-Identifier: MIT */
/* Commands that need the robot for themselves, beside an operation, a motion or a stop. */
#include "console_rig.h"
#include "robot/moves.h"

static enum cds_result outcome; // of the operation

static enum cds_result begin(struct robot *of, const void *config)
{
    (void)of;
    (void)config;
    return CDS_OK;
}

static enum cds_result poll(struct robot *of)
{
    (void)of;
    return outcome;
}

static const CDS_FLASH struct robot_operation operation = {.begin = begin, .poll = poll};

void setUp(void)
{
    outcome = CDS_PENDING;
    begin_console();
    robot.group[0] = 1;
    robot.group_count = 1;
    memset(&robot.work, 0xA5, sizeof robot.work);
    TEST_ASSERT_EQUAL_UINT8(0, robot_start(&robot, &operation, NULL));
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* Every command that needs the group or robot->work for itself ends with this error. */
static void assert_refused(const char *error)
{
    static const char *const lines[] = {
        "pose 90", "group 2",       "teach off",           "teach on",
        "scan",    "servos forget", "settings bus_baud 16"};

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(error, reply_to(lines[i]), strlen(error), lines[i]);
        for (uint16_t at = 0; at < sizeof robot.work; at++)
            TEST_ASSERT_EQUAL_HEX8(0xA5, ((const uint8_t *)&robot.work)[at]);
    }
    TEST_ASSERT_EQUAL_UINT8(1, robot.group_count);
    TEST_ASSERT_EQUAL_UINT8(1, robot.group[0]);
}

void test_cycle_shows_servo_that_was_not_read_yet(void)
{
    uint8_t packet[] = {0xFF, 0xFF, CDS_BROADCAST_ID, 8, CDS_SYNC_WRITE, 0x1E, 4, 1};

    memset(&robot.work, 0, sizeof robot.work);
    robot.work.cycle.cycle.count = 1;
    robot.work.cycle.cycle.ids = robot.group;
    robot.work.cycle.cycle.front = packet;
    robot.cycle = &robot.work.cycle.cycle;
    reply_to("cycle");
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nservo 1: not read yet\r\nok\r\n"));
    robot.cycle = NULL;
}

void test_commands_beside_an_operation_are_refused(void)
{
    assert_refused("error 43: ");
}

void test_defaults_beside_an_operation_keep_the_rate(void)
{
    settings.bus_baud = 16;
    assert_error(ERROR_CYCLE, "defaults");
    TEST_ASSERT_EQUAL_UINT8(16, settings.bus_baud);
    settings.bus_baud = 1;
    TEST_ASSERT_EQUAL_STRING_LEN("ok\r\n", reply_to("defaults"), 4);
}

void test_commands_beside_a_motion_are_refused(void)
{
    cds_servos_reserve(&robot.servos, NULL, robot.group, 1);
    assert_refused("error 58: ");
}

void test_commands_beside_a_stop_are_refused(void)
{
    robot_stop(&robot); // it waits for the end of the operation
    assert_refused("error 54: ");
}

/* Its last period is on its way: nothing takes a goal. */
void test_pose_waits_for_the_cycle_of_a_motion_to_end(void)
{
    memset(&robot.work, 0, sizeof robot.work);
    robot.cycle = &robot.work.cycle.cycle;
    robot.moves->ends_cycle = true;
    TEST_ASSERT_TRUE(motion_cycle_is_ending(&robot));
    TEST_ASSERT_EQUAL_STRING("", reply_to("pose 90"));
    outcome = CDS_OK;
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to(""));
    assert_sent("FF FF FE 09 83 1E 04 01 33 01 4A 01 D3");
}
