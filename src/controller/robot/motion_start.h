/* SPDX-License-Identifier: MIT */
/* Starts a motion of the group: a timed move, or a stored sequence. The motion runs in the running
 * cycle, or in a cycle that is started for it and ends with it. The console and the virtual device
 * start motions here, so both have the same checks.
 *
 *     error = motion_start_sequence(&robot, place, 1); // then, until it is not CDS_PENDING:
 *     error = robot.moves->start.outcome.result;
 *
 * Main context. */
#ifndef CONTROLLER_MOTION_START_H
#define CONTROLLER_MOTION_START_H

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/motion.h"        // struct cds_move
#include "robot/robot.h"           // struct robot
#include "robot/stored_pose.h"     // struct stored_joints

/* What these functions return beside enum cds_result and enum robot_refusal: numbers of errors in
 * docs/errors.md. */
enum motion_refusal {
    MOTION_NO_GROUP = 45,
    MOTION_ENDLESS = 47,  // a joint is in endless turn: a speed turns it, and no goal stops it
    MOTION_OMITTED = 55,  // this firmware has no motions
    MOTION_TOO_FAST = 57, // a step, or the move, is too fast for a joint
    MOTION_BUSY = 58,     // a motion is under way
    MOTION_SAVING = 63,   // the EEPROM is being written
    MOTION_NO_SEQUENCE = 75,
    MOTION_POSE_GONE = 78,  // a step names a deleted pose
    MOTION_NONE = 79,       // no motion is under way, or it was ended
    MOTION_ABSENT = 81,     // a joint of a pose is not in the group
    MOTION_STUCK = 83,      // a joint does not follow its goals
    MOTION_TORQUE_OFF = 84, // torque of a joint is off
    MOTION_PAUSED = 92,     // a motion is under way and paused
};

#define MOTION_NO_STEP UINT8_MAX

/* Bytes that a start reads of each servo: registers 0x06 (angle limits, which are the mode) to 0x18
 * (torque). */
#define MOTION_READ_SIZE (CDS_REG_TORQUE_ENABLE - CDS_REG_CW_ANGLE_LIMIT + 1)

/* How a start or a motion has ended. */
struct motion_outcome {
    uint8_t result; // CDS_PENDING: it has not; CDS_OK; MOTION_NONE: it was ended by motion_end();
                    // ROBOT_STOPPED; else an enum cds_result or enum motion_refusal
    uint8_t id;     // of the servo that is the reason; CDS_NO_ID: none is
    uint8_t step;   // index of the step that is the reason or was under way; MOTION_NO_STEP: of no
                    // sequence, or before a step was checked
    uint32_t shortest_ms; // MOTION_TOO_FAST: a time that works
};

/* Part of struct moves. Programs read the first field. */
struct motion_start {
    struct motion_outcome outcome; // of the last start; CDS_OK: the motion has begun
    uint8_t phase;
    bool is_sequence;
    uint8_t place;        // of the sequence
    uint8_t step;         // that is checked next
    uint16_t repeats;     // of the sequence
    uint32_t begun_us;    // when the start began
    uint8_t read_joint;   // whose mode and torque are read
    bool is_reading;      // `read` is on its way
    uint8_t beyond;       // ANGLE_LIMITS_NO_JOINT, or the joint that a pose moves beyond `limits`
    uint16_t beyond_goal; // the position of this joint in the pose
    struct angle_limits
        limits[ROBOT_SERVOS]; // that the servos keep themselves: read with mode and torque
    struct cds_request read;  // READ of mode and torque
    uint8_t read_packet[CDS_PACKET_SIZE(2)];
    uint8_t read_reply[MOTION_READ_SIZE];
    struct cds_move move;
    struct stored_joints joints;
};

/* The operation that runs the cycle, the move under way and the start of the next one. Config: as
 * group_cycle (group_cycle.h). */
extern const CDS_FLASH struct robot_operation motion_cycle;

/* Returns why the group cannot take goals: MOTION_ENDLESS or CDS_INHIBITED, with the ID of the
 * servo that is the reason in robot->servos.refused_id; or CDS_OK. Torque does not matter. */
uint8_t motion_check_group(struct robot *robot);

/* Returns 0 if a stored sequence may be started now: motion_start_sequence() would return 0, unless
 * robot_choose_group() or robot_start() refuses. Else MOTION_OMITTED, MOTION_PAUSED, MOTION_BUSY
 * (also while the cycle of the last motion ends), ROBOT_STOPPED, CDS_INHIBITED, MOTION_SAVING or
 * MOTION_NO_SEQUENCE: no whole sequence is at `place`, which may be MOTION_STORE_NONE. Takes up to
 * 0.4 ms. */
uint8_t motion_may_start_sequence(const struct robot *robot, uint8_t place);

/* Starts the sequence at `place` of the store, `repeats` times; 0: for ever. moves_set_override()
 * sets its speed. If no group is chosen, the joints of the stored poses become the group. Returns
 * 0: it starts; else an error as motion_may_start_sequence(), MOTION_NO_GROUP, ROBOT_TOO_MANY,
 * ROBOT_BUSY, or the enum cds_result of cds_cycle_begin(). */
uint8_t motion_start_sequence(struct robot *robot, uint8_t place, uint16_t repeats);

/* Starts a timed move, which may take the place of a move under way. `move->pose` stays in place
 * while start.outcome.result is CDS_PENDING. The override becomes 100%. Returns as
 * motion_start_sequence(), but neither MOTION_SAVING nor MOTION_NO_SEQUENCE. */
uint8_t motion_start_move(struct robot *robot, const struct cds_move *move);

/* As motion_start_sequence(), after power-up: in place of the operation of the autostart, which
 * polls motion_cycle from then on. The group is chosen and has torque. Its speed is 100%. */
uint8_t motion_start_alone(struct robot *robot, uint8_t place, uint16_t repeats);

/* The outcome of the last motion, when none is under way. A start that is refused is a motion that
 * has ended, unless another motion goes on. Console and virtual device show this one. */
const struct motion_outcome *motion_outcome(const struct robot *robot);

/* True while the cycle of a motion that has ended still runs: at most for a period. */
bool motion_cycle_is_ending(const struct robot *robot);

/* True while a motion is under way and paused. */
bool motion_is_paused(const struct robot *robot);

/* True while a motion starts. */
bool motion_is_starting(const struct robot *robot);

/* True if a motion can be paused or resumed: it has begun and not ended. */
bool motion_may_pause(const struct robot *robot);

/* Ends the motion that starts or is under way: the joints come to rest on their way. */
void motion_end(struct robot *robot);

#endif
