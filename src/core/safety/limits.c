/* Soft limits of one servo; see limits.h. Manual: 3.1, 0x06 to 0x09, 0x18, 0x1E to 0x21; R10, R16.
 */
#include "safety/limits.h"

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "cds55xx/packet.h"        // CDS_AT_*
#include "compiler.h"              // NOINLINE

/* ---- what a packet writes ---- */

static inline bool touches(uint8_t address, uint8_t end, uint8_t first, uint8_t last)
{
    return address <= last && end > first;
}

NOINLINE uint8_t cds_written_sets(uint8_t address, uint8_t length)
{
    uint8_t end = (uint8_t)(address + length), sets = 0; // `end`: the first register behind

    if (length == 0 || address >= CDS_TABLE_SIZE)
        return 0;
    if (end < address) // longer than any servo takes
        return UINT8_MAX;
    if (address <= CDS_REG_STATUS_RETURN_LEVEL) {
        if (touches(address, end, CDS_REG_ID, CDS_REG_ID))
            sets |= CDS_SETS_ID;
        if (touches(address, end, CDS_REG_BAUD_RATE, CDS_REG_RETURN_DELAY) ||
            end > CDS_REG_STATUS_RETURN_LEVEL)
            sets |= CDS_SETS_REPLY;
        if (touches(address, end, CDS_REG_CW_ANGLE_LIMIT, CDS_REG_CCW_ANGLE_LIMIT + 1))
            sets |= CDS_SETS_MODE;
    }
    if (touches(address, end, CDS_REG_TORQUE_ENABLE, CDS_REG_TORQUE_ENABLE))
        sets |= CDS_SETS_TORQUE;
    if (end <= CDS_REG_CW_COMPLIANCE_MARGIN)
        return sets;
    if (touches(address, end, CDS_REG_CW_COMPLIANCE_MARGIN, CDS_REG_CCW_PROPORTION) ||
        touches(address, end, CDS_REG_PUNCH, CDS_REG_PUNCH + 1))
        sets |= CDS_SETS_GAIN;
    if (touches(address, end, CDS_REG_GOAL_POSITION, CDS_REG_GOAL_POSITION + 1))
        sets |= CDS_SETS_GOAL;
    if (touches(address, end, CDS_REG_MOVING_SPEED, CDS_REG_MOVING_SPEED + 1))
        sets |= CDS_SETS_SPEED;
    if (touches(address, end, CDS_REG_REGISTERED_INSTRUCTION, CDS_REG_REGISTERED_INSTRUCTION))
        sets |= CDS_SETS_REGISTERED;
    return sets;
}

NOINLINE bool cds_written_by(const uint8_t *bytes, uint8_t index, struct cds_written *written)
{
    uint8_t count = (uint8_t)(bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN), length;
    uint16_t before;

    if (count < 2)
        return false;
    written->address = bytes[CDS_AT_PARAMETERS];
    written->id = bytes[CDS_AT_ID];
    written->data = bytes + CDS_AT_PARAMETERS + 1;
    if (bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE) {
        length = bytes[CDS_AT_SYNC_LENGTH];
        before = (uint16_t)(index * (length + 1u));
        written->data = bytes + CDS_AT_PARAMETERS + 2 + before - length; // up to the block
        written->left = (uint8_t)(count - 2u - before);
    } else {
        length = (uint8_t)(count - 1u);
    }
    written->length = length;
    written->sets = cds_written_sets(written->address, length);
    return true;
}

bool cds_written_is_torque_off(const uint8_t *bytes)
{
    return bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && bytes[CDS_AT_LENGTH] == CDS_LENGTH_MIN + 2 &&
           bytes[CDS_AT_PARAMETERS] == CDS_REG_TORQUE_ENABLE && bytes[CDS_AT_PARAMETERS + 1] == 0;
}

/* ---- what may be written ---- */

enum mode { MODE_UNKNOWN, MODE_POSITION, MODE_TURN };

ALWAYS_INLINE uint8_t mode_of(uint8_t cw_limit, uint8_t ccw_limit)
{
    if ((cw_limit | ccw_limit) & CDS_ANGLE_SET)
        return MODE_POSITION;
    return cw_limit & ccw_limit ? MODE_TURN : MODE_UNKNOWN;
}

ALWAYS_INLINE uint16_t word_at(const uint8_t *data)
{
    return (uint16_t)(data[0] | (uint16_t)data[1] << 8);
}

ALWAYS_INLINE uint16_t magnitude_at(const uint8_t *data)
{
    return word_at(data) & CDS_VALUE_MAX;
}

ALWAYS_INLINE bool has_goal_limit(const struct cds_servo_state *servo)
{
    return servo->lowest > 0 || servo->highest < CDS_VALUE_MAX;
}

/* A goal above 1023 is refused by the servo itself if the limit does not refuse it. */
ALWAYS_INLINE bool is_within(const struct cds_servo_state *servo, const uint8_t *goal)
{
    return word_at(goal) >= servo->lowest &&
           (word_at(goal) <= servo->highest || servo->highest == CDS_VALUE_MAX);
}

/* The angle limit at `reg`, of which `known` was known. */
static NOINLINE uint8_t angle_limit(uint8_t known, const struct cds_written *written, uint8_t reg)
{
    const uint8_t *low = cds_written_byte(written, reg);
    const uint8_t *high = cds_written_byte(written, (uint8_t)(reg + 1));

    if (!low && !high)
        return known;
    if ((low && *low) || (high && *high))
        return CDS_ANGLE_SET;
    return (low && high) || known == CDS_ANGLE_0 ? CDS_ANGLE_0 : CDS_ANGLE_UNKNOWN;
}

/* In endless turn a servo has no use for the goal, and stands still at speed 0. In position mode it
 * goes as fast as it can at speed 0. */
NOINLINE enum cds_result cds_limits_check_goal(struct cds_servo_state *servo, const uint8_t *data)
{
    uint16_t magnitude;
    uint8_t mode;

    if (!servo->has_limits)
        return CDS_OK;
    magnitude = magnitude_at(data + 2);
    if (!is_within(servo, data) || magnitude > servo->fastest)
        return CDS_LIMIT;
    mode = mode_of(servo->cw_limit, servo->ccw_limit);
    if (magnitude)
        return mode == MODE_POSITION || !has_goal_limit(servo) ? CDS_OK : CDS_LIMIT;
    if (mode != MODE_TURN && servo->fastest < CDS_VALUE_MAX)
        return CDS_LIMIT;
    servo->speed_0 = true;
    return CDS_OK;
}

/* Torque on alone, which a SYNC WRITE may bring to 50 servos. */
static enum cds_result check_held(const struct cds_servo_state *servo)
{
    uint8_t mode = mode_of(servo->cw_limit, servo->ccw_limit);

    if (mode == MODE_UNKNOWN || !servo->goal_known || !servo->speed_known)
        return CDS_LIMIT; // not read
    if (mode == MODE_TURN)
        return has_goal_limit(servo) ? CDS_LIMIT : CDS_OK;
    return servo->speed_0 && servo->fastest < CDS_VALUE_MAX ? CDS_LIMIT : CDS_OK;
}

/* Switched on, or over to position mode, a servo goes to the goal it holds, at the speed it holds.
 */
static NOINLINE enum cds_result check_held_after(struct cds_servo_state *servo,
                                                 const struct cds_written *written)
{
    uint8_t sets = written->sets, cw = servo->cw_limit, ccw = servo->ccw_limit;
    uint8_t before = mode_of(cw, ccw), mode = before;
    bool goal = servo->goal_known, speed = servo->speed_known, is_0 = servo->speed_0, on;
    const uint8_t *word;

    on = sets & CDS_SETS_TORQUE && cds_written_value(written, CDS_REG_TORQUE_ENABLE, 0);
    if (on && (before == MODE_UNKNOWN || !goal || !speed))
        return CDS_LIMIT; // not read
    if (sets & CDS_SETS_MODE)
        mode = mode_of(angle_limit(cw, written, CDS_REG_CW_ANGLE_LIMIT),
                       angle_limit(ccw, written, CDS_REG_CCW_ANGLE_LIMIT));
    if (sets & CDS_SETS_GOAL)
        goal = (word = cds_written_word(written, CDS_REG_GOAL_POSITION)) && is_within(servo, word);
    if (sets & CDS_SETS_SPEED) {
        word = cds_written_word(written, CDS_REG_MOVING_SPEED);
        speed = word && magnitude_at(word) <= servo->fastest;
        is_0 = word && magnitude_at(word) == 0;
    }
    if (has_goal_limit(servo)) {
        if (!goal &&
            (on || sets & CDS_SETS_GOAL || (sets & CDS_SETS_MODE && before != MODE_POSITION)))
            return CDS_LIMIT;
        if (mode != MODE_POSITION &&
            (on || sets & CDS_SETS_MODE || (sets & CDS_SETS_SPEED && !is_0)))
            return CDS_LIMIT;
    }
    if (servo->fastest < CDS_VALUE_MAX) {
        if ((sets & (CDS_SETS_GOAL | CDS_SETS_SPEED)) == CDS_SETS_GOAL)
            return CDS_LIMIT; // at which speed is not certain
        if ((on || sets & CDS_SETS_SPEED ||
             (sets & CDS_SETS_MODE && (mode == MODE_UNKNOWN || mode != before))) &&
            (!speed || (is_0 && mode != MODE_TURN)))
            return CDS_LIMIT;
    }
    if (sets & CDS_SETS_SPEED && is_0)
        servo->speed_0 = true;
    return CDS_OK;
}

enum cds_result cds_limits_check(struct cds_servo_state *servo, const struct cds_written *written)
{
    uint8_t sets = written->sets & CDS_SETS_DRIVE;

    if (!servo->has_limits || !sets)
        return CDS_OK;
    if (sets == CDS_SETS_TORQUE)
        return *cds_written_byte(written, CDS_REG_TORQUE_ENABLE) ? check_held(servo) : CDS_OK;
    return check_held_after(servo, written);
}

/* ---- what the servo holds ---- */

/* Returns what is known of the angle limit at `reg`. */
static uint8_t learn_angle(uint8_t known, const struct cds_written *written, uint8_t reg,
                           enum cds_source source)
{
    uint8_t next = angle_limit(known, written, reg);

    if (source == CDS_SOURCE_READ || next == known ||
        (source == CDS_SOURCE_ANSWERED && known != CDS_ANGLE_UNKNOWN))
        return next;
    return CDS_ANGLE_UNKNOWN;
}

NOINLINE bool cds_limits_learn(struct cds_servo_state *servo, const struct cds_written *written,
                               enum cds_source source)
{
    uint8_t cw = servo->cw_limit, ccw = servo->ccw_limit;
    bool goal = servo->goal_known, speed = servo->speed_known, is_0 = servo->speed_0, changed;
    const uint8_t *word;

    if (written->sets & CDS_SETS_MODE) {
        cw = learn_angle(cw, written, CDS_REG_CW_ANGLE_LIMIT, source);
        ccw = learn_angle(ccw, written, CDS_REG_CCW_ANGLE_LIMIT, source);
        if (cw != servo->cw_limit || ccw != servo->ccw_limit)
            servo->is_registered = false; // its registered write was checked in the other mode
    }
    if (written->sets & CDS_SETS_GOAL && source == CDS_SOURCE_READ)
        goal = (word = cds_written_word(written, CDS_REG_GOAL_POSITION)) && is_within(servo, word);
    if (written->sets & CDS_SETS_SPEED && source <= CDS_SOURCE_ANSWERED) {
        word = cds_written_word(written, CDS_REG_MOVING_SPEED);
        if (source == CDS_SOURCE_READ)
            speed = word && magnitude_at(word) <= servo->fastest;
        is_0 = !word || magnitude_at(word) == 0;
    }
    changed = cw != servo->cw_limit || ccw != servo->ccw_limit || goal != servo->goal_known ||
              speed != servo->speed_known || is_0 != servo->speed_0;
    servo->cw_limit = cw & 3u;
    servo->ccw_limit = ccw & 3u;
    servo->goal_known = goal;
    servo->speed_known = speed;
    servo->speed_0 = is_0;
    return changed;
}
