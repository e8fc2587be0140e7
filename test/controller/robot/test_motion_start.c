/* SPDX-License-Identifier: MIT */
/* The start of a motion, with servos that answer each READ: when it ends, and what it reads after
 * that. */
#include <string.h>

#include "cds55xx/control_table.h"
#include "eeprom_fake.h"
#include "port_fake.h"
#include "robot/moves.h"
#include "robot/settings.h"
#include "unity.h"

#define SERVOS   3
#define POSITION 512 // of each servo when a test begins
#define GOAL     600
#define STEP_US  50
#define TURNS    20000u // 1 s: a test that waits longer fails

static struct cds_bus bus;
static struct robot robot;
static struct settings settings;
static struct settings_store settings_store;
static uint8_t eeprom[1400]; // up to the second place of a sequence
static struct motion_store store;
static struct moves moves;
static const uint8_t ids[SERVOS] = {1, 2, 3};
static uint16_t goals[SERVOS]; // of the last SYNC WRITE; POSITION before it

static void save(const struct motion_store_record *record)
{
    TEST_ASSERT_EQUAL(MOTION_STORE_SAVING, motion_store_save(&store, record));
    while (motion_store_poll(&store)) {
    }
    TEST_ASSERT_EQUAL(MOTION_STORE_SAVED, store.result);
}

/* Sequence "a" goes from where the servos are to GOAL, in 0.3 s. */
static void save_sequence(void)
{
    struct motion_store_step step = {.time_10ms = 30};
    uint16_t positions[MOTION_STORE_JOINTS];

    memset(positions, UINT8_MAX, sizeof positions); // CDS_POSE_NONE
    for (uint8_t i = 0; i < SERVOS; i++)
        positions[i] = GOAL;
    save(&(struct motion_store_record){
        .kind = MOTION_STORE_JOINT_LIST, .count = SERVOS, .ids = ids});
    save(&(struct motion_store_record){
        .kind = MOTION_STORE_POSE, .name = "p", .length = 1, .positions = positions});
    step.pose = motion_store_number(&store, MOTION_STORE_POSE,
                                    motion_store_find(&store, MOTION_STORE_POSE, "p", 1));
    save(&(struct motion_store_record){
        .kind = MOTION_STORE_SEQUENCE, .name = "a", .length = 1, .count = 1, .steps = &step});
}

void setUp(void)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    memset(&robot, 0, sizeof robot);
    memset(&moves, 0, sizeof moves);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    robot_begin(&robot, &bus, 0);
    settings_default(&settings);
    eeprom_fake_reset_to(eeprom, sizeof eeprom);
    eeprom_fake.has_more = true;
    motion_store_load(&store, &settings_store);
    robot.moves = &moves;
    moves_open(&robot, &store, &settings);
    for (uint8_t i = 0; i < SERVOS; i++)
        goals[i] = POSITION;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

/* A servo in position mode, with torque, that is at its goal. */
static void answer_read(uint8_t id, uint8_t address, uint8_t length)
{
    uint8_t registers[] = {
        [CDS_REG_CCW_ANGLE_LIMIT] = 0xFF,
        [CDS_REG_CCW_ANGLE_LIMIT + 1] = 0x03,
        [CDS_REG_STATUS_RETURN_LEVEL] = 2,
        [CDS_REG_TORQUE_ENABLE] = 1,
        [CDS_REG_PRESENT_POSITION] = (uint8_t)goals[id - 1],
        [CDS_REG_PRESENT_POSITION + 1] = (uint8_t)(goals[id - 1] >> 8),
        [CDS_REG_LOCK] = 0,
    };

    TEST_ASSERT_TRUE(address + length <= (int)sizeof registers);
    port_fake_answer(&bus.link, id, 0, registers + address, length);
}

static void take_packet(void)
{
    const uint8_t *packet = port_fake.sent;

    if (packet[CDS_AT_INSTRUCTION] == CDS_READ)
        answer_read(packet[CDS_AT_ID], packet[5], packet[6]);
    for (uint8_t i = 0; packet[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE && i < SERVOS; i++)
        goals[i] = (uint16_t)(packet[8 + 5 * i] | packet[9 + 5 * i] << 8);
}

/* One turn of the main loop. */
static void turn(void)
{
    port_fake.now_us += STEP_US;
    if (bus.link.state == CDS_LINK_TALKING && port_fake_transmit(&bus.link, 0))
        take_packet();
    cds_bus_poll(&bus);
    robot_poll(&robot);
}

static void turn_while_starting(void)
{
    for (uint16_t left = TURNS; motion_is_starting(&robot); left--) {
        TEST_ASSERT_TRUE(left);
        turn();
    }
}

static void turn_while_in_motion(void)
{
    for (uint16_t left = TURNS; robot_is_in_motion(&robot); left--) {
        TEST_ASSERT_TRUE(left);
        turn();
    }
}

static void start_sequence(void)
{
    save_sequence();
    TEST_ASSERT_EQUAL_UINT8(
        0,
        motion_start_sequence(&robot, motion_store_find(&store, MOTION_STORE_SEQUENCE, "a", 1), 1));
}

static void start_move(const uint16_t *pose)
{
    TEST_ASSERT_EQUAL_UINT8(0, robot_choose_group(&robot, ids, SERVOS));
    TEST_ASSERT_EQUAL_UINT8(
        0, motion_start_move(&robot, &(struct cds_move){.pose = pose, .time_ms = 300}));
}

void test_pose_is_free_when_start_has_ended(void)
{
    uint16_t pose[SERVOS] = {GOAL, GOAL, GOAL};

    start_move(pose);
    turn_while_starting();
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, moves.start.outcome.result);
    memset(pose, 0, sizeof pose); // the next line of the console
    turn_while_in_motion();
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, motion_outcome(&robot)->result);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL_UINT16(GOAL, goals[i]);
}

/* The motion is ended when it has taken the move, and its joints begin one after the other. */
void test_pose_is_free_when_start_is_ended(void)
{
    uint16_t pose[SERVOS] = {GOAL, GOAL, GOAL};

    start_move(pose);
    for (uint16_t left = TURNS; moves.motion.begun != 1; left--) {
        TEST_ASSERT_TRUE(left);
        turn();
    }
    motion_end(&robot);
    memset(pose, 0, sizeof pose);
    turn_while_in_motion();
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_TRUE(goals[i] >= POSITION && goals[i] < GOAL);
}

/* A servo may no longer be driven, when all steps are checked and none has begun. */
void test_start_of_sequence_ends_with_its_first_move(void)
{
    start_sequence();
    for (uint16_t left = TURNS;
         moves.player.sequence.result != CDS_PENDING || moves.player.sequence.is_checking; left--) {
        TEST_ASSERT_TRUE(left);
        turn();
    }
    cds_servos_find(&robot.servos, 2)->inhibits = true;
    turn_while_starting();
    TEST_ASSERT_EQUAL_UINT8(CDS_INHIBITED, moves.start.outcome.result);
    TEST_ASSERT_EQUAL_UINT8(2, moves.start.outcome.id);
    turn_while_in_motion();
    TEST_ASSERT_EQUAL_UINT8(CDS_INHIBITED, motion_outcome(&robot)->result);
    for (uint8_t i = 0; i < 100; i++)
        turn();
    TEST_ASSERT_NULL(robot.cycle);
    TEST_ASSERT_EQUAL_UINT8(0, robot.group_count); // it was chosen for this sequence
}

void test_start_of_sequence_is_ok_when_its_first_move_has_begun(void)
{
    start_sequence();
    turn_while_starting();
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, moves.start.outcome.result);
    TEST_ASSERT_EQUAL(CDS_PENDING, moves.motion.result);
    turn_while_in_motion();
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, motion_outcome(&robot)->result);
    TEST_ASSERT_EQUAL_UINT16(GOAL, goals[SERVOS - 1]);
    TEST_ASSERT_EQUAL_UINT8(SERVOS, robot.group_count);
}
