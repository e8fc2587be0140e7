/* Is a move possible? See motion.h and docs/internals/motion.md. A way is counted in register units
 * of speed x periods: divided by the duration it is the mean speed. */
#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "robot/curve_internal.h"
#include "robot/motion_internal.h"

#define WINDOW_US ((uint32_t)250000) // braking takes so long at most
#define SAMPLES   16                 // of the speed of a joint that moves already

// No longer duration is tried.
#define DURATION_MAX (UINT32_MAX / 16384)

static uint32_t periods_of(const struct cds_motion *motion, uint32_t time_ms)
{
    uint16_t period_us = motion->config.cycle->period_us;

    return (time_ms * 1000 + period_us - 1) / period_us;
}

/* The basis at which the move begins. */
static const struct cds_motion_basis *basis_before(const struct cds_motion *motion)
{
    return motion->next.waits && motion->is_under_way ? &motion->last_basis : &motion->basis;
}

void cds_motion_begin_check(struct cds_motion *motion)
{
    struct cds_motion_plan *plan = &motion->next_plan;

    plan->duration = periods_of(motion, motion->next.time_ms);
    plan->passes = motion->next.next_pose != NULL;
    plan->next_duration = plan->passes ? periods_of(motion, motion->next.next_ms) : 0;
    plan->window = plan->duration;
    if (motion->next.waits)
        cds_motion_set_end(motion, &motion->last_basis);
    else if (WINDOW_US / motion->config.cycle->period_us < plan->duration)
        plan->window = WINDOW_US / motion->config.cycle->period_us + 1;
    motion->shortest = 1;
    motion->longest = 0;
    motion->shortest_ms = 0;
    motion->tried = plan->duration;
    motion->checked = motion->next.waits || motion->basis.is_at_rest
                          ? motion->count // no joint must turn back
                          : 0;
    motion->move_result = CDS_PENDING;
}

uint32_t cds_motion_per_period(const struct cds_motion *motion, uint16_t acceleration)
{
    uint32_t change = (uint32_t)acceleration * motion->config.cycle->period_us / 62500ul;

    return change ? change : 1;
}

static uint32_t root_up(uint32_t square)
{
    uint32_t root = cds_curve_root(square);

    return root * root < square ? root + 1 : root;
}

/* Periods that a trapezoid takes at least for `way`. It reaches the speed `fastest` only if the way
 * is long enough; else it is a triangle. */
static uint32_t shortest_trapezoid(uint32_t way, uint16_t fastest, uint32_t change)
{
    uint32_t to_fastest = ((uint32_t)fastest * CDS_MOTION_UNIT + change - 1) / change;

    if (to_fastest * fastest <= way)
        return (way + fastest - 1) / fastest + to_fastest;
    return 2 * root_up(way * CDS_MOTION_UNIT / change + 1);
}

/* Periods that a joint takes at least for `way` from rest. */
static uint32_t shortest(const struct cds_motion *motion, uint32_t way, uint16_t fastest)
{
    uint16_t most = motion->config.acceleration;
    uint32_t by_speed = (way + fastest - 1) / fastest, by_acceleration = 0;

    switch (motion->next.curve) {
    case CDS_MOTION_TRAPEZOID:
        return shortest_trapezoid(way, fastest,
                                  cds_motion_per_period(motion, motion->next.acceleration));
    case CDS_MOTION_MINIMUM_JERK: // peaks: 15/8 of the mean speed, 5.774 way / time^2
        by_speed = (way * 15 / 8 + fastest - 1) / fastest;
        if (most)
            by_acceleration = root_up(way * 370 / 4 / cds_motion_per_period(motion, most) + 1);
        break;
    default: break;
    }
    return by_speed > by_acceleration ? by_speed : by_acceleration;
}

static uint16_t distance(int16_t from, int16_t to)
{
    return (uint16_t)(to > from ? to - from : from - to);
}

/* True if a joint that moves at the beginning or at the end keeps `fastest`, in `duration` periods.
 */
static bool is_slow_enough(const struct cds_motion *motion, const struct cds_motion_way *way,
                           uint16_t scale, uint32_t duration, uint16_t fastest)
{
    struct cds_motion_joint joint = {.scale = scale};
    struct cds_motion_plan plan = motion->next_plan;
    struct cds_motion_basis basis = {.is_end = false};
    struct cds_curve curve;
    uint16_t most; // what is sent is limited; a servo catches up 1/8

    cds_curve_set(&curve, CDS_MOTION_MINIMUM_JERK);
    if (motion->next.curve == CDS_MOTION_TRAPEZOID)
        cds_curve_set_trapezoid(&curve, CDS_CURVE_TRIANGLE); // no other one is faster
    plan.duration = duration;
    cds_motion_aim(&joint, way, &plan);
    most = (uint16_t)(fastest * CDS_MOTION_QUARTERS + fastest * CDS_MOTION_QUARTERS / 8);
    for (uint8_t i = 0; i < SAMPLES; i++) {
        uint16_t time = (uint16_t)(i * (65536ul / SAMPLES));
        uint32_t braking = ((time >> 4) * duration / plan.window) << 4;

        basis.rate = cds_curve_rate(&curve, time);
        basis.braking_rate =
            cds_curve_braking_rate(braking > UINT16_MAX ? UINT16_MAX : (uint16_t)braking);
        basis.passing_rate = cds_curve_braking_rate((uint16_t)~time);
        if (distance(0, cds_motion_speed(&joint, &basis)) > most)
            return false;
    }
    return true;
}

/* The joint brakes within its limits. */
static void narrow_window(struct cds_motion *motion, const struct cds_motion_way *way,
                          uint16_t scale, uint16_t lowest, uint16_t highest)
{
    int16_t end = (int16_t)((way->begin_speed > 0 ? highest : lowest) * CDS_MOTION_STEP);
    uint16_t room = distance(way->position, end), periods = 1;

    if (room > CDS_MOTION_STEP)
        periods = (uint16_t)((uint32_t)(room - CDS_MOTION_STEP) * scale /
                             (4ul * distance(0, way->begin_speed)));
    if (periods < motion->next_plan.window)
        motion->next_plan.window = periods ? periods : 1;
}

/* Notes the time that joint `index` takes at least. Returns false if it moves already, and the
 * duration that was tried is too short: the next poll tries a longer one. */
static bool take_time(struct cds_motion *motion, uint8_t index, const struct cds_motion_way *way,
                      uint16_t fastest)
{
    uint16_t scale = motion->config.joints[index].scale;
    uint32_t longest = ((uint32_t)distance(way->position, way->goal) * scale >> 7) + 1, periods;

    if (longest > motion->longest)
        motion->longest = longest;
    periods = shortest(motion, longest, fastest);
    if (way->begin_speed || way->end_speed) {
        periods = motion->tried;
        if (periods < DURATION_MAX && !is_slow_enough(motion, way, scale, periods, fastest)) {
            motion->tried += periods / 8 + 1;
            return false;
        }
    }
    if (periods > motion->shortest) {
        motion->shortest = periods;
        motion->joint = index;
    }
    return true;
}

/* Checks joint `index`. CDS_PENDING: not over yet. */
static enum cds_result check_joint(struct cds_motion *motion, uint8_t index, bool is_second)
{
    uint8_t id = motion->config.cycle->ids[index];
    uint16_t goal = motion->next.pose[index], lowest = 0, highest = CDS_VALUE_MAX,
             fastest = CDS_VALUE_MAX;
    const struct cds_servo_state *servo = NULL;
    struct cds_motion_way way;

    if (goal == CDS_POSE_NONE && (is_second || !motion->config.joints[index].is_moving))
        return CDS_OK;
    if (!cds_motion_find_way(motion, index, basis_before(motion), motion->tried, &way))
        return CDS_TIMEOUT;
    if (motion->config.servos)
        servo = cds_servos_find(motion->config.servos, id);
    if (servo) {
        lowest = servo->lowest;
        highest = servo->highest;
        fastest = servo->fastest;
    }
    if (!is_second) {
        if (way.begin_speed)
            narrow_window(motion, &way, motion->config.joints[index].scale, lowest, highest);
        return CDS_OK;
    }
    if (servo && !cds_servos_may_drive(motion->config.servos, id))
        return CDS_INHIBITED;
    if (goal < lowest || goal > highest || fastest == 0)
        return CDS_LIMIT;
    motion->config.joints[index].fastest = (uint16_t)(fastest * CDS_MOTION_QUARTERS);
    return take_time(motion, index, &way, fastest) ? CDS_OK : CDS_PENDING;
}

/* ---- the plan, when all joints are checked ---- */

static enum cds_result decide(struct cds_motion *motion)
{
    uint32_t ms = (motion->shortest * motion->config.cycle->period_us + 999) / 1000;

    if (motion->shortest <= motion->next_plan.duration)
        return CDS_OK;
    if (ms > CDS_MOTION_TIME_MAX_MS)
        return CDS_LIMIT;
    motion->shortest_ms = ms;
    if (!motion->next.may_take_longer)
        return CDS_LIMIT;
    motion->next_plan.duration = motion->shortest;
    return CDS_OK;
}

static void set_curve(struct cds_motion *motion)
{
    struct cds_motion_plan *plan = &motion->next_plan;
    uint32_t mean_speed = motion->longest * CDS_MOTION_UNIT / plan->duration, bend;

    if (motion->next.curve == CDS_MOTION_TRAPEZOID) {
        bend = (mean_speed << 16) / cds_motion_per_period(motion, motion->next.acceleration) /
               plan->duration;
        cds_curve_set_trapezoid(&plan->curve,
                                bend < CDS_CURVE_TRIANGLE ? (uint16_t)bend : CDS_CURVE_TRIANGLE);
    } else {
        cds_curve_set(&plan->curve, motion->next.curve);
    }
    plan->peak = mean_speed * plan->curve.rate / CDS_CURVE_RATE_1 + 1;
}

/* The clock runs from 0 to 1 in `periods`, 1 or more, at 100 %. */
static void start_clock(struct cds_motion_clock *clock, uint32_t periods)
{
    uint32_t left; // of the division, shifted by 8 bits at a time

    *clock = (struct cds_motion_clock){.step = UINT32_MAX};
    if (periods == 1)
        return;
    clock->step = UINT32_MAX / periods;
    left = (UINT32_MAX % periods + 1) << 8;
    clock->step_low = (uint16_t)(left / periods << 8);
    clock->step_low = (uint16_t)(clock->step_low + (left % periods << 8) / periods);
}

/* How much faster the time may run: speed and acceleration stay within what was checked. */
static uint32_t most_of(const struct cds_motion *motion)
{
    uint32_t duration = motion->next_plan.duration, shortest = motion->shortest;

    if (motion->next.curve == CDS_MOTION_TRAPEZOID && motion->config.acceleration)
        return CDS_MOTION_RATE_1;
    if (duration / 2 >= shortest)
        return 2 * CDS_MOTION_RATE_1;
    for (; duration > UINT16_MAX; duration >>= 1, shortest = (shortest >> 1) + 1) {
    }
    return (duration << 16) / shortest;
}

/* The steps of the plan: a poll each, since each divides. */
static enum cds_result plan(struct cds_motion *motion, uint8_t step)
{
    struct cds_motion_plan *next = &motion->next_plan;

    switch (step) {
    case 0: return decide(motion);
    case 1: set_curve(motion); break;
    case 2: start_clock(&next->time, next->duration); break;
    case 3: start_clock(&next->braking_time, next->window); break;
    default: next->rate_most = most_of(motion); break;
    }
    return CDS_OK;
}

#define PLAN_STEPS 5

enum cds_result cds_motion_check(struct cds_motion *motion)
{
    uint8_t count = motion->count, index = motion->checked;
    enum cds_result result;

    motion->carry = CDS_MOTION_CARRY_1; // at most: the move may not run as fast
    if (motion->rate > CDS_MOTION_RATE_1)
        motion->carry = (uint16_t)(motion->rate >> 4);

    if (index < count)
        result = check_joint(motion, index, false);
    else if (index < 2 * count)
        result = check_joint(motion, index = (uint8_t)(index - count), true);
    else
        result = plan(motion, (uint8_t)(index - 2 * count));
    if (result == CDS_PENDING)
        return result;
    if (result != CDS_OK) {
        if (motion->checked < 2 * count)
            motion->joint = index;
        return result;
    }
    return ++motion->checked < 2 * count + PLAN_STEPS ? CDS_PENDING : CDS_OK;
}
