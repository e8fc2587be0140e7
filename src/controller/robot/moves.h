/* SPDX-License-Identifier: MIT */
/* Timed moves of the group: an operation of the robot that does what its cycle does
 * (group_cycle.h), and moves the servos by motion.h. A joint that does not follow its goals for
 * CDS_FOLLOW_MS ends the motion: the joints come to rest on their way, with torque.
 *
 * Three states of a motion:
 *
 *   robot_is_in_motion()  a motion starts, is under way or is paused: the servos of the group are
 *                         reserved for its goals
 *   moves_go_on()         the running cycle has a move that is checked, under way or paused, or
 *                         plays a sequence. A motion that starts: only in the last phase of the
 *                         start, when the motion checks the move or tries the steps
 *   moves_is_playing()    a sequence plays or is paused, or its steps are tried
 *
 * Main context. */
#ifndef CONTROLLER_MOVES_H
#define CONTROLLER_MOVES_H

#include "cds55xx/follow.h"     // struct cds_follow
#include "cds55xx/motion.h"     // struct cds_motion
#include "robot/autostart.h"    // struct autostart
#include "robot/motion_start.h" // struct motion_start
#include "robot/player.h"       // struct player
#include "robot/robot.h"        // struct robot

/* The storage: robot->moves. Other modules only read the fields; for `player` see player.h. */
struct moves {
    // Fields in most use stand first: `ldd` reaches offsets 0 to 63. Saves 232 bytes.
    const struct motion_store *store;
    const struct settings *settings;
    struct motion_outcome outcome; // of the last motion: written by moves_note_outcome() only
    struct cds_follow follow; // result CDS_TIMEOUT: its joint did not follow, or its torque went
                              // off, and ended the motion
    uint8_t percent;          // the override: of the motion under way, or of the next sequence
    bool end_is_unreported;   // the last motion has ended, and no command has told how
    bool group_is_tried;      // the group was chosen for a motion that has not begun
    uint8_t tried_from;       // servos of the group before it was chosen
    bool ends_cycle;          // true: the cycle ends with the motion
    bool is_paused;           // the move or the sequence: by moves_pause()
    uint8_t noted_saves;      // store->saves, modulo 256, when `outcome` was noted
    uint8_t watched;          // the last period that watch_period() has seen, modulo 256
    uint8_t sent;             // packets that the bus had sent by that period, modulo 256
    uint8_t unsent_periods;   // since the last packet left, up to UNSENT_PERIODS
    struct motion_start start;
    struct autostart autostart;
    struct cds_motion motion;
    struct player player;
    struct cds_follow_joint follow_joints[ROBOT_SERVOS];
    struct cds_motion_joint joints[ROBOT_SERVOS];
};

/* The operation that runs the cycle and the move under way. Config: as group_cycle. */
extern const CDS_FLASH struct robot_operation moves_cycle;

/* Once, at start-up: `robot->moves` is set and zero. What the pointers point to stays in place. */
void moves_open(struct robot *robot, const struct motion_store *store,
                const struct settings *settings);

/* True while a move of the running cycle is under way, paused or checked, or a sequence plays. */
bool moves_go_on(const struct robot *robot);

/* True while a sequence plays, is paused, or has its steps tried. */
bool moves_is_playing(const struct robot *robot);

/* The servos of the group are reserved for the motion that starts (motion_start.h). `ends_cycle`:
 * the cycle ends with it. */
void moves_reserve(struct robot *robot, bool ends_cycle);

/* The last motion has ended in this way; CDS_PENDING: a motion has begun to start. */
void moves_note_outcome(struct robot *robot, const struct motion_outcome *outcome);

/* Why the motion has refused a move, CDS_LIMIT as MOTION_TOO_FAST where a longer time works. */
struct motion_outcome moves_refusal(const struct robot *robot, uint8_t result);

/* Begins a move of the running cycle: cds_motion_move(). Copies move->pose. CDS_BUSY, too, while a
 * sequence plays. Until the motion has ended, nothing else sets goals of the group. `ends_cycle`:
 * the cycle ends with the motion. */
enum cds_result moves_begin(struct robot *robot, const struct cds_move *move, bool ends_cycle);

/* Begins to play a stored sequence in the running cycle: player_begin(). `percent`: the override,
 * 10 to 200. */
enum cds_result moves_play(struct robot *robot, const struct motion_store *store, uint8_t place,
                           uint16_t repeats, uint8_t percent, bool ends_cycle);

/* Returns true once after a motion has ended, unless a new motion has begun: no command has printed
 * its outcome yet. */
bool moves_take_end(struct robot *robot);

/* Sets the override, 10 to 200 percent, of the motion under way and of the next sequence. */
void moves_set_override(struct robot *robot, uint8_t percent);

/* Bring the joints to rest on their way, and let them go on. */
void moves_pause(struct robot *robot);
void moves_resume(struct robot *robot);

/* Ends move and sequence: the joints come to rest on their way. */
void moves_end(struct robot *robot);

#endif
