/* SPDX-License-Identifier: MIT */
/* Helpers for poses. */
#include "cds55xx/pose.h"

#include "cds55xx/motion.h"
#include "unity.h"

#define JOINTS 5

static uint16_t pose[JOINTS];

void setUp(void)
{
    static const uint16_t at[JOINTS] = {100, 1023, CDS_POSE_NONE, 700, 0};

    for (uint8_t i = 0; i < JOINTS; i++)
        pose[i] = at[i];
}

void tearDown(void)
{
}

static const struct cds_pose_pair pairs[] = {
    {.one = 0, .other = 3, .is_turned = true}, {.one = 1, .other = 2}, {4, 4, true}};

void test_mirror_swaps_pairs_and_turns_directions(void)
{
    static const uint16_t expected[JOINTS] = {323, CDS_POSE_NONE, 1023, 923, 1023};

    cds_pose_mirror(pose, pairs, 3);
    TEST_ASSERT_EQUAL_UINT16_ARRAY(expected, pose, JOINTS);
}

void test_mirror_keeps_joints_that_are_in_no_pair(void)
{
    cds_pose_mirror(pose, pairs, 1);
    TEST_ASSERT_EQUAL_UINT16(1023, pose[1]);
    TEST_ASSERT_EQUAL_UINT16(CDS_POSE_NONE, pose[2]);
    TEST_ASSERT_EQUAL_UINT16(0, pose[4]);
}

void test_mirror_of_none_that_is_turned_stays_none(void)
{
    static const struct cds_pose_pair turned = {2, 4, true};

    cds_pose_mirror(pose, &turned, 1);
    TEST_ASSERT_EQUAL_UINT16(1023, pose[2]);
    TEST_ASSERT_EQUAL_UINT16(CDS_POSE_NONE, pose[4]);
}

void test_mirror_twice_gives_the_pose_again(void)
{
    uint16_t before[JOINTS];

    for (uint8_t i = 0; i < JOINTS; i++)
        before[i] = pose[i];
    cds_pose_mirror(pose, pairs, 3);
    cds_pose_mirror(pose, pairs, 3);
    TEST_ASSERT_EQUAL_UINT16_ARRAY(before, pose, JOINTS);
}

void test_add_adds_offsets(void)
{
    static const int16_t offsets[JOINTS] = {-100, -1023, 5, 323, 1};
    static const uint16_t expected[JOINTS] = {0, 0, CDS_POSE_NONE, 1023, 1};

    TEST_ASSERT_TRUE(cds_pose_add(pose, offsets, JOINTS));
    TEST_ASSERT_EQUAL_UINT16_ARRAY(expected, pose, JOINTS);
}

void test_add_beyond_range_clamps_and_returns_false(void)
{
    static const int16_t low[JOINTS] = {-101}, high[JOINTS] = {0, 1023};

    TEST_ASSERT_FALSE(cds_pose_add(pose, low, JOINTS));
    TEST_ASSERT_EQUAL_UINT16(0, pose[0]);
    TEST_ASSERT_FALSE(cds_pose_add(pose, high, JOINTS));
    TEST_ASSERT_EQUAL_UINT16(1023, pose[1]);
}
