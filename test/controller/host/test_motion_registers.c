/* SPDX-License-Identifier: MIT */
/* The registers of motions: what a WRITE to MOTION_PLAY starts and ends, and what is refused. */
#include "motion_registers_rig.h"

void setUp(void)
{
    open_motions();
}

void tearDown(void)
{
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
