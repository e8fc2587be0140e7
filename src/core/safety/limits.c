/* Soft limits of one servo; see limits.h. Manual: 3.1, 0x06 to 0x09, 0x18, 0x1E to 0x21; R10, R16.
 */
#include "safety/limits.h"
#include "compiler.h" // NOINLINE

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX

const uint8_t *cds_span_byte(const struct cds_span *span, uint8_t reg)
{
    uint8_t index = (uint8_t)(reg - span->address);

    return reg >= span->address && index < span->length ? span->data + index : NULL;
}

uint8_t cds_span_value(const struct cds_span *span, uint8_t reg, uint8_t otherwise)
{
    const uint8_t *byte = cds_span_byte(span, reg);

    return byte ? *byte : otherwise;
}

bool cds_span_touches(const struct cds_span *span, uint8_t first, uint8_t last)
{
    return span->length && span->address <= last && span->address + span->length > first;
}

static uint16_t word_at(const uint8_t *data)
{
    return (uint16_t)(data[0] | (uint16_t)data[1] << 8);
}

/* The word at `reg`, low byte first (R28); NULL if one of its bytes is missing. */
static const uint8_t *word_of(const struct cds_span *span, uint8_t reg)
{
    return cds_span_byte(span, (uint8_t)(reg + 1)) ? cds_span_byte(span, reg) : NULL;
}

NOINLINE static bool position_limited(const struct cds_servo_state *servo)
{
    return servo->lowest > 0 || servo->highest < CDS_VALUE_MAX;
}

static bool speed_limited(const struct cds_servo_state *servo)
{
    return servo->fastest < CDS_VALUE_MAX;
}

bool cds_limits_any(const struct cds_servo_state *servo)
{
    return position_limited(servo) || speed_limited(servo);
}

/* What no servo has is the servo's to refuse if there is no limit: whoever asked hears it say so.
 */
static bool goal_is_good(const struct cds_servo_state *servo, uint16_t goal)
{
    return goal >= servo->lowest && (goal <= servo->highest || servo->highest == CDS_VALUE_MAX);
}

/* ---- what it holds ---- */

/* The angle limit at `reg`, of which `known` was known. */
static uint8_t angle_limit(uint8_t known, const struct cds_span *span, uint8_t reg)
{
    if (!cds_span_touches(span, reg, (uint8_t)(reg + 1)))
        return known;
    if (cds_span_value(span, reg, 0) || cds_span_value(span, (uint8_t)(reg + 1), 0))
        return CDS_ANGLE_SET;
    return word_of(span, reg) || known == CDS_ANGLE_0 ? CDS_ANGLE_0 : CDS_ANGLE_UNKNOWN;
}

void cds_limits_take(struct cds_servo_state *servo, const struct cds_span *span)
{
    const uint8_t *word = word_of(span, CDS_REG_GOAL_POSITION);
    uint16_t magnitude = 0;

    servo->cw_limit = angle_limit(servo->cw_limit, span, CDS_REG_CW_ANGLE_LIMIT) & 3u;
    servo->ccw_limit = angle_limit(servo->ccw_limit, span, CDS_REG_CCW_ANGLE_LIMIT) & 3u;
    if (cds_span_touches(span, CDS_REG_GOAL_POSITION, CDS_REG_GOAL_POSITION + 1))
        servo->goal_known = word && goal_is_good(servo, word_at(word));
    if (cds_span_touches(span, CDS_REG_MOVING_SPEED, CDS_REG_MOVING_SPEED + 1)) {
        word = word_of(span, CDS_REG_MOVING_SPEED);
        if (word)
            magnitude = word_at(word) & CDS_VALUE_MAX;
        servo->speed_known = word && magnitude <= servo->fastest;
        servo->speed_0 = magnitude == 0;
    }
}

/* ---- what may be written ---- */

/* Endless turn knows no goal. Speed 0 stands still there; in position mode it is as fast as it can.
 */
enum cds_result cds_limits_check_goal(const struct cds_servo_state *servo, const uint8_t *data)
{
    uint16_t magnitude = word_at(data + 2) & CDS_VALUE_MAX;

    if (!goal_is_good(servo, word_at(data)) || magnitude > servo->fastest)
        return CDS_LIMIT;
    if (magnitude == 0)
        return !speed_limited(servo) || cds_limits_mode(servo) == CDS_MODE_TURN ? CDS_OK
                                                                                : CDS_LIMIT;
    return cds_limits_mode(servo) == CDS_MODE_POSITION || !position_limited(servo) ? CDS_OK
                                                                                   : CDS_LIMIT;
}

/* Would it go beyond a limit? `next` is what it is with this write. Switched to position mode, or
 * on, it goes to the goal it holds; of a speed only 0 is good in any mode. */
enum cds_result cds_limits_check(const struct cds_servo_state *servo, const struct cds_span *span)
{
    bool mode_set, goal_set, speed_set, goal_counts, mode_counts, speed_counts;
    uint8_t before = cds_limits_mode(servo), mode;
    struct cds_servo_state next;

    if (!cds_limits_any(servo))
        return CDS_OK;
    next = *servo;
    cds_limits_take(&next, span);
    mode = cds_limits_mode(&next);
    mode_set = cds_span_touches(span, CDS_REG_CW_ANGLE_LIMIT, CDS_REG_CCW_ANGLE_LIMIT + 1);
    goal_set = cds_span_touches(span, CDS_REG_GOAL_POSITION, CDS_REG_GOAL_POSITION + 1);
    speed_set = cds_span_touches(span, CDS_REG_MOVING_SPEED, CDS_REG_MOVING_SPEED + 1);
    goal_counts = mode_counts = speed_counts = cds_span_value(span, CDS_REG_TORQUE_ENABLE, 0);
    if (goal_set) {
        goal_counts = true;
        if (mode != CDS_MODE_TURN) // else it goes nowhere
            speed_counts = true;
    }
    if (speed_set) {
        speed_counts = true;
        if (!next.speed_known || !next.speed_0)
            mode_counts = true;
    }
    if (mode_set) {
        mode_counts = true;
        if (before != CDS_MODE_POSITION)
            goal_counts = true;
        if (mode == CDS_MODE_UNKNOWN || mode != before)
            speed_counts = true;
    }
    if (position_limited(servo) &&
        ((goal_counts && !next.goal_known) || (mode_counts && mode != CDS_MODE_POSITION)))
        return CDS_LIMIT;
    if (speed_limited(servo) && speed_counts &&
        (!next.speed_known || (next.speed_0 && mode != CDS_MODE_TURN)))
        return CDS_LIMIT;
    return CDS_OK;
}
