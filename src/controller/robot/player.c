/* SPDX-License-Identifier: MIT */
/* Plays a stored sequence; see player.h. */
#include "robot/player.h"

/* Reads a step for the sequence. If its pose cannot be read, the step has no joints: its move is
 * refused, and the sequence ends as CDS_BAD_ARGUMENT. While the EEPROM is written no step can be
 * read: the function then returns a step without joints, too, since false would end the sequence as
 * if it were complete. */
bool player_read_step(void *context, uint8_t index, struct cds_sequence_step *step, uint16_t *pose)
{
    struct player *player = context;
    struct motion_store_step stored = {.time_10ms = 1};

    if (!motion_store_is_saving(player->store) &&
        !motion_store_read_step(player->store, player->place, index, &stored))
        return false;
    *step = (struct cds_sequence_step){.time_ms = 10ul * stored.time_10ms,
                                       .dwell_ms = (uint16_t)(10u * stored.dwell_10ms),
                                       .curve = stored.curve,
                                       .acceleration = CDS_MOTION_FACTORY_ACCELERATION,
                                       .passes = stored.passes};
    stored_pose_read(player->store, &player->joints,
                     motion_store_pose_of(player->store, stored.pose), pose);
    return true;
}

enum cds_result player_begin(struct player *player, struct cds_motion *motion,
                             const struct motion_store *store, const struct robot *robot,
                             uint8_t place, uint16_t repeats)
{
    player->store = store;
    player->place = place;
    stored_joints_find(&player->joints, store, robot);
    return cds_sequence_begin(
        &player->sequence,
        &(struct cds_sequence_config){.motion = motion,
                                      .poses = player->poses,
                                      .context = player,
                                      .read = player->read ? player->read : player_read_step,
                                      .repeats = repeats,
                                      .checks_all = true});
}

void player_abort(struct player *player)
{
    cds_sequence_abort(&player->sequence, CDS_MOTION_DECELERATION);
}
