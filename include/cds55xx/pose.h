/* SPDX-License-Identifier: MIT */
/* Helpers for poses: mirror left and right, add offsets. A pose has a position of each joint, 0 to
 * 1023 (0 to 300 degrees, R8), or CDS_POSE_NONE (motion.h), which stays.
 *
 *     static const struct cds_pose_pair pairs[] = {
 *         {.one = 0, .other = 3, .is_turned = true}, {.one = 1, .other = 4, .is_turned = true}};
 *     cds_pose_mirror(pose, pairs, 2);
 *
 * Nothing is sent. Manual: registers 0x1E. Any context. */
#ifndef CDS_POSE_H
#define CDS_POSE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Two joints that change their places in a mirror. A joint in the middle is a pair with itself. */
struct cds_pose_pair {
    uint8_t one, other; // index of each in the pose
    bool is_turned;     // true if the servos are mounted as mirror images, or for a joint in the
                        // middle: position p becomes 1023 - p. False: p stays
};

/* Mirrors `pose` in place by `count` pairs. Joints that are in no pair keep their positions. Each
 * joint stands in one pair at most. Mirrored twice it is the same pose again. */
void cds_pose_mirror(uint16_t *pose, const struct cds_pose_pair *pairs, uint8_t count);

/* Adds an offset, -1023 to 1023 steps, to each of the `count` positions of `pose`. A sum below 0 or
 * above 1023 becomes 0 or 1023. Returns false if a sum was clamped. */
bool cds_pose_add(uint16_t *pose, const int16_t *offsets, uint8_t count);

#ifdef __cplusplus
}
#endif

#endif
