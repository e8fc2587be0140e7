/* SPDX-License-Identifier: MIT */
/* Why a move was refused, in words. */
#define JOINTS 2

#include "motion_rig.h"

static char text[CDS_RESULT_TEXT_SIZE];

void setUp(void)
{
    rig_begin_moves();
}

void tearDown(void)
{
    rig_check();
}

static void check(const char *expected, uint8_t result)
{
    TEST_ASSERT_EQUAL_UINT8(strlen(expected), cds_motion_text(&motion, result, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING(expected, text);
}

void test_motion_text_of_a_time_too_short_names_the_time(void)
{
    motion.move_result = CDS_LIMIT;
    motion.shortest_ms = 196;
    check("too fast, it needs 196 ms", CDS_LIMIT);
    motion.shortest_ms = 600000;
    check("too fast, it needs 600000 ms", CDS_LIMIT);
    motion.shortest_ms = 1;
    check("too fast, it needs 1 ms", CDS_LIMIT);
}

void test_motion_text_of_other_ends_is_that_of_the_result(void)
{
    motion.shortest_ms = 196;
    check("the servo may not be driven", CDS_INHIBITED);
    motion.move_result = CDS_OK; // the move may take longer, and the permit refused a goal
    check("not within the servo's limits", CDS_LIMIT);
}

void test_motion_text_tells_a_goal_beyond_from_a_joint_beyond(void)
{
    cds_servos_set_limits(&servos, &states[1], 300, 700, 1023);
    pose[0] = 510;
    pose[1] = 701;
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(1000, CDS_MOTION_LINEAR));
    check("not within the servo's limits", CDS_LIMIT);
    feedback[1].position = 750;
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(1000, CDS_MOTION_LINEAR));
    check("not within the servo's limits", CDS_LIMIT);
    pose[1] = 700;
    TEST_ASSERT_EQUAL(CDS_LIMIT, rig_try_move(1000, CDS_MOTION_LINEAR));
    check("it stands beyond its limits", CDS_LIMIT);
}

static void check_argument(const char *expected, const struct cds_move *move)
{
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_move(&motion, move));
    check(expected, CDS_BAD_ARGUMENT);
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_motion_try(&motion, move, true));
    check(expected, CDS_BAD_ARGUMENT);
}

void test_motion_text_names_the_argument_out_of_range(void)
{
    struct cds_move it = {.pose = pose, .time_ms = 0};
    uint16_t none[JOINTS] = {CDS_POSE_NONE, CDS_POSE_NONE};

    pose[0] = 510;
    check_argument("time 0 ms is out of range: 1 to 600000 ms", &it);
    it.time_ms = 600001;
    check_argument("time 600001 ms is out of range: 1 to 600000 ms", &it);
    it.time_ms = 600000;
    it.curve = CDS_MOTION_BY_SERVO + 1;
    check_argument("there is no such curve", &it);
    it.curve = CDS_MOTION_TRAPEZOID;
    check_argument("a trapezoid has no acceleration", &it);
    it.curve = CDS_MOTION_LINEAR;
    it.next_pose = pose;
    check_argument("time 0 ms is out of range: 1 to 600000 ms", &it);
    it.next_ms = 1;
    it.next_pose = none;
    check_argument("a position is above 1023, or no joint is in the pose", &it);
    it.next_pose = NULL;
    pose[1] = 1024;
    check_argument("a position is above 1023, or no joint is in the pose", &it);
}

void test_motion_text_is_cut_to_the_capacity(void)
{
    motion.move_result = CDS_LIMIT;
    motion.shortest_ms = 196;
    TEST_ASSERT_EQUAL_UINT8(8, cds_motion_text(&motion, CDS_LIMIT, text, 9));
    TEST_ASSERT_EQUAL_STRING("too fast", text);
    TEST_ASSERT_EQUAL_UINT8(0, cds_motion_text(&motion, CDS_LIMIT, text, 1));
    TEST_ASSERT_EQUAL_STRING("", text);
}
