/* SPDX-License-Identifier: MIT */
/* The registers of motions behind the bridge, with two stored sequences. No servo answers: whole
 * motions are in test/runs/test_motion_registers.py. */
#ifndef MOTION_REGISTERS_RIG_H
#define MOTION_REGISTERS_RIG_H

#include "bridge_rig.h"
#include "console/errors.h"
#include "host/motion_registers.h"
#include "robot/moves.h"

/* Up to the third place of a sequence. The bytes behind them are erased. */
static uint8_t eeprom[1400];
static struct motion_store motions;
static struct moves moves;

static inline void save(const struct motion_store_record *record)
{
    TEST_ASSERT_EQUAL(MOTION_STORE_SAVING, motion_store_save(&motions, record));
    while (motion_store_poll(&motions)) {
    }
    TEST_ASSERT_EQUAL(MOTION_STORE_SAVED, motions.result);
}

static inline void save_sequence(const char *name)
{
    static const struct motion_store_step step = {.time_10ms = 100};

    save(&(struct motion_store_record){
        .kind = MOTION_STORE_SEQUENCE, .name = name, .length = 1, .count = 1, .steps = &step});
}

static inline void open_motions(void)
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

/* The bytes of MOTION_PLAY to MOTION_ERROR. */
static inline void assert_registers(const char *six)
{
    SAY(DEVICE_IS, CDS_READ, 0x70, 6);
    assert_heard(DEVICE_IS, 0, (const uint8_t *)six, 6);
}

static inline void write(uint8_t address, uint8_t value)
{
    SAY(DEVICE_IS, CDS_WRITE, address, value);
    assert_heard(DEVICE_IS, 0, NULL, 0);
}

static inline void assert_refused(uint8_t address, uint8_t value)
{
    SAY(DEVICE_IS, CDS_WRITE, address, value);
    assert_heard(DEVICE_IS, CDS_ERROR_RANGE, NULL, 0);
}

/* A sequence plays, in its second step. */
static inline void pretend_to_play(void)
{
    write(0x70, 2);
    moves.start.outcome.result = CDS_OK;
    moves.player.sequence.config.motion = &moves.motion;
    moves.player.place = moves.start.place;
    moves.player.sequence.result = CDS_PENDING;
    moves.player.sequence.step = 1;
}

#endif
