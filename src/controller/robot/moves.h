/* SPDX-License-Identifier: MIT */
/* Timed moves of the group: an operation of the robot that does what its cycle does
 * (group_cycle.h), and moves the servos by motion.h.
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

/* The storage: robot->moves. The fields are to be read only. */
struct moves {
    const struct motion_store *store;
    const struct settings *settings;
    struct cds_motion motion;
    struct player player;
    struct motion_start start;
    struct autostart autostart;
    uint8_t percent;          // the override: of the motion under way, or of the next sequence
    bool ends_cycle;          // when the motion has ended
    struct cds_follow follow; // result CDS_TIMEOUT: its joint did not follow, and ended the motion
    uint8_t compared;         // period in which a joint was compared last, modulo 256
    struct cds_follow_joint follow_joints[ROBOT_SERVOS];
    struct cds_motion_joint joints[ROBOT_SERVOS];
};

/* As group_cycle. */
extern const CDS_FLASH struct robot_operation moves_cycle;

/* Once, at start-up: `robot->moves` is set and zero. What the pointers point to stays in place. */
void moves_open(struct robot *robot, const struct motion_store *store,
                const struct settings *settings);

/* True while a move of the running cycle is under way, paused or checked, or a sequence plays. */
bool moves_go_on(const struct robot *robot);

/* True while a sequence plays, also while it is paused, and while the autostart is about to play.
 */
bool moves_is_playing(const struct robot *robot);

/* A joint that does not follow its goals for CDS_FOLLOW_MS ends the motion: the joints come to rest
 * on their way, with torque. */

/* The servos of the group are reserved for the motion that starts (motion_start.h). `ends_cycle`:
 * the cycle ends with it. */
void moves_reserve(struct robot *robot, bool ends_cycle);

/* Begins a move of the running cycle: cds_motion_move(). CDS_BUSY, too, while a sequence plays.
 * Until the motion has ended, nothing else sets goals of the group. `ends_cycle`: the cycle ends
 * with the motion. */
enum cds_result moves_begin(struct robot *robot, const struct cds_move *move, bool ends_cycle);

/* Begins to play a stored sequence in the running cycle: player_begin(). `percent`: the override,
 * 10 to 200. */
enum cds_result moves_play(struct robot *robot, const struct motion_store *store, uint8_t place,
                           uint16_t repeats, uint8_t percent, bool ends_cycle);

/* Sets the override, 10 to 200 percent, of the motion under way and of the next sequence. */
void moves_set_override(struct robot *robot, uint8_t percent);

/* Bring the joints to rest on their way, and let them go on. */
void moves_pause(struct robot *robot);
void moves_resume(struct robot *robot);

/* Ends move and sequence: the joints come to rest on their way. */
void moves_end(struct robot *robot);

#endif
