/* SPDX-License-Identifier: MIT */
/* Plays a stored sequence (motion_store.h) with the servos of the group. The moves are those of the
 * group's cycle (moves.h), whose poll moves the player on.
 *
 * Main context. */
#ifndef CONTROLLER_PLAYER_H
#define CONTROLLER_PLAYER_H

#include "cds55xx/sequence.h" // struct cds_sequence
#include "robot/stored_pose.h"

/* A player: robot->moves->player. Others only read the fields, with two exceptions: moves.c writes
 * `sequence.result` and `poses`, and fast_steps.c `read` and `too_fast`. */
struct player {
    const struct motion_store *store;
    uint8_t place;                // of the sequence
    struct cds_sequence sequence; // its result is CDS_PENDING while the player plays
    struct stored_joints joints;
    /* What reads a step in place of player_read_step(), or NULL; bit i of `too_fast`: step i was
     * too fast. fast_steps.c sets both for one start. */
    bool (*read)(void *context, uint8_t index, struct cds_sequence_step *step, uint16_t *pose);
    uint16_t too_fast;
    uint16_t poses[2 * ROBOT_SERVOS]; // of the sequence; or of a move, while no sequence plays
};

/* Begins to play the sequence at `place`, which motion_store_find() has returned, `repeats` times;
 * 0: for ever. CDS_OK; CDS_BUSY: a move is under way; CDS_BAD_ARGUMENT: it has no step. */
enum cds_result player_begin(struct player *player, struct cds_motion *motion,
                             const struct motion_store *store, const struct robot *robot,
                             uint8_t place, uint16_t repeats);

/* Reads step `index` of the store for the sequence; `context`: the player. */
bool player_read_step(void *context, uint8_t index, struct cds_sequence_step *step, uint16_t *pose);

/* Ends the sequence, if one plays; the joints come to rest. */
void player_abort(struct player *player);

#endif
