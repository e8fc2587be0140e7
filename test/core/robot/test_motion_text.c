/* SPDX-License-Identifier: MIT */
/* Why a move was refused, in words. */
#include "cds55xx/motion.h"
#include "cds55xx/result.h"

#include <string.h>

#include "unity.h"

static struct cds_motion motion;
static char text[CDS_RESULT_TEXT_SIZE];

void setUp(void)
{
    motion = (struct cds_motion){.move_result = CDS_LIMIT};
}

void tearDown(void)
{
}

static void check(const char *expected, uint8_t result)
{
    TEST_ASSERT_EQUAL_UINT8(strlen(expected), cds_motion_text(&motion, result, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING(expected, text);
}

void test_motion_text_of_a_time_too_short_names_the_time(void)
{
    motion.shortest_ms = 196;
    check("too fast, it needs 196 ms", CDS_LIMIT);
    motion.shortest_ms = 600000;
    check("too fast, it needs 600000 ms", CDS_LIMIT);
    motion.shortest_ms = 1;
    check("too fast, it needs 1 ms", CDS_LIMIT);
}

void test_motion_text_of_other_ends_is_that_of_the_result(void)
{
    check("not within the servo's limits", CDS_LIMIT); // a goal beyond them: no time works
    motion.shortest_ms = 196;
    check("the servo may not be driven", CDS_INHIBITED);
    motion.move_result = CDS_OK; // the move may take longer, and the permit refused a goal
    check("not within the servo's limits", CDS_LIMIT);
}

void test_motion_text_is_cut_to_the_capacity(void)
{
    motion.shortest_ms = 196;
    TEST_ASSERT_EQUAL_UINT8(8, cds_motion_text(&motion, CDS_LIMIT, text, 9));
    TEST_ASSERT_EQUAL_STRING("too fast", text);
    TEST_ASSERT_EQUAL_UINT8(0, cds_motion_text(&motion, CDS_LIMIT, text, 1));
    TEST_ASSERT_EQUAL_STRING("", text);
}
