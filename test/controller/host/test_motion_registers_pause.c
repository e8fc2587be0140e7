/* SPDX-License-Identifier: MIT */
/* The registers of motions: pause, override, those that are refused in motion, what a READ tells.
 */
#include "motion_registers_rig.h"

void setUp(void)
{
    open_motions();
}

void tearDown(void)
{
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
