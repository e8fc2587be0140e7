/* SPDX-License-Identifier: MIT */
/* The registers of motions; see motion_registers.h. */
#include "host/motion_registers.h"

#include "host/device_registers.h"
#include "robot/moves.h"

enum { STATE_NONE, STATE_STARTS, STATE_UNDER_WAY };

static struct robot *robot_of(const void *context)
{
    return ((const struct device_registers *)context)->failsafe->robot;
}

/* ---- numbers of sequences: lines of `sequence list`, from 1 on ---- */

/* The place of sequence `number`, 1 or more; MOTION_STORE_NONE: there is none. */
static uint8_t place_of(const struct motion_store *store, uint16_t number)
{
    uint8_t place = motion_store_next(store, MOTION_STORE_SEQUENCE, 0);

    while (--number && place != MOTION_STORE_NONE)
        place = motion_store_next(store, MOTION_STORE_SEQUENCE, (uint8_t)(place + 1));
    return place;
}

static uint8_t number_of(const struct motion_store *store, uint8_t place)
{
    uint8_t number = 1, other = 0;

    while ((other = motion_store_next(store, MOTION_STORE_SEQUENCE, other)) < place) {
        number++;
        other++;
    }
    return number;
}

/* ---- READ ---- */

static uint8_t state(const struct robot *robot)
{
    if (!robot_is_in_motion(robot))
        return motion_cycle_is_ending(robot) ? STATE_UNDER_WAY : STATE_NONE;
    return motion_is_starting(robot) ? STATE_STARTS : STATE_UNDER_WAY;
}

/* Number of the sequence that starts or plays; 0: none. */
static uint8_t playing(const struct robot *robot)
{
    const struct moves *moves = robot->moves;

    if (motion_is_starting(robot))
        return moves->start.is_sequence ? number_of(moves->store, moves->start.place) : 0;
    return robot_is_in_motion(robot) && moves_is_playing(robot)
               ? number_of(moves->store, moves->player.place)
               : 0;
}

static uint8_t step(const struct robot *robot)
{
    return motion_may_pause(robot) && moves_is_playing(robot)
               ? (uint8_t)(robot->moves->player.sequence.step + 1)
               : 0;
}

static uint8_t error(const struct robot *robot)
{
    return state(robot) ? 0 : motion_outcome(robot)->result;
}

static uint16_t get(void *context, uint8_t reg)
{
    const struct robot *robot = robot_of(context);

    switch (reg) {
    case DEVICE_MOTION_PLAY: return playing(robot);
    case DEVICE_MOTION_OVERRIDE: return robot->moves->percent;
    case DEVICE_MOTION_PAUSE: return motion_is_paused(robot);
    case DEVICE_MOTION_STATE: return state(robot);
    case DEVICE_MOTION_STEP: return step(robot);
    case DEVICE_MOTION_ERROR: return error(robot);
    default: return device_registers_ops.get(context, reg);
    }
}

/* ---- WRITE ---- */

static bool allows(void *context, uint8_t reg, uint16_t value)
{
    const struct robot *robot = robot_of(context);

    switch (reg) {
    case DEVICE_MOTION_PLAY:
        if (value == 0)
            return robot_is_in_motion(robot);
        return motion_may_start_sequence(robot, place_of(robot->moves->store, value)) == 0;
    case DEVICE_MOTION_OVERRIDE: return true;
    case DEVICE_MOTION_PAUSE: return motion_may_pause(robot);
    case DEVICE_BUS_BAUD: // the servos of the motion would not hear the other rate
        return value == device_registers_ops.get(context, reg) || !robot_is_in_motion(robot);
    case DEVICE_SAVE: return !robot_is_in_motion(robot); // the motion may read the EEPROM
    default: return device_registers_ops.allows(context, reg, value);
    }
}

static void play(struct robot *robot, uint8_t number)
{
    struct motion_outcome outcome = {.id = CDS_NO_ID, .step = MOTION_NO_STEP};

    if (number == 0) {
        motion_end(robot);
        return;
    }
    outcome.result = motion_start_sequence(robot, place_of(robot->moves->store, number), 1);
    if (outcome.result)
        moves_note_outcome(robot, &outcome);
}

static void set(void *context, uint8_t reg, uint16_t value)
{
    struct robot *robot = robot_of(context);

    switch (reg) {
    case DEVICE_MOTION_PLAY: play(robot, (uint8_t)value); break;
    case DEVICE_MOTION_OVERRIDE: moves_set_override(robot, (uint8_t)value); break;
    case DEVICE_MOTION_PAUSE: value ? moves_pause(robot) : moves_resume(robot); break;
    default: device_registers_ops.set(context, reg, value);
    }
}

/* A motion needs the settings of the bus. */
static bool reset(void *context)
{
    return !robot_is_in_motion(robot_of(context)) && device_registers_ops.reset(context);
}

static bool settled(void *context)
{
    return device_registers_ops.settled(context);
}

const CDS_FLASH struct device_ops motion_registers_ops = {get, set, allows, reset, settled};
