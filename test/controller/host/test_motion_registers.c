/* SPDX-License-Identifier: MIT */
/* The registers of motions: what a WRITE starts and ends, what is refused, what a READ tells. No
 * servo answers here: whole motions are in test/runs/test_motion_registers.py. */
#include "bridge_rig.h"

#include "console/errors.h"
#include "host/motion_registers.h"
#include "robot/moves.h"

/* Up to the third place of a sequence. The bytes behind them are erased. */
static uint8_t eeprom[1400];
static struct motion_store motions;
static struct moves moves;

static void save(const struct motion_store_record *record)
{
    TEST_ASSERT_EQUAL(MOTION_STORE_SAVING, motion_store_save(&motions, record));
    while (motion_store_poll(&motions)) {
    }
    TEST_ASSERT_EQUAL(MOTION_STORE_SAVED, motions.result);
}

static void save_sequence(const char *name)
{
    static const struct motion_store_step step = {.time_10ms = 100};

    save(&(struct motion_store_record){
        .kind = MOTION_STORE_SEQUENCE, .name = name, .length = 1, .count = 1, .steps = &step});
}

void setUp(void)
{
    open_all();
    eeprom_fake_reset_to(eeprom, sizeof eeprom);
    eeprom_fake.has_more = true;
    motion_store_load(&motions, &store);
    memset(&moves, 0, sizeof moves);
    robot.moves = &moves;
    moves_open(&robot, &motions, &settings);
    device.ops = &motion_registers_ops;
    TEST_ASSERT_EQUAL_UINT8(0, robot_choose_group(&robot, (const uint8_t[]){1, 2}, 2));
    save_sequence("a");
    save_sequence("b");
}

void tearDown(void)
{
}

/* The bytes of MOTION_PLAY to MOTION_ERROR. */
static void assert_registers(const char *six)
{
    SAY(DEVICE_IS, CDS_READ, 0x70, 6);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)six, 6);
}

static void write(uint8_t address, uint8_t value)
{
    SAY(DEVICE_IS, CDS_WRITE, address, value);
    assert_heard(DEVICE_IS, 0, NULL, 0);
}

static void assert_refused(uint8_t address, uint8_t value)
{
    SAY(DEVICE_IS, CDS_WRITE, address, value);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
}

/* A sequence plays, in its second step. */
static void pretend_to_play(void)
{
    write(0x70, 2);
    moves.start.outcome.result = CDS_OK;
    moves.player.sequence.config.motion = &moves.motion;
    moves.player.place = moves.start.place;
    moves.player.sequence.result = CDS_PENDING;
    moves.player.sequence.step = 1;
}

void test_registers_read_none_without_motion(void)
{
    assert_registers("\0\x64\0\0\0\0");
}

void test_play_starts_sequence_of_that_line(void)
{
    write(0x70, 2);
    TEST_ASSERT_NOT_NULL(robot.cycle);
    TEST_ASSERT_EQUAL_UINT16(1, moves.start.repeats);
    TEST_ASSERT_EQUAL_UINT8(motion_store_find(&motions, MOTION_STORE_SEQUENCE, "b", 1),
                            moves.start.place);
    assert_registers("\2\x64\0\1\0\0");
}

void test_play_of_unknown_number_is_refused(void)
{
    assert_refused(0x70, 3);
    assert_refused(0x70, 255);
    TEST_ASSERT_NULL(robot.cycle);
    assert_registers("\0\x64\0\0\0\0");
}

void test_play_counts_lines_and_not_places(void)
{
    motion_store_delete(&motions, &(struct motion_store_record){
                                      .kind = MOTION_STORE_SEQUENCE, .name = "a", .length = 1});
    while (motion_store_poll(&motions)) {
    }
    assert_refused(0x70, 2);
    write(0x70, 1);
    assert_registers("\1\x64\0\1\0\0");
}

void test_play_in_motion_is_refused(void)
{
    pretend_to_play();
    assert_refused(0x70, 1);
    moves.player.sequence.result = CDS_OK; // a timed move of the console
    assert_refused(0x70, 1);
    assert_registers("\0\x64\0\2\0\0");
}

void test_play_while_cycle_ends_is_refused(void)
{
    pretend_to_play();
    moves.player.sequence.result = CDS_OK;
    cds_servos_reserve(&robot.servos, NULL, NULL, 0);
    assert_refused(0x70, 1);
    assert_registers("\0\x64\0\2\0\0");
}

void test_play_while_eeprom_is_written_is_refused(void)
{
    static const uint8_t ids[] = {1, 2};

    motion_store_save(&motions, &(struct motion_store_record){
                                    .kind = MOTION_STORE_JOINT_LIST, .count = 2, .ids = ids});
    assert_refused(0x70, 1);
    TEST_ASSERT_EQUAL_UINT8(ERROR_SAVING, motion_may_start_sequence(&robot, 0));
}

/* Between two bytes the EEPROM is ready, but the save goes on. */
void test_play_while_settings_are_saved_is_refused(void)
{
    TEST_ASSERT_TRUE(settings_save(&store, &settings));
    TEST_ASSERT_TRUE(avr_eeprom_ready());
    assert_refused(0x70, 1);
    TEST_ASSERT_EQUAL_UINT8(ERROR_SAVING, motion_may_start_sequence(&robot, 0));
    store.result = SETTINGS_SAVED;
    write(0x70, 1);
}

/* A step that cannot be read is not the end of the sequence, which would then have no step. */
void test_save_that_begins_while_a_sequence_starts_refuses_it(void)
{
    write(0x70, 1);
    store.result = SETTINGS_SAVING;
    robot_poll(&robot);
    TEST_ASSERT_EQUAL_UINT8(MOTION_SAVING, moves.start.outcome.result);
}

void test_play_while_inhibited_or_stopping_is_refused(void)
{
    robot_inhibit(&robot);
    assert_refused(0x70, 1);
    robot_release(&robot);
    robot.stopping = true;
    assert_refused(0x70, 1);
    robot.stopping = false;
    write(0x70, 1);
}

void test_play_without_servos_tells_error_45(void)
{
    robot.group_count = 0;
    write(0x70, 1);
    assert_registers("\0\x64\0\0\0\x2D");
    TEST_ASSERT_EQUAL(45, ERROR_NO_GROUP);
}

void test_play_0_ends_motion(void)
{
    assert_refused(0x70, 0);
    pretend_to_play();
    write(0x70, 0);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, moves.player.sequence.result);
    write(0x70, 0); // still in motion until the next poll of the cycle
    cds_servos_reserve(&robot.servos, NULL, NULL, 0);
    assert_refused(0x70, 0);
}

void test_play_0_ends_motion_that_starts(void)
{
    write(0x70, 1);
    write(0x70, 0);
    TEST_ASSERT_EQUAL(MOTION_NONE, moves.start.outcome.result);
    cds_servos_reserve(&robot.servos, NULL, NULL, 0);
    moves.ends_cycle = false;
    assert_registers("\0\x64\0\0\0\x4F");
}

void test_pause_is_refused_unless_motion_has_begun(void)
{
    assert_refused(0x72, 1);
    assert_refused(0x72, 0);
    write(0x70, 1);
    assert_refused(0x72, 1);
}

void test_pause_stops_and_resumes_motion(void)
{
    pretend_to_play();
    assert_refused(0x72, 2);
    write(0x72, 1);
    TEST_ASSERT_TRUE(moves.is_paused);
    assert_registers("\2\x64\1\2\2\0");
    write(0x72, 0);
    TEST_ASSERT_FALSE(moves.is_paused);
    assert_registers("\2\x64\0\2\2\0");
}

void test_override_has_range_and_goes_to_motion(void)
{
    assert_refused(0x71, 9);
    assert_refused(0x71, 201);
    write(0x71, 10);
    assert_registers("\0\x0A\0\0\0\0");
    pretend_to_play();
    write(0x71, 200);
    TEST_ASSERT_EQUAL_UINT32(2 * 65536, moves.motion.override);
}

/* The joints of the stored poses are its group. */
void test_refused_start_keeps_the_group_of_a_start(void)
{
    write(0x70, 1);
    moves.group_is_tried = true;
    TEST_ASSERT_EQUAL_UINT8(MOTION_BUSY, motion_start_sequence(&robot, moves.start.place, 1));
    TEST_ASSERT_EQUAL_UINT8(MOTION_BUSY,
                            motion_start_move(&robot, &(struct cds_move){.time_ms = 1}));
    TEST_ASSERT_EQUAL_UINT8(2, robot.group_count);
}

void test_play_and_override_in_one_write(void)
{
    SAY(DEVICE_IS, CDS_WRITE, 0x70, 1, 50);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    assert_registers("\1\x32\0\1\0\0");
    SAY(DEVICE_IS, CDS_WRITE, 0x70, 0, 201); // nothing of it is carried out
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    assert_registers("\1\x32\0\1\0\0");
}

void test_play_while_paused_is_refused_and_has_its_number(void)
{
    pretend_to_play();
    write(0x72, 1);
    assert_refused(0x70, 1);
    TEST_ASSERT_EQUAL_UINT8(ERROR_PAUSED, motion_may_start_sequence(&robot, moves.player.place));
    assert_registers("\2\x64\1\2\2\0");
}

void test_bus_baud_in_motion_is_refused_unless_it_stays(void)
{
    uint8_t before = (uint8_t)settings.bus_baud;

    pretend_to_play();
    assert_refused(0x05, (uint8_t)(before + 1));
    write(0x05, before);
    TEST_ASSERT_EQUAL_UINT8(before, settings.bus_baud);
}

void test_state_step_and_error_are_read_only(void)
{
    assert_refused(0x73, 0);
    assert_refused(0x74, 0);
    assert_refused(0x75, 0);
}

void test_other_registers_stay(void)
{
    write(0x07, 2);
    TEST_ASSERT_EQUAL_UINT8(2, settings.repeats);
    SAY(DEVICE_IS, CDS_READ, 0x00, 2);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)"\x55\xCD", 2);
    pretend_to_play();
    assert_refused(0x10, 1); // SAVE: a motion may read the EEPROM
}

void test_reset_in_motion_is_refused_and_changes_nothing(void)
{
    write(0x07, 2);
    pretend_to_play();
    SAY(DEVICE_IS, CDS_RESET);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL_UINT8(2, settings.repeats);
    cds_servos_reserve(&robot.servos, NULL, NULL, 0);
    SAY(DEVICE_IS, CDS_RESET);
    assert_heard(DEVICE_IS, 0, NULL, 0);
    TEST_ASSERT_EQUAL_UINT8(0, settings.repeats);
}

void test_registers_of_firmware_without_motions_read_0_and_refuse(void)
{
    device.ops = &device_registers_ops;
    robot.moves = NULL;
    assert_registers("\0\0\0\0\0\0");
    for (uint8_t address = 0x70; address < 0x76; address++)
        for (uint8_t value = 0; value < 12; value++)
            assert_refused(address, value);
}
