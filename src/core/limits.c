/* Soft limits of one servo; see limits.h. Manual: 3.1, 0x06 to 0x09, 0x18, 0x1E to 0x21; R10, R16.
 */
#include "limits.h"

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "goal.h"                  // CDS_GOAL_SIZE

enum found { NONE, HALF, WHOLE };

static bool touches(uint8_t first, uint8_t last, uint8_t address, uint8_t length)
{
    return address <= last && address + length > first;
}

/* The word at `reg`, low byte first (R28), if the bytes from `address` on hold it. */
static enum found word_of(uint8_t reg, uint8_t address, const uint8_t *data, uint8_t length,
                          uint16_t *word)
{
    bool low = touches(reg, reg, address, length);
    bool high = touches((uint8_t)(reg + 1), (uint8_t)(reg + 1), address, length);

    if (!low || !high)
        return low || high ? HALF : NONE;
    *word = (uint16_t)(data[reg - address] | (uint16_t)data[reg + 1 - address] << 8);
    return WHOLE;
}

static bool position_limited(const struct cds_roster_servo *servo)
{
    return servo->lowest > 0 || servo->highest < CDS_VALUE_MAX;
}

static bool speed_limited(const struct cds_roster_servo *servo)
{
    return servo->fastest < CDS_VALUE_MAX;
}

bool cds_limits_any(const struct cds_roster_servo *servo)
{
    return position_limited(servo) || speed_limited(servo);
}

/* What no servo has is the servo's to refuse if there is no limit: whoever asked hears it say so.
 */
static bool goal_is_good(const struct cds_roster_servo *servo, uint16_t goal)
{
    return goal >= servo->lowest && (goal <= servo->highest || servo->highest == CDS_VALUE_MAX);
}

/* Endless turn knows no goal. Speed 0 stands still there; in position mode it is as fast as it can.
 */
static bool speed_is_good(const struct cds_roster_servo *servo, uint16_t speed, enum cds_mode mode)
{
    uint16_t magnitude = speed & CDS_VALUE_MAX;

    if (magnitude == 0)
        return !speed_limited(servo) || mode == CDS_MODE_TURN;
    return magnitude <= servo->fastest && (!position_limited(servo) || mode == CDS_MODE_POSITION);
}

/* ---- what it holds ---- */

static uint8_t angle_limit(uint8_t known, uint8_t reg, uint8_t address, const uint8_t *data,
                           uint8_t length)
{
    uint16_t word = 0;
    enum found found = word_of(reg, address, data, length, &word);

    if (found == HALF) {
        bool zero = data[reg >= address ? reg - address : 0] == 0;

        return !zero ? CDS_ANGLE_SET : known == CDS_ANGLE_0 ? CDS_ANGLE_0 : CDS_ANGLE_UNKNOWN;
    }
    if (found == WHOLE)
        return word ? CDS_ANGLE_SET : CDS_ANGLE_0;
    return known;
}

static void take(struct cds_roster_servo *servo, uint8_t address, const uint8_t *data,
                 uint8_t length)
{
    uint16_t word = 0;
    enum found found = word_of(CDS_REG_GOAL_POSITION, address, data, length, &word);

    servo->cw_limit = angle_limit(servo->cw_limit, CDS_REG_CW_ANGLE_LIMIT, address, data, length);
    servo->ccw_limit =
        angle_limit(servo->ccw_limit, CDS_REG_CCW_ANGLE_LIMIT, address, data, length);
    if (found != NONE)
        servo->goal_known = found == WHOLE && goal_is_good(servo, word);
    found = word_of(CDS_REG_MOVING_SPEED, address, data, length, &word);
    if (found != NONE) {
        servo->speed_known = found == WHOLE && (word & CDS_VALUE_MAX) <= servo->fastest;
        servo->speed_0 = found == HALF || (word & CDS_VALUE_MAX) == 0;
    }
}

void cds_limits_learn(struct cds_roster_servo *servo, uint8_t address, const uint8_t *data,
                      uint8_t length, bool certain)
{
    struct cds_roster_servo before = *servo;

    take(servo, address, data, length);
    if (certain)
        return;
    if (servo->cw_limit != before.cw_limit)
        servo->cw_limit = CDS_ANGLE_UNKNOWN;
    if (servo->ccw_limit != before.ccw_limit)
        servo->ccw_limit = CDS_ANGLE_UNKNOWN;
    servo->goal_known = servo->goal_known && before.goal_known;
    servo->speed_known = servo->speed_known && before.speed_known;
    servo->speed_0 = servo->speed_0 || before.speed_0;
}

/* ---- what may be written ---- */

/* The words themselves; what they do with what it holds is for the others to say. */
static bool words_are_good(const struct cds_roster_servo *servo, uint8_t address,
                           const uint8_t *data, uint8_t length, enum cds_mode mode)
{
    uint16_t word = 0;
    enum found found = word_of(CDS_REG_GOAL_POSITION, address, data, length, &word);

    if (found == HALF ? position_limited(servo) : found == WHOLE && !goal_is_good(servo, word))
        return false;
    found = word_of(CDS_REG_MOVING_SPEED, address, data, length, &word);
    if (found == HALF)
        return !speed_limited(servo) && (!position_limited(servo) || mode == CDS_MODE_POSITION);
    return found == NONE || speed_is_good(servo, word, mode);
}

/* Would it stay within the limits of its goal, with its torque on and all this written? `next` is
 * the servo then. Switched to position mode, or on, it goes to the goal it holds. */
static bool stays_in_place(const struct cds_roster_servo *servo,
                           const struct cds_roster_servo *next, bool mode_set, bool torque_on)
{
    bool begins = torque_on || (mode_set && cds_limits_mode(servo) != CDS_MODE_POSITION);

    if (!position_limited(servo) || !(mode_set || torque_on))
        return true;
    return cds_limits_mode(next) == CDS_MODE_POSITION && (!begins || next->goal_known);
}

/* ... and below the limit of its speed, going where it is told? */
static bool stays_slow(const struct cds_roster_servo *servo, const struct cds_roster_servo *next,
                       bool mode_set, bool goal_set, bool torque_on)
{
    enum cds_mode mode = cds_limits_mode(next);
    bool goes = goal_set && mode != CDS_MODE_TURN;
    bool other = mode_set && (mode == CDS_MODE_UNKNOWN || mode != cds_limits_mode(servo));

    if (!speed_limited(servo) || !(goes || torque_on || other))
        return true;
    return next->speed_known && (mode == CDS_MODE_TURN || !next->speed_0);
}

static uint16_t word_at(const uint8_t *data)
{
    return (uint16_t)(data[0] | (uint16_t)data[1] << 8);
}

static __attribute__((noinline)) bool is_good(const struct cds_roster_servo *servo, uint8_t address,
                                              const uint8_t *data, uint8_t length)
{
    struct cds_roster_servo next = *servo;
    bool mode_set = touches(CDS_REG_CW_ANGLE_LIMIT, CDS_REG_CCW_ANGLE_LIMIT + 1, address, length);
    bool goal_set = touches(CDS_REG_GOAL_POSITION, CDS_REG_GOAL_POSITION + 1, address, length);
    bool torque_on = touches(CDS_REG_TORQUE_ENABLE, CDS_REG_TORQUE_ENABLE, address, length) &&
                     data[CDS_REG_TORQUE_ENABLE - address];

    take(&next, address, data, length);
    return words_are_good(servo, address, data, length, cds_limits_mode(&next)) &&
           stays_in_place(servo, &next, mode_set, torque_on) &&
           stays_slow(servo, &next, mode_set, goal_set, torque_on);
}

enum cds_result cds_limits_check(const struct cds_roster_servo *servo, uint8_t address,
                                 const uint8_t *data, uint8_t length)
{
    bool good;

    if (address > CDS_REG_MOVING_SPEED + 1 || !cds_limits_any(servo))
        return CDS_OK;
    if (address == CDS_REG_GOAL_POSITION &&
        length == CDS_GOAL_SIZE) // the short way: 50 of them in 4 ms
        good = goal_is_good(servo, word_at(data)) &&
               speed_is_good(servo, word_at(data + 2), cds_limits_mode(servo));
    else
        good = is_good(servo, address, data, length);
    return good ? CDS_OK : CDS_LIMIT;
}
