/* Soft limits of one servo; see limits.h. Manual: 3.1, 0x06 to 0x09, 0x18, 0x1E to 0x21; R10, R16.
 */
#include "safety/limits.h"

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX

enum mode { MODE_UNKNOWN, MODE_POSITION, MODE_TURN };

static uint8_t mode_of(uint8_t cw_limit, uint8_t ccw_limit)
{
    if ((cw_limit | ccw_limit) & CDS_ANGLE_SET)
        return MODE_POSITION;
    return cw_limit & ccw_limit ? MODE_TURN : MODE_UNKNOWN;
}

static uint16_t word_at(const uint8_t *data)
{
    return (uint16_t)(data[0] | (uint16_t)data[1] << 8);
}

static uint16_t magnitude_at(const uint8_t *data)
{
    return word_at(data) & CDS_VALUE_MAX;
}

static bool has_goal_limit(const struct cds_servo_state *servo)
{
    return servo->lowest > 0 || servo->highest < CDS_VALUE_MAX;
}

/* A goal above 1023 is refused by the servo itself if the limit does not refuse it. */
static bool is_within(const struct cds_servo_state *servo, uint16_t goal)
{
    return goal >= servo->lowest && (goal <= servo->highest || servo->highest == CDS_VALUE_MAX);
}

/* The angle limit at `reg`, of which `known` was known. */
static uint8_t angle_limit(uint8_t known, const struct cds_written *written, uint8_t reg)
{
    const uint8_t *low = cds_written_byte(written, reg);
    const uint8_t *high = cds_written_byte(written, (uint8_t)(reg + 1));

    if (!low && !high)
        return known;
    if ((low && *low) || (high && *high))
        return CDS_ANGLE_SET;
    return (low && high) || known == CDS_ANGLE_0 ? CDS_ANGLE_0 : CDS_ANGLE_UNKNOWN;
}

/* ---- what may be written ---- */

/* In endless turn a servo has no use for the goal, and stands still at speed 0. In position mode it
 * goes as fast as it can at speed 0. */
enum cds_result cds_limits_check_goal(struct cds_servo_state *servo, const uint8_t *data)
{
    uint16_t magnitude;
    uint8_t mode;

    if (!servo->has_limits)
        return CDS_OK;
    magnitude = magnitude_at(data + 2);
    if (!is_within(servo, word_at(data)) || magnitude > servo->fastest)
        return CDS_LIMIT;
    mode = mode_of(servo->cw_limit, servo->ccw_limit);
    if (magnitude) {
        if (mode != MODE_POSITION && has_goal_limit(servo))
            return CDS_LIMIT;
    } else {
        if (mode != MODE_TURN && servo->fastest < CDS_VALUE_MAX)
            return CDS_LIMIT;
        servo->speed_0 = true;
    }
    return CDS_OK;
}

/* What the servo holds after a write. */
struct held {
    uint8_t mode_before, mode; // enum mode
    bool goal_is_good, speed_is_good, speed_is_0;
    bool torque; // this write switches it on
};

static void foresee(const struct cds_servo_state *servo, const struct cds_written *written,
                    struct held *held)
{
    uint8_t cw = servo->cw_limit, ccw = servo->ccw_limit;
    const uint8_t *word;

    held->mode_before = held->mode = mode_of(cw, ccw);
    held->goal_is_good = servo->goal_known;
    held->speed_is_good = servo->speed_known;
    held->speed_is_0 = servo->speed_0;
    held->torque = cds_written_value(written, CDS_REG_TORQUE_ENABLE, 0);
    if (written->sets & CDS_SETS_MODE)
        held->mode = mode_of(angle_limit(cw, written, CDS_REG_CW_ANGLE_LIMIT),
                             angle_limit(ccw, written, CDS_REG_CCW_ANGLE_LIMIT));
    if (written->sets & CDS_SETS_GOAL) {
        word = cds_written_word(written, CDS_REG_GOAL_POSITION);
        held->goal_is_good = word && is_within(servo, word_at(word));
    }
    if (written->sets & CDS_SETS_SPEED) {
        word = cds_written_word(written, CDS_REG_MOVING_SPEED);
        held->speed_is_good = word && magnitude_at(word) <= servo->fastest;
        held->speed_is_0 = word && magnitude_at(word) == 0;
    }
}

/* With a limit of the goal. Switched on, or to position mode, a servo goes to the goal it holds. */
static bool keeps_goal(const struct held *held, uint8_t sets)
{
    bool goal_counts = held->torque || sets & CDS_SETS_GOAL;
    bool mode_counts = held->torque || sets & CDS_SETS_MODE;

    if (sets & CDS_SETS_MODE && held->mode_before != MODE_POSITION)
        goal_counts = true;
    if (sets & CDS_SETS_SPEED && !held->speed_is_0)
        mode_counts = true;
    return (held->goal_is_good || !goal_counts) && (held->mode == MODE_POSITION || !mode_counts);
}

/* With a limit of the speed. */
static bool keeps_speed(const struct held *held, uint8_t sets)
{
    bool counts = held->torque || sets & CDS_SETS_SPEED;

    if ((sets & (CDS_SETS_GOAL | CDS_SETS_SPEED)) == CDS_SETS_GOAL)
        return false; // at which speed is not certain
    if (sets & CDS_SETS_MODE && (held->mode == MODE_UNKNOWN || held->mode != held->mode_before))
        counts = true;
    return !counts || (held->speed_is_good && (!held->speed_is_0 || held->mode == MODE_TURN));
}

enum cds_result cds_limits_check(struct cds_servo_state *servo, const struct cds_written *written)
{
    uint8_t sets =
        written->sets & (CDS_SETS_MODE | CDS_SETS_TORQUE | CDS_SETS_GOAL | CDS_SETS_SPEED);
    struct held held;

    if (!servo->has_limits || !sets)
        return CDS_OK;
    foresee(servo, written, &held);
    if (held.torque &&
        (held.mode == MODE_UNKNOWN || !servo->goal_known || !servo->speed_known)) // not read
        return CDS_LIMIT;
    if ((has_goal_limit(servo) && !keeps_goal(&held, sets)) ||
        (servo->fastest < CDS_VALUE_MAX && !keeps_speed(&held, sets)))
        return CDS_LIMIT;
    if (sets & CDS_SETS_SPEED && held.speed_is_0)
        servo->speed_0 = true;
    return CDS_OK;
}

/* ---- what it holds ---- */

/* Returns what is known of the angle limit at `reg`. */
static uint8_t learn_angle(uint8_t known, const struct cds_written *written, uint8_t reg,
                           enum cds_source source)
{
    uint8_t next = angle_limit(known, written, reg);

    if (source == CDS_SOURCE_READ || next == known)
        return next;
    if (source == CDS_SOURCE_ANSWERED && known != CDS_ANGLE_UNKNOWN)
        return next;
    return CDS_ANGLE_UNKNOWN;
}

bool cds_limits_learn(struct cds_servo_state *servo, const struct cds_written *written,
                      enum cds_source source)
{
    struct cds_servo_state before = *servo;
    const uint8_t *word;

    if (written->sets & CDS_SETS_MODE) {
        servo->cw_limit =
            learn_angle(before.cw_limit, written, CDS_REG_CW_ANGLE_LIMIT, source) & 3u;
        servo->ccw_limit =
            learn_angle(before.ccw_limit, written, CDS_REG_CCW_ANGLE_LIMIT, source) & 3u;
        if (servo->cw_limit != before.cw_limit || servo->ccw_limit != before.ccw_limit)
            servo->is_registered = false; // its registered write was checked in the other mode
    }
    if (written->sets & CDS_SETS_GOAL && source == CDS_SOURCE_READ) {
        word = cds_written_word(written, CDS_REG_GOAL_POSITION);
        servo->goal_known = word && is_within(servo, word_at(word));
    }
    if (written->sets & CDS_SETS_SPEED && source <= CDS_SOURCE_ANSWERED) {
        word = cds_written_word(written, CDS_REG_MOVING_SPEED);
        if (source == CDS_SOURCE_READ)
            servo->speed_known = word && magnitude_at(word) <= servo->fastest;
        servo->speed_0 = !word || magnitude_at(word) == 0;
    }
    return servo->cw_limit != before.cw_limit || servo->ccw_limit != before.ccw_limit ||
           servo->goal_known != before.goal_known || servo->speed_known != before.speed_known ||
           servo->speed_0 != before.speed_0;
}
