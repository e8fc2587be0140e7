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
    return robot->moves->start.result == CDS_PENDING ? STATE_STARTS : STATE_UNDER_WAY;
}

/* Number of the sequence that starts or plays; 0: none. */
static uint8_t playing(const struct robot *robot)
{
    const struct moves *moves = robot->moves;

    if (moves->start.result == CDS_PENDING)
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
    uint8_t joint;

    return state(robot) ? 0 : motion_outcome(robot, &joint);
}

static uint16_t get(void *context, uint8_t reg)
{
    const struct robot *robot = robot_of(context);

    switch (reg) {
    case DEVICE_MOTION_PLAY: return playing(robot);
    case DEVICE_MOTION_OVERRIDE: return robot->moves->percent;
    case DEVICE_MOTION_PAUSE: return motion_may_pause(robot) && robot->moves->player.is_paused;
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
    default: return device_registers_ops.allows(context, reg, value);
    }
}

static void play(struct robot *robot, uint8_t number)
{
    struct motion_start *start = &robot->moves->start;
    uint8_t refusal;

    if (number == 0) {
        motion_end(robot);
        return;
    }
    refusal = motion_start_sequence(robot, place_of(robot->moves->store, number), 1);
    if (refusal) {
        start->refusal = refusal;
        start->joint = MOTION_NO_JOINT;
    }
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

static void reset(void *context)
{
    device_registers_ops.reset(context);
}

static bool settled(void *context)
{
    return device_registers_ops.settled(context);
}

const CDS_FLASH struct device_ops motion_registers_ops = {get, set, allows, reset, settled};
