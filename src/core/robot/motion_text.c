/* SPDX-License-Identifier: MIT */
/* Why a move was refused or has ended, in words; see motion.h. */
#include "cds55xx/motion.h"

#include "cds55xx/result.h"
#include "flash.h" // CDS_FLASH
#include "robot/motion_internal.h"
#include "robot/rest_internal.h" // cds_rest_find()

static const CDS_FLASH char text_too_fast[] = "too fast, it needs ";
static const CDS_FLASH char text_old[] = "its feedback is too old: no reply, or a slow main loop";
static const CDS_FLASH char text_beyond[] = "it stands beyond its limits";
static const CDS_FLASH char text_time[] = "time ";
static const CDS_FLASH char text_range[] = " ms is out of range: 1 to ";
static const CDS_FLASH char text_curve[] = "there is no such curve";
static const CDS_FLASH char text_acceleration[] = "a trapezoid has no acceleration";
static const CDS_FLASH char text_pose[] = "a position is above 1023, or no joint is in the pose";
static const CDS_FLASH char text_ms[] = " ms";

/* A text that grows, with a zero behind it. */
struct text {
    char *characters;
    uint8_t length, capacity;
};

static void add_character(struct text *text, char c)
{
    if (text->length + 1 < text->capacity)
        text->characters[text->length++] = c;
    text->characters[text->length] = '\0';
}

static void add_flash(struct text *text, const CDS_FLASH char *from)
{
    while (*from)
        add_character(text, *from++);
}

static void add_number(struct text *text, uint32_t number)
{
    uint32_t power = 1;

    while (number / power >= 10)
        power *= 10;
    for (; power; power /= 10)
        add_character(text, (char)('0' + number / power % 10));
}

/* Adds "time 0 ms is out of range: 1 to 600000 ms". */
static void add_time_range(struct text *text, uint32_t time_ms)
{
    add_flash(text, text_time);
    add_number(text, time_ms);
    add_flash(text, text_range);
    add_number(text, CDS_MOTION_TIME_MAX_MS);
    add_flash(text, text_ms);
}

/* Adds which argument of the move is out of range. */
static void add_argument(struct text *text, const struct cds_motion *motion)
{
    switch (motion->wrong_argument) {
    case CDS_MOTION_TIME: add_time_range(text, motion->next.time_ms); break;
    case CDS_MOTION_NEXT_TIME: add_time_range(text, motion->next.next_ms); break;
    case CDS_MOTION_CURVE: add_flash(text, text_curve); break;
    case CDS_MOTION_ACCELERATION: add_flash(text, text_acceleration); break;
    default: add_flash(text, text_pose); break;
    }
}

static bool is_permitted(const struct cds_servo_state *servo, uint16_t position)
{
    return position >= servo->lowest && position <= servo->highest;
}

/* True if motion->joint rests beyond its soft limits, and its goal is within them. */
static bool stands_beyond(const struct cds_motion *motion)
{
    const struct cds_cycle *cycle = motion->config.cycle;
    const struct cds_servo_state *servo = cds_motion_servo(motion, motion->joint);
    uint16_t start;

    return servo && is_permitted(servo, motion->next.pose[motion->joint]) &&
           cds_rest_find(cycle, motion->joint, cds_cycle_sent_goal(cycle, motion->joint), &start) &&
           !is_permitted(servo, start);
}

/* True if `result` is why motion->next was refused: its joint is beyond a limit, or too fast. */
static bool is_limit_of_next(const struct cds_motion *motion, uint8_t result)
{
    return result == CDS_LIMIT && motion->move_result == CDS_LIMIT &&
           motion->wrong_argument == CDS_MOTION_NO_ARGUMENT;
}

uint8_t cds_motion_text(const struct cds_motion *motion, uint8_t result, char *text,
                        uint8_t capacity)
{
    struct text told = {.characters = text, .capacity = capacity};

    if (result == CDS_BAD_ARGUMENT && motion->wrong_argument != CDS_MOTION_NO_ARGUMENT) {
        add_argument(&told, motion);
    } else if (result == CDS_TIMEOUT) {
        add_flash(&told, text_old);
    } else if (!is_limit_of_next(motion, result)) {
        return cds_result_text(result, text, capacity);
    } else if (motion->shortest_ms) {
        add_flash(&told, text_too_fast);
        add_number(&told, motion->shortest_ms);
        add_flash(&told, text_ms);
    } else if (stands_beyond(motion)) {
        add_flash(&told, text_beyond);
    } else {
        return cds_result_text(result, text, capacity);
    }
    return told.length;
}
