/* SPDX-License-Identifier: MIT */
/* Plays a stored sequence after power-up, without a host: an operation of the robot. It plays only
 * if the reset was power-on, no byte comes from the host before the sequence begins, every servo is
 * well, and each pose is within the angle limits of its servos. It writes to no servo before
 * servos and poses are checked. Then each servo gets torque where it is (torque_on.h). If the
 * motion is refused after that, the servos that got torque lose it again.
 *
 * Main context. */
#ifndef CONTROLLER_AUTOSTART_H
#define CONTROLLER_AUTOSTART_H

#include "robot/failsafe.h"     // struct failsafe
#include "robot/motion_start.h" // struct motion_outcome
#include "robot/motion_store.h" // struct motion_store

/* State of the autostart; from AUTOSTART_RESET on: why the sequence does not play. */
enum autostart_state {
    AUTOSTART_OFF,     // no sequence is set
    AUTOSTART_WAITING, // for a byte of the host, or the end of the delay
    AUTOSTART_CHECKING_SERVOS,
    AUTOSTART_CHECKING_POSES,
    AUTOSTART_SWITCHING_ON,    // servos get torque
    AUTOSTART_STARTING_MOTION, // until the motion has begun or was refused (motion_start.h)
    AUTOSTART_BEGUN,           // the sequence has begun
    // it does not play:
    AUTOSTART_RESET,     // the reset was not power-on
    AUTOSTART_HOST,      // a byte came from the host
    AUTOSTART_ALARM,     // driving is inhibited, or a servo has an alarm
    AUTOSTART_MISSING,   // there is no such sequence, or no stored pose
    AUTOSTART_POSE_GONE, // the pose of outcome.step is deleted
    AUTOSTART_NOT_WELL,  // servo outcome.id; outcome.result is an enum cds_reason
    AUTOSTART_LIMITS,    // the pose of outcome.step is beyond `lowest` to `highest` of outcome.id
    AUTOSTART_REFUSED,   // the motion was refused, or a stop came before it began: `outcome`
} __attribute__((packed));

/* Delay in a record of the store: seconds, and whether the sequence is repeated for ever. */
#define AUTOSTART_DELAY_MAX 127
#define AUTOSTART_LOOP      0x80

/* Times that a servo without a good reply is read, or gets WRITEs that switch torque off again. */
#define AUTOSTART_TRIES 3

/* Part of struct moves. Programs read the fields before `delay`. */
struct autostart {
    uint8_t state;                 // enum autostart_state
    struct motion_outcome outcome; // id, step and result that the state names. While poses are
                                   // checked, `step` is the one that is next
    uint16_t lowest, highest;      // LIMITS: angle limits of the servo
    uint8_t place;                 // of the sequence
    uint8_t saves;                 // store->saves, modulo 256, when `place` was found
    uint8_t delay;                 // of the record
    bool is_aborted;
    bool has_switched_on;    // servos have got torque
    bool is_switching_off;   // nothing plays: the servos lose this torque again
    uint32_t without_torque; // bit i: servo i of the group had no torque before
    uint32_t begun_us;
    const struct failsafe *failsafe;
    struct motion_store *store;
};

/* Once, at start-up, after motion_store_load() and failsafe_begin(): begins the operation if the
 * store names a sequence and the reset allows it. */
void autostart_begin(const struct failsafe *failsafe, struct motion_store *store);

#endif
