/* Soft limits of one servo; see limits.h. Manual: 3.1, 0x06 to 0x09, 0x1E to 0x21; R10, R16. */
#include "limits.h"

#include <stdbool.h>

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "goal.h"                  // CDS_GOAL_SIZE

enum found { NONE, HALF, WHOLE };

/* The word at `reg`, low byte first (R28), if the bytes from `address` on hold it. */
static enum found word_of(uint8_t reg, uint8_t address, const uint8_t *data, uint8_t length,
                          uint16_t *word)
{
    bool low = reg >= address && reg - address < length;
    bool high = reg + 1 >= address && reg + 1 - address < length;

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

/* As far as known: both angle limits 0. */
static bool turns(const struct cds_roster_servo *servo)
{
    return servo->cw_limit_0 && servo->ccw_limit_0;
}

/* Endless turn knows no goal, so a servo with a limit of its goal must not get there. */
static bool mode_is_good(const struct cds_roster_servo *servo, uint8_t address, const uint8_t *data,
                         uint8_t length)
{
    uint16_t cw = 1, ccw = 1;
    enum found cw_found, ccw_found;

    if (address > CDS_REG_CCW_ANGLE_LIMIT + 1 || !position_limited(servo))
        return true; // the first is what a goal is, and goals come often
    cw_found = word_of(CDS_REG_CW_ANGLE_LIMIT, address, data, length, &cw);
    ccw_found = word_of(CDS_REG_CCW_ANGLE_LIMIT, address, data, length, &ccw);
    if (cw_found == NONE && ccw_found == NONE)
        return true;
    if (cw_found == HALF || ccw_found == HALF)
        return false;
    return !((cw_found == WHOLE ? cw == 0 : servo->cw_limit_0) &&
             (ccw_found == WHOLE ? ccw == 0 : servo->ccw_limit_0));
}

static bool speed_is_good(const struct cds_roster_servo *servo, uint16_t speed)
{
    uint16_t magnitude = speed & CDS_VALUE_MAX;

    if (turns(servo) && magnitude && position_limited(servo))
        return false;
    if (!speed_limited(servo))
        return true;
    if (magnitude == 0) // endless turn: it stands still; position mode: as fast as it can
        return turns(servo);
    return magnitude <= servo->fastest;
}

static uint16_t word_at(const uint8_t *data)
{
    return (uint16_t)(data[0] | (uint16_t)data[1] << 8);
}

/* What no servo has is the servo's to refuse if there is no limit: whoever asked hears it say so. */
static bool goal_is_good(const struct cds_roster_servo *servo, uint16_t goal)
{
    return goal >= servo->lowest && (goal <= servo->highest || servo->highest == CDS_VALUE_MAX);
}

enum cds_result cds_limits_check(const struct cds_roster_servo *servo, uint8_t address,
                                 const uint8_t *data, uint8_t length)
{
    uint16_t goal = 0, speed = 0;
    enum found goal_found, speed_found;
    bool good;

    if (address == CDS_REG_GOAL_POSITION &&
        length == CDS_GOAL_SIZE) // the short way: 50 of them in 4 ms
        return goal_is_good(servo, word_at(data)) && speed_is_good(servo, word_at(data + 2))
                   ? CDS_OK
                   : CDS_LIMIT;
    goal_found = word_of(CDS_REG_GOAL_POSITION, address, data, length, &goal);
    speed_found = word_of(CDS_REG_MOVING_SPEED, address, data, length, &speed);
    good = mode_is_good(servo, address, data, length);
    if (goal_found == HALF)
        good = good && !position_limited(servo);
    if (goal_found == WHOLE)
        good = good && goal_is_good(servo, goal);
    if (speed_found == HALF)
        good = good && !speed_limited(servo) && !(turns(servo) && position_limited(servo));
    if (speed_found == WHOLE)
        good = good && speed_is_good(servo, speed);
    else if (goal_found != NONE) // it would go there at a speed that nobody has limited
        good = good && (!speed_limited(servo) || servo->speed_known || turns(servo));
    return good ? CDS_OK : CDS_LIMIT;
}
